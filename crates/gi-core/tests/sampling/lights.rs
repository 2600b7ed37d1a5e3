//! Tests of lights: sampled with their density, consistent with rays that hit them, and with the right emitted power.

use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::{Frame, Rgb};
use gi_core::ray::Ray;
use gi_core::rng::Pcg;
use gi_core::scene::{Scene, SceneParts};
use gi_core::texture::{Bitmap, Lookup, Texels, Texture, Wrap};
use glam::{Affine2, Affine3A, Vec2, Vec3};
use std::sync::Arc;

use crate::grid::check_edged;

fn shining(geometry: Geometry) -> SceneParts {
    // Smooth across the seam of u, so that a point and the ray to it may differ by rounding.
    let texel = |x: usize, y: usize| {
        Rgb::grey(2.0 + (x as f32 / 64.0 * std::f32::consts::TAU).cos() + y as f32 / 32.0)
    };
    let texels = (0..32).flat_map(|y| (0..64).map(move |x| texel(x, y))).collect();
    let bitmap =
        Arc::new(Bitmap::new(64, 32, Texels::Float(texels), Wrap::Repeat, Lookup::Bilinear));
    let to_uv = Affine2::from_scale(Vec2::new(1.0, 0.9));
    let emission = Some(Texture::Bitmap { bitmap, to_uv, scale: Rgb::WHITE });
    let shape = Shape { emission, ..Shape::new("light", geometry, 0) };
    let materials = vec![Material::Diffuse { reflectance: Texture::grey(0.5) }];
    SceneParts { shapes: vec![shape], materials, ..SceneParts::default() }
}

fn triangles() -> Geometry {
    let corners =
        [[-1.0, -1.0, 2.0], [1.0, -1.2, 2.2], [1.1, 1.0, 2.0], [-1.0, 1.3, 1.5], [-3.0, 0.0, 0.5]];
    Geometry::Mesh(Mesh {
        positions: corners.map(Vec3::from_array).to_vec(),
        // Faces down, toward the origin.
        triangles: vec![[0, 2, 1], [0, 3, 2], [0, 4, 3]].into(),
        ..Mesh::default()
    })
}

fn environment() -> LightSource {
    // A gradient with a bright spot and a black band.
    let texel = |x: usize, y: usize| {
        let base = if y == 9 { 0.0 } else { 0.2 + 0.05 * y as f32 };
        Rgb::grey(base + if (x, y) == (7, 4) { 20.0 } else { 0.0 }) * if x > 24 { 3.0 } else { 1.0 }
    };
    let texels = (0..16).flat_map(|y| (0..32).map(move |x| texel(x, y))).collect();
    let image = Bitmap::new(32, 16, Texels::Float(texels), Wrap::Repeat, Lookup::Bilinear);
    LightSource::Environment { image, scale: 2.0, to_world: Affine3A::from_rotation_x(0.7) }
}

/// Scenes with one kind of light each, all visible from the origin.
fn scenes() -> Vec<(&'static str, Scene)> {
    let solid = |g| Scene::new(shining(g)).expect("a scene");
    let distant = |light| {
        let parts = SceneParts { lights: vec![light], ..shining(Geometry::Mesh(Mesh::default())) };
        Scene::new(parts).expect("a scene")
    };
    let axes = Frame::from_normal(Vec3::Z);
    vec![
        ("triangles", solid(triangles())),
        ("sphere", solid(Geometry::Sphere { center: Vec3::new(0.3, 1.0, 1.5), radius: 0.6, axes })),
        (
            "distant sphere",
            solid(Geometry::Sphere { center: Vec3::new(12.0, 1.0, 6.0), radius: 4.0, axes }),
        ),
        (
            "disk",
            solid(Geometry::Disk {
                center: Vec3::new(0.5, 0.0, 1.0),
                du: -Vec3::X,
                dv: Vec3::new(0.0, 0.7, 0.2),
            }),
        ),
        (
            "cylinder",
            solid(Geometry::Cylinder {
                p0: Vec3::new(1.0, -1.0, 1.0),
                p1: Vec3::new(1.0, 1.0, 0.7),
                radius: 0.6,
            }),
        ),
        ("constant", distant(LightSource::Constant { radiance: Rgb::WHITE })),
        ("environment", distant(environment())),
        (
            "distant disc",
            distant(LightSource::DistantDisc {
                direction: Vec3::new(0.6, 0.0, 0.8),
                angular_radius: 0.4,
                radiance: Rgb::WHITE,
            }),
        ),
        ("all together", {
            let lights = vec![LightSource::Constant { radiance: Rgb::grey(0.01) }, environment()];
            Scene::new(SceneParts { lights, ..shining(triangles()) }).expect("a scene")
        }),
    ]
}

/// Radiance and density of the light that a ray from the origin hits, as in a path tracer.
fn seen(scene: &Scene, d: Vec3) -> (Rgb, f32) {
    let escaped: Vec<(Rgb, f32)> = scene.escaped(d).collect();
    let behind: f32 = escaped.iter().map(|e| e.1).sum();
    match scene.intersect(&Ray::new(Vec3::ZERO, d)) {
        Some((surface, _)) => {
            let emitted = scene.emitted(&surface, -d);
            let pdf =
                if emitted.is_black() { 0.0 } else { scene.light_pdf_w(Vec3::ZERO, &surface) };
            (emitted, pdf + behind)
        }
        None => (escaped.iter().map(|e| e.0).sum(), behind),
    }
}

#[test]
fn lights_are_sampled_with_the_density() {
    for (k, (name, scene)) in scenes().iter().enumerate() {
        let draw = |r: &mut Pcg| scene.sample_light(Vec3::ZERO, r.next_2d()).map(|s| s.wi);
        check_edged(name, 300 + k as u64, draw, |w| seen(scene, w).1);
    }
}

#[test]
fn samples_agree_with_rays_that_hit_the_light() {
    let mut rng = Pcg::new(2, 2);
    for (name, scene) in scenes() {
        if name == "all together" {
            continue; // several lights share a direction there
        }
        let mut found = 0;
        for _ in 0..5000 {
            let Some(s) = scene.sample_light(Vec3::ZERO, rng.next_2d()) else {
                continue;
            };
            let (radiance, pdf_w) = seen(&scene, s.wi);
            if pdf_w == 0.0 || s.pdf_w > 50.0 {
                continue; // the edge, which rounding may miss, or a grazing view, where the cosine is inaccurate
            }
            // The density contains one over a cosine, which has an absolute error.
            let tolerance = s.pdf_w * (2e-3 + 2e-4 * s.pdf_w);
            found += 1;
            assert!(
                (radiance.r - s.radiance.r).abs() < 5e-3 * (1.0 + s.radiance.r),
                "{name}: {radiance:?}, {s:?}"
            );
            assert!(
                (pdf_w - s.pdf_w).abs() < tolerance,
                "{name}: density {pdf_w}, sampled with {}",
                s.pdf_w
            );
        }
        assert!(found > 1500, "{name}: only {found} samples reach the light");
    }
}

#[test]
fn samples_that_rounding_moves_off_a_light_keep_their_densities() {
    // Rounding moves directions at the edge of so narrow a sun off its disc.
    let direction = Vec3::new(0.6, 0.0, 0.8);
    let sun = LightSource::DistantDisc { direction, angular_radius: 0.002, radiance: Rgb::WHITE };
    let parts = SceneParts { lights: vec![sun], ..shining(triangles()) };
    let narrow = ("narrow sun", Scene::new(parts).expect("a scene"));
    let mut rng = Pcg::new(12, 0);
    for (name, scene) in scenes().into_iter().chain([narrow]) {
        let finite = |x: f32| x.is_finite() && x > 0.0;
        for _ in 0..20_000 {
            let z = Vec3::from_array([(); 3].map(|()| 4.0 * rng.next_f32() - 2.0));
            if let Some(s) = scene.sample_light(z, rng.next_2d()) {
                let end = scene.lights().end_of_sample(&s, z);
                assert!(finite(end.emit) && finite(end.direct), "{name}: {s:?} has {end:?}");
            }
            if let Some(e) = scene.emit(rng.next_f32(), rng.next_2d(), rng.next_2d()) {
                let end = scene.lights().end_of_emission(&e, e.p + e.d);
                assert!(finite(end.emit) && finite(end.direct), "{name}: {e:?} has {end:?}");
            }
        }
    }
}

#[test]
fn a_narrow_spot_emits_all_of_its_power() {
    // As the loader makes of a collimated beam: 1 - cos of the cutoff is 8.4 units in the last place of 1.
    let cutoff = 1e-3;
    let direction = Vec3::new(0.36, 0.48, 0.8);
    let intensity = Rgb::WHITE;
    let light =
        LightSource::Spot { position: Vec3::ZERO, direction, intensity, cutoff, beam: cutoff };
    let parts = SceneParts { lights: vec![light], ..shining(Geometry::Mesh(Mesh::default())) };
    let scene = Scene::new(parts).expect("a scene");
    let (mut rng, n, mut power) = (Pcg::new(13, 0), 20_000, 0.0f64);
    for _ in 0..n {
        let e = scene.emit(rng.next_f32(), rng.next_2d(), rng.next_2d()).expect("it shines");
        power += f64::from(e.power.r);
    }
    let expected = std::f64::consts::PI * f64::from(cutoff).powi(2);
    // Rounding moves few directions at the rim outside.
    assert!((power / f64::from(n) / expected - 1.0).abs() < 2e-3, "{power} of {expected}");
}

#[test]
fn emitted_power_equals_the_power_that_falls_on_a_closed_sphere() {
    // Compute it backwards: the irradiance at points of a large sphere, by light sampling, sums to the emitted power.
    let mut rng = Pcg::new(4, 4);
    for (name, scene) in scenes() {
        if scene.lights().all().iter().any(|l| !matches!(l, gi_core::light::Light::Area { .. })) {
            continue; // light from infinity does not leave through the sphere
        }
        let (n, radius) = (400_000, 20.0f32);
        let center = scene.bounds().center();
        let (mut emitted, mut received) = (0.0f64, 0.0f64);
        for _ in 0..n {
            let e = scene.emit(rng.next_f32(), rng.next_2d(), rng.next_2d()).expect("it shines");
            emitted += f64::from(e.power.r);
            let inward = -gi_core::warp::sphere(rng.next_2d());
            let p = center - inward * radius;
            if let Some(s) = scene.sample_light(p, rng.next_2d()) {
                // The emitters are convex pieces in the open. Only other pieces occlude them, as they do for the
                // emission, part of which hits them again.
                let ray = scene.tree().shadow_ray(p, inward, s.p.expect("near"));
                let arrives = scene.transmittance(ray).r * s.wi.dot(inward);
                received += f64::from(s.radiance.r * arrives / s.pdf_w)
                    * 4.0
                    * std::f64::consts::PI
                    * f64::from(radius * radius);
            }
        }
        let (emitted, received) = (emitted / n as f64, received / n as f64);
        // Light between the triangles of the bent sheet stays inside: less than 3 % of it.
        assert!(
            (received / emitted - 1.0).abs() < 0.03,
            "{name}: {emitted} emitted, {received} received"
        );
    }
}

#[test]
fn a_tilted_quad_gives_no_nan_at_its_own_points() {
    let turn = Affine3A::from_axis_angle(Vec3::new(0.6, 0.8, 0.0), 0.7)
        * Affine3A::from_scale(Vec3::splat(0.6));
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let positions = corners.map(|[x, y]| turn.transform_point3(Vec3::new(x, y, 0.0))).to_vec();
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]].into(), ..Mesh::default() };
    let scene = Scene::new(shining(Geometry::Mesh(mesh))).expect("a scene");
    let mut rng = Pcg::new(11, 0);
    for _ in 0..200_000 {
        let [x, y] = rng.next_2d().map(|u| 2.0 * u - 1.0);
        let p = turn.transform_point3(Vec3::new(x, y, 0.0));
        if let Some(s) = scene.sample_light(p, rng.next_2d()) {
            assert!(s.wi.is_finite() && s.radiance.is_finite() && s.pdf_w > 0.0, "{s:?} from {p}");
        }
    }
}
