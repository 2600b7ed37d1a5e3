//! The steps by which a cut of pairs is refined: a shadow ray between two representatives, a bound of the error, the
//! split of a pair on one of its sides. And the light of a finished cut.

use gi_core::math::Rgb;
use gi_core::rng::{bits_to_unit, hash_words};

use super::gather::Gather;
use super::tree::GatherTree;
use crate::bound::{Terms, error};
use crate::cut::{Cut, Limits, Lit};
use crate::light::Lights;
use crate::tree::{Family, NodeId};

/// A cluster of gather points with a cluster of lights: a node of the product graph [Walter06, 3].
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// Upper bound of the error of its estimate, as luminance; 0 for a single point with a single light.
    pub(super) error: f32,
    /// The gather points.
    pub(super) gather: NodeId,
    /// The lights.
    pub(super) light: NodeId,
    /// The representative point.
    pub(super) point: u32,
    /// The light that the representative light brings to the representative point, with shadows and the clamped geometry
    /// term: at unit power, and divided by the colour of the point.
    pub(super) unit: Rgb,
    /// The fraction of it that the clamp of the geometry term kept.
    pub(super) kept: f32,
}

/// The sides of a pair.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Gather,
    Light,
}

/// The gather points of a pixel, the lights, and their trees. The product graph of the trees is implicit: its nodes are
/// the pairs of a gather node and a light node.
pub(super) struct Product<'p, 'l, 's, 'a> {
    /// Lights and light trees.
    pub(super) lights: &'p Lights<'l, 'a>,
    /// Gather points.
    pub(super) gathers: &'p [Gather<'s, 'a>],
    /// Gather trees.
    pub(super) trees: &'p [GatherTree],
    /// Length by which directions are compared with positions.
    pub(super) c: f32,
    /// For the choice of representatives.
    pub(super) seed: u32,
}

impl Product<'_, '_, '_, '_> {
    /// Add a pair to a cut, with a shadow ray between the representatives.
    pub(super) fn add(&self, cut: &mut Cut<Pair>, gather: NodeId, light: NodeId) {
        let point = self.draw(gather, light);
        let mut pair = Pair { error: 0.0, gather, light, point, unit: Rgb::BLACK, kept: 1.0 };
        let is_single = self.is_single(&pair);
        cut.bounds += u32::from(!is_single);
        let bound = self.bound(&pair);
        // A pair that cannot bring light needs no shadow ray.
        if !is_single && bound.is_none() {
            return;
        }
        let point = &self.gathers[point as usize];
        let shape = &self.lights.forest.trees[light.tree as usize];
        let representative = shape.node(light.node).representative as usize;
        if let Some(c) = self.lights.prepared.connect_unit(representative, &point.at.receiver) {
            cut.rays += 1;
            pair.kept = point.at.kept(c.geometry, shape.is_direct());
            let open = c.transmittance(self.lights.scene) * pair.kept;
            pair.unit = (c.radiance * open).zip(point.colour, |unit, colour| unit / colour);
        } else if is_single {
            return;
        }
        cut.clusters.push(pair);
        self.weigh(cut, cut.clusters.len() as u32 - 1, bound);
    }

    /// Replace a pair by two pairs: one of its sides by its children. One of the pairs has the same representatives, so its
    /// light is known already.
    pub(super) fn split(&self, cut: &mut Cut<Pair>, number: u32) {
        let parent = cut.clusters[number as usize];
        cut.total -= self.signed(&parent);
        cut.squares = cut.squares.map(|s| s - f64::from(parent.error).powi(2));
        let (mut heir, mut other) = (parent, parent);
        match self.side(&parent) {
            Side::Gather => {
                let tree = self.gather_tree(&parent);
                let children = tree.node(parent.gather.node).children().expect("it is a cluster");
                let same = |k: u32| tree.members(k).contains(&parent.point);
                [heir.gather.node, other.gather.node] = heir_first(children, same);
            }
            Side::Light => {
                let tree = &self.lights.forest.trees[parent.light.tree as usize];
                let children = tree.node(parent.light.node).children().expect("it is a cluster");
                let same = |k: u32| {
                    tree.node(k).representative == tree.node(parent.light.node).representative
                };
                [heir.light.node, other.light.node] = heir_first(children, same);
            }
        }
        cut.clusters[number as usize] = heir;
        cut.bounds += u32::from(!self.is_single(&heir));
        let bound = self.bound(&heir);
        self.weigh(cut, number, bound);
        self.add(cut, other.gather, other.light);
    }

    /// The representative point of a pair. The paper has one per gather cluster. Pairs of the same cluster would then err
    /// in the same direction, and their errors would add up. So each pair draws its own.
    fn draw(&self, gather: NodeId, light: NodeId) -> u32 {
        let pair = [gather.tree, gather.node, light.tree, light.node, self.seed];
        self.trees[gather.tree as usize].draw(gather.node, bits_to_unit(hash_words(&pair)))
    }

    /// The side that is refined: the larger one, which makes the bound loose [Walter06, 4.3]. Positions and directions are
    /// compared as in the cost of a light cluster.
    fn side(&self, pair: &Pair) -> Side {
        let gather = self.gather_tree(pair).node(pair.gather.node);
        let tree = &self.lights.forest.trees[pair.light.tree as usize];
        let light = tree.node(pair.light.node);
        if gather.children().is_none() {
            return Side::Light;
        }
        if light.children().is_none() {
            return Side::Gather;
        }
        let turned = |cos: f32| (self.c * (1.0 - cos)).powi(2);
        let mut gather_size = turned(gather.cone.angle.cos());
        let mut light_size = light.bounds.extent().length_squared();
        match tree.family {
            // Parallel light reaches all points from the same direction; the positions in the tree are directions.
            Family::Directional => light_size *= self.c * self.c,
            _ => gather_size += gather.bounds.extent().length_squared(),
        }
        if tree.family == Family::Oriented || tree.family == Family::Glossy {
            light_size += turned(light.cone.cos);
        }
        if gather_size > light_size { Side::Gather } else { Side::Light }
    }

    /// Upper bound of the light of a pair; `None` for a single point with a single light, and if there is no light.
    pub(super) fn bound(&self, pair: &Pair) -> Option<Rgb> {
        if self.is_single(pair) {
            return None;
        }
        let tree = &self.lights.forest.trees[pair.light.tree as usize];
        let at = self.gather_tree(pair).cluster(pair.gather.node, self.gathers);
        let terms = Terms::new(tree, pair.light.node, &at)?;
        Some(terms.bound(tree, tree.node(pair.light.node), &at))
    }

    /// The estimate of the light of a pair.
    pub(super) fn estimate(&self, pair: &Pair) -> Rgb {
        let tree = &self.lights.forest.trees[pair.light.tree as usize];
        let strength = self.gather_tree(pair).node(pair.gather.node).strength;
        pair.unit * tree.node(pair.light.node).power * strength
    }

    /// The light of a cut.
    pub(super) fn add_up(&self, cut: &mut Cut<Pair>, limits: &Limits) -> Lit {
        let at_most = !cut.is_good(limits);
        let mut lit = Lit { rays: cut.rays, bounds: cut.bounds, at_most, ..Lit::default() };
        for pair in &cut.clusters {
            let (light, kind) = (self.estimate(pair), self.gather_tree(pair).kind);
            let is_direct = self.lights.forest.trees[pair.light.tree as usize].is_direct();
            if !is_direct {
                lit.cut_off += light.luminance() * (1.0 / pair.kept - 1.0);
            }
            let light = if kind.negative { light * -1.0 } else { light };
            // After a non-specular scattering of the path, all light is indirect.
            *(if is_direct && kind.seen { &mut lit.direct } else { &mut lit.indirect }) += light;
        }
        lit.size = cut.clusters.len() as u32;
        lit
    }

    /// Set the error of a pair, add its estimate to the total, and put it on the heap.
    fn weigh(&self, cut: &mut Cut<Pair>, number: u32, bound: Option<Rgb>) {
        let pair = &mut cut.clusters[number as usize];
        pair.error = bound.map_or(0.0, |bound| error(self.estimate(pair), bound));
        let pair = *pair;
        cut.total += self.signed(&pair);
        if pair.error > 0.0 {
            cut.push(pair.error, number);
        }
    }

    /// What a pair adds to the total of the pixel, as luminance.
    fn signed(&self, pair: &Pair) -> f64 {
        let light = f64::from(self.estimate(pair).luminance());
        if self.gather_tree(pair).kind.negative { -light } else { light }
    }

    /// Whether a pair is a single point with a single light.
    fn is_single(&self, pair: &Pair) -> bool {
        let tree = &self.lights.forest.trees[pair.light.tree as usize];
        self.gather_tree(pair).node(pair.gather.node).children().is_none()
            && tree.node(pair.light.node).children().is_none()
    }

    fn gather_tree(&self, pair: &Pair) -> &GatherTree {
        &self.trees[pair.gather.tree as usize]
    }
}

/// Two children, first the one with the representative of the parent.
fn heir_first([a, b]: [u32; 2], is_heir: impl Fn(u32) -> bool) -> [u32; 2] {
    if is_heir(a) { [a, b] } else { [b, a] }
}
