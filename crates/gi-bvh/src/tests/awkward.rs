//! Unusual rays, scales and positions.

use std::sync::Arc;

use super::*;

fn quad_at(z: f32) -> Vec<Triangle> {
    mesh(
        &[
            Vec3::new(-1.0, -1.0, z),
            Vec3::new(1.0, -1.0, z),
            Vec3::new(1.0, 1.0, z),
            Vec3::new(-1.0, 1.0, z),
        ],
        &[[0, 1, 2], [0, 2, 3]],
    )
}

#[test]
fn signed_zero_and_denormal_components_hit() {
    let tiny = [0.0, -0.0, 1e-40, -1e-40, f32::MIN_POSITIVE, 1e-20, -1e-20];
    for_each_kernel(build(&closed_box(Vec3::splat(-1.0), Vec3::splat(1.0))), |bvh, isa| {
        let mut rng = Pcg::new(1, 0);
        for k in 0..3000 {
            let mut d = Vec3::splat(tiny[k % 7]);
            d[(k / 7 + 1) % 3] = tiny[(k / 21) % 7];
            d[k % 3] = if k % 2 == 0 { 1.0 } else { -1.0 };
            let ray = Ray::new(in_cube(&mut rng) * 0.99, d);
            let hit =
                bvh.closest(&ray).unwrap_or_else(|| panic!("{isa:?}: {ray:?} leaves the box"));
            let p = ray.at(hit.t).abs().max_element();
            assert!((p - 1.0).abs() < 1e-6 && bvh.occluded(&ray), "{isa:?}: {ray:?} hits at {p}");
        }
    });
}

#[test]
fn rays_that_are_not_numbers_hit_nothing() {
    for_each_kernel(build(&icosphere(2)), |bvh, isa| {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let (mut o, mut d) = (Vec3::ZERO, Vec3::X);
                o[axis] = bad;
                d[axis] = bad;
                for ray in [Ray::new(o, Vec3::X), Ray::new(Vec3::ZERO, d), Ray::new(o, d)] {
                    assert!(bvh.closest(&ray).is_none() && !bvh.occluded(&ray), "{isa:?}: {ray:?}");
                }
            }
        }
        let ray = Ray::new(Vec3::ZERO, Vec3::X);
        let empty = [
            Ray { tmin: f32::NAN, ..ray },
            Ray { tmax: f32::NAN, ..ray },
            Ray { tmin: 2.0, tmax: 1.0, ..ray },
            Ray { d: Vec3::ZERO, ..ray },
        ];
        for ray in empty {
            assert!(bvh.closest(&ray).is_none() && !bvh.occluded(&ray), "{isa:?}: {ray:?}");
        }
    });
}

#[test]
fn the_interval_is_open_below_and_closed_above() {
    let solids = [
        (Solid::Sphere { center: Vec3::ZERO, radius: 2.0 }, 7),
        (Solid::Disk { center: Vec3::Z * 3.0, du: Vec3::X, dv: Vec3::Y }, 8),
        (
            Solid::Cylinder {
                p0: Vec3::new(-1.0, 0.0, 5.0),
                p1: Vec3::new(1.0, 0.0, 5.0),
                radius: 1.0,
            },
            9,
        ),
        (
            Solid::Instance {
                tree: Arc::new(build(&quad_at(0.0))),
                to_world: Affine3A::from_translation(Vec3::Z * 7.0),
                index: 3,
            },
            10,
        ),
    ];
    let crossings = [1.0, 2.0, 3.0, 4.0, 6.0, 7.0];
    let bvh = Bvh::build(&quad_at(1.0), &solids).expect("sound input");
    for_each_kernel(bvh, |bvh, isa| {
        let ray = |tmin, tmax| Ray { o: Vec3::new(0.25, 0.0, 0.0), tmin, d: Vec3::Z, tmax };
        let mut at = 0.0;
        let mut seen = Vec::new();
        while let Some(hit) = bvh.closest(&ray(at, f32::INFINITY)) {
            // An interval that ends at a hit includes it; intervals after it, or before it, do not.
            assert_eq!(bvh.closest(&ray(at, hit.t)), Some(hit), "{isa:?}");
            assert!(
                bvh.occluded(&ray(at, hit.t)) && !bvh.occluded(&ray(at, hit.t.next_down())),
                "{isa:?}"
            );
            assert!(bvh.closest(&ray(at, hit.t.next_down())).is_none(), "{isa:?}");
            seen.push(hit.t);
            at = hit.t;
        }
        let expected = |(a, b): (&f32, &f32)| (a - b).abs() < 0.07;
        assert!(seen.len() == 6 && seen.iter().zip(&crossings).all(expected), "{isa:?}: {seen:?}");
    });
}

#[test]
fn negative_parameters_count_when_asked_for() {
    for_each_kernel(build(&quad_at(-2.0)), |bvh, isa| {
        let ray = Ray { o: Vec3::new(0.1, 0.2, 0.0), tmin: -5.0, d: Vec3::Z, tmax: -1.0 };
        assert_eq!(bvh.closest(&ray).map(|h| h.t), Some(-2.0), "{isa:?}");
    });
}

/// Rays from far outside toward a sphere. Each is aimed well inside the silhouette, so that all must hit.
#[test]
fn far_origins_hit() {
    let sphere = icosphere(4);
    for (scale, shift) in [
        (1.0, Vec3::ZERO),
        (1e-4, Vec3::ZERO),
        (1e4, Vec3::ZERO),
        (1.0, Vec3::new(100.0, -53.0, 78.0)),
    ] {
        for_each_kernel(build(&mapped(&sphere, |p| p * scale + shift)), |bvh, isa| {
            let mut rng = Pcg::new(4, 0);
            for k in 0..4000 {
                let distance = scale * [1.5, 3.0, 4.0, 1e2, 1e4, 1e5][k % 6];
                let (o, at) = (
                    on_sphere(&mut rng) * distance + shift,
                    in_cube(&mut rng) * 0.5 * scale + shift,
                );
                let d = (at - o) * [1.0, 1e-9, 1e9][k % 3];
                let ray = Ray::new(o, d);
                let hit = bvh.closest(&ray).unwrap_or_else(|| panic!("{isa:?}: {ray:?} misses"));
                // Absolute error of t in single precision, world units.
                let slack = 0.1 * scale + 1e-6 * distance;
                let (near, far) =
                    ((distance - scale - slack) / d.length(), (distance + slack) / d.length());
                assert!(
                    bvh.occluded(&ray) && hit.t >= near && hit.t <= far,
                    "{isa:?}: {ray:?} at {}",
                    hit.t
                );
                assert!(!bvh.occluded(&Ray { tmax: near, ..ray }), "{isa:?}: {ray:?}");
            }
        });
    }
}

#[test]
fn scaled_and_moved_scenes_give_the_same_hits() {
    let mut rng = Pcg::new(5, 0);
    let own = soup(&mut rng, 400, 0.3);
    let rays: Vec<Ray> =
        (0..3000).map(|_| Ray::new(in_cube(&mut rng), on_sphere(&mut rng))).collect();
    let expected: Vec<Option<u32>> = rays.iter().map(|r| build_hit(&build(&own), r)).collect();
    for (scale, shift, most_differ) in [
        (2f32.powi(-13), 0.0, 0),
        (2f32.powi(13), 0.0, 0),
        (1e-4, 0.0, 3),
        (1e4, 0.0, 3),
        (1.0, 100.0, 3),
    ] {
        let shift = Vec3::splat(shift);
        for_each_kernel(build(&mapped(&own, |p| p * scale + shift)), |bvh, isa| {
            let moved = |r: &Ray| Ray::new(r.o * scale + shift, r.d);
            let differ = rays
                .iter()
                .zip(&expected)
                .filter(|(r, e)| build_hit(bvh, &moved(r)) != **e)
                .count();
            assert!(
                differ <= most_differ,
                "{isa:?}, scale {scale}, shift {shift}: {differ} of 3000 rays differ"
            );
        });
    }
}

fn build_hit(bvh: &Bvh, ray: &Ray) -> Option<u32> {
    bvh.closest(ray).map(|h| h.prim)
}

/// A corridor with walls at exactly x = -1 and 1, and an end wall: axis-parallel rays at any distance from the walls.
#[test]
fn rays_along_walls_reach_the_end() {
    let mut corridor = mapped(&quad_at(0.0), |p| p + Vec3::Z * 2000.0);
    for k in 0..64u8 {
        let z = f32::from(k) * 31.25;
        for x in [-1.0, 1.0] {
            let v = [
                Vec3::new(x, -1.0, z),
                Vec3::new(x, 1.0, z + 31.25),
                Vec3::new(x, -1.0, z + 31.25),
            ];
            corridor.push(Triangle { v, id: 100 });
        }
    }
    for_each_kernel(build(&corridor), |bvh, isa| {
        for k in 0..2000u16 {
            let gap = 10f32.powf(-1.0 - 5.5 * f32::from(k) / 2000.0);
            let x = if k % 2 == 0 { 1.0 - gap } else { gap - 1.0 };
            let hit = bvh.closest(&Ray::new(Vec3::new(x, 0.1234, 0.5), Vec3::Z));
            assert!(
                hit.is_some_and(|h| (h.t - 1999.5).abs() < 1e-3),
                "{isa:?}, gap {gap}: {hit:?}"
            );
        }
    });
}
