//! Photons that entered a body, and the exitance that they cause. Far photons are summed by clusters \[Jensen02\].

use gi_core::math::{Bounds, Rgb};
use glam::Vec3;

use super::profile::Dipole;
use crate::heap::Heap;
use crate::photon::Rgbe;

/// A photon at the point where it entered a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    /// Where, world.
    pub(crate) position: [f32; 3],
    /// Power that came in, already divided by the number of emitted paths.
    pub(crate) power: Rgbe,
    /// Segments from the light to the first point inside, 255 standing for more.
    pub(crate) depth: u8,
}

impl Entry {
    fn p(&self) -> Vec3 {
        Vec3::from_array(self.position)
    }
}

/// A cluster is opened if the diagonal of its box exceeds this fraction of its distance.
const OPENING: f32 = 0.2;

/// All photons that entered one body.
pub(super) struct Entries {
    photons: Vec<Entry>,
    heap: Heap,
    clusters: Vec<Cluster>,
}

/// The photons of a node as one.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    power: Rgb,
    /// Mean of their points, weighted by power.
    p: Vec3,
    /// Squared diagonal of the box round them.
    extent_sq: f32,
    bounds: Bounds,
    /// Largest depth.
    deepest: u8,
}

impl Entries {
    pub(super) fn build(mut photons: Vec<Entry>) -> Self {
        let heap = Heap::order(&mut photons, Entry::p);
        let one = |e: &Entry| Cluster {
            power: e.power.to_rgb(),
            p: e.p(),
            extent_sq: 0.0,
            bounds: Bounds::of([e.p()]),
            deepest: e.depth,
        };
        let leaf = |run: std::ops::Range<usize>| {
            photons[run].iter().map(one).fold(Cluster::NONE, |a, b| a.join(&b))
        };
        let clusters = heap.sum_up(leaf, Cluster::join);
        Entries { photons, heap, clusters }
    }

    pub(super) fn len(&self) -> usize {
        self.photons.len()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.photons[..]) + size_of_val(&self.clusters[..])
    }

    /// Power that leaves the body per area at its surface point `x`, of photons of at most `depth` segments: the sum of
    /// R_d(|x - p|) power.
    pub(super) fn exitance(&self, x: Vec3, dipole: &Dipole, depth: u8) -> Rgb {
        let mut sum = Rgb::BLACK;
        // The stack holds at most one node per level.
        let mut stack = [self.heap.root(); 64];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = stack[count];
            let cluster = &self.clusters[node.index];
            let distance_sq = cluster.p.distance_squared(x);
            if cluster.deepest <= depth && cluster.extent_sq < OPENING * OPENING * distance_sq {
                sum += cluster.power * dipole.reflectance(distance_sq);
            } else if self.heap.is_leaf(node) {
                for e in self.photons[node.run()].iter().filter(|e| e.depth <= depth) {
                    sum += e.power.to_rgb() * dipole.reflectance(e.p().distance_squared(x));
                }
            } else {
                let [a, b] = node.halves();
                (stack[count], stack[count + 1]) = (b, a);
                count += 2;
            }
        }
        sum
    }
}

impl Cluster {
    const NONE: Cluster = Cluster {
        power: Rgb::BLACK,
        p: Vec3::ZERO,
        extent_sq: 0.0,
        bounds: Bounds::EMPTY,
        deepest: 0,
    };

    fn join(&self, other: &Cluster) -> Cluster {
        let power = self.power + other.power;
        let share = if power.is_black() { 0.5 } else { other.power.mean() / power.mean() };
        // A cluster without power has no mean position.
        let p = if self.bounds.is_empty() { other.p } else { self.p.lerp(other.p, share) };
        let bounds = self.bounds.union(other.bounds);
        let extent_sq = bounds.extent().length_squared();
        Cluster { power, p, extent_sq, bounds, deepest: self.deepest.max(other.deepest) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::medium::{Medium, Phase};
    use gi_core::rng::Pcg;
    use gi_core::warp;

    /// Photons all over a ball of radius 1, more of them and redder on one side.
    fn strewn(n: usize) -> Vec<Entry> {
        let mut rng = Pcg::new(8, 3);
        let mut one = || {
            let p = warp::sphere(rng.next_2d());
            let c = Rgb::new(1.0 + p.x, 0.6, 0.5 - 0.5 * p.x) * (0.5 + rng.next_f32());
            let depth = 2 + (rng.next_f32() * 5.0) as u8;
            Entry { position: p.to_array(), power: Rgbe::nearest(c), depth }
        };
        (0..n).map(|_| one()).collect()
    }

    #[test]
    fn clusters_add_up_to_what_all_photons_do() {
        // Mean free paths from a thousandth of the body to all of it; an absorbing channel beside a white one.
        for sigma_t in [1.0, 10.0, 1000.0] {
            let medium =
                Medium::homogeneous(Rgb::grey(sigma_t), Rgb::new(1.0, 0.99, 0.6), Phase::Isotropic);
            let dipole = Dipole::new(&medium, 1.4);
            for n in [0, 1, 9, 20_000] {
                let photons = strewn(n);
                let entries = Entries::build(photons.clone());
                let mut rng = Pcg::new(1, 1);
                for k in 0..40 {
                    let (x, depth) = (warp::sphere(rng.next_2d()), [255, 255, 4, 2][k % 4]);
                    let found = entries.exitance(x, &dipole, depth);
                    let counted = photons.iter().filter(|e| e.depth <= depth);
                    let all = counted.fold(Rgb::BLACK, |sum, e| {
                        sum + e.power.to_rgb() * dipole.reflectance(e.p().distance_squared(x))
                    });
                    let off = found.zip(all, |a, b| (a - b).abs() / b.max(1e-30)).max();
                    assert!(off < 0.004, "{sigma_t}, {n} photons: {found:?} is not {all:?}");
                }
            }
        }
    }
}
