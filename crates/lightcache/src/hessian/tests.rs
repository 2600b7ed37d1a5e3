use super::*;
use crate::hemisphere::Strata;
use crate::hemisphere::tests::hemisphere;

#[test]
fn edge_derivatives_are_finite_differences() {
    let gamma = |a: DVec3, b: DVec3| {
        let c = a.cross(b);
        c.length().atan2(a.dot(b)) * c.z / c.length()
    };
    let cases = [
        (DVec3::new(0.3, -0.2, 1.1), DVec3::new(-0.6, 0.5, 0.7)),
        (DVec3::new(0.3, -0.2, 1.1), DVec3::new(0.31, -0.19, 1.12)),
        (DVec3::new(2.0, 1.0, 0.1), DVec3::new(-2.0, 1.0, 0.1)),
        (DVec3::new(0.3, -0.2, 1.1), DVec3::new(0.61, -0.39, 2.2)),
    ];
    for (a, b) in cases {
        let at = |x: f64, y: f64| gamma(a - DVec3::new(x, y, 0.0), b - DVec3::new(x, y, 0.0));
        let (g, h) = edge_derivatives(a, b);
        let d = 1e-3;
        let numeric = DVec2::new(at(d, 0.0) - at(-d, 0.0), at(0.0, d) - at(0.0, -d)) / (2.0 * d);
        assert!((g - numeric).length() < 1e-5 * (1.0 + numeric.length()), "{g} is not {numeric}");
        let xx = (at(d, 0.0) - 2.0 * at(0.0, 0.0) + at(-d, 0.0)) / (d * d);
        let yy = (at(0.0, d) - 2.0 * at(0.0, 0.0) + at(0.0, -d)) / (d * d);
        let xy = (at(d, d) - at(d, -d) - at(-d, d) + at(-d, -d)) / (4.0 * d * d);
        for (found, exact) in [(h.x_axis.x, xx), (h.y_axis.y, yy), (h.x_axis.y, xy)] {
            assert!(
                (found - exact).abs() < 2e-4 * (1.0 + exact.abs()),
                "{found} is not {exact}: {a}, {b}"
            );
        }
    }
}

/// A smooth ceiling at height 1 whose radiance grows with x^2, for which both Hessians should agree.
fn bowl(w: Vec3) -> (Rgb, f32, Vec3) {
    let q = w / w.z;
    let bright = (-(q.x - 0.3).powi(2) - 0.5 * q.y * q.y).exp();
    (Rgb::grey(bright), q.length(), -Vec3::Z)
}

/// E of this ceiling at a moved point, by brute force.
fn bowl_irradiance(x: f64, y: f64) -> f64 {
    let (n, reach) = (800, 5.0);
    let step = 2.0 * reach / f64::from(n);
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let q = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) * step - reach;
            let l = (-(q.x - 0.3).powi(2) - 0.5 * q.y * q.y).exp();
            let r_sq = (q.x - x).powi(2) + (q.y - y).powi(2) + 1.0;
            sum += l / (r_sq * r_sq);
        }
    }
    sum * step * step
}

#[test]
fn both_hessians_and_the_mesh_gradient_are_those_of_a_smooth_ceiling() {
    let e = bowl_irradiance;
    let d = 0.02;
    let xx = (e(d, 0.0) - 2.0 * e(0.0, 0.0) + e(-d, 0.0)) / (d * d);
    let yy = (e(0.0, d) - 2.0 * e(0.0, 0.0) + e(0.0, -d)) / (d * d);
    let gx = (e(d, 0.0) - e(-d, 0.0)) / (2.0 * d);
    // Use many rays: both are compared with the exact value, and the mesh must be fine.
    let runs: Vec<_> = (0..8).map(|s| hemisphere(Strata::of(20_000), s, bowl)).collect();
    let mean = |f: &dyn Fn(&Hemisphere) -> f64| runs.iter().map(f).sum::<f64>() / 8.0;
    for (name, found, exact) in [
        ("geometric xx", mean(&|h| geometric(h).x_axis.x), xx),
        ("geometric yy", mean(&|h| geometric(h).y_axis.y), yy),
        ("occlusion xx", mean(&|h| occlusion(h).1.x_axis.x), xx),
        ("occlusion yy", mean(&|h| occlusion(h).1.y_axis.y), yy),
        ("mesh gradient x", mean(&|h| f64::from(occlusion(h).0.0[0].x)), gx),
    ] {
        assert!((found / exact - 1.0).abs() < 0.05, "{name}: {found} is not {exact}");
    }
}

#[test]
fn under_a_constant_sky_all_derivatives_are_zero() {
    let h = hemisphere(Strata::of(500), 4, |w| (Rgb::WHITE, 1.0 + w.z, -w));
    let (gradient, hessian) = occlusion(&h);
    assert!(gradient.0[1].length() < 1e-6 && hessian.x_axis.length() < 1e-6);
}

#[test]
fn eigenvalues_and_vectors() {
    let turn = DMat2::from_angle(0.4);
    for (large, small) in [(3.0, 1.0), (-3.0, 1.0), (2.0, -0.5), (-2.0, -0.1), (1.0, 0.0)] {
        let h = turn * DMat2::from_diagonal(DVec2::new(large, small)) * turn.transpose();
        let ([l, s], v) = eigen(h);
        assert!((l - large).abs() < 1e-9 && (s - small).abs() < 1e-9, "{l} {s}");
        assert!((v.dot(turn.x_axis).abs() - 1.0).abs() < 1e-9, "{v}");
    }
    assert_eq!(eigen(DMat2::IDENTITY * 2.0), ([2.0, 2.0], DVec2::X));
}
