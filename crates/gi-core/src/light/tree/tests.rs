use std::f32::consts::PI;

use super::bounds::LightBounds;
use super::*;
use crate::geometry::{Geometry, Mesh, Shape};
use crate::light::{LightSource, Lights, Window};
use crate::math::{Frame, Rgb};
use crate::rng::Pcg;
use crate::texture::Texture;
use crate::warp;
use glam::Vec3;

/// A point of a cube with this half width.
fn point(rng: &mut Pcg, half: f32) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| half * (2.0 * rng.next_f32() - 1.0)))
}

/// Random triangles, spheres, disks, cylinders, points and spots in a cube; with `distant` also a sky and a sun.
pub(super) fn lights(count: u32, distant: bool, seed: u64) -> (Vec<Shape>, Lights) {
    let rng = &mut Pcg::new(seed, 0);
    let (mut shapes, mut sources) = (Vec::new(), Vec::new());
    for k in 0..count {
        let (p, size) = (point(rng, 5.0), 0.02 + rng.next_f32().powi(3));
        let brightness = rng.next_f32().powi(4) * 10.0;
        let direction = warp::sphere(rng.next_2d());
        let axes = Frame::from_normal(direction);
        let geometry = match k % 7 {
            0 | 1 => Geometry::Mesh(Mesh {
                positions: (0..3).map(|_| p + point(rng, size)).collect(),
                triangles: vec![[0, 1, 2]].into(),
                ..Mesh::default()
            }),
            2 => Geometry::Sphere { center: p, radius: size, axes },
            3 => Geometry::Disk { center: p, du: axes.s * size, dv: axes.t * 0.5 * size },
            4 => Geometry::Cylinder { p0: p, p1: p + direction * size, radius: 0.3 * size },
            5 => {
                sources.push(LightSource::Point { position: p, intensity: Rgb::grey(brightness) });
                continue;
            }
            _ => {
                let cutoff = 0.1 + 1.2 * rng.next_f32();
                let intensity = Rgb::grey(brightness);
                let beam = 0.5 * cutoff;
                sources.push(LightSource::Spot { position: p, direction, intensity, cutoff, beam });
                continue;
            }
        };
        let emission = Some(Texture::grey(brightness));
        let flip_normals = k % 3 == 0;
        shapes.push(Shape { emission, flip_normals, ..Shape::new("lamp", geometry, 0) });
    }
    if distant {
        sources.push(LightSource::Constant { radiance: Rgb::grey(0.1) });
        let direction = Vec3::new(0.0, -0.6, 0.8);
        sources.push(LightSource::Directional { direction, irradiance: Rgb::WHITE });
    }
    let lights = Lights::new(&shapes, sources, (Vec3::ZERO, 10.0));
    (shapes, lights)
}

/// Random points, in media and on surfaces of both kinds; some are very near a lamp.
pub(super) fn vantage<'a>(shapes: &[Shape], lights: &'a Lights, rng: &mut Pcg) -> Vantage<'a> {
    let n = warp::sphere(rng.next_2d());
    let facing =
        [Facing::Any, Facing::Side(n), Facing::Both(n)][(rng.next_f32() * 3.0) as usize % 3];
    let mut p = point(rng, 6.0);
    let lamp = (rng.next_f32() * (lights.all().len() - 1) as f32) as usize;
    if rng.next_f32() < 0.5
        && let Some(of) = LightBounds::of(&lights.all()[lamp], shapes)
    {
        p = of.bounds.center() + point(rng, 0.01);
    }
    Vantage { p, facing, tree: Some(lights.tree(shapes)) }
}

/// Radiance times cosine of a light sample at a point.
fn contribution(lights: &Lights, light: usize, at: &Vantage, rng: &mut Pcg) -> f32 {
    let sample = lights.sample_light(light, at.p, rng.next_2d(), |_, _, _| Rgb::WHITE);
    sample.map_or(0.0, |s| {
        let cos = match at.facing {
            Facing::Any => 1.0,
            Facing::Side(n) => n.dot(s.wi).max(0.0),
            Facing::Both(n) => n.dot(s.wi).abs(),
        };
        s.radiance.luminance() * cos
    })
}

#[test]
fn a_light_that_contributes_has_a_probability_and_all_probabilities_add_up_to_one() {
    for (count, distant) in [(1, false), (2, true), (30, false), (700, true), (0, true)] {
        let (shapes, lights) = lights(count, distant, u64::from(count) + 3);
        let tree = lights.tree(&shapes);
        let rng = &mut Pcg::new(7, u64::from(count));
        let mut contributing = 0;
        for _ in 0..400 {
            let at = vantage(&shapes, &lights, rng);
            let mut sum = 0.0;
            for k in 0..lights.all().len() {
                let probability = tree.probability(&at, k);
                sum += f64::from(probability);
                let most = (0..4).map(|_| contribution(&lights, k, &at, rng)).fold(0.0, f32::max);
                if most > 0.0 {
                    contributing += 1;
                    assert!(probability > 0.0, "light {k} of {count} brings {most} to {at:?}");
                }
            }
            assert!((sum - 1.0).abs() < 1e-4, "{sum} for {count} lights at {at:?}");
        }
        assert!(contributing > 100, "{contributing} contributions of {count} lights");
    }
}

#[test]
fn lights_are_chosen_with_their_probability() {
    let (shapes, lights) = lights(40, true, 11);
    let tree = lights.tree(&shapes);
    let rng = &mut Pcg::new(3, 1);
    let (points, n) = (20, 20_000);
    for _ in 0..points {
        let at = vantage(&shapes, &lights, rng);
        let mut counts = vec![0u32; lights.all().len()];
        for _ in 0..n {
            let (k, p, rest) = tree.choose(&at, rng.next_2d()).expect("lights");
            assert!((0.0..1.0).contains(&rest));
            let expected = tree.probability(&at, k);
            assert!((p / expected - 1.0).abs() < 1e-4, "light {k}: {p}, not {expected}");
            counts[k] += 1;
        }
        for (k, &count) in counts.iter().enumerate() {
            let p = f64::from(tree.probability(&at, k));
            let (mean, n) = (p * f64::from(n), f64::from(n));
            let deviation = (n * p * (1.0 - p)).sqrt();
            // One of 20 x 42 counts is beyond 5 standard deviations in one of two thousand runs.
            assert!((f64::from(count) - mean).abs() <= 5.0 * deviation.max(1.0), "{k}: {count}");
        }
    }
}

#[test]
fn the_rest_of_the_random_number_is_uniform_for_unlikely_lights_too() {
    // Of 10^5 equal points, each has about 170 of the 2^24 values of a float.
    let sources = (0..100_000).map(|k| {
        let [x, z] = [k % 300, k / 300].map(|i| i as f32);
        LightSource::Point { position: Vec3::new(x, 0.0, z), intensity: Rgb::WHITE }
    });
    let lights = Lights::new(&[], sources.collect(), (Vec3::ZERO, 500.0));
    let tree = lights.tree(&[]);
    let at = Vantage::new(Some(tree), Vec3::new(150.0, 1e5, 150.0));
    let rng = &mut Pcg::new(9, 2);
    let mut bins = [0u32; 16];
    let n = 160_000;
    for _ in 0..n {
        let (_, _, rest) = tree.choose(&at, rng.next_2d()).expect("lights");
        bins[(rest * 16.0) as usize] += 1;
    }
    for count in bins {
        assert!((f64::from(count) - 1e4).abs() < 5.0 * 1e2, "{bins:?}");
    }
}

#[test]
fn near_lamps_are_preferred() {
    let at = |x: f32| LightSource::Point { position: Vec3::X * x, intensity: Rgb::WHITE };
    let lights = Lights::new(&[], (0..64).map(|k| at(k as f32)).collect(), (Vec3::ZERO, 99.0));
    let tree = lights.tree(&[]);
    let at = Vantage::new(Some(tree), Vec3::new(20.0, 0.3, 0.0));
    let near = (18..23).map(|k| tree.probability(&at, k)).sum::<f32>();
    // By power, it would be five of 64.
    assert!(near > 4.0 * 5.0 / 64.0, "{near}");
}

/// The light tree ignores the axis of a light that emits in all directions.
#[test]
fn a_spot_of_all_directions_is_chosen_like_a_point() {
    let place = |k: u32| Vec3::new((k % 8) as f32, (k / 8) as f32, 0.0);
    let points = (0..64).map(|k| LightSource::Point { position: place(k), intensity: Rgb::WHITE });
    let spots = (0..64).map(|k| LightSource::Projector {
        position: place(k),
        axes: [Vec3::X, Vec3::Y, Vec3::Z],
        intensity: Rgb::WHITE,
        cutoff: PI,
        beam: PI,
        picture: Texture::grey(1.0),
        window: Window::Unfolded,
    });
    let of = |sources: Vec<LightSource>| Lights::new(&[], sources, (Vec3::ZERO, 99.0));
    let [points, spots] = [of(points.collect()), of(spots.collect())];
    let p = Vec3::new(2.3, 1.2, -1.0);
    let choices = [&points, &spots].map(|lights| {
        let at = Vantage::new(Some(lights.tree(&[])), p);
        (0..64).map(|k| lights.tree(&[]).probability(&at, k)).collect::<Vec<f32>>()
    });
    let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * b;
    assert!(choices[0].iter().zip(&choices[1]).all(close), "{choices:?}");
}

#[test]
fn lamps_behind_a_surface_and_lamps_that_face_away_are_not_chosen() {
    let at = |z: f32| LightSource::Point { position: Vec3::Z * z, intensity: Rgb::WHITE };
    let away = LightSource::Spot {
        position: Vec3::Z,
        direction: Vec3::Z,
        intensity: Rgb::WHITE,
        cutoff: 0.5 * PI,
        beam: 0.1,
    };
    let lights = Lights::new(&[], vec![at(1.0), at(-1.0), away], (Vec3::ZERO, 9.0));
    let tree = lights.tree(&[]);
    let facing = |facing| Vantage { p: Vec3::ZERO, facing, tree: Some(tree) };
    let all = |at: Vantage| [0, 1, 2].map(|k| tree.probability(&at, k));
    assert_eq!(all(facing(Facing::Side(Vec3::Z))), [1.0, 0.0, 0.0]);
    assert_eq!(all(facing(Facing::Side(-Vec3::Z))), [0.0, 1.0, 0.0]);
    let [above, below, away] = all(facing(Facing::Both(Vec3::Z)));
    assert!(above > 0.2 && below > 0.2 && away == 0.0, "{above} {below} {away}");
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (shapes, lights) = lights(20_000, true, 2);
            format!("{:?}", lights.tree(&shapes))
        })
    };
    let one = with(1);
    assert!(one == with(2) && one == with(3));
}

#[test]
fn ten_thousand_lamps_at_one_place_are_found() {
    let lamp = LightSource::Point { position: Vec3::ONE, intensity: Rgb::WHITE };
    let lights = Lights::new(&[], vec![lamp; 10_000], (Vec3::ZERO, 9.0));
    let tree = lights.tree(&[]);
    let at = Vantage::new(Some(tree), Vec3::ZERO);
    let most = (0..10_000).map(|k| tree.probability(&at, k)).fold(0.0, f32::max);
    assert!(most > 0.0 && most < 2e-4, "{most}");
}
