//! The photon maps of a run: traced, or read from a file.

use std::path::Path;

use gi_core::files;
use gi_core::scene::Scene;
use gi_core::technique::Setting;

use crate::estimate::Estimator;
use crate::irradiance::{self, IrradianceMap, irradiance_maps};
use crate::map::{Order, PhotonMap};
use crate::media::{self, MediaMaps};
use crate::params::{Gather, Params};
use crate::shoot::{NEAR_SPECULAR, Shot, Source, Wanted};
use crate::volume::VolumeMaps;
use crate::{file, seen};

/// The largest radius of a caustic estimate, relative to the radius that half of its photons need. Caustics are read directly
/// and have sharp edges.
const CAUSTIC_RADIUS: f32 = 0.5;

/// All maps that a picture reads.
pub(crate) struct PhotonMaps {
    pub(crate) global: Estimator,
    pub(crate) caustic: Option<Estimator>,
    /// Light in media; `None` if the scene has none.
    pub(crate) media: Option<MediaMaps>,
    /// Precomputed irradiance, by the maximum depth of its light. One map serves all depths if depth is unbounded.
    irradiance: Vec<IrradianceMap>,
    /// Whether tracing gave up before there were enough photons in the global and the caustic map.
    gave_up: [bool; 2],
}

impl PhotonMaps {
    /// Trace photons, build the maps, and precompute irradiance.
    ///
    /// # Errors
    /// One line: the dipole has nothing to stand for, or the file of saved maps cannot be used.
    pub(crate) fn new(setting: &Setting, params: &Params) -> Result<Self, String> {
        media::check(setting, params)?;
        let Photons { global, caustic, volume, order } = match &params.map_in {
            Some(path) => load(setting, params, path)?,
            None => shoot(setting, params),
        };
        let gave_up = [global.gave_up, caustic.as_ref().is_some_and(|c| c.gave_up)];
        let max_radius = params.max_radius * setting.scene.radius();
        let estimator = |shot: Shot, k, factor| {
            let bounded = params.limits.max_depth.is_some();
            let map = PhotonMap::build(shot.photons, shot.emitted, params.layout, order, bounded);
            Estimator::new(map, params.kernel, k, max_radius, factor)
        };
        // Gather rays average over many estimates: half as many photons blur less.
        let halves = if params.gather == Gather::Final { 2 } else { 1 };
        let (k, factor) = (params.lookup.div_ceil(halves), params.gather.radius_factor());
        let mut global = estimator(global, k, factor);
        let caustic = caustic.map(|shot| estimator(shot, params.lookup, CAUSTIC_RADIUS));
        let places = seen::places(setting, params.gather, irradiance::count(global.map.len()));
        if params.max_radius == 0.0 {
            global.bound_radius(&places, factor);
        }
        let irradiance = match params.gather {
            Gather::Final => irradiance_maps(setting, params, &global, &places),
            Gather::None | Gather::Direct => Vec::new(),
        };
        let media = params
            .knows_media(setting.scene)
            .then(|| MediaMaps::shoot(&source(setting, params), params, volume));
        Ok(PhotonMaps { global, caustic, media, irradiance, gave_up })
    }

    /// Irradiance of light that took at most `depth` segments.
    pub(crate) fn irradiance(&self, depth: u8) -> &IrradianceMap {
        let last = self.irradiance.len() - 1;
        &self.irradiance[(depth as usize - 1).min(last)]
    }

    /// The maps on surfaces.
    pub(crate) fn on_surfaces(&self) -> [Option<&PhotonMap>; 2] {
        [Some(&self.global.map), self.caustic.as_ref().map(|c| &c.map)]
    }

    /// The maps in media.
    pub(crate) fn volume(&self) -> Option<&VolumeMaps> {
        self.media.as_ref().map(|media| &media.volume)
    }

    /// Sizes and radii; radii are relative to that of the scene.
    pub(crate) fn statistics(&self, scene_radius: f32) -> Vec<(String, f64)> {
        let mut out = Vec::new();
        let maps = [("global", Some(&self.global)), ("caustic", self.caustic.as_ref())];
        for ((name, map), gave_up) in maps.into_iter().zip(self.gave_up) {
            let Some(Estimator { map, max_radius_sq, .. }) = map else { continue };
            out.push((format!("{name}_photons"), map.len() as f64));
            out.push((format!("{name}_paths"), map.emitted as f64));
            out.push((format!("{name}_bytes"), map.bytes() as f64));
            let radius = max_radius_sq.sqrt() / scene_radius;
            out.push((format!("{name}_max_radius"), f64::from(radius)));
            out.push((format!("{name}_gave_up"), f64::from(u8::from(gave_up))));
        }
        if let Some(media) = &self.media {
            out.extend(media.statistics());
        }
        let bytes: usize = self.irradiance.iter().map(IrradianceMap::bytes).sum();
        out.push(("irradiance_bytes".into(), bytes as f64));
        out
    }
}

impl Gather {
    /// The largest radius of an estimate, relative to the radius that half of the places need. In the dark, a disc that grows
    /// until it reaches a bright region reads too much light. Where the map is read directly, that is less bad than blotches.
    fn radius_factor(self) -> f32 {
        if self == Gather::Final { 0.75 } else { 3.0 }
    }
}

/// The photons of both maps on surfaces, and the maps in media if they come from a file.
struct Photons {
    global: Shot,
    caustic: Option<Shot>,
    volume: Option<VolumeMaps>,
    order: Order,
}

impl Params {
    /// Whether media attenuate and scatter light.
    pub(crate) fn knows_media(&self, scene: &Scene) -> bool {
        scene.has_media() && self.volume_photons > 0
    }
}

/// How photons are traced.
pub(crate) fn source<'a>(setting: &Setting<'a>, params: &Params) -> Source<'a> {
    let max_segments = params.limits.max_depth.map(|most| most.saturating_sub(1));
    let media = params.knows_media(setting.scene);
    Source { scene: setting.scene, seed: setting.seed, max_segments, media }
}

/// Photon tracing [slide 22].
fn shoot(setting: &Setting, params: &Params) -> Photons {
    let source = source(setting, params);
    let targets = seen::targets(setting, params);
    let wanted = targets.as_ref().map_or(Wanted::Global, Wanted::Aimed);
    let global = source.shoot(wanted, params.photons);
    let caustic = (params.gather == Gather::Final && params.caustic_photons > 0).then(|| {
        let targets = setting.scene.focusing_below(NEAR_SPECULAR);
        let count = if targets.is_empty() { 0 } else { params.caustic_photons };
        source.shoot_caustic(&targets, count)
    });
    Photons { global, caustic, volume: None, order: Order::Any }
}

/// Read the photons of an earlier run.
///
/// # Errors
/// One line with the file's name and the cause.
fn load(setting: &Setting, params: &Params, path: &Path) -> Result<Photons, String> {
    let refused = |cause: String| files::refusal(path, &cause);
    let saved = file::from_bytes(&files::read(path)?).map_err(refused)?;
    saved.check(setting, params).map_err(refused)?;
    let order = if saved.layout == params.layout { Order::Tree } else { Order::Any };
    let caustic = saved.caustic.filter(|_| params.caustic_photons > 0);
    let media = setting.scene.media();
    let build = |shot| VolumeMaps::build(shot, media, params.volume_lookup, Order::Tree);
    Ok(Photons { global: saved.global, caustic, volume: saved.volume.map(build), order })
}
