//! The gather tree: leaves are the gather points of a pixel, and inner nodes are clusters of the points below.
//!
//! Trees are built top-down: a cluster is split at the middle of the longest side of its box of positions and normals
//! [Walter06, 4.1].

use gi_core::bsdf::{ScatterBound, Toward};
use gi_core::math::{Bounds, Cone, Rgb};
use gi_core::medium::Phase;
use glam::Vec3;
use vpl::Scatterer;

use super::cube::CubeMap;
use super::gather::{Gather, Kind};
use crate::bound::{Receives, max_cos};

/// A gather point or a cluster of gather points.
#[derive(Clone, Copy, Debug)]
pub(super) struct GatherNode {
    /// The box around their positions.
    pub(super) bounds: Bounds,
    /// The cone around their normals; in media, around the directions back along the paths.
    pub(super) cone: Cone,
    /// Sum of strength times colour.
    pub(super) strength: Rgb,
    /// The points below, as a range of [`GatherTree::order`].
    range: [u32; 2],
    /// Sum of strength times f of the Lambertian points; in media, sum of the strengths.
    lambert: Rgb,
    /// Largest strength of each channel of the other points, as a fraction of the point's strongest channel. Times the
    /// bounds of the node's [`CubeMap`], it bounds their sum.
    glossy: Rgb,
    /// Whether shading uses the geometric normals.
    is_flat: bool,
    /// The first of two children, the second follows it; 0 for a point.
    child: u32,
}

/// A tree of gather points of one kind.
pub(super) struct GatherTree {
    /// Their kind.
    pub(super) kind: Kind,
    /// The root first; parents before children.
    nodes: Vec<GatherNode>,
    /// The gather points in the order of the leaves.
    order: Vec<u32>,
    /// One map per node, for the points that are not Lambertian; empty if there are none.
    maps: Vec<CubeMap>,
}

impl GatherNode {
    /// The two children; `None` for a point.
    #[inline]
    pub(super) fn children(&self) -> Option<[u32; 2]> {
        (self.child != 0).then_some([self.child, self.child + 1])
    }

    fn leaf(gather: &Gather, range: [u32; 2]) -> Self {
        let site = &gather.at.site;
        let (lambert, glossy) = match (site.lambert(), site.scatterer) {
            (Some((f, _)), _) => (gather.strength * f, Rgb::BLACK),
            (None, Scatterer::Medium(_)) => (gather.strength, Rgb::BLACK),
            (None, Scatterer::Surface(..)) => {
                let strongest = gather.strength.max().max(f32::MIN_POSITIVE);
                (Rgb::BLACK, gather.strength / strongest)
            }
        };
        GatherNode {
            bounds: Bounds { min: site.p, max: site.p },
            cone: Cone::new(gather.normal),
            strength: gather.strength * gather.colour,
            range,
            lambert,
            glossy,
            is_flat: site.is_flat(),
            child: 0,
        }
    }

    /// The bound of the points that are not Lambertian; `cos` bounds the cosine on the side of the eye.
    fn glossy_bound(&self, map: &CubeMap, toward: &Toward, mut cos: f32) -> ScatterBound {
        let [mut f_cos, f] = map.from(toward);
        if self.is_flat {
            if map.both_sides {
                cos = cos.max(max_cos(toward, -self.cone.axis, self.cone.angle.cos()));
            }
            f_cos = f_cos.min(f * cos);
        }
        ScatterBound { f: self.glossy * f, f_cos: self.glossy * f_cos }
    }

    fn join(a: &Self, b: &Self, child: u32) -> Self {
        GatherNode {
            bounds: a.bounds.union(b.bounds),
            cone: a.cone.union(&b.cone),
            strength: a.strength + b.strength,
            range: [a.range[0], b.range[1]],
            lambert: a.lambert + b.lambert,
            glossy: a.glossy.zip(b.glossy, f32::max),
            is_flat: a.is_flat && b.is_flat,
            child,
        }
    }
}

impl GatherTree {
    /// The trees of the gather points of a pixel, one for each kind. Directions count like positions times `c`.
    pub(super) fn build_all(gathers: &[Gather], c: f32) -> Vec<Self> {
        let mut numbers: Vec<u32> = (0..gathers.len() as u32).collect();
        numbers.sort_by_key(|&k| gathers[k as usize].kind);
        let kind = |k: &u32| gathers[*k as usize].kind;
        let kinds = numbers.chunk_by_mut(|a, b| kind(a) == kind(b));
        kinds.map(|members| Self::build(gathers, members, c)).collect()
    }

    /// The tree of some gather points of one kind. Changes the order of `members`.
    fn build(gathers: &[Gather], members: &mut [u32], c: f32) -> Self {
        let kind = gathers[members[0] as usize].kind;
        // Lay out the tree: the members below each node, and its first child.
        let mut layout = vec![(0, members.len(), 0)];
        let mut k = 0;
        while k < layout.len() {
            let (from, to, _) = layout[k];
            if to - from > 1 {
                let middle = from + split(gathers, &mut members[from..to], c);
                layout[k].2 = layout.len();
                layout.extend([(from, middle, 0), (middle, to, 0)]);
            }
            k += 1;
        }
        let leaf = |&(from, to, _): &(usize, usize, usize)| {
            GatherNode::leaf(&gathers[members[from] as usize], [from as u32, to as u32])
        };
        let mut nodes: Vec<GatherNode> = layout.iter().map(leaf).collect();
        for (k, &(.., child)) in layout.iter().enumerate().rev().filter(|(_, l)| l.2 != 0) {
            nodes[k] = GatherNode::join(&nodes[child], &nodes[child + 1], child as u32);
        }
        let maps = maps(&nodes, |node| &gathers[members[node.range[0] as usize] as usize]);
        GatherTree { kind, nodes, order: members.to_vec(), maps }
    }

    /// A node.
    #[inline]
    pub(super) fn node(&self, k: u32) -> &GatherNode {
        &self.nodes[k as usize]
    }

    /// The gather points below a node.
    pub(super) fn members(&self, k: u32) -> &[u32] {
        let [from, to] = self.node(k).range.map(|i| i as usize);
        &self.order[from..to]
    }

    /// Choose a representative point below a node in proportion to strength times colour, by a random number.
    pub(super) fn draw(&self, mut k: u32, mut u: f32) -> u32 {
        while let Some([a, b]) = self.node(k).children() {
            let [first, both] = [a, k].map(|k| self.node(k).strength.luminance());
            let share = if both > 0.0 { first / both } else { 0.5 };
            (k, u) = if u < share { (a, u / share) } else { (b, (u - share) / (1.0 - share)) };
        }
        self.members(k)[0]
    }

    /// Number of nodes.
    #[cfg(test)]
    pub(super) fn len(&self) -> u32 {
        self.nodes.len() as u32
    }

    /// A node in the form that bounds need.
    #[inline]
    pub(super) fn cluster<'g, 's, 'a>(
        &'g self,
        k: u32,
        gathers: &'g [Gather<'s, 'a>],
    ) -> GatherCluster<'g, 's, 'a> {
        let node = self.node(k);
        let first = &gathers[self.members(k)[0] as usize];
        match node.children() {
            None => GatherCluster::Point(first),
            Some(_) => GatherCluster::Cluster {
                node,
                phase: match first.at.site.scatterer {
                    Scatterer::Surface(..) => None,
                    Scatterer::Medium(phase) => Some(phase),
                },
                map: self.maps.get(k as usize).filter(|_| !node.glossy.is_black()),
                most: first.at.site.most,
            },
        }
    }
}

/// The maps of all nodes; none if all points are Lambertian, or there is only one.
fn maps<'g, 's: 'g, 'a: 's>(
    nodes: &[GatherNode],
    point: impl Fn(&GatherNode) -> &'g Gather<'s, 'a>,
) -> Vec<CubeMap> {
    if nodes[0].glossy.is_black() || nodes.len() == 1 {
        return Vec::new();
    }
    let mut maps = vec![CubeMap::EMPTY; nodes.len()];
    for (k, node) in nodes.iter().enumerate().rev().filter(|(_, n)| !n.glossy.is_black()) {
        maps[k] = match node.children() {
            Some([a, b]) => CubeMap::join(&maps[a as usize], &maps[b as usize]),
            None => {
                let Gather { at, strength, .. } = point(node);
                let Scatterer::Surface(_, bsdf) = at.site.scatterer else {
                    unreachable!("points of media have no glossy part")
                };
                CubeMap::new(bsdf, at.site.wo, strength.max())
            }
        };
    }
    maps
}

/// Order gather points by the middle of the longest side of their box, and return the number of points below it.
fn split(gathers: &[Gather], members: &mut [u32], c: f32) -> usize {
    let place = |k: u32| {
        let gather = &gathers[k as usize];
        [gather.at.site.p, gather.normal * c]
    };
    let (mut low, mut high) = ([Vec3::INFINITY; 2], [Vec3::NEG_INFINITY; 2]);
    for place in members.iter().map(|&k| place(k)) {
        for i in 0..2 {
            (low[i], high[i]) = (low[i].min(place[i]), high[i].max(place[i]));
        }
    }
    let side = |axis: usize| high[axis / 3][axis % 3] - low[axis / 3][axis % 3];
    let longest = (0..6).fold(0, |a, b| if side(b) > side(a) { b } else { a });
    let along = |k: u32| place(k)[longest / 3][longest % 3];
    let middle = low[longest / 3][longest % 3] + 0.5 * side(longest);
    members.sort_by(|&a, &b| along(a).total_cmp(&along(b)));
    let below = members.partition_point(|&k| along(k) < middle);
    // Equal points are halved.
    if below == 0 || below == members.len() { members.len() / 2 } else { below }
}

/// What receives light in a pair: one gather point, or a cluster of them.
pub(super) enum GatherCluster<'g, 's, 'a> {
    /// A point.
    Point(&'g Gather<'s, 'a>),
    /// A cluster.
    Cluster {
        /// The node.
        node: &'g GatherNode,
        /// The phase function, if the points are in a medium.
        phase: Option<Phase>,
        /// The map of the points that are not Lambertian, if there are any.
        map: Option<&'g CubeMap>,
        /// The clamp of the geometry term.
        most: f32,
    },
}

impl Receives for GatherCluster<'_, '_, '_> {
    #[inline]
    fn toward(&self, bounds: &Bounds) -> Toward {
        match self {
            Self::Point(gather) => gather.at.site.toward(bounds),
            Self::Cluster { node, .. } => Toward::between(&node.bounds, bounds),
        }
    }

    #[inline]
    fn scatter(&self, toward: &Toward) -> ScatterBound {
        match self {
            Self::Point(gather) => {
                let ScatterBound { f, f_cos } = gather.at.site.scatter(toward);
                ScatterBound { f: f * gather.strength, f_cos: f_cos * gather.strength }
            }
            Self::Cluster { node, phase: Some(phase), .. } => {
                let most = |axis: Vec3| max_cos(toward, axis, node.cone.angle.cos());
                let bound = phase.bound(|| most(-node.cone.axis), || most(node.cone.axis));
                ScatterBound { f: node.lambert * bound, f_cos: node.lambert * bound }
            }
            Self::Cluster { node, phase: None, map, .. } => {
                let cos = max_cos(toward, node.cone.axis, node.cone.angle.cos());
                let bound = ScatterBound { f: node.lambert, f_cos: node.lambert * cos };
                match map {
                    Some(map) => bound + node.glossy_bound(map, toward, cos),
                    None => bound,
                }
            }
        }
    }

    #[inline]
    fn clamp(&self) -> Option<f32> {
        match self {
            Self::Point(gather) => gather.at.site.clamp(),
            Self::Cluster { node, most, .. } => {
                (node.is_flat && *most < f32::INFINITY).then_some(*most)
            }
        }
    }
}
