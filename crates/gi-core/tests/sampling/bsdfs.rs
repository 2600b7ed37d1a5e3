//! Tests of BSDFs: sampled with their density, weights consistent with f, reciprocal, and conserving energy.

mod bounds;
mod materials;

use gi_core::bsdf::{Bsdf, Toward, Transport};
use gi_core::geometry::{Geometry, Mesh, Shape, Surface};
use gi_core::material::{Distribution, Material, Principled, PrincipledThin};
use gi_core::math::{Bounds, Rgb};
use gi_core::ray::Ray;
use gi_core::rng::Pcg;
use gi_core::scene::{Scene, SceneParts};
use gi_core::texture::Texture;
use gi_core::warp;
use glam::{Vec2, Vec3};

use crate::grid::check;
use crate::principled::{principled, sheet};
use materials::{glass, materials, metal, rough};

/// A floor with the last of the materials, seen from above.
pub(crate) fn floor(materials: Vec<Material>) -> (Scene, Surface) {
    let mesh = Mesh {
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| Vec3::new(x, y, 0.0))
            .to_vec(),
        uvs: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from).to_vec().into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
        ..Mesh::default()
    };
    let shapes = vec![Shape::new("floor", Geometry::Mesh(mesh), materials.len() - 1)];
    let scene =
        Scene::new(SceneParts { shapes, materials, ..SceneParts::default() }).expect("a scene");
    let (surface, _) =
        scene.intersect(&Ray::new(Vec3::new(0.3, 0.1, 1.0), -Vec3::Z)).expect("a hit");
    (scene, surface)
}

/// Viewing directions: high, grazing, and from below.
fn views() -> [Vec3; 4] {
    [
        Vec3::new(0.1, 0.2, 1.0),
        Vec3::new(-0.7, 0.3, 0.5),
        Vec3::new(0.9, 0.4, 0.15),
        Vec3::new(0.5, -0.4, -0.7),
    ]
    .map(Vec3::normalize)
}

fn each(mut test: impl FnMut(&str, &Bsdf, Vec3, bool)) {
    each_of(Transport::Radiance, &mut test);
}

fn each_of(transport: Transport, test: &mut impl FnMut(&str, &Bsdf, Vec3, bool)) {
    for (name, table, whole) in materials() {
        let (scene, surface) = floor(table);
        for wo in views() {
            let bsdf = scene.bsdf(&surface, wo, transport);
            test(&format!("{name} from {wo:.2}, {transport:?}"), &bsdf, wo, whole);
        }
    }
}

#[test]
fn directions_are_sampled_with_the_density() {
    let mut seed = 100;
    let mut test = |name: &str, bsdf: &Bsdf, wo: Vec3, _| {
        seed += 1;
        // Delta samples have no density: they count as not sampled, and their fraction is not part of the density.
        let mut delta = 0u32;
        let mut total = 0u32;
        let draw = |r: &mut Pcg| {
            let s = bsdf.sample(wo, r.next_f32(), r.next_2d());
            total += 1;
            delta += u32::from(s.is_some_and(|s| s.delta));
            s.filter(|s| !s.delta).map(|s| s.wi)
        };
        check(name, seed, draw, |wi| bsdf.pdf_w(wo, wi));
    };
    each_of(Transport::Radiance, &mut test);
    // Other materials sample the same directions on light paths.
    each_of(Transport::Power, &mut |name: &str, bsdf: &Bsdf, wo, whole| {
        if name.contains("map") {
            test(name, bsdf, wo, whole);
        }
    });
}

#[test]
fn weights_of_samples_agree_with_f_and_the_density() {
    let mut rng = Pcg::new(5, 5);
    let mut test = |name: &str, bsdf: &Bsdf, wo: Vec3, _| {
        for _ in 0..2000 {
            let Some(s) = bsdf.sample(wo, rng.next_f32(), rng.next_2d()) else { continue };
            assert!(s.weight.is_finite() && s.pdf_w > 0.0, "{name}: {s:?}");
            if s.delta {
                assert!(bsdf.f_cos(wo, s.wi).max() * 0.0 == 0.0, "{name}: f is not finite");
                continue;
            }
            let (f_cos, pdf_w) = bsdf.f_cos_pdf(wo, s.wi);
            let close = |a: f32, b: f32| (a - b).abs() <= 2e-3 * (a.abs() + b.abs()) + 1e-6;
            assert!(close(pdf_w, s.pdf_w), "{name}: density {pdf_w}, sampled with {}", s.pdf_w);
            let expected = f_cos / pdf_w;
            assert!(
                close(expected.r, s.weight.r) && close(expected.b, s.weight.b),
                "{name}: {expected:?}, {:?}",
                s.weight
            );
        }
    };
    each_of(Transport::Radiance, &mut test);
    each_of(Transport::Power, &mut test);
}

#[test]
fn reflection_is_reciprocal() {
    let mut rng = Pcg::new(6, 6);
    for (name, table, _) in materials() {
        // A bent normal is reciprocal only in the bent frame, and refraction only up to the squared index.
        if name.starts_with("normal map") {
            continue;
        }
        let (scene, surface) = floor(table);
        for _ in 0..500 {
            // At grazing angles, the half vector is inaccurate.
            let [wo, wi] =
                [0; 2].map(|_| (warp::hemisphere(rng.next_2d()) + 0.05 * Vec3::Z).normalize());
            let f = |a: Vec3, b: Vec3| scene.bsdf(&surface, a, Transport::Radiance).f(a, b);
            let (there, back) = (f(wo, wi), f(wi, wo));
            let close = |a: f32, b: f32| (a - b).abs() <= 1e-3 * (a.abs() + b.abs()) + 1e-5;
            assert!(
                close(there.r, back.r) && close(there.g, back.g),
                "{name}: {there:?} against {back:?}"
            );
        }
    }
}

/// Regression: over a normal map, light tracing was 9 % too dark, and photons were too bright.
#[test]
fn light_paths_over_bent_normals_agree_with_eye_paths() {
    let mut rng = Pcg::new(6, 7);
    for (name, table, _) in materials().into_iter().filter(|(name, ..)| name.contains("map")) {
        let (scene, surface) = floor(table);
        let mut lit = 0;
        for _ in 0..2000 {
            // Test both sides, because a bent normal may face a direction below the surface. At grazing angles, values
            // are inaccurate.
            let [eye, light] = [0; 2].map(|_| {
                let d = warp::sphere(rng.next_2d());
                (d + 0.05 * Vec3::Z.copysign(d)).normalize()
            });
            let there = scene.bsdf(&surface, eye, Transport::Radiance).f_cos(eye, light).g;
            let back = scene.bsdf(&surface, light, Transport::Power).f_cos(light, eye).g;
            let (there, back) = (there * eye.z.abs(), back * light.z.abs());
            assert!(
                (there - back).abs() <= 1e-3 * (there + back) + 1e-5,
                "{name}: {there} from the eye {eye}, {back} from the light {light}"
            );
            lit += u32::from(there > 0.0);
        }
        assert!(lit > 100 || name.contains("mirror"), "{name}: {lit} pairs scatter light");
    }
}

/// Regression: caustics of mirrors with a normal map had a different brightness in light tracing.
#[test]
fn light_paths_over_a_mirror_with_bent_normals_agree_with_eye_paths() {
    // The integral over both directions of the reflected light, times the cosines and some function of both directions.
    let weight = |eye: Vec3, light: Vec3| (2.0 + eye.x) * (1.5 + light.y);
    let (_, table, _) =
        materials().into_iter().find(|(name, ..)| name.ends_with("of a mirror")).expect("a mirror");
    let (scene, surface) = floor(table);
    let mut rng = Pcg::new(6, 8);
    let mut sums = [gi_stats::Running::default(); 2];
    for (transport, sum) in [Transport::Radiance, Transport::Power].into_iter().zip(&mut sums) {
        for _ in 0..100_000 {
            let wo = warp::cosine_hemisphere(rng.next_2d());
            let bsdf = scene.bsdf(&surface, wo, transport);
            let s = bsdf.sample(wo, rng.next_f32(), rng.next_2d()).filter(|s| s.wi.z > 0.0);
            let value = s.map_or(0.0, |s| match transport {
                Transport::Radiance => s.weight.g * weight(wo, s.wi),
                Transport::Power => s.weight.g * weight(s.wi, wo),
            });
            sum.push(value.into());
        }
    }
    let p = gi_stats::welch_t_test(&sums[0], &sums[1]);
    assert!(p > 1e-3, "{} from the eye, {} from the light", sums[0].mean(), sums[1].mean());
}

#[test]
fn the_albedo_layer_lies_in_0_to_1_and_does_not_depend_on_the_view() {
    let mut seen: Vec<(String, Rgb)> = Vec::new();
    each(|view, bsdf, _, _| {
        let (name, albedo) = (view.split(" from ").next().expect("a name"), bsdf.albedo());
        assert!(albedo.to_array().iter().all(|v| (0.0..=1.0).contains(v)), "{name}: {albedo:?}");
        match seen.iter().find(|(known, _)| known == name) {
            Some((_, first)) => assert_eq!(*first, albedo, "{view}"),
            None => seen.push((name.to_string(), albedo)),
        }
    });
    let of = |name: &str| seen.iter().find(|(n, _)| n == name).expect("a material").1;
    assert_eq!(of("diffuse"), Rgb::grey(0.8));
    // Reflectance at normal incidence of index 0.2 + 3.9 i: ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2).
    let exact = (0.64 + 15.21) / (1.44 + 15.21);
    assert!((of("conductor").r - exact).abs() < 1e-5, "{:?}", of("conductor"));
}

#[test]
fn refraction_is_reciprocal_up_to_the_squared_index() {
    for distribution in [Distribution::Ggx, Distribution::Beckmann] {
        refraction_is_reciprocal(glass(rough(distribution, 0.3, 0.3)), 1.5);
    }
    let clear = |p: &mut Principled| (p.spec_trans, p.eta) = (Texture::grey(0.8), 1.5);
    refraction_is_reciprocal(principled(clear), 1.5);
}

fn refraction_is_reciprocal(material: Material, eta: f32) {
    let (scene, surface) = floor(vec![material]);
    let mut rng = Pcg::new(7, 7);
    for _ in 0..500 {
        let (above, below) = (warp::hemisphere(rng.next_2d()), -warp::hemisphere(rng.next_2d()));
        let power = |a, b| scene.bsdf(&surface, a, Transport::Power).f(a, b).r;
        let radiance = |a, b| scene.bsdf(&surface, a, Transport::Radiance).f(a, b).r;
        // f(wo, wi) / eta_i^2 = f(wi, wo) / eta_o^2 [Veach97, 5.2]; for power, the directions are exchanged.
        let (down, up) = (radiance(above, below), radiance(below, above));
        assert!((down * eta * eta - up).abs() <= 1e-3 * up + 1e-5, "{down} {up}");
        assert!((power(above, below) - up).abs() <= 1e-3 * up + 1e-5);
    }
}

#[test]
fn light_through_a_sheet_is_the_same_from_either_end() {
    let all = |p: &mut PrincipledThin| {
        (p.spec_trans, p.diff_trans) = (Texture::grey(0.6), Texture::grey(1.2));
        (p.roughness, p.anisotropic) = (Texture::grey(0.9), Texture::grey(0.5));
    };
    let (scene, surface) = floor(vec![sheet(all)]);
    let mut rng = Pcg::new(9, 7);
    for _ in 0..2000 {
        let (a, b) = (warp::sphere(rng.next_2d()), warp::sphere(rng.next_2d()));
        let radiance = scene.bsdf(&surface, a, Transport::Radiance).f(a, b).r;
        let power = scene.bsdf(&surface, b, Transport::Power).f(b, a).r;
        assert!((radiance - power).abs() <= 1e-3 * power + 1e-5, "{a} {b}: {radiance} {power}");
    }
}

#[test]
fn no_material_creates_light_and_smooth_glass_loses_none() {
    let mut rng = Pcg::new(8, 8);
    each(|name, bsdf, wo, whole| {
        let n = 20_000;
        let mut sum = 0.0f64;
        for _ in 0..n {
            if let Some(s) = bsdf.sample(wo, rng.next_f32(), rng.next_2d()) {
                // Refraction changes radiance by the squared index, but not the total power that leaves.
                sum += f64::from(s.weight.max() * s.eta * s.eta);
            }
        }
        let albedo = sum / n as f64;
        assert!(albedo < 1.01, "{name}: albedo {albedo}");
        if whole {
            assert!((albedo - 1.0).abs() < 1e-3, "{name}: albedo {albedo}");
        }
    });
}
