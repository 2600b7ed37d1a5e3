//! The single lobes of a BSDF, and their shapes without colours, for techniques that tabulate shapes.

use glam::Vec3;

use super::lobe::Lobe;
use super::{Bsdf, Component, PreparedMaterial, Transport};
use crate::material::{Material, Roughness};
use crate::math::{Frame, Rgb};
use crate::scene::Scene;
use crate::texture::Texture;

/// How a lobe scatters light, apart from its diffuse part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Only by a diffuse part, or by delta lobes.
    Diffuse,
    /// Over a range of directions, in addition to a diffuse part if there is one.
    Glossy,
}

/// A lobe of a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct LobeView {
    /// Index of its material in the scene.
    pub material: usize,
    /// Its kind.
    pub kind: Kind,
    /// Factor on [`GlossyLobe::f_cos`] here: colours from textures, the weight in a blend, and the mean shadowing of a
    /// bent normal.
    pub tint: Rgb,
    /// Its frame; the normal is on the side of the path.
    pub frame: Frame,
}

impl Bsdf<'_> {
    /// The lobes, except delta lobes.
    pub fn lobes(&self) -> impl Iterator<Item = LobeView> {
        self.components().iter().filter(|c| !c.lobe.is_delta()).map(Component::view)
    }
}

impl Component<'_> {
    fn view(&self) -> LobeView {
        let (tint, glossy) = match self.lobe {
            Lobe::OrenNayar { albedo, .. } => (albedo, true),
            Lobe::RoughConductor { tint, .. } => (tint, true),
            Lobe::RoughDielectric { .. } | Lobe::Principled(_) | Lobe::PrincipledThin(_) => {
                (Rgb::WHITE, true)
            }
            Lobe::Plastic { coat, specular, .. } => (specular, !coat.is_smooth()),
            Lobe::Phong { specular, .. } => (specular, true),
            _ => (Rgb::BLACK, false),
        };
        let kind = if glossy && !tint.is_black() { Kind::Glossy } else { Kind::Diffuse };
        let material = self.material as usize;
        let tint = tint * (self.weight * self.mean_unshadowed());
        LobeView { material, kind, tint, frame: self.frame }
    }
}

/// The shape of a material's glossy lobe: without texture colours and without its diffuse part. It is the same at all
/// points, and isotropic. Directions are local, z along the normal.
#[derive(Clone, Copy, Debug)]
pub struct GlossyLobe<'a> {
    lobe: Lobe<'a>,
}

impl Scene {
    /// Number of materials.
    pub fn material_count(&self) -> usize {
        self.prepared_materials().len()
    }

    /// Shape of the glossy lobe of a material without children. `None` if there is no such lobe, if a texture changes
    /// its roughness, if it is anisotropic, or if it transmits light.
    pub fn glossy_lobe(&self, material: usize) -> Option<GlossyLobe<'_>> {
        let prepared = &self.prepared_materials()[material];
        shape(prepared).map(|lobe| GlossyLobe { lobe })
    }
}

fn shape(prepared: &PreparedMaterial) -> Option<Lobe<'_>> {
    let (tint, black) = (Rgb::WHITE, Rgb::BLACK);
    let constant = |t: &Texture| match t {
        Texture::Constant(c) => Some(c.mean()),
        _ => None,
    };
    let alike = |r: &Roughness| {
        let (u, v) = (constant(&r.alpha_u)?, constant(&r.alpha_v)?);
        (u == v).then_some(())
    };
    match &prepared.material {
        Material::RoughDiffuse { alpha, .. } => constant(alpha).map(|_| ())?,
        Material::Conductor { roughness: Some(r), .. }
        | Material::Plastic { roughness: Some(r), .. } => alike(r)?,
        Material::Phong { exponent, .. } => constant(exponent).map(|_| ())?,
        _ => return None,
    }
    Some(match prepared.lobe_at(glam::Vec2::ZERO)? {
        Lobe::OrenNayar { sigma_sq, .. } => Lobe::OrenNayar { albedo: tint, sigma_sq },
        Lobe::RoughConductor { eta, k, facets, .. } => {
            Lobe::RoughConductor { eta, k, tint, facets }
        }
        Lobe::Plastic { coat, .. } => Lobe::Plastic { coat, diffuse: black, specular: tint },
        Lobe::Phong { exponent, .. } => Lobe::Phong { diffuse: black, specular: tint, exponent },
        _ => return None,
    })
}

impl GlossyLobe<'_> {
    /// f(wo, wi) times the cosine of `wi`, minus the diffuse part. In Oren and Nayar's model, the diffuse part is the
    /// constant term, so the rest may be negative.
    #[inline]
    pub fn f_cos(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let f = self.lobe.f(wo, wi, Transport::Radiance) - self.lobe.diffuse_f(wo, wi);
        f * wi.z.max(0.0)
    }

    /// Sample `wi` for `wo` above. Returns the direction, and [`GlossyLobe::f_cos`] divided by its density per solid
    /// angle.
    #[inline]
    pub fn sample(&self, wo: Vec3, u: [f32; 2]) -> Option<(Vec3, Rgb)> {
        let wi = self.lobe.sample(wo, 0.0, u, Transport::Radiance)?.wi;
        let pdf_w = self.lobe.pdf_w(wo, wi);
        (pdf_w > 0.0 && wi.z > 0.0).then(|| (wi, self.f_cos(wo, wi) / pdf_w))
    }

    /// Width of the lobe as a microfacet alpha; 1 for lobes that cover the hemisphere.
    pub fn roughness(&self) -> f32 {
        self.lobe.roughness()
    }

    /// The kind of surface, in a word or two.
    pub fn name(&self) -> &'static str {
        match self.lobe {
            Lobe::OrenNayar { .. } => "rough diffuse",
            Lobe::RoughConductor { .. } => "rough conductor",
            Lobe::Plastic { .. } => "rough plastic",
            Lobe::Phong { .. } => "phong",
            _ => "other",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Shape};
    use crate::material::Distribution;
    use crate::rng::Pcg;
    use crate::scene::SceneParts;

    fn rough(alpha: f32) -> Option<Roughness> {
        let alpha = Texture::grey(alpha);
        Some(Roughness { distribution: Distribution::Ggx, alpha_u: alpha.clone(), alpha_v: alpha })
    }

    fn scene(materials: Vec<Material>) -> Scene {
        let ball =
            Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes: Frame::from_normal(Vec3::Z) };
        let last = materials.len() - 1;
        let shapes = vec![Shape::new("ball", ball, last)];
        Scene::new(SceneParts { shapes, materials, ..SceneParts::default() }).expect("valid")
    }

    #[test]
    fn diffuse_part_and_tinted_shapes_add_up_to_the_whole() {
        let colour = |r, g, b| Texture::Constant(Rgb::new(r, g, b));
        let (eta, k) = (Rgb::new(0.2, 0.9, 1.1), Rgb::new(3.9, 2.4, 2.2));
        let materials = vec![
            Material::Conductor {
                eta,
                k,
                reflectance: colour(0.9, 0.5, 0.2),
                roughness: rough(0.3),
            },
            Material::Phong {
                diffuse: colour(0.1, 0.2, 0.3),
                specular: colour(0.4, 0.3, 0.2),
                exponent: Texture::grey(12.0),
            },
            Material::RoughDiffuse {
                reflectance: colour(0.6, 0.7, 0.8),
                alpha: Texture::grey(0.5),
            },
            Material::Blend { weight: Texture::grey(0.3), first: 0, second: 1 },
            Material::Blend { weight: Texture::grey(0.6), first: 3, second: 2 },
        ];
        let scene = scene(materials);
        let ray = crate::ray::Ray::new(Vec3::new(0.3, 0.2, 3.0), -Vec3::Z);
        let (surface, _) = scene.intersect(&ray).expect("the ball");
        let mut rng = Pcg::new(3, 0);
        for _ in 0..1000 {
            let mut direction = || {
                let local = crate::warp::cosine_hemisphere(rng.next_2d());
                surface.frame.to_world(local)
            };
            let (wo, wi) = (direction(), direction());
            let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
            let part = bsdf.diffuse_part(wo).expect("a diffuse part");
            let mut sum = part.albedo * (crate::math::INV_PI * wi.dot(part.normal));
            for lobe in bsdf.lobes() {
                let shape = scene.glossy_lobe(lobe.material).expect("a shape");
                let f = lobe.frame;
                sum += lobe.tint * shape.f_cos(f.to_local(wo), f.to_local(wi));
            }
            let whole = bsdf.f_cos(wo, wi);
            let off = whole.zip(sum, |a, b| (a - b).abs() / (1e-3 + a)).max();
            assert!(off < 1e-3, "{whole:?} is not {sum:?}");
        }
    }

    #[test]
    fn lobes_that_cannot_be_tabulated_have_no_shape() {
        let grey = Texture::grey(0.5);
        let uneven = Roughness {
            distribution: Distribution::Ggx,
            alpha_u: Texture::grey(0.1),
            alpha_v: Texture::grey(0.3),
        };
        let conductor = |roughness| Material::Conductor {
            eta: Rgb::BLACK,
            k: Rgb::WHITE,
            reflectance: grey.clone(),
            roughness,
        };
        let scene = scene(vec![
            Material::Diffuse { reflectance: grey.clone() },
            conductor(None),
            conductor(Some(uneven)),
            Material::TwoSided { front: 0, back: 0 },
            conductor(rough(0.2)),
        ]);
        let found: Vec<bool> =
            (0..scene.material_count()).map(|k| scene.glossy_lobe(k).is_some()).collect();
        assert_eq!(found, [false, false, false, false, true]);
    }
}
