//! The maps of light in media, and the check of `--subsurface dipole`.

use gi_core::medium::MediumId;
use gi_core::technique::Setting;

use crate::dipole::Dipoles;
use crate::params::{Params, Subsurface};
use crate::shoot::Source;
use crate::solids::Solids;
use crate::volume::VolumeMaps;

/// The light in all media.
pub(crate) struct MediaMaps {
    pub(crate) solids: Solids,
    /// Photons in media, but for those that the dipole stands for.
    pub(crate) volume: VolumeMaps,
    pub(crate) dipoles: Option<Dipoles>,
}

/// Why the dipole is refused where it has nothing to stand for.
const NO_SOLID: &str = "--subsurface dipole: no medium fills a solid here, that is: all of its boundaries refract \
     (dielectric, roughdielectric), no light stands in it, and --volume-photons is not 0; leave it out to use photons in the medium";

/// Why it is refused where the eye sees what it does not know.
const INSIDE: &str = "--subsurface dipole: the camera stands inside a solid, and the dipole knows only what \
     leaves it; leave it out to use photons in the medium";

/// Check that the dipole can stand for what it is asked to.
///
/// # Errors
/// Why it can't, and the way out.
pub(crate) fn check(setting: &Setting, params: &Params) -> Result<(), String> {
    if params.subsurface == Subsurface::Photons {
        return Ok(());
    }
    let scene = setting.scene;
    let solids = Solids::of(scene);
    let mut media = (0..scene.media().len()).map(MediumId::new);
    if !params.knows_media(scene) || !media.any(|m| solids.is_dark(m)) {
        return Err(NO_SOLID.into());
    }
    let is_inside = setting.camera_medium().is_some_and(|m| solids.is_dark(m));
    if is_inside { Err(INSIDE.into()) } else { Ok(()) }
}

impl MediaMaps {
    /// Trace photons in media, except those that `saved` already holds.
    pub(crate) fn shoot(source: &Source, params: &Params, saved: Option<VolumeMaps>) -> Self {
        let solids = Solids::of(source.scene);
        let by_dipole = params.subsurface == Subsurface::Dipole;
        let dipoles = by_dipole.then(|| Dipoles::shoot(source, &solids, params.volume_photons));
        let is_wanted = |m| !(by_dipole && solids.is_dark(m));
        let volume = saved.unwrap_or_else(|| VolumeMaps::shoot(source, params, is_wanted));
        MediaMaps { solids, volume, dipoles }
    }

    /// What is worth knowing.
    pub(crate) fn statistics(&self) -> Vec<(String, f64)> {
        let dipoles = self.dipoles.iter().flat_map(Dipoles::statistics);
        self.volume.statistics().into_iter().chain(dipoles).collect()
    }
}
