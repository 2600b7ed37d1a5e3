//! Next-event estimation: sample a light from a point of a surface or a medium. Multiple importance sampling weights it
//! against BSDF or phase function sampling.

use crate::medium::MediumId;
use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::geometry::Surface;
use crate::light::{LightSample, Vantage};
use crate::math::{Rgb, sqr};
use crate::sampler::Sampler;
use crate::scene::Scene;

/// Weight of a sample with density `pdf`, if the other strategy has density `other` for it: the power heuristic with
/// exponent 2 [Veach97, 9.2.4].
#[inline]
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // Divided by pdf^2, so that large densities do not overflow.
    1.0 / (1.0 + sqr(other / pdf))
}

/// Radiance scattered along `wo`, from light straight from a light source, by one light sample for the point `at` of
/// `surface`. Rays that hit a light contribute the rest, weighted by [`emitter_weight`].
#[inline(always)]
pub fn direct_light(
    scene: &Scene,
    (at, surface): (&Vantage, &Surface),
    bsdf: &Bsdf,
    wo: Vec3,
    sampler: &mut Sampler,
) -> Rgb {
    direct_light_seen(scene, at, bsdf, wo, sampler, |light| scene.visibility(surface, light))
}

/// The same for a path that reached `surface` through `medium`. Media attenuate the light on its way.
#[inline]
pub fn direct_light_through_media(
    scene: &Scene,
    (at, surface, medium): (&Vantage, &Surface, Option<MediumId>),
    bsdf: &Bsdf,
    wo: Vec3,
    sampler: &mut Sampler,
) -> Rgb {
    let mut random = scene.tracking(sampler);
    direct_light_seen(scene, at, bsdf, wo, sampler, |light| {
        scene.visibility_through_media(surface, medium, light, &mut random)
    })
}

/// Radiance scattered along `wo` at a point inside a medium, divided by the scattering coefficient, from light
/// straight from a light source. One light sample, weighted against phase function sampling.
#[inline]
pub fn direct_light_within(
    scene: &Scene,
    medium: MediumId,
    at: &Vantage,
    wo: Vec3,
    sampler: &mut Sampler,
) -> Rgb {
    light_within(scene, medium, (at, wo), sampler, power_heuristic)
}

/// The same at the point `p` without the weight, for techniques that do not sample the phase function.
#[inline]
pub fn all_direct_light_within(
    scene: &Scene,
    medium: MediumId,
    p: Vec3,
    wo: Vec3,
    sampler: &mut Sampler,
) -> Rgb {
    let at = Vantage::new(scene.tree_of_many_lights(), p);
    light_within(scene, medium, (&at, wo), sampler, |_, _| 1.0)
}

#[inline]
fn light_within(
    scene: &Scene,
    medium: MediumId,
    (at, wo): (&Vantage, Vec3),
    sampler: &mut Sampler,
    weigh: impl FnOnce(f32, f32) -> f32,
) -> Rgb {
    let (u, mut random) = (sampler.next_2d(), scene.tracking(sampler));
    let Some(light) = scene.aim_at_light(at, u) else { return Rgb::BLACK };
    // A phase function equals its own density.
    let phase = scene.medium(medium).phase.eval(wo, light.wi);
    let arriving = light.radiance * phase;
    if arriving.is_black() {
        return Rgb::BLACK;
    }
    let weight = if light.delta { 1.0 } else { weigh(light.pdf_w, phase) };
    let visible = scene.visibility_from_within(at.p, Some(medium), &light, &mut random);
    seen(scene, &light, visible) * arriving * (weight / light.pdf_w)
}

#[inline(always)]
fn direct_light_seen(
    scene: &Scene,
    at: &Vantage,
    bsdf: &Bsdf,
    wo: Vec3,
    sampler: &mut Sampler,
    visibility: impl FnOnce(&LightSample) -> Rgb,
) -> Rgb {
    let u = sampler.next_2d();
    if bsdf.is_delta() {
        return Rgb::BLACK;
    }
    let Some(light) = &scene.aim_at_light(at, u) else { return Rgb::BLACK };
    let (f_cos, pdf_bsdf) = bsdf.f_cos_pdf(wo, light.wi);
    let arriving = f_cos * light.radiance;
    if arriving.is_black() {
        at.learn(light, || 0.0);
        return Rgb::BLACK;
    }
    let weight = if light.delta { 1.0 } else { power_heuristic(light.pdf_w, pdf_bsdf) };
    let direct = seen(scene, light, visibility(light)) * arriving;
    at.learn(light, || direct.luminance() / light.pdf_w);
    direct * (weight / light.pdf_w)
}

/// The radiance of a light sample that reaches `surface`.
#[inline]
pub fn arriving_light(scene: &Scene, surface: &Surface, light: &LightSample) -> Rgb {
    seen(scene, light, scene.visibility(surface, light)) * light.radiance
}

/// The visible fraction of a light sample, times what is not yet looked up of its radiance.
#[inline]
fn seen(scene: &Scene, light: &LightSample, visible: Rgb) -> Rgb {
    if visible.is_black() { visible } else { visible * scene.looked_up(light) }
}

/// Weight of a light that a ray hit, where BSDF sampling has density `pdf_bsdf` and light sampling has density
/// `pdf_light`. `None` stands for a delta lobe or the camera: light sampling cannot find these paths.
#[inline]
pub fn emitter_weight(pdf_bsdf: Option<f32>, pdf_light: f32) -> f32 {
    pdf_bsdf.map_or(1.0, |pdf| power_heuristic(pdf, pdf_light))
}
