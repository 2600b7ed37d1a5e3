//! Greedy clustering of lights in n log n.
//!
//! Two clusters are a mutual pair if each is the cheapest partner of the other. The cheapest pair of all is mutual.
//! Joining a pair never makes a third cluster cheaper to join, so the greedy order joins every mutual pair sooner or
//! later. Therefore all mutual pairs are joined at once, round by round, and the result is the greedy tree. With many
//! clusters, each searches for partners only among its neighbours on a space-filling curve through positions and
//! normals.

use gi_core::math::{Bounds, Cone, Rgb};
use gi_core::rng::{bits_to_unit, hash_words};
use glam::Vec3;
use rayon::prelude::*;

/// A light, or a cluster of two others.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// The box around the lights' positions.
    pub bounds: Bounds,
    /// The cone around their normals.
    pub cone: Cone,
    /// Sum of their powers.
    pub power: Rgb,
    /// The representative light.
    pub representative: u32,
    /// Indices of the two joined clusters; for a light, the same index twice.
    children: [u32; 2],
}

/// From this number of clusters on, only [`NEIGHBOURS`] on either side are searched. Larger values are closer to
/// greedy, but slower.
const MANY: usize = 384;
const NEIGHBOURS: usize = 16;
/// A round that joins fewer than one pair per this many clusters is too slow.
const LEAST_JOINED: usize = 16;

impl Cluster {
    /// A light at `p`.
    pub fn light(p: Vec3, n: Vec3, power: Rgb, number: u32) -> Self {
        let bounds = Bounds { min: p, max: p };
        Cluster { bounds, cone: Cone::new(n), power, representative: number, children: [0; 2] }
    }

    /// The two joined clusters; `None` for a light.
    pub fn children(&self) -> Option<[usize; 2]> {
        let [a, b] = self.children.map(|k| k as usize);
        (a != b).then_some([a, b])
    }

    /// Join the two clusters with indices `children`. One of their representatives is chosen in proportion to power. No
    /// two joins have the same representatives, so their hashes are independent.
    fn join(a: &Cluster, b: &Cluster, children: [u32; 2], seed: u32) -> Self {
        let power = a.power + b.power;
        let u = bits_to_unit(hash_words(&[seed, a.representative, b.representative]));
        let first = u * power.luminance() < a.power.luminance();
        Cluster {
            bounds: a.bounds.union(b.bounds),
            cone: a.cone.union(&b.cone),
            power,
            representative: if first { a.representative } else { b.representative },
            children,
        }
    }

    /// The cost of one representative for both: I (diagonal^2 + c^2 (1 - cos beta)^2) [Walter05, 3.2].
    #[inline]
    fn cost(&self, other: &Cluster, c: f32) -> f32 {
        let diagonal_sq = self.bounds.union(other.bounds).extent().length_squared();
        let turned =
            if c == 0.0 { 0.0 } else { c * (1.0 - self.cone.union_angle(&other.cone).cos()) };
        (self.power + other.power).luminance() * (diagonal_sq + turned * turned)
    }
}

/// Join lights until one cluster is left. Returns all clusters, the root last. `c` is the length by which normals are
/// weighted.
pub fn join_all(mut leaves: Vec<Cluster>, c: f32, seed: u32) -> Option<Vec<Cluster>> {
    sort_along_curve(&mut leaves, c);
    let mut open: Vec<u32> = (0..leaves.len() as u32).collect();
    let mut all = leaves;
    all.reserve(all.len());
    while open.len() > 1 {
        // Copy the open clusters side by side: neighbours are read many times.
        let clusters: Vec<Cluster> = open.iter().map(|&k| all[k as usize]).collect();
        let mut partners = cheapest_partners(&clusters, c);
        let mutual = |p: &[u32], i: usize| p[p[i] as usize] == i as u32;
        let joined = (0..open.len()).filter(|&i| mutual(&partners, i)).count() / 2;
        if joined * LEAST_JOINED < open.len() && open.len() > MANY {
            // Powers or distances that grow along a chain give few mutual pairs: join neighbours on the curve.
            partners = (0..open.len() as u32).map(|i| (i ^ 1).min(open.len() as u32 - 1)).collect();
        }
        let mut next = Vec::with_capacity(open.len() - joined);
        for i in 0..open.len() {
            let j = partners[i] as usize;
            if i == j || !mutual(&partners, i) {
                next.push(open[i]);
            } else if i < j {
                next.push(all.len() as u32);
                all.push(Cluster::join(&clusters[i], &clusters[j], [open[i], open[j]], seed));
            }
        }
        open = next;
    }
    (!all.is_empty()).then_some(all)
}

/// The cheapest partner of each cluster. Pairs are strictly ordered, so that at least one pair is mutual. Ties prefer
/// indices that differ in bit 0, which yields many mutual pairs per round.
fn cheapest_partners(clusters: &[Cluster], c: f32) -> Vec<u32> {
    let reach = if clusters.len() <= MANY { clusters.len() } else { NEIGHBOURS };
    let best = |i: usize| {
        let mut best = (f32::INFINITY, usize::MAX, usize::MAX);
        let mut partner = i;
        for j in i.saturating_sub(reach)..(i + reach + 1).min(clusters.len()) {
            if j == i {
                continue;
            }
            let key = (clusters[i].cost(&clusters[j], c), i ^ j, i.min(j));
            if key < best {
                (best, partner) = (key, j);
            }
        }
        partner as u32
    };
    (0..clusters.len()).into_par_iter().with_min_len(256).map(best).collect()
}

/// Sort lights along a Morton curve through positions and, if `c` is not 0, normals.
fn sort_along_curve(leaves: &mut Vec<Cluster>, c: f32) {
    let bounds = leaves.iter().fold(Bounds::EMPTY, |b, l| b.union(l.bounds));
    let (low, size) = (bounds.min, bounds.extent().max_element().max(f32::MIN_POSITIVE));
    // All axes have the same unit of length; normals are weighted by c.
    let unit = size.max(2.0 * c);
    let bits = if c > 0.0 { 10 } else { 20 };
    let most = (1u32 << bits) - 1;
    let quantise = |x: f32| ((x / unit * most as f32) as u32).min(most);
    let key = |l: &Cluster| {
        let p = ((l.bounds.min - low).to_array()).map(quantise);
        let n = l.cone.axis.to_array().map(|x| quantise((x + 1.0) * c));
        let axes = if c > 0.0 {
            [p[0], p[1], p[2], n[0], n[1], n[2]]
        } else {
            [p[0], p[1], p[2], 0, 0, 0]
        };
        let used = if c > 0.0 { 6 } else { 3 };
        let mut key = 0u64;
        for bit in (0..bits).rev() {
            for axis in &axes[..used] {
                key = key << 1 | u64::from(axis >> bit & 1);
            }
        }
        (key, l.representative)
    };
    let mut keyed: Vec<((u64, u32), Cluster)> = leaves.par_iter().map(|l| (key(l), *l)).collect();
    keyed.par_sort_unstable_by_key(|k| k.0);
    *leaves = keyed.into_iter().map(|k| k.1).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::rng::Pcg;
    use gi_core::warp;
    use std::collections::BTreeSet;

    fn lights(n: u32, rng: &mut Pcg) -> Vec<Cluster> {
        let light = |k| {
            let p = Vec3::from_array([0; 3].map(|_| rng.next_f32()));
            Cluster::light(p, warp::sphere(rng.next_2d()), Rgb::grey(0.1 + rng.next_f32()), k)
        };
        (0..n).map(light).collect()
    }

    /// The set of lights of each cluster of a tree.
    fn sets(all: &[Cluster]) -> BTreeSet<Vec<u32>> {
        let mut sets: Vec<Vec<u32>> = Vec::new();
        for cluster in all {
            let mut set = match cluster.children() {
                None => vec![cluster.representative],
                Some([a, b]) => [&sets[a][..], &sets[b][..]].concat(),
            };
            set.sort_unstable();
            sets.push(set);
        }
        sets.into_iter().collect()
    }

    #[test]
    fn few_lights_are_joined_in_the_greedy_order() {
        let mut rng = Pcg::new(3, 1);
        for c in [0.0, 0.8] {
            let leaves = lights(90, &mut rng);
            let (mut greedy, mut open) = (leaves.clone(), (0..90usize).collect::<Vec<_>>());
            while open.len() > 1 {
                let pairs = (0..open.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
                let cost = |&(i, j): &(usize, usize)| greedy[open[i]].cost(&greedy[open[j]], c);
                let (i, j) = pairs.min_by(|a, b| cost(a).total_cmp(&cost(b))).expect("a pair");
                let (a, b) = (open[i], open[j]);
                greedy.push(Cluster::join(&greedy[a], &greedy[b], [a as u32, b as u32], 0));
                open.retain(|&k| k != a && k != b);
                open.push(greedy.len() - 1);
            }
            assert_eq!(sets(&greedy), sets(&join_all(leaves, c, 0).expect("a tree")));
        }
    }

    #[test]
    fn many_lights_cost_little_more_than_with_greedy_joins_and_chains_end() {
        // The total cost of a tree; used to compare a search among a few neighbours with a search among all.
        let total = |all: &[Cluster]| -> f64 {
            let cost = |[a, b]: [usize; 2]| f64::from(all[a].cost(&all[b], 0.8));
            all.iter().filter_map(Cluster::children).map(cost).sum()
        };
        let mut rng = Pcg::new(3, 2);
        let some = lights(380, &mut rng);
        let greedy = total(&join_all(some.clone(), 0.8, 0).expect("a tree"));
        // The same lights, with so many others far away that only neighbours are searched.
        let far = |l: &Cluster| {
            let p = l.bounds.min + Vec3::splat(3.0);
            Cluster::light(p, l.cone.axis, l.power, l.representative + 380)
        };
        let both: Vec<Cluster> = some.iter().copied().chain(some.iter().map(far)).collect();
        let all = join_all(both, 0.8, 0).expect("a tree");
        let near = 0.5 * total(&all[..all.len() - 1]);
        assert!(near < 1.5 * greedy, "{near} against {greedy}");
        // Distances grow along the chain, so each light's cheapest partner is its predecessor.
        let chain =
            |k: u32| Cluster::light(Vec3::X * 1.01f32.powi(k as i32), Vec3::Z, Rgb::WHITE, k);
        let same = |k: u32| Cluster::light(Vec3::X, Vec3::Z, Rgb::WHITE, k);
        for all in [
            join_all((0..6000).map(chain).collect(), 0.8, 0),
            join_all((0..6000).map(same).collect(), 0.8, 0),
        ] {
            let all = all.expect("a tree");
            assert_eq!(all.len(), 11_999);
            let mut depth = vec![0u32; all.len()];
            for (k, cluster) in all.iter().enumerate() {
                if let Some([a, b]) = cluster.children() {
                    depth[k] = depth[a].max(depth[b]) + 1;
                }
            }
            assert!(depth[all.len() - 1] < 600, "{}", depth[all.len() - 1]);
        }
    }
}
