//! Learns where light paths must start to succeed, such as to reach a caustic.
//!
//! A projection map divides the directions of a light into cells, and paths start only in cells where the light sees a
//! surface that focuses it \[Jensen01, 5.2\]. A wall in between is not noticed. This map has cells as well, but it counts
//! in which of them paths succeed. The cells divide the unit cube of the five random numbers that start a path: one
//! chooses the light, two the point on it, two the direction. So lights of all kinds are treated alike.
//!
//! No path is left out. A path starts in a cell with a probability proportional to the cell's volume times a power of its
//! success rate, and its own power is divided by the density.

use super::LightWalk;
use crate::light::Targets;
use crate::sampler::Sampler;
use crate::scene::Scene;

/// Number of random numbers that start a path.
const AXES: usize = 5;
/// The random numbers: for the light, the point on it, and the direction.
pub type Numbers = [f32; AXES];

/// A cell is halved if this many of the newest paths have succeeded there.
const ENOUGH: u32 = 8;
/// The density of paths in a cell is proportional to this power of the success rate. With 1/2, the variance of the summed
/// power would be smallest for a given number of paths, but the powers of photons would differ more. With 1/3, the
/// variance is hardly larger.
const POWER: f64 = 1.0 / 3.0;
/// Smallest volume of a cell that is halved.
const SMALLEST: f64 = 1e-6;
/// Largest number of nodes, 56 bytes each.
const MOST_NODES: usize = 1 << 15;
/// Smallest fraction of the paths that a half gets. A smaller fraction would be lost to rounding.
const LEAST_SHARE: f64 = 1e-6;
/// Largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A binary tree of cells.
#[derive(Clone, Debug)]
pub struct ProjectionMap {
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
enum Node {
    /// Halved across an axis. The fraction `share` of its paths starts in the lower half, node `first`; the upper half is
    /// the next node.
    Halved {
        axis: u8,
        share: f32,
        first: u32,
    },
    Cell(Cell),
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Smallest corner and size.
    low: Numbers,
    size: Numbers,
    tally: Tally,
}

/// Numbers of paths.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    tried: u32,
    succeeded: u32,
}

/// The start of a path in a cell.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The random numbers of the path.
    pub numbers: Numbers,
    /// Their density relative to uniform random numbers.
    pub density: f32,
    cell: u32,
}

/// A path that was traced, and whether it has succeeded.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    start: Start,
    succeeded: bool,
}

impl Start {
    /// The result of the path that starts here.
    pub fn result(self, succeeded: bool) -> Trial {
        Trial { start: self, succeeded }
    }
}

impl Tally {
    fn of(trials: &[Trial]) -> Self {
        let mut tally = Tally::default();
        trials.iter().for_each(|trial| tally.count(trial));
        tally
    }

    fn count(&mut self, trial: &Trial) {
        self.tried += 1;
        self.succeeded += u32::from(trial.succeeded);
    }

    /// Wanted density of paths, not normalised. It is never zero: what has not succeeded yet may succeed later.
    fn wish(self) -> f64 {
        ((f64::from(self.succeeded) + 0.5) / (f64::from(self.tried) + 1.0)).powf(POWER)
    }
}

impl Cell {
    fn volume(&self) -> f64 {
        self.size.iter().map(|&size| f64::from(size)).product()
    }

    /// The lower (0) or upper (1) half across an axis, with the paths that were started there.
    fn half(&self, axis: usize, upper: usize, trials: &[Trial]) -> Self {
        let mut half = Cell { tally: Tally::of(trials), ..*self };
        half.size[axis] *= 0.5;
        half.low[axis] += half.size[axis] * upper as f32;
        half
    }

    /// Whether a path started in the upper half across an axis.
    fn is_upper(&self, axis: usize, trial: &Trial) -> bool {
        trial.start.numbers[axis] >= self.low[axis] + 0.5 * self.size[axis]
    }

    /// The axis across which the success rates of the halves differ most: there, the sum of the wanted densities is
    /// smallest.
    fn best_axis(&self, trials: &[Trial]) -> usize {
        let cost = |axis: usize| {
            let mut halves = [Tally::default(); 2];
            trials.iter().for_each(|t| halves[usize::from(self.is_upper(axis, t))].count(t));
            halves.map(Tally::wish).iter().sum::<f64>()
        };
        let costs: [f64; AXES] = std::array::from_fn(cost);
        (1..AXES).fold(0, |best, axis| if costs[axis] < costs[best] { axis } else { best })
    }
}

impl Default for ProjectionMap {
    /// One cell: paths start uniformly.
    fn default() -> Self {
        let cube = Cell { low: [0.0; AXES], size: [1.0; AXES], tally: Tally::default() };
        ProjectionMap { nodes: vec![Node::Cell(cube)] }
    }
}

impl ProjectionMap {
    /// Choose a cell and a point in it with uniform random numbers. Points that are spread evenly stay so.
    pub fn start(&self, mut u: Numbers) -> Start {
        let (mut node, mut density) = (0, 1.0);
        loop {
            match &self.nodes[node as usize] {
                &Node::Halved { axis, share, first } => {
                    let u = &mut u[usize::from(axis)];
                    let upper = *u >= share;
                    let (from, part) = if upper { (share, 1.0 - share) } else { (0.0, share) };
                    *u = (*u - from) / part;
                    density *= 2.0 * part;
                    node = first + u32::from(upper);
                }
                Node::Cell(Cell { low, size, .. }) => {
                    let number = |k: usize| (low[k] + size[k] * u[k]).min(BELOW_ONE);
                    return Start { numbers: std::array::from_fn(number), density, cell: node };
                }
            }
        }
    }

    /// Learn from the results of all paths that the map has started since it learned last, in any order.
    pub fn learn(&mut self, mut trials: Vec<Trial>) {
        trials.sort_unstable_by_key(|trial| trial.start.cell);
        for of_cell in trials.chunk_by_mut(|a, b| a.start.cell == b.start.cell) {
            let node = of_cell[0].start.cell as usize;
            if let Node::Cell(cell) = &mut self.nodes[node] {
                of_cell.iter().for_each(|trial| cell.tally.count(trial));
            }
            self.halve(node, of_cell);
        }
        self.share_out();
    }

    /// Halve a cell as long as enough of the newest paths have succeeded there. Its halves know of these paths only.
    fn halve(&mut self, node: usize, trials: &mut [Trial]) {
        let Node::Cell(cell) = self.nodes[node] else { return };
        let is_final = cell.volume() < SMALLEST || self.nodes.len() >= MOST_NODES;
        if is_final || Tally::of(trials).succeeded < ENOUGH {
            return;
        }
        let axis = cell.best_axis(trials);
        trials.sort_unstable_by_key(|trial| cell.is_upper(axis, trial));
        let (lower, upper) =
            trials.split_at_mut(trials.partition_point(|t| !cell.is_upper(axis, t)));
        let first = self.nodes.len();
        self.nodes.push(Node::Cell(cell.half(axis, 0, lower)));
        self.nodes.push(Node::Cell(cell.half(axis, 1, upper)));
        self.nodes[node] = Node::Halved { axis: axis as u8, share: 0.5, first: first as u32 };
        self.halve(first, lower);
        self.halve(first + 1, upper);
    }

    /// Share out the paths: to each cell its volume times the density that it wants.
    fn share_out(&mut self) {
        let mut wanted = vec![0.0; self.nodes.len()];
        // Halves have larger indices than what they are halves of.
        for node in (0..self.nodes.len()).rev() {
            wanted[node] = match &mut self.nodes[node] {
                Node::Cell(cell) => cell.volume() * cell.tally.wish(),
                Node::Halved { share, first, .. } => {
                    let [lower, upper] = [0, 1].map(|k| wanted[*first as usize + k]);
                    let fraction = lower / (lower + upper);
                    *share = fraction.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE) as f32;
                    lower + upper
                }
            };
        }
    }
}

impl<'a> LightWalk<'a> {
    /// As [`LightWalk::begin_toward`], with a start that `map` chooses. Also returns this start, for
    /// [`ProjectionMap::learn`].
    pub fn begin_projected(
        scene: &'a Scene,
        mut sampler: Sampler,
        targets: &Targets,
        map: &ProjectionMap,
    ) -> (Start, Option<Self>) {
        let (u_light, [px, py], [dx, dy]) =
            (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        let start = map.start([u_light, px, py, dx, dy]);
        let [u_light, px, py, dx, dy] = start.numbers;
        let emission = scene.emit_toward(targets, u_light, [px, py], [dx, dy]);
        let walk = emission.map(|emission| {
            let mut walk = Self::follow(scene, sampler, emission);
            walk.power *= 1.0 / start.density;
            walk
        });
        (start, walk)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;
    use gi_stats::Running;

    /// Paths succeed in a box with a volume of 0.012, which no halving matches exactly.
    fn succeeds(u: &Numbers) -> bool {
        (0.3..0.5).contains(&u[0]) && u[1] > 0.8 && u[3] < 0.3
    }
    const VOLUME: f64 = 0.2 * 0.2 * 0.3;

    fn uniform(rng: &mut Pcg) -> Numbers {
        std::array::from_fn(|_| rng.next_f32())
    }

    /// A map that has learned from ten rounds of 10,000 paths.
    fn learned(rng: &mut Pcg) -> ProjectionMap {
        let mut map = ProjectionMap::default();
        for _ in 0..10 {
            let trial = |start: Start| start.result(succeeds(&start.numbers));
            let round = (0..10_000).map(|_| trial(map.start(uniform(rng)))).collect();
            map.learn(round);
        }
        map
    }

    #[test]
    fn what_has_learned_still_integrates_to_the_same() {
        let mut rng = Pcg::new(1, 1);
        let map = learned(&mut rng);
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
        let map = learned(&mut rng);
        let starts = (0..10_000).map(|_| map.start(uniform(&mut rng)));
        let share = starts.filter(|start| succeeds(&start.numbers)).count() as f64 / 10_000.0;
        assert!(share > 15.0 * VOLUME, "{share}");
    }

    #[test]
    fn a_map_that_has_seen_no_success_changes_nothing() {
        let mut rng = Pcg::new(3, 1);
        let mut map = ProjectionMap::default();
        let round = (0..1000).map(|_| map.start(uniform(&mut rng)).result(false)).collect();
        map.learn(round);
        let u = uniform(&mut rng);
        let start = map.start(u);
        assert_eq!((start.numbers, start.density), (u, 1.0));
    }

    #[test]
    fn learning_does_not_depend_on_the_order_of_the_paths() {
        let mut rng = Pcg::new(4, 1);
        let map = learned(&mut rng);
        let trials: Vec<Trial> = (0..5000)
            .map(|_| map.start(uniform(&mut rng)))
            .map(|start| start.result(succeeds(&start.numbers)))
            .collect();
        let after = |trials: Vec<Trial>| {
            let mut map = map.clone();
            map.learn(trials);
            map.start([0.4, 0.9, 0.5, 0.1, 0.6]).density.to_bits()
        };
        let reversed = trials.iter().rev().copied().collect();
        assert_eq!(after(trials), after(reversed));
    }
}
