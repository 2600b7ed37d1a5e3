use gi_core::warp;
use glam::Vec3;

use crate::grid::{check, check_edged};

#[test]
fn warps_of_directions() {
    check("sphere", 1, |r| Some(warp::sphere(r.next_2d())), |_| warp::sphere_pdf());
    let folded = |u: [f32; 2]| warp::folded_sphere(u.into());
    check("folded_sphere", 8, |r| Some(folded(r.next_2d())), |_| warp::sphere_pdf());
    check(
        "hemisphere",
        2,
        |r| Some(warp::hemisphere(r.next_2d())),
        |w| {
            if w.z > 0.0 { warp::hemisphere_pdf() } else { 0.0 }
        },
    );
    check(
        "cosine hemisphere",
        3,
        |r| Some(warp::cosine_hemisphere(r.next_2d())),
        |w| warp::cosine_hemisphere_pdf(w.z),
    );
    // Sizes whose rim coincides with borders of cells.
    for (seed, size) in [(4, 1.0 / 6.0f32), (5, 0.5), (6, 10.0 / 6.0)] {
        check(
            &format!("cone {size}"),
            seed,
            |r| Some(warp::cone(r.next_2d(), size)),
            |w| {
                if 1.0 - w.z <= size { warp::cone_pdf(size) } else { 0.0 }
            },
        );
    }
}

#[test]
fn phase_functions() {
    use gi_core::medium::Phase;
    let wo = Vec3::new(0.6, -0.64, 0.48);
    let phases = [-0.7, 0.0, 0.3, 0.9].map(|g| Phase::HenyeyGreenstein { g });
    for (k, phase) in phases.into_iter().chain([Phase::Isotropic]).enumerate() {
        let name = format!("{phase:?}");
        check(&name, 30 + k as u64, |r| Some(phase.sample(wo, r.next_2d())), |w| phase.eval(wo, w));
    }
}

#[test]
fn spherical_triangles() {
    let triangles = [
        [Vec3::X, Vec3::Y, Vec3::Z],
        [Vec3::new(1.0, 0.2, 0.1), Vec3::new(-0.3, 1.0, 0.2), Vec3::new(0.1, -0.4, -1.0)],
        [Vec3::new(1.0, 0.0, 0.3), Vec3::new(0.9, 0.3, 0.35), Vec3::new(0.2, 0.1, 1.0)],
    ];
    for (k, t) in triangles.into_iter().enumerate() {
        let [a, b, c] = t.map(Vec3::normalize);
        let side = a.dot(b.cross(c)).signum();
        let inside = |w: Vec3| {
            [(a, b), (b, c), (c, a)].iter().all(|(p, q)| w.dot(p.cross(*q)) * side >= -1e-5)
        };
        let omega = warp::solid_angle(a, b, c);
        let pdf = 1.0 / omega;
        check_edged(
            &format!("spherical triangle {k}"),
            10 + k as u64,
            |r| warp::spherical_triangle(r.next_2d(), a, b, c, omega),
            |w| {
                if inside(w) { pdf } else { 0.0 }
            },
        );
    }
}

#[test]
fn the_disk_and_the_triangle_are_uniform() {
    let mut rng = gi_core::rng::Pcg::new(20, 0);
    let (n, cells) = (100_000u32, 64);
    let mut disk = vec![0u64; cells];
    let mut triangle = vec![0u64; cells];
    for _ in 0..n {
        // Equal-area cells: squared radius and angle; for the triangle 1 - (1 - s)^2 and t / (1 - s).
        let p = warp::disk(rng.next_2d());
        let (r, phi) = (p.length_squared(), p.y.atan2(p.x) / std::f32::consts::TAU + 0.5);
        disk[((r * 8.0) as usize).min(7) * 8 + ((phi * 8.0) as usize).min(7)] += 1;
        let [s, t] = warp::triangle(rng.next_2d());
        let (x, y) = (1.0 - (1.0 - s) * (1.0 - s), t / (1.0 - s));
        triangle[((x * 8.0) as usize).min(7) * 8 + ((y * 8.0) as usize).min(7)] += 1;
    }
    for (name, counts) in [("disk", disk), ("triangle", triangle)] {
        let found = gi_stats::chi2_test(&counts, &vec![f64::from(n) / cells as f64; cells])
            .expect("all possible");
        assert!(found.p_value > 1e-4, "{name}: {found:?}");
    }
}
