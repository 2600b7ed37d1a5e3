//! Photons for the maps: shot, or of an earlier run.

use std::path::Path;

use gi_core::files;
use gi_core::scene::Scene;
use gi_core::technique::Setting;

use crate::map::Order;
use crate::shoot::{NEAR_SPECULAR, Shot, Source, Wanted};
use crate::volume::VolumeMaps;
use crate::{Gather, Params, file, seen};

/// Photons for both maps on surfaces, and the maps of media if they were saved.
pub(crate) struct Maps {
    pub(crate) global: Shot,
    pub(crate) caustic: Option<Shot>,
    pub(crate) volume: Option<VolumeMaps>,
    pub(crate) order: Order,
}

impl Params {
    /// Whether media absorb and scatter light.
    pub(crate) fn knows_media(&self, scene: &Scene) -> bool {
        scene.has_media() && self.volume_photons > 0
    }
}

/// Where photons come from, by the parameters.
pub(crate) fn source<'a>(setting: &Setting<'a>, params: &Params) -> Source<'a> {
    let max_segments = params.limits.max_depth.map(|most| most.saturating_sub(1));
    let media = params.knows_media(setting.scene);
    Source { scene: setting.scene, seed: setting.seed, max_segments, media }
}

/// Photon tracing [slide 22].
pub(crate) fn shoot(setting: &Setting, params: &Params) -> Maps {
    let source = source(setting, params);
    let targets = seen::targets(setting, params);
    let wanted = targets.as_ref().map_or(Wanted::Global, Wanted::Aimed);
    let global = source.shoot(wanted, params.photons);
    let caustic = (params.gather == Gather::Final && params.caustic_photons > 0).then(|| {
        let targets = setting.scene.focusing_below(NEAR_SPECULAR);
        let count = if targets.is_empty() { 0 } else { params.caustic_photons };
        source.shoot(Wanted::Caustic(&targets), count)
    });
    Maps { global, caustic, volume: None, order: Order::Any }
}

/// Photons of an earlier run.
///
/// # Errors
/// One line with the file's name and the cause.
pub(crate) fn load(setting: &Setting, params: &Params, path: &Path) -> Result<Maps, String> {
    let refused = |cause| format!("cannot use {}: {cause}", path.display());
    let saved = file::from_bytes(&files::read(path)?).map_err(refused)?;
    saved.check(setting, params).map_err(refused)?;
    let order = if saved.layout == params.layout { Order::Tree } else { Order::Any };
    let caustic = saved.caustic.filter(|_| params.caustic_photons > 0);
    let media = setting.scene.media();
    let build = |shot| VolumeMaps::build(shot, media, params.volume_lookup, Order::Tree);
    Ok(Maps { global: saved.global, caustic, volume: saved.volume.map(build), order })
}
