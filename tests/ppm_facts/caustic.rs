//! The caustic of a metal ring, compared with light tracing.

use super::*;

#[test]
fn a_caustic_agrees_with_light_tracing_and_more_passes_reduce_the_error() {
    let world = World::load("ring.xml", [32, 32], &[]);
    let light = pathtrace::Params { mode: Mode::Light, ..Default::default() };
    let reference = world.render::<PathTracer>(&light, 1024, 5, Show::Caustic);
    // Light tracing does not find the light that the ring reflects, so only the table is compared.
    let table: Vec<bool> = channel(&reference, "N.Y").into_iter().map(|n| n > 0.9999).collect();
    let of_table = |film: &Film| -> Vec<f64> {
        let g = channel(film, "G").into_iter().zip(&table);
        g.filter(|(_, table)| **table).map(|(v, _)| v).collect()
    };
    let truth = of_table(&reference);
    for method in METHODS {
        // The edge of the caustic is finer than a pixel, so one hit point per pixel is not enough.
        let params = Params { initial_radius: 0.02, hit_points: 32, ..with(method, 16384) };
        let [first, .., last] = [2, 8, 32].map(|passes| {
            let film = of_table(&render(&world, &params, passes, 2, Show::Caustic));
            let error = film.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            let ratio = film.iter().sum::<f64>() / truth.iter().sum::<f64>();
            (error / truth.iter().map(|v| v * v).sum::<f64>(), ratio)
        });
        // The disc extends over the foot of the ring and into its wall, so some wrong light is counted there.
        assert!(last.0 < 0.5 * first.0 && last.0 < 0.1, "{method:?}: {first:?}, {last:?}");
        assert!((last.1 - 1.0).abs() < 0.06, "{method:?}: {last:?}");
    }
}

/// The slope of the squared error over the table with the ring's caustic against passes, from 8, 32, 128 and 512
/// passes.
fn slope_on_the_caustic(world: &World, reference: &Film, alpha: f64, seed: u32) -> f64 {
    let (truth, normal) = (channel(reference, "G"), channel(reference, "N.Y"));
    let noise = channel(reference, "Variance.G");
    let params = Params { alpha, initial_radius: 0.006, ..with(Method::Sppm, 16384) };
    let (mut technique, mut film) = world.run::<Ppm>(&params, 0, seed, Show::Caustic);
    let mut points = Vec::new();
    for pass in 0..512u32 {
        technique.pass(pass, &mut film);
        if [8, 32, 128, 512].contains(&(pass + 1)) {
            let picture = channel(&film, "G");
            let of_table = (0..truth.len()).filter(|&i| normal[i] > 0.9999);
            let error: f64 = of_table.map(|i| (picture[i] - truth[i]).powi(2) - noise[i]).sum();
            points.push((f64::from(pass + 1).ln(), error.ln()));
        }
    }
    let n = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let product: f64 = points.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum();
    product / points.iter().map(|p| (p.0 - mean.0).powi(2)).sum::<f64>()
}

#[test]
#[ignore = "slow: thousands of passes"]
fn on_a_caustic_the_error_falls_as_in_theory() {
    let world = World::load("ring.xml", [48, 48], &[]);
    let light = pathtrace::Params { mode: Mode::Light, ..Default::default() };
    let reference = world.render::<PathTracer>(&light, 8192, 5, Show::Caustic);
    let slope = |alpha| -> Running {
        (0..4).map(|seed| slope_on_the_caustic(&world, &reference, alpha, seed)).collect()
    };
    // Noise falls like passes^(-alpha), the squared bias like passes^(2 alpha - 2). The slower one dominates in the
    // end. At alpha = 2/3 both fall equally fast [Knaus11, 4]. The law holds in the limit; after 512 passes, the slope
    // still differs by a tenth.
    for (alpha, expected) in [(0.5, -0.5), (0.6, -0.6), (2.0 / 3.0, -2.0 / 3.0)] {
        let slopes = slope(alpha);
        let error = 3.0 * slopes.variance_of_mean().sqrt();
        println!("alpha {alpha}: {} +- {error}", slopes.mean());
        assert!((slopes.mean() - expected).abs() < 0.1 + error, "{alpha}: {}", slopes.mean());
    }
    let [middle, large] = [0.7, 0.95].map(|alpha| slope(alpha).mean());
    assert!(
        middle < large,
        "the bias should remain if the radius hardly shrinks: {middle}, {large}"
    );
}
