//! Collapses the binary tree into the wide tree: dynamic programming over the surface-area cost chooses which nodes to
//! merge into one with eight children \[Ylitie17\].

use std::ops::Deref;
use std::sync::atomic::{AtomicU32, Ordering};

use super::input::{Input, PrimRef};
use super::layout::{LANES, LEAF_BLOCKS, WIDTH};
use super::optimise::BinaryNode;

/// Cost of testing one block of triangles, relative to testing the eight boxes of a node. Tuned with the benchmark. It
/// is lower than the time of a test, because large leaves also make the tree smaller, which causes fewer cache misses.
const BLOCK_COST: f32 = 0.3;
/// Cost of testing one solid.
const SOLID_COST: f32 = 1.0;
/// Most triangles in a leaf; 8 cost four per cent of speed, 24 gain nothing.
const LEAF_TRIANGLES: u32 = 16;
/// Depth to which both children become separate tasks.
const TASK_DEPTH: u32 = 12;
const _: () = assert!(LEAF_TRIANGLES as usize <= LANES * LEAF_BLOCKS);

/// For each binary node, the best way to cut it into j pieces.
pub(super) struct Plan<'a> {
    nodes: &'a [BinaryNode],
    refs: &'a [PrimRef],
    input: &'a Input<'a>,
    /// Three bits for each j = 2..=8: the number of pieces from the left child, or 0 if j - 1 pieces are better.
    /// Also [`AS_LEAF`].
    choice: Vec<AtomicU32>,
}

/// Set if a single piece becomes a leaf instead of a wide node.
const AS_LEAF: u32 = 1 << 31;

/// Up to eight binary nodes.
#[derive(Default)]
pub(super) struct Pieces {
    node: [u32; WIDTH],
    count: usize,
}

impl Pieces {
    pub(super) fn push(&mut self, node: u32) {
        self.node[self.count] = node;
        self.count += 1;
    }
}

impl Deref for Pieces {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.node[..self.count]
    }
}

/// The smallest costs of a subtree.
#[derive(Clone, Copy)]
struct Best {
    /// `cost[j - 1]`: with at most j pieces, j = 1..=7.
    cost: [f32; WIDTH - 1],
    triangles: u32,
    solids: u32,
}

impl<'a> Plan<'a> {
    pub(super) fn new(nodes: &'a [BinaryNode], input: &'a Input<'a>) -> Self {
        let choice = nodes.iter().map(|_| AtomicU32::new(0)).collect();
        let plan = Plan { nodes, refs: &input.refs, input, choice };
        if !nodes.is_empty() {
            plan.solve(0, 0);
        }
        plan
    }

    fn solve(&self, i: u32, depth: u32) -> Best {
        let node = &self.nodes[i as usize];
        let area = half_area(node);
        if node.prim_count > 0 {
            let solid = self.input.is_solid(&self.refs[node.first_index as usize]);
            let (triangles, solids) =
                if solid { (0, node.prim_count) } else { (node.prim_count, 0) };
            self.choice[i as usize].store(AS_LEAF, Ordering::Relaxed);
            return Best {
                cost: [leaf_cost(area, triangles, solids); WIDTH - 1],
                triangles,
                solids,
            };
        }
        let child = node.first_index;
        let (left, right) = if depth < TASK_DEPTH {
            rayon::join(|| self.solve(child, depth + 1), || self.solve(child + 1, depth + 1))
        } else {
            (self.solve(child, depth + 1), self.solve(child + 1, depth + 1))
        };
        let (best, choice) = merge(area, &left, &right);
        self.choice[i as usize].store(choice, Ordering::Relaxed);
        best
    }

    /// Whether node `i` as a single piece becomes a leaf.
    pub(super) fn is_leaf(&self, i: u32) -> bool {
        self.choice[i as usize].load(Ordering::Relaxed) & AS_LEAF != 0
    }

    /// Whether the whole tree is one leaf; `None` if the tree is empty.
    pub(super) fn root_is_leaf(&self) -> Option<bool> {
        (!self.nodes.is_empty()).then(|| self.is_leaf(0))
    }

    /// The children of wide node `i`.
    pub(super) fn children(&self, i: u32) -> Pieces {
        let mut pieces = Pieces::default();
        self.cut(i, WIDTH, &mut pieces);
        pieces
    }

    fn cut(&self, i: u32, pieces: usize, out: &mut Pieces) {
        let choice = self.choice[i as usize].load(Ordering::Relaxed);
        let from_left = |j: usize| (choice >> (3 * (j - 2)) & 7) as usize;
        let mut j = pieces;
        while j > 1 && (self.nodes[i as usize].prim_count > 0 || from_left(j) == 0) {
            j -= 1;
        }
        if j == 1 {
            out.push(i);
            return;
        }
        let (child, k) = (self.nodes[i as usize].first_index, from_left(j));
        self.cut(child, k, out);
        self.cut(child + 1, j - k, out);
    }

    /// Collect the references below node `i`.
    pub(super) fn gather(&self, i: u32, out: &mut Vec<PrimRef>) {
        let node = &self.nodes[i as usize];
        if node.prim_count > 0 {
            let first = node.first_index as usize;
            out.extend_from_slice(&self.refs[first..first + node.prim_count as usize]);
        } else {
            self.gather(node.first_index, out);
            self.gather(node.first_index + 1, out);
        }
    }
}

fn half_area(node: &BinaryNode) -> f32 {
    let d = node.max - node.min;
    d.x * d.y + (d.x + d.y) * d.z
}

fn leaf_cost(area: f32, triangles: u32, solids: u32) -> f32 {
    area * (BLOCK_COST * triangles.div_ceil(LANES as u32) as f32 + SOLID_COST * solids as f32)
}

/// The best cuts of a node, computed from those of its children.
fn merge(area: f32, left: &Best, right: &Best) -> (Best, u32) {
    let (triangles, solids) = (left.triangles + right.triangles, left.solids + right.solids);
    // Distribute j pieces between the two children.
    let mut choice = 0;
    let mut shared = [f32::INFINITY; WIDTH + 1];
    for (j, shared) in shared.iter_mut().enumerate().skip(2) {
        let mut best = (f32::INFINITY, 1);
        for k in j.saturating_sub(WIDTH - 1).max(1)..=(j - 1).min(WIDTH - 1) {
            let c = left.cost[k - 1] + right.cost[j - k - 1];
            best = if c < best.0 { (c, k) } else { best };
        }
        *shared = best.0;
        choice |= (best.1 as u32) << (3 * (j - 2));
    }
    // As one piece: a wide node with eight children, or a leaf if allowed.
    let leaf_allowed =
        if solids == 0 { triangles <= LEAF_TRIANGLES } else { triangles == 0 && solids <= 2 };
    let node_cost = area + shared[WIDTH];
    let leaf_cost = if leaf_allowed { leaf_cost(area, triangles, solids) } else { f32::INFINITY };
    if leaf_allowed && leaf_cost <= node_cost {
        choice |= AS_LEAF;
    }
    let mut cost = [node_cost.min(leaf_cost); WIDTH - 1];
    for j in 2..WIDTH {
        cost[j - 1] = cost[j - 2].min(shared[j]);
        if shared[j] >= cost[j - 2] {
            choice &= !(7 << (3 * (j - 2)));
        }
    }
    (Best { cost, triangles, solids }, choice)
}
