//! The light tree [slide 57]: leaves are lights, and inner nodes are clusters of the lights below.
//!
//! Trees are built bottom-up: join the pair of clusters that is cheapest to represent by one light, until one cluster
//! is left [Walter05, 3.2]. [`crate::cluster`] finds many pairs per round.

use gi_core::math::{Bounds, Rgb};
use gi_core::scene::Scene;
use glam::Vec3;
use vpl::{Kind, Vpl, Vpls};

use crate::cluster::{Cluster, join_all};
use crate::gain::{Exact, Gain, gain};

/// How the lights of a tree emit. Each kind has a tree of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Equally in all directions, or less in some (spots).
    Omni,
    /// Proportional to the cosine with the normal.
    Oriented,
    /// Parallel light. The positions in such a tree are unit directions toward the lights.
    Directional,
    /// By a BSDF.
    Glossy,
}

/// A cone of normals, with the cosine that bounds need.
#[derive(Clone, Copy, Debug)]
pub struct NormalCone {
    /// Unit axis.
    pub axis: Vec3,
    /// Cosine of the half angle: 1 for a single direction, -1 for all directions.
    pub cos: f32,
}

/// A node of one of the trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeId {
    /// Index of the tree.
    pub tree: u32,
    /// Index of the node in the tree; 0 is the root.
    pub node: u32,
}

/// A light or a cluster of lights.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// The box around the lights' positions.
    pub bounds: Bounds,
    /// The cone around their normals.
    pub cone: NormalCone,
    /// Sum of their powers.
    pub power: Rgb,
    /// The representative light, sampled in proportion to power from the representatives of the children.
    pub representative: u32,
    /// The first of two children, the second follows it; 0 for a light.
    child: u32,
}

impl Node {
    /// The two children; `None` for a light.
    #[inline]
    pub fn children(&self) -> Option<[u32; 2]> {
        (self.child != 0).then_some([self.child, self.child + 1])
    }
}

/// A tree of lights of one kind.
#[derive(Clone, Debug)]
pub struct Tree {
    /// How its lights emit.
    pub family: Family,
    /// Largest and smallest number of scatterings of its lights. Either all are 0 or none is.
    pub depth: [u32; 2],
    /// The root first; parents before children.
    nodes: Vec<Node>,
    /// One gain per node of a glossy tree; empty for other trees.
    gains: Vec<Gain>,
}

impl Tree {
    /// A node.
    #[inline]
    pub fn node(&self, k: u32) -> &Node {
        &self.nodes[k as usize]
    }

    /// Whether a node consists of two lights.
    #[inline]
    pub fn is_pair(&self, k: u32) -> bool {
        let is_light = |k: u32| self.node(k).child == 0;
        self.node(k).children().is_some_and(|[a, b]| is_light(a) && is_light(b))
    }

    /// All nodes.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Upper bounds of the fraction that the glossy lights of a node scatter; for glossy trees only.
    #[inline]
    pub fn gain(&self, k: u32) -> &Gain {
        &self.gains[k as usize]
    }

    /// Whether its lights lie on light sources, so that they bring direct light.
    #[inline]
    pub fn is_direct(&self) -> bool {
        self.depth[0] == 0
    }

    /// The lights below a node.
    pub fn members(&self, k: u32) -> Vec<u32> {
        let (mut members, mut open) = (Vec::new(), vec![k]);
        while let Some(k) = open.pop() {
            match self.node(k).children() {
                Some(children) => open.extend(children),
                None => members.push(self.node(k).representative),
            }
        }
        members
    }

    /// Build the tree over some lights of a set.
    fn build(scene: &Scene, set: &Vpls, family: Family, lights: &[u32], seed: u32) -> Option<Self> {
        // Directions count in proportion to half the diagonal of the scene [Walter05, 3.2].
        let c = if family == Family::Oriented || family == Family::Glossy {
            scene.radius()
        } else {
            0.0
        };
        let leaves = lights.iter().map(|&k| leaf(&set.lights[k as usize], k)).collect();
        let joined = join_all(leaves, c, seed)?;
        let depths = || lights.iter().map(|&k| set.lights[k as usize].depth);
        let depth = [depths().max().unwrap_or(0), depths().min().unwrap_or(0)];
        let mut tree = Tree { family, depth, nodes: lay_out(&joined), gains: Vec::new() };
        if family == Family::Glossy {
            tree.gains = tree.gains(scene, set);
        }
        Some(tree)
    }

    /// Gains of all nodes.
    fn gains(&self, scene: &Scene, set: &Vpls) -> Vec<Gain> {
        use rayon::prelude::*;
        let of_light = |node: &Node| match set.lights[node.representative as usize].kind {
            Kind::Glossy(k) if node.child == 0 => gain(scene, &set.surfaces[k as usize]),
            _ => Gain::default(),
        };
        let mut gains: Vec<Gain> = self.nodes.par_iter().map(of_light).collect();
        // Children follow their parents. A gain is dropped once it is joined, so that few of them take memory.
        let mut exact: Vec<Option<Box<Exact>>> = vec![None; self.nodes.len()];
        for k in (0..self.nodes.len()).rev() {
            let Some(children) = self.nodes[k].children() else { continue };
            let mut part = |c: u32| {
                exact[c as usize].take().unwrap_or_else(|| Box::new((&gains[c as usize]).into()))
            };
            let parts = children.map(&mut part);
            let joined = Exact::join([&parts[0], &parts[1]], children.map(|c| self.node(c).power));
            gains[k] = (&joined).into();
            exact[k] = Some(Box::new(joined));
        }
        gains
    }
}

fn leaf(light: &Vpl, k: u32) -> Cluster {
    let p = if light.kind == Kind::Directional { -light.n } else { light.p };
    Cluster::light(p, light.n, light.power, k)
}

/// Put nodes in order: parents before children, siblings side by side.
fn lay_out(joined: &[Cluster]) -> Vec<Node> {
    let node = |c: &Cluster| Node {
        bounds: c.bounds,
        cone: NormalCone { axis: c.cone.axis, cos: c.cone.angle.cos() },
        power: c.power,
        representative: c.representative,
        child: 0,
    };
    let root = joined.len() - 1;
    let mut nodes = Vec::with_capacity(joined.len());
    nodes.push(node(&joined[root]));
    let mut open = vec![(root, 0usize)];
    while let Some((from, to)) = open.pop() {
        let Some([a, b]) = joined[from].children() else { continue };
        let first = nodes.len();
        nodes[to].child = first as u32;
        nodes.extend([node(&joined[a]), node(&joined[b])]);
        // Descend into the first child next: nodes that are refined together lie together in memory.
        open.extend([(b, first + 1), (a, first)]);
    }
    nodes
}

/// All lights as trees.
#[derive(Clone, Debug, Default)]
pub struct Forest {
    /// The trees of lights on light sources, then the trees of lights on surfaces.
    pub trees: Vec<Tree>,
}

impl Forest {
    /// Build all trees of a set. With `by_depth` (for `max_depth`), the lights of each number of scatterings have trees
    /// of their own, because not all of them may illuminate every point.
    pub fn build(scene: &Scene, set: &Vpls, by_depth: bool, seed: u32) -> Self {
        let deepest = set.lights.iter().map(|v| v.depth).max().unwrap_or(0);
        let groups: Vec<[u32; 2]> = match by_depth {
            true => (0..=deepest).map(|d| [d, d]).collect(),
            false => vec![[0, 0], [1, u32::MAX]],
        };
        let mut trees = Vec::new();
        for [low, high] in groups {
            for family in [Family::Oriented, Family::Omni, Family::Directional, Family::Glossy] {
                let is = |v: &Vpl| family_of(v) == family && (low..=high).contains(&v.depth);
                let lights: Vec<u32> =
                    (0..set.lights.len() as u32).filter(|&k| is(&set.lights[k as usize])).collect();
                trees.extend(Tree::build(scene, set, family, &lights, seed));
            }
        }
        Forest { trees }
    }

    /// Memory of the trees in bytes.
    pub fn memory_bytes(&self) -> usize {
        let bytes = |t: &Tree| size_of_val(&t.nodes[..]) + size_of_val(&t.gains[..]);
        self.trees.iter().map(bytes).sum()
    }
}

fn family_of(v: &Vpl) -> Family {
    match v.kind {
        Kind::Oriented => Family::Oriented,
        Kind::Omni | Kind::Spot(_) => Family::Omni,
        Kind::Directional => Family::Directional,
        Kind::Glossy(_) => Family::Glossy,
    }
}

/// The position of a light in the space of its tree.
pub fn place(light: &Vpl) -> Vec3 {
    leaf(light, 0).bounds.min
}

#[cfg(test)]
mod tests;
