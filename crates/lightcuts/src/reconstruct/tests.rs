use super::*;
use crate::cut::{Limits, Rule};
use crate::light::tests::at_points;
use crate::{light_by_cut, reconstruct, record_cut};
use gi_core::bsdf::Transport;
use gi_core::ray::Ray;

const LIMITS: Limits = Limits { error: 0.02, rule: Rule::Whole, max_cut: Some(1000) };

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-3 * (a.abs() + b.abs()) + 1e-7
}

#[test]
fn between_four_equal_samples_is_that_sample() {
    let mut some = 0;
    at_points(300, 60, |lights, at| {
        let surface = at.receiver.surface().expect("on a surface");
        let sample = record_cut(lights, at, &LIMITS);
        let cut = light_by_cut(lights, at, &LIMITS);
        assert!(sample.serves(lights.scene, surface));
        assert!(close(sample.total, cut.all().luminance()));
        let corners = [(&sample, 0.1), (&sample, 0.2), (&sample, 0.3), (&sample, 0.4)];
        let lit = reconstruct(lights, at, &corners, &LIMITS, 0.01);
        assert!(close(lit.direct.luminance(), cut.direct.luminance()), "{lit:?} is not {cut:?}");
        assert!(
            close(lit.indirect.luminance(), cut.indirect.luminance()),
            "{lit:?} is not {cut:?}"
        );
        assert_eq!(lit.rays, 0, "the samples agree on everything");
        some += u32::from(!cut.all().is_black());
    });
    assert!(some > 100);
}

#[test]
fn near_samples_give_nearly_the_light_of_all_lights_with_fewer_rays() {
    let mut rng = gi_core::rng::Pcg::new(9, 9);
    let (mut errors, mut rays) = (Vec::new(), [0u32; 2]);
    at_points(600, 60, |lights, at| {
        let (surface, wo) = (at.receiver.surface().expect("on a surface"), at.site.wo);
        let mut samples = Vec::new();
        for _ in 0..40 {
            // Nearby points, seen from the same eye position.
            let eye = surface.p + 0.3 * wo;
            let beside = gi_core::warp::sphere(rng.next_2d()) * 0.004;
            let ray = Ray::new(eye, (beside - wo).normalize());
            let Some((surface, _)) = lights.scene.intersect(&ray) else { continue };
            let bsdf = lights.scene.bsdf(&surface, -ray.d, Transport::Radiance);
            let other = At {
                receiver: vpl::Receiver::new(&surface, -ray.d, &bsdf),
                site: crate::bound::Site::new(&surface, -ray.d, &bsdf, at.site.most),
                ..*at
            };
            let sample = record_cut(lights, &other, &LIMITS);
            if sample.serves(lights.scene, at.receiver.surface().expect("on a surface")) {
                samples.push(sample);
            }
        }
        if samples.len() < 4 {
            return;
        }
        let corners = std::array::from_fn(|k| (&samples[k], 0.25));
        let lit = reconstruct(lights, at, &corners, &LIMITS, 0.01);
        let exact = lights.light_by_all(at).all().luminance();
        if exact > 0.0 {
            errors.push((lit.all().luminance() - exact).abs() / exact);
            rays[0] += lit.rays;
            rays[1] += light_by_cut(lights, at, &LIMITS).rays;
        }
    });
    errors.sort_unstable_by(f32::total_cmp);
    // Percentiles are used because shadow edges and sharp lobes between the samples cause larger errors.
    let of = |share: f32| errors[(share * errors.len() as f32) as usize];
    assert!(
        errors.len() > 100 && of(0.5) < 0.01 && of(0.8) < 0.03,
        "{} {} {}",
        errors.len(),
        of(0.5),
        of(0.8)
    );
    assert!(2 * rays[0] < rays[1], "{rays:?} rays");
}

#[test]
fn samples_on_another_surface_or_around_a_corner_are_not_used() {
    at_points(50, 10, |lights, at| {
        let surface = at.receiver.surface().expect("on a surface");
        let sample = record_cut(lights, at, &LIMITS);
        let away = |d: Vec3| {
            let mut other = *surface;
            other.p += d;
            other
        };
        assert!(sample.serves(lights.scene, &away(0.01 * surface.frame.s.cross(surface.ng))));
        assert!(!sample.serves(lights.scene, &away(0.1 * surface.ng)), "another plane");
        let mut turned = *surface;
        turned.ng = surface.ng.any_orthonormal_vector();
        assert!(!sample.serves(lights.scene, &turned), "another normal");
        let other = lights.scene.intersect(&Ray::new(surface.p + 2.0 * at.site.wo, -at.site.wo));
        if let Some((other, _)) = other.filter(|(o, _)| o.shape % 15 != surface.shape % 15) {
            assert!(!sample.serves(lights.scene, &other), "another material");
        }
    });
}
