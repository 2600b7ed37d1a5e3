//! Illuminates a point by one virtual point light [slide 50].

use gi_core::bsdf::{Bsdf, DiffusePart};
use gi_core::geometry::Surface;
use gi_core::math::{INV_PI, Rgb};
use gi_core::ray::Ray;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::light::{Kind, Vpl, Vpls};

/// A point that receives light, at a vertex of an eye path.
#[derive(Clone, Copy)]
pub struct Receiver<'r, 'a> {
    /// The point.
    pub surface: &'r Surface,
    /// Unit direction back to the eye.
    pub wo: Vec3,
    /// How it scatters.
    pub bsdf: &'r Bsdf<'a>,
    /// The whole BSDF if it is purely Lambertian: evaluated once for all lights.
    diffuse: Option<DiffusePart>,
    /// Lights below this normal are skipped; `None` if light from below may be transmitted.
    pub(crate) normal: Option<Vec3>,
}

impl<'r, 'a> Receiver<'r, 'a> {
    /// A point of a surface seen along `wo`.
    #[inline]
    pub fn new(surface: &'r Surface, wo: Vec3, bsdf: &'r Bsdf<'a>) -> Self {
        let normal = bsdf.opaque_normal();
        Receiver { surface, wo, bsdf, diffuse: bsdf.diffuse_only(wo), normal }
    }

    /// f if it is the same for all directions above the surface.
    #[inline]
    pub(crate) fn diffuse_f(&self) -> Option<Rgb> {
        self.diffuse.map(|part| part.albedo * INV_PI)
    }

    /// f times the cosine of `wi`.
    #[inline]
    pub fn f_cos(&self, wi: Vec3) -> Rgb {
        match &self.diffuse {
            Some(part) => part.albedo * (INV_PI * part.normal.dot(wi).max(0.0)),
            None => self.bsdf.f_cos(self.wo, wi),
        }
    }
}

/// The unshadowed light from a virtual light that a point scatters toward the eye.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Radiance toward the eye, with the geometry term not clamped.
    pub radiance: Rgb,
    /// Unshadowed irradiance on a plane perpendicular to `wi`; `radiance` is the part that the point scatters toward
    /// the eye.
    pub arriving: Rgb,
    /// The geometry term cos cos' / d^2 with the geometric normals, per squared world unit; 0 for lights without a
    /// surface, which paths cannot hit.
    pub geometry: f32,
    /// Unit direction to the light.
    pub wi: Vec3,
    /// The shadow ray. Hits on the primitive of the light do not count.
    pub shadow: Ray,
    /// [`Vpl::on`] of the light.
    on: Option<u32>,
}

impl Connection {
    /// The fraction of the light that passes the shadow ray.
    #[inline]
    pub fn transmittance(&self, scene: &Scene) -> Rgb {
        scene.transmittance_to(self.shadow, self.on)
    }
}

impl Vpls {
    /// Connect a point with a light. `None` if the light faces away or the point scatters nothing toward the eye.
    #[inline]
    pub fn connect(&self, scene: &Scene, vpl: &Vpl, at: &Receiver) -> Option<Connection> {
        connect(scene, vpl, at, |k, d| self.scattered(scene, k, d))
    }

    /// Fraction of the arriving power, per solid angle, that a glossy light scatters toward `d`.
    pub(crate) fn scattered(&self, scene: &Scene, k: u32, d: Vec3) -> Rgb {
        let lit = &self.surfaces[k as usize];
        lit.bsdf(scene).map_or(Rgb::BLACK, |bsdf| bsdf.f_cos(lit.wo, d))
    }
}

/// Connect a point with a light. `scattered` gives the fraction of the arriving power, per solid angle, that a glossy
/// light scatters toward a direction.
#[inline]
pub(crate) fn connect(
    scene: &Scene,
    vpl: &Vpl,
    at: &Receiver,
    scattered: impl FnOnce(u32, Vec3) -> Rgb,
) -> Option<Connection> {
    let x = at.surface;
    if vpl.kind == Kind::Directional {
        let wi = -vpl.n;
        let radiance = at.f_cos(wi) * vpl.power;
        return (!radiance.is_black()).then(|| Connection {
            radiance,
            arriving: vpl.power,
            geometry: 0.0,
            wi,
            shadow: scene.spawn(x, wi),
            on: None,
        });
    }
    let to = vpl.p - x.p;
    // Most pairs face away from each other: test that before the division.
    let facing = match vpl.kind {
        Kind::Oriented => to.dot(vpl.n) < 0.0 && to.dot(vpl.ns) < 0.0,
        _ => to != Vec3::ZERO,
    };
    if !facing || at.normal.is_some_and(|n| n.dot(to) <= 0.0) {
        return None;
    }
    let inverse_sq = 1.0 / to.length_squared();
    let wi = to * inverse_sq.sqrt();
    let cos_light = -wi.dot(vpl.n);
    let (intensity, cos_light) = match vpl.kind {
        Kind::Oriented => (vpl.power * cos_light, cos_light),
        Kind::Omni => (vpl.power, 0.0),
        Kind::Spot(light) => (vpl.power * scene.lights().all()[light as usize].spot_fade(-wi), 0.0),
        Kind::Glossy(k) => (scattered(k, -wi) * vpl.power, cos_light.abs()),
        Kind::Directional => unreachable!("parallel light has no position"),
    };
    let radiance = at.f_cos(wi) * intensity * inverse_sq;
    if radiance.is_black() {
        return None;
    }
    let geometry = x.ng.dot(wi).abs() * cos_light * inverse_sq;
    let shadow = scene.tree().shadow_ray(x.p, x.ng, vpl.p);
    Some(Connection {
        radiance,
        arriving: intensity * inverse_sq,
        geometry,
        wi,
        shadow,
        on: vpl.on,
    })
}
