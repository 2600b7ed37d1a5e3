//! What the benchmarks of lightcuts share: the scene, its lights, and points prepared for cuts.

use std::path::Path;
use std::time::Instant;

use gi_core::bsdf::Bsdf;
use gi_core::camera::Camera;
use gi_core::geometry::Surface;
use gi_core::scene::Scene;
use glam::Vec3;
use lightcuts::Params;
use lightcuts::bound::Site;
use lightcuts::light::At;
use vpl::{LightNumbers, Pilot, Receiver, Shooting, Termination, Vpls, points, shoot};

/// A point that is visible in the picture.
pub(crate) type Point<'a> = (Surface, Vec3, Bsdf<'a>);

/// The scene of the project that is measured unless another one is named.
pub(crate) const GALLERY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/gallery.xml");

/// Read a scene.
pub(crate) fn read(scene: &str, defines: &[(String, String)]) -> (Scene, Camera) {
    let options = gi_scene::Options { defines: defines.to_vec(), ..Default::default() };
    let loaded = gi_scene::load(Path::new(scene), &options);
    let loaded = loaded.unwrap_or_else(|problems| panic!("{problems}"));
    (Scene::new(loaded.parts).expect("a scene"), Camera::new(&loaded.camera))
}

/// The name and the value of a parameter of the scene, `NAME=VALUE`.
pub(crate) fn define(text: &str) -> (String, String) {
    let (name, value) = text.split_once('=').expect("-D name=value");
    (name.into(), value.into())
}

/// Points on light sources, and about `indirect` lights on surfaces.
pub(crate) fn make(scene: &Scene, direct: u32, indirect: u32) -> Vpls {
    let pilot = Pilot::of(scene, 0, false);
    let how = Shooting {
        seed: 0,
        first_path: 0,
        paths: pilot.paths_for(indirect.max(1)),
        termination: Termination::Roulette,
        max_scatterings: None,
        lights: false,
        pilot,
        through_media: false,
    };
    let mut set = if indirect > 0 { shoot(scene, &how) } else { Vpls::default() };
    let numbers = LightNumbers { total: direct, area: None, sky: None, sun: None };
    set.lights.splice(0..0, points(scene, &numbers, 0, 0).lights);
    set
}

/// Call `look` with a point prepared for cuts.
pub(crate) fn at<'a, T>(
    scene: &Scene,
    (surface, wo, bsdf): &Point<'a>,
    look: impl FnOnce(&At<'_, '_, 'a>) -> T,
) -> T {
    let most = Params::default().bound.clamp / (scene.radius() * scene.radius());
    look(&At {
        receiver: Receiver::new(surface, *wo, bsdf),
        site: Site::new(surface, *wo, bsdf, most),
        deepest: u32::MAX,
        direct: true,
    })
}

/// A clock for one thread. It uses the thread's CPU time if the system reports it, so that other threads do not count;
/// short spans use wall-clock time.
pub(crate) struct Clock(Instant, Option<u64>);

impl Clock {
    pub(crate) fn start() -> Self {
        Clock(Instant::now(), Self::own())
    }

    /// Seconds since the start.
    pub(crate) fn seconds(&self) -> f64 {
        let wall = self.0.elapsed().as_secs_f64();
        match (self.1, Self::own()) {
            (Some(before), Some(now)) if wall > 0.05 => (now - before) as f64 * 1e-9,
            _ => wall,
        }
    }

    /// CPU time of the thread in nanoseconds. Linux updates it at its clock ticks.
    fn own() -> Option<u64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        text.split(' ').next()?.parse().ok()
    }
}
