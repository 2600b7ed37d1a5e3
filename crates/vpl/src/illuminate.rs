//! Illuminates a point of a surface or of a medium by one virtual point light [slide 50].

use gi_core::bsdf::{Bsdf, DiffusePart};
use gi_core::geometry::Surface;
use gi_core::math::{INV_PI, Rgb};
use gi_core::medium::{MediumId, Phase, Tracking};
use gi_core::ray::Ray;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::light::{Kind, Vpl, Vpls};

/// What scatters light at a receiver.
#[derive(Clone, Copy)]
pub enum Scatterer<'r, 'a> {
    /// A surface.
    Surface(&'r Surface, &'r Bsdf<'a>),
    /// A medium.
    Medium(Phase),
}

/// A point that receives light, at a vertex of an eye path.
#[derive(Clone, Copy)]
pub struct Receiver<'r, 'a> {
    /// Position, world.
    pub p: Vec3,
    /// Unit direction back to the eye.
    pub wo: Vec3,
    /// What scatters there.
    pub scatterer: Scatterer<'r, 'a>,
    /// Unit geometric normal; zero in a medium.
    pub ng: Vec3,
    /// The whole BSDF if it is purely Lambertian: evaluated once for all lights.
    diffuse: Option<DiffusePart>,
    /// Lights below this normal are skipped; `None` if light from below may be scattered.
    pub(crate) normal: Option<Vec3>,
    /// `None`: media are left out. Otherwise the medium through which the eye path reaches the point.
    media: Option<Option<MediumId>>,
}

impl<'r, 'a> Receiver<'r, 'a> {
    /// A point of a surface seen along `wo`. Media are left out.
    #[inline]
    pub fn new(surface: &'r Surface, wo: Vec3, bsdf: &'r Bsdf<'a>) -> Self {
        Receiver {
            p: surface.p,
            wo,
            scatterer: Scatterer::Surface(surface, bsdf),
            ng: surface.ng,
            diffuse: bsdf.diffuse_only(wo),
            normal: bsdf.opaque_normal(),
            media: None,
        }
    }

    /// The same, but media attenuate the light. The eye path reaches the point through `medium`.
    #[inline]
    pub fn through_media(self, medium: Option<MediumId>) -> Self {
        Receiver { media: Some(medium), ..self }
    }

    /// A point of a medium.
    pub fn in_medium(scene: &Scene, p: Vec3, wo: Vec3, medium: MediumId) -> Self {
        Receiver {
            p,
            wo,
            scatterer: Scatterer::Medium(scene.medium(medium).phase),
            ng: Vec3::ZERO,
            diffuse: None,
            normal: None,
            media: Some(Some(medium)),
        }
    }

    /// Its surface, if it is on one.
    pub fn surface(&self) -> Option<&'r Surface> {
        match self.scatterer {
            Scatterer::Surface(surface, _) => Some(surface),
            Scatterer::Medium(_) => None,
        }
    }

    /// The medium that it is in; `None` on a surface.
    pub fn medium(&self) -> Option<MediumId> {
        match self.scatterer {
            Scatterer::Surface(..) => None,
            Scatterer::Medium(_) => self.media?,
        }
    }

    /// f if it is the same for all directions above the surface.
    #[inline]
    pub(crate) fn diffuse_f(&self) -> Option<Rgb> {
        self.diffuse.map(|part| part.albedo * INV_PI)
    }

    /// f times the cosine of `wi`; in a medium, the phase function.
    #[inline]
    pub fn f_cos(&self, wi: Vec3) -> Rgb {
        match (&self.diffuse, self.scatterer) {
            (Some(part), _) => part.albedo * (INV_PI * part.normal.dot(wi).max(0.0)),
            (None, Scatterer::Surface(_, bsdf)) => bsdf.f_cos(self.wo, wi),
            (None, Scatterer::Medium(phase)) => Rgb::grey(phase.eval(self.wo, wi)),
        }
    }

    /// A ray from the point to infinity.
    pub(crate) fn ray_along(&self, scene: &Scene, wi: Vec3) -> Ray {
        match self.scatterer {
            Scatterer::Surface(surface, _) => scene.spawn(surface, wi),
            Scatterer::Medium(_) => Ray::new(self.p, wi),
        }
    }

    /// The medium in which a shadow ray along `wi` starts, see [`passing`].
    #[inline]
    pub(crate) fn start_medium(&self, scene: &Scene, wi: Vec3) -> Option<Option<MediumId>> {
        let medium = self.media?;
        Some(match self.scatterer {
            Scatterer::Surface(surface, _) => scene.medium_toward(surface, wi, medium),
            Scatterer::Medium(_) => medium,
        })
    }
}

/// The fraction of light that passes a shadow ray, which may end on the flat primitive `on`. `start` is the medium in which
/// the ray starts; without it, media are left out.
#[inline]
pub(crate) fn passing(
    scene: &Scene,
    ray: Ray,
    on: Option<u32>,
    start: Option<Option<MediumId>>,
) -> Rgb {
    match start {
        None => scene.transmittance_to(ray, on),
        Some(medium) => {
            scene.transmittance_through_media_to(ray, on, medium, &mut Tracking::none())
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
    /// [`Receiver::start_medium`].
    start: Option<Option<MediumId>>,
}

impl Connection {
    /// The fraction of the light that passes the shadow ray.
    #[inline]
    pub fn transmittance(&self, scene: &Scene) -> Rgb {
        passing(scene, self.shadow, self.on, self.start)
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
    if vpl.kind == Kind::Directional {
        let wi = -vpl.n;
        let radiance = at.f_cos(wi) * vpl.power;
        return (!radiance.is_black()).then(|| Connection {
            radiance,
            arriving: vpl.power,
            geometry: 0.0,
            wi,
            shadow: at.ray_along(scene, wi),
            on: None,
            start: at.start_medium(scene, wi),
        });
    }
    let to = vpl.p - at.p;
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
    let geometry = at.ng.dot(wi).abs() * cos_light * inverse_sq;
    let shadow = scene.tree().shadow_ray(at.p, at.ng, vpl.p);
    Some(Connection {
        radiance,
        arriving: intensity * inverse_sq,
        geometry,
        wi,
        shadow,
        on: vpl.on,
        start: at.start_medium(scene, wi),
    })
}
