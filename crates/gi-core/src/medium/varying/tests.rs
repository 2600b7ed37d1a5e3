use std::sync::Arc;

use glam::Quat;

use super::*;
use crate::medium::{Between, Cells, Grid, Medium, Outside, Phase};

const N: u32 = 100_000;

fn grid(size: [usize; 3], values: Vec<Rgb>, outside: Outside, between: Between) -> Arc<Grid> {
    Arc::new(Grid::new(size, Cells::Color(values.into()), outside, between).expect("a grid"))
}

/// A medium of these values over the box from the origin to `extent`.
fn medium(size: [usize; 3], values: Vec<Rgb>, extent: Vec3, between: Between) -> Varying {
    let to_local = Affine3A::from_scale(extent).inverse();
    let grid = grid(size, values, Outside::Clamp, between);
    let sigma_t = Volume::Grid { grid, to_local, factor: Rgb::WHITE };
    Varying::new(sigma_t, Volume::Constant(Rgb::new(0.9, 0.5, 0.2)), Domain::Cube(to_local))
}

/// Random values, of which most are zero: the majorants differ from block to block.
fn sparse(size: [usize; 3]) -> Vec<Rgb> {
    let mut rng = Pcg::new(1, 2);
    let count = size.iter().product();
    let value = |rng: &mut Pcg| match rng.next_below(4) {
        0 => Rgb::new(rng.next_f32(), 2.0 * rng.next_f32(), 5.0 * rng.next_f32()),
        _ => Rgb::BLACK,
    };
    (0..count).map(|_| value(&mut rng)).collect()
}

/// The integral of sigma_t on a ray by the midpoint rule.
fn optical_depth(m: &Varying, (o, d): (Vec3, Vec3), reach: f32) -> [f64; 3] {
    const STEPS: u32 = 200_000;
    let step = f64::from(reach) / f64::from(STEPS);
    let mut sum = [0.0; 3];
    for k in 0..STEPS {
        let p = o + d * ((f64::from(k) + 0.5) * step) as f32;
        let q = m.domain.to_cube().transform_point3(p);
        if q.min_element() >= 0.0 && q.max_element() <= 1.0 {
            let sigma = m.sigma_t.at(p).to_array();
            (0..3).for_each(|c| sum[c] += f64::from(sigma[c]) * step);
        }
    }
    sum
}

/// Mean and standard error of colours.
fn mean(mut draw: impl FnMut(&mut Tracking) -> Rgb) -> [(f64, f64); 3] {
    let (mut sum, mut squares) = ([0.0f64; 3], [0.0f64; 3]);
    let mut rng = Pcg::new(9, 4);
    for _ in 0..N {
        let value = draw(&mut Tracking::new(rng.next_2d())).to_array().map(f64::from);
        for c in 0..3 {
            sum[c] += value[c];
            squares[c] += value[c] * value[c];
        }
    }
    let n = f64::from(N);
    [0, 1, 2].map(|c| {
        let mean = sum[c] / n;
        (mean, ((squares[c] / n - mean * mean).max(0.0) / n).sqrt())
    })
}

fn assert_means(what: &str, found: [(f64, f64); 3], expected: [f64; 3]) {
    for c in 0..3 {
        let (mean, error) = found[c];
        let z = (mean - expected[c]).abs() / (error + 1e-5);
        assert!(z < 4.5, "{what}, channel {c}: {mean} +- {error}, not {}", expected[c]);
    }
}

/// Rays through the unit cube in several directions; one is along an axis, one starts inside, one misses the cube.
fn rays() -> [((Vec3, Vec3), f32); 4] {
    let o = Vec3::new(-0.5, 0.2, 0.3);
    let slanted = Vec3::new(1.0, 0.4, 0.3).normalize();
    [
        ((o, Vec3::X), 4.0),
        ((o, slanted), 1.1),
        ((Vec3::new(0.5, 0.6, 0.4), -slanted), 3.0),
        ((o, Vec3::Y), 3.0),
    ]
}

#[test]
fn the_mean_of_ratio_tracking_is_the_transmittance_by_quadrature() {
    for between in [Between::Trilinear, Between::Nearest] {
        let m = medium([9, 12, 7], sparse([9, 12, 7]), Vec3::ONE, between);
        for (line, reach) in rays() {
            let expected = optical_depth(&m, line, reach).map(|depth| (-depth).exp());
            let found = mean(|random| m.transmittance(line, reach, random));
            assert_means(&format!("{between:?}, {line:?}"), found, expected);
        }
    }
}

#[test]
fn delta_tracking_passes_and_scatters_the_right_fractions_in_each_channel() {
    let m = medium([9, 12, 7], sparse([9, 12, 7]), Vec3::ONE, Between::Trilinear);
    for throughput in [Rgb::WHITE, Rgb::new(0.1, 0.5, 3.0)] {
        for (line, reach) in rays() {
            let passed = optical_depth(&m, line, reach).map(|depth| (-depth).exp());
            let found = mean(|random| match m.track(line, reach, throughput, random) {
                Flight::Passed { weight } => weight,
                Flight::Scattered { .. } => Rgb::BLACK,
            });
            assert_means(&format!("passed, {line:?}"), found, passed);
            let albedo = [0.9, 0.5, 0.2];
            let scattered = [0, 1, 2].map(|c| (1.0 - passed[c]) * albedo[c]);
            let found = mean(|random| match m.track(line, reach, throughput, random) {
                Flight::Passed { .. } => Rgb::BLACK,
                Flight::Scattered { t, weight } => {
                    assert!((0.0..reach).contains(&t));
                    weight
                }
            });
            assert_means(&format!("scattered, {line:?}"), found, scattered);
        }
    }
}

#[test]
fn a_slab_of_linearly_varying_density_transmits_the_exponential_of_its_integral() {
    // Between the outer centres of a grid of two cells the density is a + (b - a) x.
    let [a, b] = [Rgb::new(0.2, 1.0, 3.0), Rgb::new(2.0, 1.0, 0.0)];
    let m = medium([2, 1, 1], vec![a, b], Vec3::ONE, Between::Trilinear);
    let line = (Vec3::new(0.25, 0.5, 0.5), Vec3::X);
    let depth = ((a + b) * 0.25).to_array().map(f64::from);
    let found = mean(|random| m.transmittance(line, 0.5, random));
    assert_means("slab", found, depth.map(|d| (-d).exp()));
    // The part up to a third of the way: the integral of a + (b - a) x over (0, 1/3), times the width 1/2.
    let third = (a * (1.0 / 3.0) + (b - a) * (1.0 / 18.0)) * 0.5;
    let found = mean(|random| m.transmittance(line, 0.5 / 3.0, random));
    assert_means("a third of it", found, third.to_array().map(|d| (-f64::from(d)).exp()));
}

#[test]
fn a_grid_of_one_value_tracks_like_the_homogeneous_medium() {
    let sigma_t = Rgb::new(0.3, 1.0, 4.0);
    let m = medium([5, 9, 13], vec![sigma_t; 5 * 9 * 13], Vec3::splat(2.0), Between::Trilinear);
    let exact = Medium::homogeneous(sigma_t, Rgb::new(0.9, 0.5, 0.2), Phase::Isotropic);
    let line = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.6, 0.48, 0.64));
    // The density of a block is known, so its transmittance is exact.
    let found = m.transmittance(line, 1.5, &mut Tracking::none()).to_array();
    for (found, expected) in found.into_iter().zip(exact.transmittance(1.5).to_array()) {
        assert!((found / expected - 1.0).abs() < 1e-5, "{found}, not {expected}");
    }
    // Moments of the distance, weighted by the light that is scattered there.
    for power in 0..3 {
        let moment = |flight| match flight {
            Flight::Passed { .. } => Rgb::BLACK,
            Flight::Scattered { t, weight } => weight * t.powi(power),
        };
        let a = mean(|random| moment(m.track(line, 1.5, Rgb::WHITE, random)));
        let b = mean(|random| {
            let u = [random.next(), random.next()];
            moment(exact.fly(1.5, Rgb::WHITE, u))
        });
        for c in 0..3 {
            let error = (a[c].1.powi(2) + b[c].1.powi(2)).sqrt();
            let z = (a[c].0 - b[c].0) / error;
            assert!(z.abs() < 4.5, "moment {power}, channel {c}: {:?} and {:?}", a[c], b[c]);
        }
    }
}

#[test]
fn a_turned_medium_ends_at_its_cube_or_at_the_box_around_it() {
    let turn = Affine3A::from_quat(Quat::from_rotation_z(std::f32::consts::FRAC_PI_4));
    let to_local = (turn * Affine3A::from_translation(Vec3::splat(-0.5))).inverse();
    let values = grid([1; 3], vec![Rgb::WHITE], Outside::Clamp, Between::Trilinear);
    let line = (Vec3::new(-3.0, 0.6, 0.1), Vec3::X);
    // At this height the turned square is 2 (1/sqrt 2 - 0.6) wide, the box around it sqrt 2.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    for (domain, width) in
        [(Domain::Cube(to_local), 2.0 * (half - 0.6)), (Domain::BoxAround(to_local), 2.0 * half)]
    {
        let sigma_t = Volume::Grid { grid: values.clone(), to_local, factor: Rgb::grey(2.0) };
        let mut m = Varying::new(sigma_t, Volume::Constant(Rgb::WHITE), domain);
        for by in [Vec3::ZERO, Vec3::new(0.25, 0.5, -2.0)] {
            m.shift(by);
            let line = (line.0 + by, line.1);
            let found = m.transmittance(line, f32::INFINITY, &mut Tracking::none()).g;
            assert!((found.ln() / (-2.0 * width) - 1.0).abs() < 1e-4, "{domain:?}: {found}");
        }
    }
}

#[test]
fn empty_space_and_rays_along_faces_cost_no_collisions() {
    let mut values = vec![Rgb::BLACK; 64 * 64];
    values[0] = Rgb::grey(50.0);
    let m = medium([64, 64, 1], values, Vec3::ONE, Between::Trilinear);
    for (o, d) in [
        (Vec3::new(-1.0, 0.9, 0.5), Vec3::X),
        (Vec3::new(0.5, 1.0, 0.0), Vec3::Y),
        (Vec3::new(0.0, 0.5, 1.0), -Vec3::Z),
    ] {
        let mut random = Tracking::new([0.25, 0.5]);
        let flight = m.track((o, d), f32::INFINITY, Rgb::WHITE, &mut random);
        assert_eq!(flight, Flight::Passed { weight: Rgb::WHITE });
        let mut fresh = Tracking::new([0.25, 0.5]);
        fresh.next();
        assert_eq!(random.next(), fresh.next(), "one number is drawn for the whole ray");
    }
}
