use super::*;
use crate::rng::Pcg;
use gi_stats::Running;

/// Paths succeed in a box with a volume of 0.012. Its faces are not faces of cells.
fn succeeds(u: &Numbers) -> bool {
    (0.3..0.5).contains(&u[0]) && u[1] > 0.8 && u[3] < 0.3
}
const VOLUME: f64 = 0.2 * 0.2 * 0.3;

fn uniform(rng: &mut Pcg) -> Numbers {
    std::array::from_fn(|_| rng.next_f32())
}

/// A map that has learned from rounds of 10,000 paths.
fn learned(rng: &mut Pcg, rounds: u32, succeeds: impl Fn(&Numbers) -> bool) -> ProjectionMap {
    let mut map = ProjectionMap::default();
    for _ in 0..rounds {
        let trial = |start: Start| start.result(succeeds(&start.numbers));
        let round: Vec<_> = (0..10_000).map(|_| trial(map.start(uniform(rng)))).collect();
        map.learn(round);
    }
    map
}

/// Fraction of the paths that succeed.
fn yield_of(map: &ProjectionMap, rng: &mut Pcg, succeeds: impl Fn(&Numbers) -> bool) -> f64 {
    let starts = (0..10_000).map(|_| map.start(uniform(rng)));
    starts.filter(|start| succeeds(&start.numbers)).count() as f64 / 10_000.0
}

#[test]
fn what_has_learned_still_integrates_to_the_same() {
    let mut rng = Pcg::new(1, 1);
    let map = learned(&mut rng, 10, succeeds);
    let (mut all, mut inside, mut moment) = <[Running; 3]>::default().into();
    for _ in 0..200_000 {
        let Start { numbers, density, .. } = map.start(uniform(&mut rng));
        assert!(numbers.iter().all(|u| (0.0..1.0).contains(u)));
        let weight = f64::from(1.0 / density);
        all.push(weight);
        inside.push(if succeeds(&numbers) { weight } else { 0.0 });
        moment.push(weight * f64::from(numbers[2] * numbers[4] * numbers[4]));
    }
    for (sum, exact) in [(all, 1.0), (inside, VOLUME), (moment, 1.0 / 6.0)] {
        let (off, error) = (sum.mean() - exact, sum.variance_of_mean().sqrt());
        assert!(off.abs() < 4.0 * error, "{} is not {exact}", sum.mean());
        assert!(error < 0.05 * exact, "{error}");
    }
}

#[test]
fn paths_start_where_paths_have_succeeded() {
    let mut rng = Pcg::new(2, 1);
    let map = learned(&mut rng, 10, succeeds);
    let share = yield_of(&map, &mut rng, succeeds);
    assert!(share > 15.0 * VOLUME, "{share}");
}

#[test]
fn a_map_that_has_seen_no_success_changes_nothing() {
    let mut rng = Pcg::new(3, 1);
    let mut map = ProjectionMap::default();
    let round: Vec<_> = (0..1000).map(|_| map.start(uniform(&mut rng)).result(false)).collect();
    map.learn(round);
    let u = uniform(&mut rng);
    let start = map.start(u);
    assert_eq!((start.numbers, start.density), (u, 1.0));
}

#[test]
fn where_many_paths_succeed_the_cube_is_not_divided() {
    let map = learned(&mut Pcg::new(5, 1), 4, |u| u[2] < 0.2);
    assert_eq!(map.nodes.len(), 1);
}

#[test]
fn success_in_the_middle_of_all_axes_is_found() {
    let mut rng = Pcg::new(6, 1);
    let succeeds = |u: &Numbers| u.iter().all(|u| (u - 0.5).abs() < 0.25);
    let map = learned(&mut rng, 10, succeeds);
    let share = yield_of(&map, &mut rng, succeeds);
    assert!(share > 5.0 / 32.0, "{share}");
}

#[test]
fn learning_does_not_depend_on_the_order_of_the_paths() {
    let mut rng = Pcg::new(4, 1);
    let map = learned(&mut rng, 10, succeeds);
    let trials: Vec<Trial> = (0..5000)
        .map(|_| map.start(uniform(&mut rng)))
        .map(|start| start.result(succeeds(&start.numbers)))
        .collect();
    let after = |trials: Vec<Trial>| {
        let mut map = map.clone();
        map.learn(trials);
        map.start([0.4, 0.9, 0.5, 0.1, 0.6]).density.to_bits()
    };
    let reversed: Vec<_> = trials.iter().rev().copied().collect();
    assert_eq!(after(trials), after(reversed));
}
