use super::*;
use crate::light::tests::at_points;

/// For each light that contributes: its light at the point, and the probability of sampling it, found by visiting all
/// branches.
fn all_walks(lights: &Lights, at: &At) -> Vec<[f64; 2]> {
    let roots = lights.forest.trees.iter().map(|t| importance(t, 0, &at.site));
    let roots: Vec<f64> = roots.map(f64::from).collect();
    let all: f64 = roots.iter().sum();
    let mut walks = Vec::new();
    for (tree, root) in lights.forest.trees.iter().zip(roots) {
        let mut open = vec![(0u32, root / all)];
        while let Some((k, p)) = open.pop() {
            let Some([a, b]) = tree.node(k).children() else {
                let brings = lights.one(at, tree.node(k).representative).luminance();
                if brings > 0.0 {
                    walks.push([brings.into(), p]);
                }
                continue;
            };
            let [x, y] = [a, b].map(|k| f64::from(importance(tree, k, &at.site)));
            if x + y > 0.0 {
                open.extend([(a, p * x / (x + y)), (b, p * y / (x + y))]);
            }
        }
    }
    walks
}

#[test]
fn the_mean_over_sampled_lights_is_the_light_of_all_lights() {
    const DRAWS: u32 = 4000;
    let n = f64::from(DRAWS);
    let (mut cases, mut stream) = (0, 0);
    at_points(120, 80, |lights, at| {
        let exact = f64::from(lights.light_by_all(at).all().luminance());
        let walks = all_walks(lights, at);
        // Every light that contributes has a positive probability, so the estimate contribution / p has the right mean.
        assert!(walks.iter().all(|[_, p]| *p > 0.0));
        let mean: f64 = walks.iter().map(|[brings, _]| brings).sum();
        assert!((mean - exact).abs() <= 1e-4 * exact);
        let variance =
            walks.iter().map(|[brings, p]| brings * brings / p).sum::<f64>() - mean * mean;
        let largest = walks.iter().map(|[brings, p]| brings / p).fold(0.0, f64::max);
        // The mean of this many samples is normally distributed, unless single samples dominate it.
        if walks.is_empty() || largest > 0.1 * (variance * n).sqrt() {
            return;
        }
        cases += 1;
        for stochastic in [false, true] {
            stream += 1;
            let (mut sum, mut squares) = (0.0f64, 0.0f64);
            for i in 0..DRAWS {
                let mut sampler = Sampler::new(7, stream * 10_007 + i, 0);
                let lit = if stochastic {
                    lights.light_stochastically(at, 6, &mut sampler)
                } else {
                    lights.light_by_some(at, 1, &mut sampler)
                };
                let value = f64::from(lit.all().luminance());
                sum += value;
                squares += value * value;
            }
            let mean = sum / n;
            let sampled = (squares / n - mean * mean).max(0.0);
            let error = (if stochastic { sampled } else { variance } / n).sqrt();
            let z = (mean - exact).abs() / error.max(1e-4 * exact);
            // Beyond 4.5 standard deviations by chance: about once in a thousand runs of these hundred cases.
            assert!(z < 4.5, "stochastic {stochastic}: {mean} +- {error} is not {exact}");
        }
    });
    assert!(cases > 30, "{cases} lit points");
}
