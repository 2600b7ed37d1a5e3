//! An octree over positions, each with a radius of influence [slide 8]. It does not know which records belong to them.
//!
//! Every leaf contains fewer than three items. Every node stores the bounding box of its items' influence. A lookup
//! descends only into boxes that contain the point, and finds the same items as a scan of all items.

use gi_core::math::Bounds;
use glam::Vec3;

/// Index of an item, in the order of insertion.
pub type Id = u32;

/// Largest number of items in a leaf: "< 3" [slide 8].
const LEAF: usize = 2;
/// Number of levels below the root. A leaf at the last level contains any number of items, because items at the same
/// position cannot be separated.
const MAX_DEPTH: u32 = 20;
const NONE: u32 = u32::MAX;

#[derive(Clone, Debug)]
struct Item {
    p: Vec3,
    radius: f32,
    /// The next item in the same leaf.
    next: Id,
}

#[derive(Clone, Debug)]
struct Node {
    /// Smallest corner and side of the node's cube.
    low: Vec3,
    side: f32,
    /// Bounding box of the influence of all items below.
    reach: Bounds,
    /// Largest and smallest radius of the items below.
    largest: f32,
    smallest: f32,
    /// First of eight children, or [`NONE`] in a leaf.
    children: u32,
    /// First item of a leaf, and how many there are.
    first: Id,
    count: u32,
}

impl Node {
    fn leaf(low: Vec3, side: f32) -> Self {
        let (largest, smallest) = (0.0, f32::INFINITY);
        Node {
            low,
            side,
            reach: Bounds::EMPTY,
            largest,
            smallest,
            children: NONE,
            first: NONE,
            count: 0,
        }
    }

    fn take_in(&mut self, p: Vec3, radius: f32) {
        self.reach = self.reach.with(p - radius).with(p + radius);
        self.largest = self.largest.max(radius);
        self.smallest = self.smallest.min(radius);
    }

    /// The child whose cube contains `p`.
    fn octant(&self, p: Vec3) -> u32 {
        let middle = self.low + 0.5 * self.side;
        u32::from(p.x >= middle.x)
            | u32::from(p.y >= middle.y) << 1
            | u32::from(p.z >= middle.z) << 2
    }

    /// Distance from the node's cube to `p`.
    fn distance(&self, p: Vec3) -> f32 {
        (p - p.clamp(self.low, self.low + self.side)).length()
    }
}

/// The tree.
#[derive(Clone, Debug)]
pub struct Octree {
    nodes: Vec<Node>,
    items: Vec<Item>,
}

/// A limit on radii: an item of `radius` at `p` allows radius + slope * distance elsewhere \[Krivanek06\].
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Position of the item.
    pub p: Vec3,
    /// Radius of the item.
    pub radius: f32,
    /// Growth of the limit per unit of distance.
    pub slope: f32,
}

/// A leaf, for figures and tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Its cube.
    pub cube: Bounds,
    /// Number of items in it.
    pub items: usize,
}

impl Octree {
    /// An empty tree over a box. Items outside the box are stored in the leaves at its edge.
    pub fn new(bounds: Bounds) -> Self {
        let side = bounds.extent().max_element().max(f32::MIN_POSITIVE) * 1.001;
        let low = bounds.center() - 0.5 * side;
        Octree { nodes: vec![Node::leaf(low, side)], items: Vec::new() }
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether the tree is empty.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Insert an item.
    pub fn insert(&mut self, p: Vec3, radius: f32) -> Id {
        let id = self.items.len() as Id;
        self.items.push(Item { p, radius, next: NONE });
        let (mut at, mut depth) = (0, 0);
        loop {
            self.nodes[at].take_in(p, radius);
            if self.nodes[at].children == NONE {
                if (self.nodes[at].count as usize) < LEAF || depth == MAX_DEPTH {
                    self.push(at, id);
                    return id;
                }
                self.split(at);
            }
            at = (self.nodes[at].children + self.nodes[at].octant(p)) as usize;
            depth += 1;
        }
    }

    fn push(&mut self, leaf: usize, id: Id) {
        let node = &mut self.nodes[leaf];
        self.items[id as usize].next = node.first;
        (node.first, node.count) = (id, node.count + 1);
    }

    /// Split a leaf: move its items to eight new children.
    fn split(&mut self, at: usize) {
        let first_child = self.nodes.len() as u32;
        let (low, half) = (self.nodes[at].low, 0.5 * self.nodes[at].side);
        for k in 0..8 {
            let offset = Vec3::from_array([0, 1, 2].map(|axis| (k >> axis & 1) as f32 * half));
            self.nodes.push(Node::leaf(low + offset, half));
        }
        let mut next = self.nodes[at].first;
        let node = &mut self.nodes[at];
        (node.children, node.first, node.count) = (first_child, NONE, 0);
        while next != NONE {
            let (id, item) = (next, self.items[next as usize].clone());
            next = item.next;
            let child = (first_child + self.nodes[at].octant(item.p)) as usize;
            self.nodes[child].take_in(item.p, item.radius);
            self.push(child, id);
        }
    }

    /// Call `visit` for every item whose influence, times `slack` (1 or more), reaches `p`.
    #[inline]
    pub fn visit(&self, p: Vec3, slack: f32, mut visit: impl FnMut(Id)) {
        // At most eight children per level are on the stack.
        let mut stack = [0u32; 8 * MAX_DEPTH as usize + 1];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting] as usize];
            let margin = (slack - 1.0) * node.largest;
            let inside = p.cmpge(node.reach.min - margin) & p.cmple(node.reach.max + margin);
            if !inside.all() {
                continue;
            }
            if node.children != NONE {
                for child in node.children..node.children + 8 {
                    stack[waiting] = child;
                    waiting += 1;
                }
                continue;
            }
            let mut id = node.first;
            while id != NONE {
                let item = &self.items[id as usize];
                if (item.p - p).length_squared() <= (item.radius * slack).powi(2) {
                    visit(id);
                }
                id = item.next;
            }
        }
    }

    /// The smallest value of radius + slope * distance over all items: the radius that neighbours allow at `p`.
    pub fn cone_at(&self, p: Vec3, slope: f32) -> f32 {
        let mut best = f32::INFINITY;
        self.cone_below(0, p, slope, &mut best);
        best
    }

    fn cone_below(&self, at: u32, p: Vec3, slope: f32, best: &mut f32) {
        let node = &self.nodes[at as usize];
        if node.smallest + slope * node.distance(p) >= *best {
            return;
        }
        if node.children != NONE {
            (node.children..node.children + 8).for_each(|c| self.cone_below(c, p, slope, best));
            return;
        }
        let mut id = node.first;
        while id != NONE {
            let item = &self.items[id as usize];
            *best = best.min(item.radius + slope * (item.p - p).length());
            id = item.next;
        }
    }

    /// Lower the radius of every item to the value of `cone` at the item, but not below `least` of the item. `lowered`
    /// is called with each item that changes, and its new radius.
    pub fn lower(
        &mut self,
        cone: &Cone,
        least: &impl Fn(Id) -> f32,
        lowered: &mut impl FnMut(Id, f32),
    ) {
        self.lower_below(0, cone, least, lowered);
    }

    fn lower_below(
        &mut self,
        at: u32,
        cone: &Cone,
        least: &impl Fn(Id) -> f32,
        lowered: &mut impl FnMut(Id, f32),
    ) {
        let node = &self.nodes[at as usize];
        if node.largest <= cone.radius + cone.slope * node.distance(cone.p) {
            return;
        }
        let (children, mut id) = (node.children, node.first);
        let (mut reach, mut largest, mut smallest) = (Bounds::EMPTY, 0f32, f32::INFINITY);
        if children != NONE {
            for c in children..children + 8 {
                self.lower_below(c, cone, least, lowered);
                let child = &self.nodes[c as usize];
                reach = reach.union(child.reach);
                largest = largest.max(child.largest);
                smallest = smallest.min(child.smallest);
            }
        }
        while id != NONE {
            let item = &mut self.items[id as usize];
            let allowed = (cone.radius + cone.slope * (item.p - cone.p).length()).max(least(id));
            if item.radius > allowed {
                item.radius = allowed;
                lowered(id, allowed);
            }
            reach = reach.with(item.p - item.radius).with(item.p + item.radius);
            largest = largest.max(item.radius);
            smallest = smallest.min(item.radius);
            id = item.next;
        }
        let node = &mut self.nodes[at as usize];
        (node.reach, node.largest, node.smallest) = (reach, largest, smallest);
    }

    /// All leaves, with the empty ones.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        self.nodes.iter().filter(|n| n.children == NONE).map(|n| Cell {
            cube: Bounds { min: n.low, max: n.low + n.side },
            items: n.count as usize,
        })
    }
}

#[cfg(test)]
mod tests;
