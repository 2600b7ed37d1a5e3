//! Aim light from infinity at the points that eye paths reach after the first gather point.
//!
//! The value of a photon is its effect on the picture. Eye paths that continue beyond gather points sample points in
//! proportion to that value. So the photons of a sun go where the picture needs them, even if the ground extends to the
//! horizon.

use gi_core::eye::EyeWalk;
use gi_core::light::{Light, Targets};
use gi_core::technique::Setting;
use glam::Vec3;
use rayon::prelude::*;

use crate::gather::covers;
use crate::params::Params;

/// Number of eye paths. This is few compared to a pass, because they only estimate where photons are needed, not how
/// bright the light is.
const PATHS: u32 = 4096;
/// Maximum number of surfaces per path.
const MOST_MET: u32 = 8;
/// Separates the random numbers of these paths from all others.
const STREAM: u32 = 0x6169_6d21;

/// The targets of photons; `None` if photons are not aimed.
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

/// Weighted points: where photons should be scattered, and where they are gathered.
type Walk = (Vec<(Vec3, f32)>, Vec<(Vec3, f32)>);

/// Follow one path from the eye.
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
