use super::*;
use crate::rng::Pcg;

fn coloured() -> Medium {
    let (sigma_t, albedo) = (Rgb::new(0.3, 1.0, 4.0), Rgb::new(0.9, 0.5, 0.2));
    Medium::homogeneous(sigma_t, albedo, Phase::Isotropic)
}

#[test]
fn transmittance_is_beers_law_and_multiplies() {
    let m = coloured();
    let expected = Rgb::new((-0.6f32).exp(), (-2.0f32).exp(), (-8.0f32).exp());
    assert_eq!(m.transmittance(2.0), expected);
    let parts = m.transmittance(0.7) * m.transmittance(1.3);
    for (a, b) in parts.to_array().into_iter().zip(expected.to_array()) {
        assert!((a / b - 1.0).abs() < 2e-6, "{a} is not {b}");
    }
    let clear = Medium { sigma_t: Rgb::BLACK, ..m };
    assert_eq!(clear.transmittance(f32::INFINITY), Rgb::WHITE);
}

/// Mean weights of passing, and of scattering beyond `from` and before the far end, for one channel, with their
/// standard errors.
fn mean(m: &Medium, reach: f32, throughput: Rgb, channel: usize) -> [(f64, f64); 2] {
    let mut rng = Pcg::new(5, 1);
    let n = 200_000;
    let (mut sum, mut squares) = ([0.0f64; 2], [0.0f64; 2]);
    for _ in 0..n {
        let u = [rng.next_f32(), rng.next_f32()];
        let (k, weight) = match m.fly(reach, throughput, u) {
            Flight::Passed { weight } => (0, weight),
            Flight::Scattered { t, weight } => {
                assert!((0.0..reach).contains(&t));
                (1, weight)
            }
        };
        let w = f64::from(weight.to_array()[channel]);
        sum[k] += w;
        squares[k] += w * w;
    }
    let n = f64::from(n);
    [0, 1].map(|k| {
        let mean = sum[k] / n;
        (mean, ((squares[k] / n - mean * mean) / n).sqrt())
    })
}

#[test]
fn weights_of_flights_average_to_the_transmitted_and_scattered_light() {
    let m = coloured();
    let reach = 0.8;
    for throughput in [Rgb::WHITE, Rgb::new(0.1, 0.5, 3.0), Rgb::new(1.0, 0.0, 0.02)] {
        for channel in 0..3 {
            if throughput.to_array()[channel] == 0.0 {
                continue;
            }
            let pass = f64::from(m.transmittance(reach).to_array()[channel]);
            let scatter = f64::from(m.albedo.to_array()[channel]) * (1.0 - pass);
            let found = mean(&m, reach, throughput, channel);
            for ((mean, error), expected) in found.into_iter().zip([pass, scatter]) {
                assert!(
                    (mean - expected).abs() < 4.5 * error + 1e-6,
                    "channel {channel}, {throughput:?}: {mean} +- {error}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn grey_media_scatter_with_their_albedo_and_absorbing_ones_let_all_paths_pass() {
    let grey = Medium { sigma_t: Rgb::grey(2.0), albedo: Rgb::grey(0.7), ..coloured() };
    let Flight::Scattered { weight, .. } = grey.fly(f32::INFINITY, Rgb::WHITE, [0.3, 0.9]) else {
        panic!("nothing passes through an infinite medium");
    };
    assert!((weight.r - 0.7).abs() < 1e-6);
    let dark = Medium { albedo: Rgb::BLACK, ..grey };
    let weight = dark.transmittance(3.0);
    assert_eq!(dark.fly(3.0, Rgb::WHITE, [0.3, 0.9]), Flight::Passed { weight });
}

#[test]
fn equiangular_distances_have_their_density() {
    for (along, across, reach) in
        [(1.0f32, 0.3f32, 2.5f32), (-0.5, 1.0, f32::INFINITY), (4.0, 0.1, 2.0)]
    {
        // The distance as a function of u has the slope 1 / density.
        for k in 1..40 {
            let u = k as f32 / 40.0;
            let h = 1e-3;
            let slope = (equiangular(along, across, reach, u + h).0
                - equiangular(along, across, reach, u - h).0)
                / (2.0 * h);
            let (t, pdf) = equiangular(along, across, reach, u);
            let again = equiangular_pdf(along, across, reach, t);
            assert!((again / pdf - 1.0).abs() < 1e-3, "{again} is not {pdf}");
            assert!(t > 0.0 && t < reach);
            // Central differences have an error of a sixth of h^2 times the third derivative: below 1 % away from
            // the ends.
            assert!((slope * pdf - 1.0).abs() < 0.02, "{along} {across} {u}: {slope} {pdf}");
        }
    }
}
