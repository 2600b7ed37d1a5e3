//! Scenes and lights for the tests of bounds and cuts: every material, every kind of light, and shading normals that
//! differ.

use gi_core::bsdf::Transport;
use gi_core::geometry::{Geometry, Mesh, Shape, Surface};
use gi_core::light::{Light, LightSource};
use gi_core::material::{BentNormals, Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::medium::{Medium, Phase};
use gi_core::ray::Ray;
use gi_core::rng::Pcg;
use gi_core::scene::{Scene, SceneParts};
use gi_core::texture::Texture;
use gi_core::warp;
use glam::Vec3;
use vpl::{Kind, LitSurface, Vpl, Vpls};

use crate::light::{At, Lights};

fn rough(distribution: Distribution, u: f32, v: f32) -> Option<Roughness> {
    Some(Roughness { distribution, alpha_u: Texture::grey(u), alpha_v: Texture::grey(v) })
}

/// One material of each kind, sharp and wide. Materials that refer to others come after them.
pub(crate) fn materials() -> Vec<Material> {
    use Distribution::{Beckmann, Ggx};
    let metal = |roughness| Material::Conductor {
        eta: Rgb::new(0.2, 0.9, 1.1),
        k: Rgb::new(3.9, 2.4, 2.2),
        reflectance: Texture::grey(1.0),
        roughness,
    };
    let plastic = |roughness| Material::Plastic {
        eta: 1.49,
        diffuse: Texture::Constant(Rgb::new(0.7, 0.4, 0.0)),
        specular: Texture::grey(1.0),
        nonlinear: true,
        roughness,
    };
    let phong = |exponent| Material::Phong {
        diffuse: Texture::grey(0.3),
        specular: Texture::grey(0.5),
        exponent: Texture::grey(exponent),
    };
    let glass = |roughness| Material::Dielectric {
        eta: 1.5,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness,
    };
    vec![
        Material::Diffuse { reflectance: Texture::Constant(Rgb::new(0.8, 0.5, 0.0)) },
        metal(rough(Ggx, 0.2, 0.2)),
        Material::RoughDiffuse { reflectance: Texture::grey(0.8), alpha: Texture::grey(0.4) },
        metal(rough(Ggx, 0.02, 0.02)),
        metal(rough(Beckmann, 0.4, 0.1)),
        plastic(None),
        plastic(rough(Ggx, 0.2, 0.2)),
        plastic(rough(Beckmann, 0.1, 0.1)),
        phong(10.0),
        phong(300.0),
        glass(rough(Ggx, 0.3, 0.3)),
        Material::Blend { weight: Texture::grey(0.4), first: 0, second: 1 },
        Material::NormalMap {
            map: Texture::Constant(Rgb::new(0.6, 0.45, 0.95)),
            inner: 0,
            normals: BentNormals::default(),
        },
        Material::TwoSided { front: 6, back: 0 },
        Material::TwoSided { front: 12, back: 11 },
    ]
}

pub(crate) fn in_cube(rng: &mut Pcg) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| 2.0 * rng.next_f32() - 1.0))
}

/// Whether triangle `k` has shading normals that differ: a third of the triangles of each material.
pub(crate) fn is_bent(k: usize) -> bool {
    (k + k / materials().len()).is_multiple_of(3)
}

/// Random triangles, some of each material with shading normals that differ, a lamp and a spot light.
pub(crate) fn rubble(seed: u64) -> Scene {
    let mut rng = Pcg::new(seed, 77);
    let materials = materials();
    let triangle = |k: usize| {
        let middle = in_cube(&mut rng);
        let positions: Vec<Vec3> = (0..3).map(|_| middle + 0.6 * in_cube(&mut rng)).collect();
        let n = (positions[1] - positions[0]).cross(positions[2] - positions[0]);
        let n = n.try_normalize().unwrap_or(Vec3::Z);
        let mut bent = || (n + 0.6 * in_cube(&mut rng)).normalize();
        let normals = if is_bent(k) { vec![bent(), bent(), bent()] } else { Vec::new() };
        let mesh =
            Mesh { positions, triangles: vec![[0, 1, 2]].into(), normals, ..Mesh::default() };
        Shape::new("shard", Geometry::Mesh(mesh), k % materials.len())
    };
    let shapes = (0..60).map(triangle).collect();
    let lights = vec![
        LightSource::Point { position: Vec3::ZERO, intensity: Rgb::WHITE },
        LightSource::Spot {
            position: Vec3::ZERO,
            direction: Vec3::Z,
            intensity: Rgb::WHITE,
            cutoff: 1.2,
            beam: 0.4,
        },
    ];
    let media = media();
    Scene::new(SceneParts { shapes, materials, lights, media, ..SceneParts::default() })
        .expect("a scene")
}

/// Media with every phase function. No shape bounds them.
fn media() -> Vec<Medium> {
    let phases = [
        Phase::Isotropic,
        Phase::Rayleigh,
        Phase::HenyeyGreenstein { g: 0.8 },
        Phase::HenyeyGreenstein { g: -0.5 },
    ];
    phases.map(|phase| Medium::homogeneous(Rgb::grey(0.1), Rgb::grey(0.9), phase)).into()
}

/// A random point of the scene, and the direction from which it is seen.
pub(crate) fn point(scene: &Scene, rng: &mut Pcg) -> (Surface, Vec3) {
    loop {
        let ray = Ray::new(1.5 * in_cube(rng), warp::sphere(rng.next_2d()));
        if let Some((surface, _)) = scene.intersect(&ray) {
            let delta = scene.bsdf(&surface, -ray.d, Transport::Radiance).is_delta();
            if !delta {
                return (surface, -ray.d);
            }
        }
    }
}

/// Lights of all kinds, direct and indirect, some close to each other.
pub(crate) fn lights(scene: &Scene, count: u32, rng: &mut Pcg) -> Vpls {
    let mut set = Vpls::default();
    let is_spot = |l: &Light| matches!(l, Light::Spot { .. });
    let spot = scene.lights().all().iter().position(is_spot).expect("a spot") as u32;
    for _ in 0..count {
        let (surface, wo) = point(scene, rng);
        let toward = |n: Vec3| n * 1f32.copysign(n.dot(wo));
        let power = Rgb::from([0; 3].map(|_| rng.next_f32().powi(3)));
        let depth = rng.next_below(3);
        let n = toward(surface.ng);
        let (p, n, kind) = match rng.next_below(9) {
            0 => (in_cube(rng), Vec3::Z, Kind::Omni),
            1 => (Vec3::ZERO, warp::sphere(rng.next_2d()), Kind::Directional),
            2 => (in_cube(rng), Vec3::Z, Kind::Spot(spot)),
            3..=5 if depth > 0 => {
                set.surfaces.push(LitSurface { surface, wo });
                (surface.p, n, Kind::Glossy(set.surfaces.len() as u32 - 1))
            }
            _ => (surface.p, n, Kind::Oriented),
        };
        let on_surface = matches!(kind, Kind::Oriented | Kind::Glossy(_));
        let ns = if on_surface { toward(surface.ns()) } else { n };
        set.lights.push(Vpl { p, n, ns, power, kind, depth, on: None });
    }
    set.lights.sort_by_key(|v| v.depth);
    set
}

/// The unshadowed light from one virtual light.
pub(crate) fn unshadowed(lights: &Lights, at: &At, k: u32, direct: bool) -> Rgb {
    let power = lights.prepared.set().lights[k as usize].power;
    lights
        .prepared
        .connect_unit(k as usize, &at.receiver)
        .map_or(Rgb::BLACK, |c| c.radiance * power * at.kept(c.geometry, direct))
}

/// Counts of the checks of bounds, for one kind of surface.
#[derive(Clone, Copy, Default)]
pub(crate) struct Checked {
    pub(crate) cases: u32,
    /// Cases with some light.
    pub(crate) lit: u32,
    /// Cases with more than 0.3 of the bound.
    pub(crate) tight: u32,
    /// Cases whose bound is zero.
    pub(crate) dark: u32,
}

impl Checked {
    /// Check a value in each channel. If the bound is zero, the value must be zero. A NaN bound counts as infinite.
    pub(crate) fn check(&mut self, value: Rgb, bound: Rgb, what: &dyn std::fmt::Debug) {
        let pairs = value.to_array().into_iter().zip(bound.to_array());
        let holds = pairs.into_iter().all(|(v, b)| v <= b || b.is_nan());
        assert!(holds, "{what:?}: {value:?} is above the bound {bound:?}");
        self.cases += 1;
        self.lit += u32::from(!value.is_black());
        self.tight += u32::from(value.luminance() > 0.3 * bound.luminance());
        self.dark += u32::from(bound.is_black());
    }
}
