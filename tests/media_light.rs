//! Compares paths from the lights in participating media with closed forms and with `pathtrace --mode volpath`.
//!
//! A path from a light may splat many times onto a picture, so the pixels of a pass are not independent. The variance
//! of means is therefore estimated from several seeds, not from the film.

use gi_core::camera::CameraSpec;
use gi_core::eye::PathLimits;
use gi_core::film::Show;
use gi_core::geometry::Shape;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::medium::{Medium, Phase};
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_stats::{Running, sidak, welch_t_test};
use gi_tests::{World, furnace, grey, polygon, sphere};
use glam::Vec3;
use pathtrace::{Mode, Params, PathTracer};

use crate::agreement::blocks;

const SEEDS: u32 = 16;

/// Means over seeds, for blocks of `side` pixels and for each channel.
pub(crate) fn block_means<'a, T: Technique<'a>>(
    world: &'a World,
    params: &T::Params,
    passes: u32,
    show: Show,
    side: usize,
) -> Vec<Running> {
    let mut means = Vec::new();
    for seed in 0..SEEDS {
        let found = blocks(&world.render::<T>(params, passes, seed, show), side);
        means.resize(found.len(), Running::default());
        means.iter_mut().zip(found).for_each(|(running, (mean, _))| running.push(mean));
    }
    means
}

pub(crate) fn assert_agree(name: &str, found: &[Running], expected: &[Running]) {
    let level = sidak(1e-3, found.len());
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        let p = welch_t_test(a, b);
        let [ea, eb] = [a, b].map(|r| r.variance_of_mean().sqrt());
        assert!(
            p > level,
            "{name}, block {k}: {:.5} +- {ea:.1e} against {:.5} +- {eb:.1e}, p = {p:.1e}",
            a.mean(),
            b.mean()
        );
    }
}

/// Check that the standard error of the mean over the picture is at most this fraction of it.
pub(crate) fn assert_accurate(name: &str, means: &[Running], fraction: f64) {
    let mean = means.iter().map(Running::mean).sum::<f64>();
    let variance = means.iter().map(Running::variance_of_mean).sum::<f64>();
    assert!(variance.sqrt() < fraction * mean, "{name}: {mean} +- {}", variance.sqrt());
}

pub(crate) fn mode(mode: Mode, max_depth: Option<u32>) -> Params {
    Params { mode, limits: PathLimits { max_depth, ..PathLimits::default() }, ..Params::default() }
}

/// Check that a medium is invisible: the picture reads `expected` everywhere.
pub(crate) fn assert_reads(name: &str, world: &World, (m, passes): (Mode, u32), expected: f64) {
    let found = block_means::<PathTracer>(world, &mode(m, None), passes, Show::All, 8);
    // With a sample of zero variance, Welch's test becomes Student's test.
    let exact: Running = [expected; 2].into_iter().collect();
    assert_agree(name, &found, &vec![exact; found.len()]);
    let error = found.iter().map(|r| r.variance_of_mean().sqrt()).fold(0.0, f64::max);
    assert!(error < 0.02 * expected, "{name}: noise {error:.1e}");
}

fn mist(sigma_t: f32, g: f32) -> Medium {
    let phase = if g == 0.0 { Phase::Isotropic } else { Phase::HenyeyGreenstein { g } };
    Medium::homogeneous(Rgb::grey(sigma_t), Rgb::WHITE, phase)
}

pub(crate) fn ball(center: Vec3, radius: f32, material: usize) -> Shape {
    Shape::new("ball", sphere(center, radius), material)
}

#[test]
fn a_medium_of_albedo_one_is_invisible_in_a_white_furnace() {
    for (sigma_t, g) in [(0.5, 0.0), (4.0, 0.7), (4.0, -0.4)] {
        let parts = SceneParts {
            shapes: vec![Shape { interior: Some(MediumId::new(0)), ..ball(Vec3::ZERO, 0.6, 0) }],
            materials: vec![Material::Null],
            media: vec![mist(sigma_t, g)],
            lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
            ..SceneParts::default()
        };
        let camera =
            CameraSpec::look_at(Vec3::new(0.0, 0.0, -2.0), Vec3::ZERO, Vec3::Y, 0.6, [16, 16]);
        assert_reads(
            &format!("sigma_t {sigma_t}, g {g}"),
            &World::new(parts, &camera),
            (Mode::Light, 64),
            1.0,
        );
    }
}

#[test]
fn a_furnace_filled_with_a_medium_of_albedo_one_reads_one_over_one_minus_a() {
    // The camera is inside. Scattering close to it would contribute without bound, so it sees only beyond its near
    // plane.
    let (mut parts, camera) = furnace(0.5);
    parts.media = vec![mist(0.8, 0.3)];
    parts.shapes[0].exterior = Some(MediumId::new(0));
    let world = World::new(parts, &CameraSpec { near: 0.3, ..camera });
    assert_reads("full furnace", &world, (Mode::Light, 64), 2.0);
}

/// Mist with a denser ball in it, over a floor under a lamp and a sky. A glass ball outside the picture focuses the
/// lamp onto both. Everything, including the camera, is in a ball of absorbing air. Media differ by channel.
pub(crate) fn murky_parts() -> SceneParts {
    let floor = [[-2.0, -1.0, -2.0], [-2.0, -1.0, 2.0], [2.0, -1.0, 2.0], [2.0, -1.0, -2.0]];
    let lamp = [[-0.6, 1.6, -0.4], [0.2, 1.6, -0.4], [0.2, 1.6, 0.4], [-0.6, 1.6, 0.4]];
    let phase = Phase::HenyeyGreenstein { g: 0.5 };
    let [air, thin, dense] = [0, 1, 2].map(|k| Some(MediumId::new(k)));
    let within = |interior, exterior, shape| Shape { interior, exterior, ..shape };
    let emission = Some(Texture::Constant(Rgb::new(5.0, 4.0, 3.0)));
    SceneParts {
        shapes: vec![
            Shape::new("floor", polygon(&floor.map(Vec3::from_array)), 0),
            within(air, None, ball(Vec3::ZERO, 3.0, 1)),
            within(thin, air, ball(Vec3::new(0.0, -0.1, 0.0), 0.8, 1)),
            within(dense, thin, ball(Vec3::new(0.2, -0.2, 0.1), 0.4, 1)),
            within(None, air, ball(Vec3::new(-0.2, 1.15, 0.0), 0.3, 2)),
            Shape { emission, ..Shape::new("lamp", polygon(&lamp.map(Vec3::from_array)), 0) },
        ],
        materials: vec![
            grey(0.5),
            Material::Null,
            Material::Dielectric {
                eta: 1.5,
                reflectance: Texture::grey(1.0),
                transmittance: Texture::grey(1.0),
                roughness: None,
            },
        ],
        media: vec![
            Medium::homogeneous(Rgb::new(0.05, 0.1, 0.2), Rgb::BLACK, phase),
            Medium::homogeneous(Rgb::new(2.0, 1.2, 0.7), Rgb::new(0.9, 0.7, 0.5), phase),
            Medium::homogeneous(
                Rgb::new(3.0, 4.0, 6.0),
                Rgb::new(0.5, 0.9, 0.95),
                Phase::Isotropic,
            ),
        ],
        lights: vec![LightSource::Constant { radiance: Rgb::new(0.05, 0.1, 0.2) }],
        ..SceneParts::default()
    }
}

pub(crate) fn murky_camera() -> CameraSpec {
    let target = Vec3::new(0.0, -0.1, 0.0);
    let camera = CameraSpec::look_at(Vec3::new(0.3, 0.2, 2.6), target, Vec3::Y, 0.7, [24, 24]);
    CameraSpec { near: 0.4, ..camera }
}

#[test]
fn paths_from_the_eye_and_from_the_lights_agree_in_media() {
    assert_paths_agree(&World::new(murky_parts(), &murky_camera()));
}

/// Check that both find the same light, of each kind.
pub(crate) fn assert_paths_agree(world: &World) {
    assert!(world.scene.media_warnings().is_empty(), "{:?}", world.scene.media_warnings());
    for (show, max_depth, passes) in [
        (Show::All, None, [8, 64]),
        (Show::Direct, None, [8, 32]),
        (Show::Indirect, None, [16, 96]),
        (Show::Indirect, Some(3), [16, 96]),
        (Show::Caustic, None, [64, 64]),
    ] {
        let [eye, light] = [(Mode::VolPath, passes[0]), (Mode::Light, passes[1])]
            .map(|(m, n)| block_means::<PathTracer>(world, &mode(m, max_depth), n, show, 8));
        assert_agree(&format!("{show:?}, {max_depth:?}"), &light, &eye);
        // The mean over the picture must be accurate to 2 % in both.
        [&eye, &light].into_iter().for_each(|all| assert_accurate(&format!("{show:?}"), all, 0.02));
    }
}
