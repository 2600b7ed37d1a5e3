//! Upper bounds of BSDFs over boxes of directions.

use super::*;

/// A box around the point at `distance` along `d`, and points inside it, including that point.
fn box_along(d: Vec3, distance: f32, rng: &mut Pcg) -> (Bounds, Vec<Vec3>) {
    let unit = |rng: &mut Pcg| Vec3::from_array([0; 3].map(|_| rng.next_f32()));
    // The boxes are flat, small, or large enough to contain the origin.
    let size = distance * 10f32.powf(3.5 * rng.next_f32() - 3.0);
    let extent = unit(rng).map(|u| if u < 0.3 { 0.0 } else { u * size });
    let min = d * distance - extent * unit(rng);
    let bounds = Bounds { min, max: min + extent };
    let inside = |p: Vec3| p.clamp(bounds.min, bounds.max);
    let mut points = vec![inside(d * distance), inside(Vec3::ZERO)];
    points.extend((0..8).map(|_| bounds.min + extent * unit(rng)));
    (bounds, points)
}

#[test]
fn no_direction_into_a_box_scatters_more_than_its_bound() {
    let mut rng = Pcg::new(11, 4);
    let (mut cases, mut tight) = (0u32, 0u32);
    for (name, materials, _) in materials().into_iter().chain(sharp_materials()) {
        let (scene, surface) = floor(materials);
        for _ in 0..4000 {
            let wo = warp::sphere(rng.next_2d());
            // Also test grazing directions.
            let flatten = if rng.next_f32() < 0.3 { 0.02 } else { 1.0 };
            let wo = Vec3::new(wo.x, wo.y, wo.z * flatten).normalize();
            let transport =
                if rng.next_f32() < 0.5 { Transport::Radiance } else { Transport::Power };
            let bsdf = scene.bsdf(&surface, wo, transport);
            let drawn = bsdf.sample(wo, rng.next_f32(), rng.next_2d()).map(|s| s.wi);
            let d = drawn.filter(|_| rng.next_f32() < 0.7).unwrap_or(warp::sphere(rng.next_2d()));
            let distance = 10f32.powf(4.0 * rng.next_f32() - 2.0);
            let (bounds, points) = box_along(d, distance, &mut rng);
            // Also test with an origin that makes the coordinates inaccurate.
            let p = Vec3::new(0.3, 0.1, 0.0) * if rng.next_f32() < 0.5 { 0.0 } else { distance };
            let moved = Bounds { min: bounds.min + p, max: bounds.max + p };
            let bound = bsdf.bound(wo, &Toward::new(p, &moved));
            for q in points {
                let Some(wi) = ((q + p).clamp(moved.min, moved.max) - p).try_normalize() else {
                    continue;
                };
                for (value, most) in [(bsdf.f(wo, wi), bound.f), (bsdf.f_cos(wo, wi), bound.f_cos)]
                {
                    let holds = value.r <= most.r && value.g <= most.g && value.b <= most.b;
                    assert!(
                        holds,
                        "{name}: {value:?} is above the bound {most:?}, wo {wo}, wi {wi}, {bounds:?}"
                    );
                    cases += 1;
                    tight += u32::from(value.max() > 0.5 * most.max());
                }
            }
        }
    }
    // A bound that is far too large would pass too, so require cases near the bound.
    assert!(tight > cases / 8, "{tight} of {cases} within a factor of two");
}

/// Sharp lobes, which are inaccurate in single precision.
fn sharp_materials() -> Vec<(&'static str, Vec<Material>, bool)> {
    use Distribution::{Beckmann, Ggx};
    let mut all = Vec::new();
    for (name, alpha_u, alpha_v) in
        [("0.001", 0.001, 0.001), ("0.02", 0.02, 0.02), ("0.9, 0.05", 0.9, 0.05), ("1.3", 1.3, 1.3)]
    {
        for distribution in [Ggx, Beckmann] {
            all.push((name, vec![metal(rough(distribution, alpha_u, alpha_v))], false));
            all.push((name, vec![glass(rough(distribution, alpha_u, alpha_v))], false));
        }
    }
    all
}
