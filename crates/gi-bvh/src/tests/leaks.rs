//! No ray leaks through a closed surface, and no ray hits the surface that it starts on.

use rayon::prelude::*;

use super::*;

/// A ray from inside the sphere of radius `room` around `center`, aimed at a point of an edge or at a corner.
fn aimed(rng: &mut Pcg, triangles: &[Triangle], center: Vec3, room: f32) -> Ray {
    let o = center + on_sphere(rng) * (room * rng.next_f32().cbrt());
    let t = &triangles[rng.next_below(triangles.len() as u32) as usize];
    let edge = rng.next_below(3) as usize;
    let along = if rng.next_below(8) == 0 { 0.0 } else { rng.next_f32() };
    let at = t.v[edge] + (t.v[(edge + 1) % 3] - t.v[edge]) * along;
    Ray::new(o, (at - o).normalize())
}

fn leaks(bvh: &Bvh, triangles: &[Triangle], center: Vec3, room: f32, rays: u64) -> u64 {
    const CHUNK: u64 = 10_000;
    let chunk = |k: u64| {
        let mut rng = Pcg::new(k, 3);
        let leak = |_: &u64| {
            let ray = aimed(&mut rng, triangles, center, room);
            bvh.closest(&ray).is_none() || !bvh.occluded(&ray)
        };
        (0..CHUNK).filter(leak).count() as u64
    };
    (0..rays / CHUNK).into_par_iter().map(chunk).sum()
}

/// Name, triangles, a centre and the radius of a sphere inside.
fn rooms(levels: u32) -> Vec<(&'static str, Vec<Triangle>, Vec3, f32)> {
    let sphere = icosphere(levels);
    let cut = |t: &Triangle| {
        let m = [(t.v[0] + t.v[1]) * 0.5, (t.v[1] + t.v[2]) * 0.5, (t.v[2] + t.v[0]) * 0.5];
        [[t.v[0], m[0], m[2]], [m[0], t.v[1], m[1]], [m[2], m[1], t.v[2]], m]
            .map(|v| Triangle { v, id: 0 })
    };
    let mut flat = closed_box(Vec3::splat(-1.0), Vec3::splat(1.0));
    for _ in 0..levels {
        flat = flat.iter().flat_map(cut).collect();
    }
    let turn = glam::Quat::from_rotation_y(0.5) * glam::Quat::from_rotation_x(0.3);
    let at = Vec3::new(100.37, -53.11, 77.77);
    vec![
        ("box", closed_box(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0)), Vec3::Y, 0.9),
        (
            "sphere",
            mapped(&sphere, |p| p + Vec3::new(0.37, -0.11, 0.77)),
            Vec3::new(0.37, -0.11, 0.77),
            0.5,
        ),
        ("moved sphere", mapped(&sphere, |p| p + at), at, 0.5),
        ("small sphere", mapped(&sphere, |p| p * 1e-4), Vec3::ZERO, 0.5e-4),
        ("large sphere", mapped(&sphere, |p| p * 1e4), Vec3::ZERO, 0.5e4),
        ("turned box, coplanar pieces", mapped(&flat, |p| turn * p), Vec3::ZERO, 0.9),
    ]
}

#[test]
fn no_ray_leaks_through_an_edge() {
    for (name, triangles, center, room) in rooms(4) {
        for_each_kernel(build(&triangles), |bvh, isa| {
            let count = leaks(bvh, &triangles, center, room, 200_000);
            assert_eq!(count, 0, "{name}, {isa:?}: {count} of 200,000 rays leak");
        });
    }
}

#[test]
#[ignore = "slow: 10^8 rays into each of six rooms"]
fn no_ray_of_a_hundred_million_leaks() {
    const RAYS: u64 = 100_000_000;
    for (name, triangles, center, room) in rooms(6) {
        let count = leaks(&build(&triangles), &triangles, center, room, RAYS);
        println!("{name}, {} triangles: {count} of {RAYS} edge-aimed rays leak", triangles.len());
        assert_eq!(count, 0, "{name}");
    }
}

/// Rays from outside, from about the distance at which origins are moved closer, aimed at edges that face them.
#[test]
fn no_ray_from_outside_slips_through_an_edge() {
    let sphere = icosphere(4);
    for_each_kernel(build(&sphere), |bvh, isa| {
        let mut rng = Pcg::new(12, 0);
        for k in 0..200_000 {
            let o = on_sphere(&mut rng) * [1.5, 1.99, 2.5, 3.5, 100.0, 1e4][k % 6];
            let target = aimed(&mut rng, &sphere, Vec3::ZERO, 0.0).d * 0.9;
            let ray = Ray::new(o, (target - o).normalize());
            // The line passes through the sphere of radius 0.9, so it must enter and leave.
            let hit = bvh.closest(&ray).unwrap_or_else(|| panic!("{isa:?}: {ray:?} misses"));
            let leave = Ray { tmin: hit.t + 0.1, ..ray };
            assert!(bvh.closest(&leave).is_some(), "{isa:?}: {leave:?} stays inside");
        }
    });
}

/// Bounce rays with a cosine distribution, and count the hits on the triangle that the ray left.
fn bounces_that_stay(bvh: &Bvh, triangles: &[Triangle], center: Vec3, rays: u32) -> u32 {
    let mut rng = Pcg::new(13, 0);
    let mut stay = 0;
    let mut ray = Ray::new(center, on_sphere(&mut rng));
    for _ in 0..rays {
        let hit = bvh.closest(&ray).expect("the room is closed");
        let [a, b, c] = triangles[hit.prim as usize].v;
        let ng = (b - a).cross(c - a).normalize();
        let ng = if ng.dot(ray.d) > 0.0 { -ng } else { ng };
        let p = a + (b - a) * hit.u + (c - a) * hit.v;
        let [u, v] = rng.next_2d();
        let (s, c) = (v * std::f32::consts::TAU).sin_cos();
        let (x, y) = ng.any_orthonormal_pair();
        let d = x * (u.sqrt() * c) + y * (u.sqrt() * s) + ng * (1.0 - u).sqrt();
        let before = hit.prim;
        ray = Ray::new(bvh.offset_origin(p, ng, d), d);
        stay += u32::from(bvh.closest(&ray).is_some_and(|h| h.prim == before));
    }
    stay
}

#[test]
fn bounces_leave_the_triangle_they_start_on() {
    let sphere = icosphere(5);
    let displaced = |p: Vec3| {
        let wave =
            |f: f32| ((p * f).x.sin() * (p * f).y.cos() + (p * f).y.sin() * (p * f).z.cos()) / 2.0;
        p * (1.0 + 0.2 * wave(3.0) + 0.05 * wave(17.0))
    };
    for (scale, shift) in [
        (1.0, Vec3::ZERO),
        (1e-4, Vec3::ZERO),
        (1e4, Vec3::ZERO),
        (1.0, Vec3::new(100.0, -37.0, 55.0)),
    ] {
        let cave = mapped(&sphere, |p| displaced(p) * scale + shift);
        let stay = bounces_that_stay(&build(&cave), &cave, shift, 100_000);
        assert_eq!(stay, 0, "scale {scale}, shift {shift}: {stay} of 100,000 bounces");
    }
}

/// A tilted floor through the world's origin: the coordinates vanish there, but the rounding error of the point does
/// not.
#[test]
fn bounces_leave_a_tilted_floor_at_the_origin() {
    let turn = glam::Quat::from_rotation_z(0.3) * glam::Quat::from_rotation_x(0.7);
    let corner = |x: f32, z: f32| turn * Vec3::new(x, 0.0, z);
    let floor = mesh(&[corner(-1.0, -1.0), corner(1.0, -0.9), corner(0.8, 1.0)], &[[0, 1, 2]]);
    let [a, b, c] = floor[0].v;
    let ng = (b - a).cross(c - a).normalize();
    let bvh = build(&floor);
    let mut rng = Pcg::new(14, 0);
    let mut stay = 0;
    for _ in 0..100_000 {
        let near = on_sphere(&mut rng) * 10f32.powf(-6.0 * rng.next_f32());
        let Some(hit) = bvh.closest(&Ray::new(near + ng * 2.0, -ng)) else { continue };
        let p = a + (b - a) * hit.u + (c - a) * hit.v;
        let d = (on_sphere(&mut rng) + ng).normalize();
        stay += u32::from(bvh.occluded(&Ray::new(bvh.offset_origin(p, ng, d), d)));
    }
    assert_eq!(stay, 0, "{stay} of 100,000 bounces stay");
}

/// Shadow rays between two points of one convex room are never blocked by the surfaces at their ends.
#[test]
fn shadow_rays_reach_their_end_point() {
    for (scale, shift) in [
        (1.0, Vec3::ZERO),
        (1e-4, Vec3::ZERO),
        (1e4, Vec3::ZERO),
        (1.0, Vec3::new(100.0, -37.0, 55.0)),
    ] {
        let turn = glam::Quat::from_rotation_y(0.5) * glam::Quat::from_rotation_x(0.3);
        let room =
            mapped(&closed_box(Vec3::splat(-1.0), Vec3::splat(1.0)), |p| turn * p * scale + shift);
        let bvh = build(&room);
        let mut rng = Pcg::new(15, 0);
        let point = |rng: &mut Pcg| {
            let hit = bvh.closest(&Ray::new(shift, on_sphere(rng))).expect("the room is closed");
            let [a, b, c] = room[hit.prim as usize].v;
            let ng = (b - a).cross(c - a).normalize();
            let p = a + (b - a) * hit.u + (c - a) * hit.v;
            (p, if ng.dot(shift - p) < 0.0 { -ng } else { ng })
        };
        for _ in 0..50_000 {
            let ((p, np), (q, nq)) = (point(&mut rng), point(&mut rng));
            let w = (q - p).normalize();
            // At grazing angles, a light contributes almost nothing.
            if np.dot(w) < 0.03 || nq.dot(w) > -0.03 {
                continue;
            }
            let ray = bvh.shadow_ray(p, np, q);
            assert!(
                !bvh.occluded(&ray),
                "scale {scale}, shift {shift}: {p} to {q}: {:?}",
                bvh.closest(&ray)
            );
            // A wall half-way blocks the ray, and so does the wall at q if the ray is extended.
            assert!(
                bvh.occluded(&Ray { tmax: 1.01, ..ray }),
                "scale {scale}, shift {shift}: {p} to {q}"
            );
        }
    }
}

#[test]
fn shadow_rays_to_far_and_to_coincident_points() {
    let bvh = build(&closed_box(Vec3::splat(-1.0), Vec3::splat(1.0)));
    let (inside, above) = (Vec3::new(0.1, -1.0, 0.2), Vec3::new(0.1, 1.0, 0.2));
    for far in [1e3, 1e8, 1e18, 1e30] {
        assert!(
            bvh.occluded(&bvh.shadow_ray(inside, Vec3::Y, Vec3::new(0.3, far, 0.0))),
            "sky at {far}"
        );
        assert!(
            !bvh.occluded(&bvh.shadow_ray(above, Vec3::Y, Vec3::new(0.3, far, 0.0))),
            "sky at {far}"
        );
    }
    for near in [0.0, 1e-30, 1e-8, 1e-6] {
        assert!(
            !bvh.occluded(&bvh.shadow_ray(inside, Vec3::Y, inside + Vec3::Y * near)),
            "gap {near}"
        );
    }
    assert!(!bvh.occluded(&bvh.shadow_ray(Vec3::ZERO, Vec3::Y, Vec3::ZERO)));
}
