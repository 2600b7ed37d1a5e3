//! All illumination becomes point lights [slides 53, 61].

use std::time::{Duration, Instant};

use gi_core::film::Show;
use gi_core::options::Parameters;
use gi_core::progress;
use gi_core::technique::Setting;
use vpl::{Direct, Pilot, Shooting, Termination, Vpls, points, shoot};

use crate::params::Params;
use crate::tree::Forest;

/// The lights of a pass, and their trees.
#[derive(Default)]
pub(crate) struct PassLights {
    pub(crate) vpls: Vpls,
    pub(crate) forest: Forest,
    /// The pass that they were made for.
    pub(crate) pass: u32,
    /// Time for building the trees.
    pub(crate) building: Duration,
}

impl PassLights {
    /// Make the lights of a pass, and build their trees.
    pub(crate) fn make(setting: &Setting, params: &Params, pilot: Pilot, pass: u32) -> Self {
        let vpls = make_lights(setting, params, pilot, pass);
        let clock = Instant::now();
        let by_depth = params.limits.max_depth.is_some();
        progress::begin("light trees", 0);
        let forest = Forest::build(setting.scene, &vpls, by_depth, setting.seed ^ pass);
        PassLights { vpls, forest, pass, building: clock.elapsed() }
    }
}

/// The lights of a pass: points on light sources, and the lights that light paths leave on surfaces.
fn make_lights(setting: &Setting, params: &Params, pilot: Pilot, index: u32) -> Vpls {
    let Setting { scene, seed, .. } = *setting;
    let paths = pilot.paths_for(params.vpls);
    let how = Shooting {
        seed,
        first_path: index.wrapping_mul(paths),
        paths,
        termination: Termination::Roulette,
        // The eye ray and the connection are two of the segments that `max_depth` counts.
        max_scatterings: params.limits.max_depth.map(|d| d.saturating_sub(2)),
        lights: false,
        pilot,
        through_media: params.simulates_media(),
    };
    // A picture of direct light or caustics needs no lights on surfaces.
    let indirect = !matches!(setting.show, Show::Direct | Show::Caustic);
    let mut set = if indirect { shoot(scene, &how) } else { Vpls::default() };
    if params.direct == Direct::Vpl {
        let direct = points(scene, &params.lights, seed, index).lights;
        set.lights.splice(0..0, direct);
    }
    set
}
