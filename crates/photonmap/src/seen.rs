//! Find the points where the maps will be read, by paths from the eye. Photons are aimed at them, they limit the radii, and
//! irradiance is precomputed at them.

use gi_core::bsdf::Bsdf;
use gi_core::eye::EyeWalk;
use gi_core::light::{Light, Targets};
use gi_core::technique::Setting;
use glam::Vec3;
use rayon::prelude::*;

use crate::estimate::{Place, facing};
use crate::params::{Gather, Params};

/// Number of paths that aim photons from infinity. They tell roughly where, not how bright.
const PATHS: u32 = 4096;
/// Maximum number of surfaces per path.
const MOST_MET: u32 = 8;
/// Separates the random numbers of these paths from all others.
const STREAM: u32 = 0x7365_656e;
/// Number of rounds in which places are looked for. Many paths may leave the scene.
const ROUNDS: u32 = 4;

/// Weighted points: where photons should be scattered, and where they are read.
type Walk = (Vec<(Vec3, f32)>, Vec<(Vec3, f32)>);

impl Gather {
    /// Number of diffuse surfaces on the path before the one where the global map is read.
    fn skipped(self) -> u32 {
        u32::from(self == Gather::Final)
    }

    /// Number of diffuse surfaces on the path before the first where photons give the direct light.
    fn sampled(self) -> u32 {
        u32::from(self != Gather::None)
    }

    /// Whether a surface has a part that a map covers.
    fn answers(self, bsdf: &Bsdf, wo: Vec3) -> bool {
        match self {
            Gather::None | Gather::Direct => !bsdf.is_delta(),
            Gather::Final => bsdf.diffuse_part(wo).is_some(),
        }
    }
}

/// Targets of light from infinity; `None` if there is no such light.
pub(crate) fn targets(setting: &Setting, params: &Params) -> Option<Targets> {
    if !setting.scene.lights().all().iter().any(Light::is_infinite) {
        return None;
    }
    let walks: Vec<Walk> =
        (0..PATHS).into_par_iter().map(|path| walk(setting, params.gather, path)).collect();
    let (met, ends) = walks.into_iter().unzip::<_, _, Vec<_>, Vec<_>>();
    let [met, ends] = [met, ends].map(|lists| lists.into_iter().flatten().collect());
    setting.scene.around([met, ends])
}

fn walk(setting: &Setting, gather: Gather, path: u32) -> Walk {
    let (mut met, mut ends, mut answered) = (Vec::new(), Vec::new(), 0);
    let mut walk = EyeWalk::through_picture(setting, STREAM, path);
    for _ in 0..MOST_MET {
        let Some(v) = &walk.next_vertex() else { break };
        if !walk.scatter(v) {
            break;
        }
        let point = (v.surface.p, walk.throughput().luminance());
        let passes_straight = walk.segments() == v.segments;
        if answered >= gather.sampled() && !passes_straight {
            met.push(point);
        }
        if gather.answers(&v.bsdf, v.wo) {
            if answered == gather.skipped() {
                ends.push(point);
            }
            answered += 1;
        }
    }
    (met, ends)
}

/// At most `count` points at which the global map will be read.
pub(crate) fn places(setting: &Setting, gather: Gather, count: usize) -> Vec<Place> {
    let mut places = Vec::with_capacity(count);
    for round in 0..ROUNDS {
        let paths = round * count as u32..(round + 1) * count as u32;
        let found: Vec<Option<Place>> =
            paths.into_par_iter().map(|path| place(setting, gather, path)).collect();
        places.extend(found.into_iter().flatten().take(count - places.len()));
        if places.len() == count {
            break;
        }
    }
    places
}

fn place(setting: &Setting, gather: Gather, path: u32) -> Option<Place> {
    let mut walk = EyeWalk::through_picture(setting, STREAM ^ 1, path);
    let mut answered = 0;
    for _ in 0..MOST_MET {
        let v = &walk.next_vertex()?;
        if gather.answers(&v.bsdf, v.wo) {
            if answered == gather.skipped() {
                return Some((v.surface.p, facing(&v.surface, v.wo)));
            }
            answered += 1;
        }
        if !walk.scatter(v) {
            break;
        }
    }
    None
}
