//! Learns where light paths must start to succeed, such as to reach a caustic.
//!
//! A projection map divides the directions of a light into cells, and paths start only in cells where the light sees a
//! surface that focuses it \[Jensen01, 5.2\]. It does not notice walls in between. This map counts instead in which cells
//! paths succeed. The cells divide the unit cube of the five random numbers that start a path: one chooses the light, two
//! the point on it, two the direction. So lights of all kinds are treated alike.
//!
//! No path is left out. A path starts in a cell with a probability proportional to the cell's volume times the cube root of
//! its success rate. The flux of the path is divided by the density.

use super::LightWalk;
use crate::light::Targets;
use crate::sampler::Sampler;
use crate::scene::Scene;

/// Number of random numbers that start a path.
const AXES: usize = 5;
/// The random numbers: for the light, the point on it, and the direction.
type Numbers = [f32; AXES];

/// If a larger fraction of the first paths succeeds, the cube is not divided: cells would gain less than they cost.
const RARE: f64 = 0.125;
/// Minimum number of successes in a cell that is halved.
const ENOUGH: u32 = 8;
/// A cell is halved if the success rates of its halves differ by more than this many standard deviations.
const SIGMAS: f64 = 2.0;
/// A cell with this many successes is halved even if its halves have the same rate. They do if the paths that succeed
/// start in the middle.
const PLENTY: u32 = 64;
/// The density of paths in a cell is proportional to its success rate, raised to this exponent. The exponent 1/2 minimises
/// the variance of the total flux for a given number of paths. With 1/3, this variance is hardly larger, and the fluxes of
/// photons differ less.
const EXPONENT: f64 = 1.0 / 3.0;
/// Smallest volume of a cell that is halved.
const SMALLEST: f64 = 1e-6;
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

#[derive(Clone, Debug)]
struct Cell {
    /// Smallest corner and size.
    low: Numbers,
    size: Numbers,
    /// The paths that have started here.
    trials: Vec<Trial>,
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
    numbers: Numbers,
    /// Their density relative to uniform random numbers.
    density: f32,
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
    fn count(&mut self, trial: &Trial) {
        self.tried += 1;
        self.succeeded += u32::from(trial.succeeded);
    }

    /// Estimated success rate. It is never zero: what has not succeeded yet may succeed later.
    fn rate(self) -> f64 {
        (f64::from(self.succeeded) + 0.5) / (f64::from(self.tried) + 1.0)
    }

    /// Wanted density of paths, not normalised.
    fn wanted_density(self) -> f64 {
        self.rate().powf(EXPONENT)
    }

    /// Whether the rates of two tallies differ significantly.
    fn differs_from(self, other: Self) -> bool {
        let both =
            Tally { tried: self.tried + other.tried, succeeded: self.succeeded + other.succeeded };
        let inverse = |tally: Self| 1.0 / f64::from(tally.tried.max(1));
        let variance = both.rate() * (1.0 - both.rate()) * (inverse(self) + inverse(other));
        (self.rate() - other.rate()).powi(2) > SIGMAS * SIGMAS * variance
    }
}

impl Cell {
    fn new(low: Numbers, size: Numbers) -> Self {
        Cell { low, size, trials: Vec::new(), tally: Tally::default() }
    }

    fn volume(&self) -> f64 {
        self.size.iter().map(|&size| f64::from(size)).product()
    }

    fn add(&mut self, trial: Trial) {
        self.tally.count(&trial);
        self.trials.push(trial);
    }

    /// Whether a path started in the upper half across an axis.
    fn is_upper(&self, axis: usize, trial: &Trial) -> bool {
        trial.start.numbers[axis] >= self.low[axis] + 0.5 * self.size[axis]
    }

    /// The axis across which the cell should be halved, if any: there, the sum of the wanted densities is smallest.
    fn best_axis(&self) -> Option<usize> {
        if self.tally.succeeded < ENOUGH || self.volume() < SMALLEST {
            return None;
        }
        let halves: [[Tally; 2]; AXES] = std::array::from_fn(|axis| {
            let mut halves = [Tally::default(); 2];
            self.trials.iter().for_each(|t| halves[usize::from(self.is_upper(axis, t))].count(t));
            halves
        });
        let cost = |axis: usize| halves[axis].map(Tally::wanted_density).iter().sum::<f64>();
        let best = (0..AXES).min_by(|&a, &b| cost(a).total_cmp(&cost(b)))?;
        let [lower, upper] = halves[best];
        (self.tally.succeeded >= PLENTY || lower.differs_from(upper)).then_some(best)
    }

    /// The lower and the upper half across an axis.
    fn halves(&self, axis: usize) -> [Cell; 2] {
        let (mut size, mut middle) = (self.size, self.low);
        size[axis] *= 0.5;
        middle[axis] += size[axis];
        let mut halves = [self.low, middle].map(|low| Cell::new(low, size));
        for trial in &self.trials {
            halves[usize::from(self.is_upper(axis, trial))].add(*trial);
        }
        halves
    }
}

impl Default for ProjectionMap {
    /// One cell: paths start uniformly.
    fn default() -> Self {
        ProjectionMap { nodes: vec![Node::Cell(Cell::new([0.0; AXES], [1.0; AXES]))] }
    }
}

impl ProjectionMap {
    /// Choose a cell and a point in it with uniform random numbers. Within a cell the map is linear, so points stay
    /// stratified.
    fn start(&self, mut u: Numbers) -> Start {
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

    /// Learn from the results of paths that the map has started since it learned last, in any order. Trials are kept, 32
    /// bytes each.
    pub fn learn(&mut self, trials: impl IntoIterator<Item = Trial>) {
        for trial in trials {
            if let Node::Cell(cell) = &mut self.nodes[trial.start.cell as usize] {
                cell.add(trial);
            }
        }
        if matches!(&self.nodes[..], [Node::Cell(cube)] if cube.tally.rate() > RARE) {
            return;
        }
        // Halves are appended, so that they are halved too.
        let mut node = 0;
        while node < self.nodes.len() {
            self.halve(node);
            node += 1;
        }
        self.share_out();
    }

    /// Halve a cell if that helps.
    fn halve(&mut self, node: usize) {
        let Node::Cell(cell) = &self.nodes[node] else { return };
        let Some(axis) = cell.best_axis() else { return };
        let (halves, first) = (cell.halves(axis), self.nodes.len() as u32);
        self.nodes[node] = Node::Halved { axis: axis as u8, share: 0.5, first };
        self.nodes.extend(halves.map(Node::Cell));
    }

    /// Set the fraction of the paths that start in each half. It is proportional to volume times wanted density, summed
    /// over the cells of the half.
    fn share_out(&mut self) {
        let mut wanted = vec![0.0; self.nodes.len()];
        // Children have larger indices than their parents.
        for node in (0..self.nodes.len()).rev() {
            wanted[node] = match &mut self.nodes[node] {
                Node::Cell(cell) => cell.volume() * cell.tally.wanted_density(),
                Node::Halved { share, first, .. } => {
                    let [lower, upper] = [0, 1].map(|k| wanted[*first as usize + k]);
                    *share = (lower / (lower + upper)) as f32;
                    lower + upper
                }
            };
        }
    }
}

impl<'a> LightWalk<'a> {
    /// As [`LightWalk::begin_toward`], with a start that `starts` chooses. Also returns this start, for
    /// [`ProjectionMap::learn`].
    pub fn begin_projected(
        scene: &'a Scene,
        mut sampler: Sampler,
        targets: &Targets,
        starts: &ProjectionMap,
    ) -> (Start, Option<Self>) {
        let (u_light, [px, py], [dx, dy]) =
            (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        let start = starts.start([u_light, px, py, dx, dy]);
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
mod tests;
