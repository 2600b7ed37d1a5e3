use super::*;

#[test]
fn erf_and_its_inverse_agree() {
    assert!((erf(0.5) - 0.520_499_9).abs() < 1e-6);
    for i in -99..=99 {
        let y = i as f32 / 100.0;
        assert!((erf(erf_inv(y)) - y).abs() < 2e-6, "{y}");
    }
}

#[test]
fn projected_facet_area_is_one_and_visible_area_is_the_cosine() {
    let n = 1000;
    for distribution in [Distribution::Ggx, Distribution::Beckmann] {
        for alpha in [Vec2::new(0.2, 0.2), Vec2::new(0.5, 0.15)] {
            let facets = Microfacets::new(distribution, alpha);
            let wo = Vec3::new(0.6, 0.3, 0.5).normalize();
            let (mut projected, mut visible) = (0.0f64, 0.0f64);
            for i in 0..n * n {
                let u = [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32];
                let m = warp::hemisphere(u);
                projected += f64::from(facets.d(m) * m.z);
                visible += f64::from(facets.visible_pdf(wo, m));
            }
            let scale = 2.0 * std::f64::consts::PI / (n * n) as f64;
            assert!(
                (projected * scale - 1.0).abs() < 2e-3,
                "{distribution:?} {alpha}: {}",
                projected * scale
            );
            // Exact for GGX; the fit of Beckmann's shadowing is accurate to 0.35 %.
            assert!(
                (visible * scale - 1.0).abs() < 5e-3,
                "{distribution:?} {alpha}: {}",
                visible * scale
            );
        }
    }
}
