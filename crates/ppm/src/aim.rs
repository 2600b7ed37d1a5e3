//! Where light from infinity is aimed: at what the eye's paths meet behind the first point where photons are gathered.
//!
//! A photon is worth what the picture makes of it. Paths from the eye, going on where they gather, end up at points in
//! proportion to that; a sun that lights ground to the horizon sends its photons there.

use gi_core::eye::EyeWalk;
use gi_core::light::{Light, Targets};
use gi_core::technique::Setting;
use glam::Vec3;
use rayon::prelude::*;

use crate::gather::covers;
use crate::params::Params;

/// Paths from the eye. They are few beside those of a pass, and say about where, not how bright.
const PATHS: u32 = 4096;
/// Surfaces that one meets at most.
const MOST_MET: u32 = 8;
/// Makes the numbers of these paths differ from those of all others.
const STREAM: u32 = 0x6169_6d21;

/// What photons are aimed at; `None` where they begin as ever.
pub(crate) fn targets(setting: &Setting, params: &Params) -> Option<Targets> {
    if !setting.scene.lights().all().iter().any(Light::is_infinite) {
        return None;
    }
    let walks: Vec<Walk> =
        (0..PATHS).into_par_iter().map(|path| walk(setting, params, path)).collect();
    let (met, ends) = walks.into_iter().unzip::<_, _, Vec<_>, Vec<_>>();
    let [met, ends] = [met, ends].map(|lists| lists.into_iter().flatten().collect());
    setting.scene.around([met, ends])
}

/// Points and what photons there would be worth: where they would have to be scattered, and where they would be gathered.
type Walk = (Vec<(Vec3, f32)>, Vec<(Vec3, f32)>);

/// Walk a path from the eye.
fn walk(setting: &Setting, params: &Params, path: u32) -> Walk {
    let (mut met, mut ends) = (Vec::new(), Vec::new());
    let mut gathered = params.direct_by_photons;
    let mut walk = EyeWalk::through_picture(setting, STREAM, path);
    for _ in 0..MOST_MET {
        let Some(v) = &walk.next_vertex() else { break };
        if !walk.scatter(v) {
            break;
        }
        let point = (v.surface.p, walk.throughput().luminance());
        let passes_straight = walk.segments() == v.segments;
        if gathered && !passes_straight {
            met.push(point);
        }
        if !v.bsdf.is_delta() && covers(&v.bsdf, v.wo, params.min_roughness).is_some() {
            if ends.is_empty() {
                ends.push(point);
            }
            gathered = true;
        }
    }
    (met, ends)
}
