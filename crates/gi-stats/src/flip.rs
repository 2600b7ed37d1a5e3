//! FLIP: the difference that a viewer perceives when flipping between two pictures \[Andersson20\], and its extension
//! to high dynamic range \[Andersson21\]. 0 means no difference, 1 is the largest.

mod colour;

use std::f64::consts::PI;

use colour::*;

/// Pixels per degree of visual angle, for a 0.7 m wide 4K screen seen from 0.7 m: the authors' default.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_26;

type Color = [f64; 3];

/// One plane of numbers in row order.
#[derive(Clone)]
struct Plane {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

/// FLIP of two pictures in linear RGB, clamped to [0, 1]: one number per pixel.
///
/// # Panics
/// If the pictures are not `width` times `height` RGB triples.
pub fn flip_ldr(
    picture: &[f32],
    reference: &[f32],
    width: usize,
    height: usize,
    pixels_per_degree: f64,
) -> Vec<f64> {
    assert!(
        picture.len() == 3 * width * height && reference.len() == picture.len(),
        "two RGB pictures of the same size"
    );
    let opponent = |p: &[f32]| -> [Plane; 3] {
        let colors: Vec<Color> = p
            .chunks_exact(3)
            .map(|c| to_opponent([0, 1, 2].map(|k| f64::from(c[k]).clamp(0.0, 1.0))))
            .collect();
        [0, 1, 2].map(|k| Plane { width, height, values: colors.iter().map(|c| c[k]).collect() })
    };
    let (test, truth) = (opponent(picture), opponent(reference));
    let color = color_difference(&test, &truth, pixels_per_degree);
    let feature = feature_difference(&test[0], &truth[0], pixels_per_degree);
    color.into_iter().zip(feature).map(|(c, f)| c.powf(1.0 - f)).collect()
}

/// FLIP of two pictures in linear RGB of any range: the largest LDR-FLIP over a range of exposures that suits the
/// reference, tone-mapped like ACES.
///
/// # Panics
/// If the pictures are not `width` times `height` RGB triples.
pub fn flip_hdr(
    picture: &[f32],
    reference: &[f32],
    width: usize,
    height: usize,
    pixels_per_degree: f64,
) -> Vec<f64> {
    let (start, stop) = exposures(reference);
    let count = ((stop - start).ceil() as usize).max(2);
    let mut worst = vec![0.0f64; width * height];
    for k in 0..count {
        let exposure = start + (stop - start) * k as f64 / (count - 1) as f64;
        let expose = |p: &[f32]| -> Vec<f32> {
            p.iter().map(|&v| aces(f64::from(v) * exposure.exp2()) as f32).collect()
        };
        let map = flip_ldr(&expose(picture), &expose(reference), width, height, pixels_per_degree);
        worst.iter_mut().zip(map).for_each(|(w, v)| *w = w.max(v));
    }
    worst
}

/// The coefficients of the rational curve that fits the ACES tone mapper.
const ACES: [f64; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

fn aces(x: f64) -> f64 {
    let x = x.max(0.0);
    let [a, b, c, d, e, f] = ACES;
    ((a * x * x + b * x + c) / (d * x * x + e * x + f)).clamp(0.0, 1.0)
}

/// Exposures (powers of two) at which the brightest and the median pixel of a picture reach 85 % of the tone curve.
fn exposures(reference: &[f32]) -> (f64, f64) {
    const SHARE: f64 = 0.85;
    let [k0, k1, k2, k3, k4, k5] = ACES;
    let (a, b, c) = (k0 - SHARE * k3, k1 - SHARE * k4, k2 - SHARE * k5);
    let x = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let mut luminance: Vec<f64> =
        reference.chunks_exact(3).map(|p| to_xyz([0, 1, 2].map(|k| f64::from(p[k])))[1]).collect();
    luminance.sort_by(f64::total_cmp);
    let brightest = luminance.last().copied().unwrap_or(0.0).max(1e-12);
    let middle = luminance.len() / 2;
    let median = match luminance.len() {
        0 => 1.0,
        n if n % 2 == 0 => 0.5 * (luminance[middle - 1] + luminance[middle]),
        _ => luminance[middle],
    };
    ((x / brightest).log2(), (x / median.max(1e-12)).log2())
}

/// Colour difference in [0, 1]: filtered by the eye's resolution, compared in a perceptual colour space.
fn color_difference(test: &[Plane; 3], truth: &[Plane; 3], ppd: f64) -> Vec<f64> {
    /// Exponent, and the two points between which errors are stretched.
    const Q: f64 = 0.7;
    const C: f64 = 0.4;
    const T: f64 = 0.95;
    let seen = |p: &[Plane; 3]| -> Vec<Color> {
        let [y, cx, cz] = [0, 1, 2].map(|k| resolve(&p[k], k, ppd));
        (0..y.values.len())
            .map(|i| {
                let rgb = to_rgb(from_opponent([y.values[i], cx.values[i], cz.values[i]]));
                hunt(to_lab(to_xyz(rgb.map(|v| v.clamp(0.0, 1.0)))))
            })
            .collect()
    };
    let largest =
        hyab(hunt(to_lab(to_xyz([0.0, 1.0, 0.0]))), hunt(to_lab(to_xyz([0.0, 0.0, 1.0])))).powf(Q);
    let bend = C * largest;
    let stretch = |d: f64| {
        if d < bend { T / bend * d } else { T + (d - bend) / (largest - bend) * (1.0 - T) }
    };
    seen(test).into_iter().zip(seen(truth)).map(|(a, b)| stretch(hyab(a, b).powf(Q))).collect()
}

/// Convolve an opponent channel with the eye's contrast sensitivity: a sum of Gaussians in degrees.
fn resolve(plane: &Plane, channel: usize, ppd: f64) -> Plane {
    /// Pairs (a, b) of a sqrt(pi / b) exp(-pi^2 x^2 / b) for the achromatic, red-green and blue-yellow channel.
    const GAUSSIANS: [[(f64, f64); 2]; 3] =
        [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i64;
    // A 2D Gaussian is a product over the axes; the sum of both Gaussians is normalised as a whole.
    let mut total = 0.0;
    let mut sum = Plane { values: vec![0.0; plane.values.len()], ..plane.clone() };
    for (a, b) in GAUSSIANS[channel] {
        if a == 0.0 {
            continue;
        }
        let kernel: Vec<f64> =
            (-radius..=radius).map(|i| (-PI * PI * (i as f64 / ppd).powi(2) / b).exp()).collect();
        let scale = a * (PI / b).sqrt();
        total += scale * kernel.iter().sum::<f64>().powi(2);
        let part = convolve(&convolve(plane, &kernel, true), &kernel, false);
        sum.values.iter_mut().zip(part.values).for_each(|(s, v)| *s += scale * v);
    }
    sum.values.iter_mut().for_each(|v| *v /= total);
    sum
}

/// Difference of edges and points, in [0, 1].
fn feature_difference(test: &Plane, truth: &Plane, ppd: f64) -> Vec<f64> {
    /// Width of the detector, degrees.
    const WIDTH: f64 = 0.082;
    let sigma = 0.5 * WIDTH * ppd;
    let radius = (3.0 * sigma).ceil() as i64;
    let gauss = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
    let across: Vec<f64> = (-radius..=radius).map(|i| gauss(i as f64)).collect();
    let along = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let raw: Vec<f64> = (-radius..=radius).map(|i| shape(i as f64) * gauss(i as f64)).collect();
        // Over the whole square, the positive weights sum to one and the negative ones to minus one.
        let all: f64 = across.iter().sum();
        let plus: f64 = raw.iter().filter(|v| **v > 0.0).sum::<f64>() * all;
        let minus: f64 = -raw.iter().filter(|v| **v < 0.0).sum::<f64>() * all;
        raw.into_iter().map(|v| if v > 0.0 { v / plus } else { v / minus }).collect()
    };
    let kernels = [along(&|x| -x), along(&|x| x * x / (sigma * sigma) - 1.0)];
    let strength = |plane: &Plane, kernel: &[f64]| -> Vec<f64> {
        let grey = Plane {
            values: plane.values.iter().map(|v| (v + 16.0) / 116.0).collect(),
            ..plane.clone()
        };
        let x = convolve(&convolve(&grey, kernel, true), &across, false);
        let y = convolve(&convolve(&grey, &across, true), kernel, false);
        x.values.into_iter().zip(y.values).map(|(x, y)| x.hypot(y)).collect()
    };
    let [edges, points] = kernels.map(|k| -> Vec<f64> {
        strength(test, &k)
            .into_iter()
            .zip(strength(truth, &k))
            .map(|(a, b)| (a - b).abs())
            .collect()
    });
    edges.into_iter().zip(points).map(|(e, p)| (e.max(p) / 2f64.sqrt()).sqrt()).collect()
}

/// Convolve along one axis, with the border pixels repeated outward. Whole rows are added at a time.
fn convolve(plane: &Plane, kernel: &[f64], along_x: bool) -> Plane {
    let (w, h, radius) = (plane.width, plane.height, kernel.len() / 2);
    let row = |y: usize| &plane.values[y * w..(y + 1) * w];
    let mut values = vec![0.0; w * h];
    for (y, out) in values.chunks_exact_mut(w).enumerate() {
        let add = |out: &mut [f64], f: f64, row: &[f64]| {
            out.iter_mut().zip(row).for_each(|(sum, v)| *sum += f * v);
        };
        if along_x {
            let (first, last) = (row(y)[0], row(y)[w - 1]);
            let wide = [&vec![first; radius], row(y), &vec![last; radius]].concat();
            kernel.iter().enumerate().for_each(|(k, f)| add(out, *f, &wide[k..k + w]));
        } else {
            let at = |k: usize| (y + k).saturating_sub(radius).min(h - 1);
            kernel.iter().enumerate().for_each(|(k, f)| add(out, *f, row(at(k))));
        }
    }
    Plane { values, ..*plane }
}

#[cfg(test)]
mod tests;
