//! Compares counts of directions in cells of the sphere with a density integrated over the same cells.

use gi_core::rng::Pcg;
use gi_stats::{chi2_test, sidak};
use glam::Vec3;

/// Number of cells in cos(theta) and in phi.
const CELLS: [usize; 2] = [12, 24];
/// Number of sampled directions per test.
const DRAWS: usize = 100_000;
/// Probability of a false alarm in any of the tests of this file together. Seeds are fixed, so a test that passes keeps
/// passing.
const ALPHA: f64 = 1e-2;
/// An upper bound of the number of tests.
const TESTS: usize = 500;

/// Check that `draw` has density `pdf_w` per solid angle. Samples that are `None` end a path: the density then
/// integrates to one minus their fraction.
pub(crate) fn check(
    name: &str,
    seed: u64,
    draw: impl FnMut(&mut Pcg) -> Option<Vec3>,
    pdf_w: impl Fn(Vec3) -> f32,
) {
    compare(name, seed, draw, |c| integrate_smooth(c, &pdf_w));
}

/// [`check`] for a density with edges and poles, where quadrature rules fail: integrates with jittered points.
pub(crate) fn check_edged(
    name: &str,
    seed: u64,
    draw: impl FnMut(&mut Pcg) -> Option<Vec3>,
    pdf_w: impl Fn(Vec3) -> f32,
) {
    let mut rng = Pcg::new(seed, 78);
    compare(name, seed, draw, |c| integrate_jittered(c, &pdf_w, &mut rng));
}

fn compare(
    name: &str,
    seed: u64,
    mut draw: impl FnMut(&mut Pcg) -> Option<Vec3>,
    mut integral: impl FnMut(usize) -> f64,
) {
    let mut rng = Pcg::new(seed, 77);
    let mut counts = vec![0u64; CELLS[0] * CELLS[1]];
    for _ in 0..DRAWS {
        if let Some(w) = draw(&mut rng) {
            assert!((w.length() - 1.0).abs() < 1e-3, "{name}: {w} is not unit");
            counts[cell(w)] += 1;
        }
    }
    let expected: Vec<f64> = (0..counts.len()).map(|c| DRAWS as f64 * integral(c)).collect();
    // Samples that are `None` have a cell of their own.
    let (drawn, total) = (counts.iter().sum::<u64>(), expected.iter().sum::<f64>());
    assert!(
        total < DRAWS as f64 * 1.02,
        "{name}: the density integrates to {}",
        total / DRAWS as f64
    );
    let counts = [counts, vec![DRAWS as u64 - drawn]].concat();
    // A sliver that the points of the quadrature miss may catch a sample or two. More would be an error of the density.
    let in_holes: u64 =
        counts.iter().zip(&expected).filter(|(_, e)| **e == 0.0).map(|(c, _)| c).sum();
    assert!(in_holes <= 5, "{name}: {in_holes} draws where the density is zero");
    let expected: Vec<f64> = expected.into_iter().map(|e| e.max(1e-3)).collect();
    let rest = (DRAWS as f64 - total).max(if drawn < DRAWS as u64 { 1e-3 } else { 0.0 });
    let expected = [expected, vec![rest]].concat();
    match chi2_test(&counts, &expected) {
        Ok(found) => assert!(
            found.p_value > sidak(ALPHA, TESTS),
            "{name}: chi^2 {:.1} with {} degrees, p = {:.2e}",
            found.statistic,
            found.degrees,
            found.p_value
        ),
        Err(c) => panic!("{name}: {} draws in cell {c}, where the density is zero", counts[c]),
    }
}

fn cell(w: Vec3) -> usize {
    let [nz, nphi] = CELLS;
    let z = (((w.z + 1.0) * 0.5 * nz as f32) as usize).min(nz - 1);
    let phi = w.y.atan2(w.x) / std::f32::consts::TAU + 0.5;
    z * nphi + ((phi * nphi as f32) as usize).min(nphi - 1)
}

/// The direction at fractions (z, phi) of a cell.
fn direction(c: usize, z: f64, phi: f64) -> Vec3 {
    let [nz, nphi] = CELLS;
    let z = 2.0 * ((c / nphi) as f64 + z) / nz as f64 - 1.0;
    let phi = (((c % nphi) as f64 + phi) / nphi as f64 - 0.5) * std::f64::consts::TAU;
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32).normalize()
}

/// Solid angle of a cell.
fn solid_angle() -> f64 {
    4.0 * std::f64::consts::PI / (CELLS[0] * CELLS[1]) as f64
}

/// Integral of the density over a cell: Gauss's rule. A cell is divided in four while the parts disagree with the
/// whole.
fn integrate_smooth(c: usize, pdf_w: &impl Fn(Vec3) -> f32) -> f64 {
    solid_angle() * refine(&|z, phi| f64::from(pdf_w(direction(c, z, phi))), [0.0; 2], [1.0; 2], 0)
}

/// Integral of the density over a cell, from one random point in each of N x N parts.
fn integrate_jittered(c: usize, pdf_w: &impl Fn(Vec3) -> f32, rng: &mut Pcg) -> f64 {
    const N: usize = 192;
    let mut at = |i: usize| (i as f64 + f64::from(rng.next_f32())) / N as f64;
    let sum: f64 = (0..N * N).map(|i| f64::from(pdf_w(direction(c, at(i % N), at(i / N))))).sum();
    solid_angle() * sum / (N * N) as f64
}

/// Integrate over a rectangle, dividing it in four while that changes the result.
fn refine(f: &impl Fn(f64, f64) -> f64, [x, y]: [f64; 2], [w, h]: [f64; 2], depth: u32) -> f64 {
    let gauss = |[x, y]: [f64; 2], [w, h]: [f64; 2]| {
        const NODES: [(f64, f64); 3] = [
            (0.112_701_665_379_258_3, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ];
        let mut sum = 0.0;
        for (u, wu) in NODES {
            for (v, wv) in NODES {
                sum += wu * wv * f(x + u * w, y + v * h);
            }
        }
        sum * w * h
    };
    let whole = gauss([x, y], [w, h]);
    let half = [0.5 * w, 0.5 * h];
    let quarters = [[x, y], [x + half[0], y], [x, y + half[1]], [x + half[0], y + half[1]]];
    let parts: f64 = quarters.iter().map(|&q| gauss(q, half)).sum();
    if depth >= 9 || (depth >= 3 && (whole - parts).abs() < 1e-9 + 1e-3 * parts.abs()) {
        return parts;
    }
    quarters.iter().map(|&q| refine(f, q, half, depth + 1)).sum()
}
