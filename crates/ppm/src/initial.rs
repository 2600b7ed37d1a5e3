//! Initial radii.

use gi_core::disc::Disc;
use gi_core::film::PerPixel;
use gi_core::geometry::Surface;
use gi_core::math::{Rgb, median};
use gi_core::scene::Scene;
use glam::Vec3;

use crate::gather::{Point, radius_of};
use crate::methods::Method;
use crate::photons::{Photon, Photons, SAME_SURFACE};
use crate::region::{Look, Region};
use crate::statistics::Statistics;

/// Number of the pilot pass that the radii are derived from. It is not added to the picture.
pub(crate) const PILOT: u32 = u32::MAX;
/// Cap on the automatic radius, relative to min(scene radius, length of the eye path).
const MOST: f32 = 0.03;
/// Smallest automatic radius, in pixel widths at the end of the eye path.
const LEAST_PIXELS: f32 = 1.0;
/// Fraction of a disc that must lie on its surface, and number of probes to test it. A disc that extends beyond its
/// surface, such as over a narrow slat, is shrunk.
const LEAST_COVERED: f32 = 0.75;
const PROBES: u32 = 16;
/// Factor by which such a disc shrinks per step.
const STEP: f32 = 0.7;

/// Number of pixels whose radius is limited, so that it does not contain the wanted number of photons.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AtBounds {
    pub(crate) least: u64,
    pub(crate) most: u64,
}

/// Initial regions from the photons of the pilot pass.
pub(crate) fn regions(look: &Look, photons: &[Vec<Photon>]) -> (PerPixel<Region>, AtBounds) {
    let (scene, camera, params) = (look.setting.scene, look.setting.camera, look.params);
    let mut bounds = AtBounds::default();
    let size = camera.size();
    let radii = if params.initial_radius > 0.0 {
        let radius = f64::from(params.initial_radius * scene.radius());
        PerPixel::new(size, |_| radius)
    } else {
        // This holds if photons are uniform on the sphere around the scene: pi r^2 / (4 pi R^2) = k / n.
        let stored = photons.iter().map(Vec::len).sum::<usize>().max(1);
        let share = params.initial_photons as f32 / stored as f32;
        let guess = scene.radius() * (2.0 * share.sqrt()).min(MOST);
        let grid = Photons::build(photons, guess);
        let found = PerPixel::new(size, |at| nearest(look, at, &grid, guess));
        for n in found.rows().flatten() {
            bounds.least += u64::from(n.radius <= n.least);
            bounds.most += u64::from(n.radius >= n.most);
        }
        let median =
            median(found.rows().flatten().map(|n| n.radius)).unwrap_or(0.01 * scene.radius());
        PerPixel::new(size, |at| match found.get(at) {
            // With the same radius for all pixels, passes do not depend on each other.
            Some(n) if params.method != Method::Ppa => f64::from(n.radius),
            _ => f64::from(median),
        })
    };
    let regions = PerPixel::new(size, |at| {
        let initial = *radii.get(at);
        let hits = match params.method {
            Method::Ppm => look.hit_points(at, params.hit_points, initial),
            _ => Vec::new(),
        };
        Region { statistics: Statistics::new(initial), initial, hits, ..Region::default() }
    });
    (regions, bounds)
}

/// The radius that contains the wanted number of photons, and its limits.
#[derive(Clone, Copy)]
struct Nearest {
    radius: f32,
    least: f32,
    most: f32,
}

/// Search around the first gather point of a pixel.
fn nearest(look: &Look, at: [usize; 2], grid: &Photons, guess: f32) -> Option<Nearest> {
    let setting = look.setting;
    let count = look.params.initial_photons as usize;
    let mut walk = look.walk(at, PILOT);
    while let Some(v) = &walk.next_vertex() {
        if let Some(covers) = look.covers(v) {
            let most = MOST * v.length.min(setting.scene.radius());
            let least = (LEAST_PIXELS * setting.camera.pixel_width_at(v.length))
                .clamp(f32::MIN_POSITIVE, most);
            let point = Point {
                surface: &v.surface,
                wo: v.wo,
                bsdf: &v.bsdf,
                covers,
                max_segments: None,
                throughput: Rgb::WHITE,
            };
            if let Some(radius) = radius_of(grid, &point, count, guess, [least, most]) {
                let radius = on_surface(setting.scene, (&v.surface, v.wo), [least, radius]);
                return Some(Nearest { radius, least, most });
            }
            walk.add_estimate(v, look.nothing(covers));
        }
        walk.skip_direct(v);
        if !walk.scatter(v) {
            break;
        }
    }
    None
}

/// Shrink the radius until the disc lies on its surface: beyond an edge there are no photons.
fn on_surface(
    scene: &Scene,
    (surface, wo): (&Surface, Vec3),
    [least, mut radius]: [f32; 2],
) -> f32 {
    let n = surface.ng * 1f32.copysign(wo.dot(surface.ng));
    let covered = |radius| {
        Disc::new(scene, surface.p, n, radius, SAME_SURFACE).lowered().share(PROBES, [0.0; 2])
    };
    while radius > least && covered(radius) < LEAST_COVERED {
        radius = (STEP * radius).max(least);
    }
    radius
}
