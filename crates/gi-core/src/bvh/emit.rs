//! Writing the wide tree: list its nodes and blocks in depth-first order, then fill them in parallel.

use rayon::prelude::*;

use super::Triangle;
use super::collapse::Plan;
use super::input::{Input, PrimRef};
use super::layout::{
    Block, LANES, MAX_LEAF_INDEX, Node, SENTINEL, Tree, WIDTH, block_word, inner_word, solid_word,
};
use super::optimise::BinaryNode;
use super::{BuildError, solid::PlacedSolid};

/// Items that one task fills at least.
const GRAIN: usize = 256;

/// A node to write: the binary nodes that become its children, and the words for them.
#[derive(Clone, Copy)]
struct Listed {
    source: [u32; WIDTH],
    child: [u32; WIDTH],
}

const EMPTY_SLOT: u32 = u32::MAX;

/// Everything to write, in its final order.
struct List<'a> {
    plan: &'a Plan<'a>,
    input: &'a Input<'a>,
    nodes: Vec<Listed>,
    /// The triangles of each block, the last repeated to fill it.
    blocks: Vec<[u32; LANES]>,
    /// The solids, by primitive, in leaf order.
    solids: Vec<usize>,
    children: Vec<u32>,
    gathered: Vec<PrimRef>,
}

/// Write the tree that `nodes` collapse into; every box is padded by `pad`.
pub(super) fn emit(nodes: &[BinaryNode], input: &mut Input, pad: f32) -> Result<Tree, BuildError> {
    let (listed, blocks, solid_order) = {
        let plan = Plan::new(nodes, input);
        let mut list = List {
            plan: &plan,
            input,
            nodes: Vec::with_capacity(nodes.len() / 8 + 1),
            blocks: Vec::with_capacity(nodes.len() / 3 + 1),
            solids: Vec::new(),
            children: Vec::new(),
            gathered: Vec::new(),
        };
        list.blocks.push([u32::MAX; LANES]);
        list.root(nodes);
        if list.blocks.len() > MAX_LEAF_INDEX {
            return Err(BuildError::TooMany);
        }
        let write = |l: &Listed| write_node(l, nodes, pad);
        let written: Vec<Node> = list.nodes.par_iter().with_min_len(GRAIN).map(write).collect();
        (written, list.blocks, list.solids)
    };
    let write = |ids: &[u32; LANES]| write_block(ids, input.triangles);
    let blocks: Vec<Block> = blocks.par_iter().with_min_len(GRAIN).map(write).collect();
    let take = |i: &usize| input.solids[i - input.triangles.len()].take();
    let solids: Vec<PlacedSolid> = solid_order.iter().filter_map(take).collect();
    Ok(Tree { nodes: listed, blocks, solids })
}

impl List<'_> {
    /// Always make the root a node, so that a leaf is only met through its box.
    fn root(&mut self, nodes: &[BinaryNode]) {
        if nodes.is_empty() {
            self.nodes.push(Listed { source: [EMPTY_SLOT; WIDTH], child: [SENTINEL; WIDTH] });
        } else if self.plan.is_leaf(0) {
            self.node(&[0]);
        } else {
            let mut children = Vec::new();
            self.plan.children(0, &mut children);
            self.node(&children);
        }
    }

    /// List a node with these children, and all below it.
    fn node(&mut self, sources: &[u32]) -> u32 {
        let index = self.nodes.len();
        let mut listed = Listed { source: [EMPTY_SLOT; WIDTH], child: [SENTINEL; WIDTH] };
        listed.source[..sources.len()].copy_from_slice(sources);
        self.nodes.push(listed);
        for (slot, &source) in sources.iter().enumerate() {
            let word = if self.plan.is_leaf(source) {
                self.leaf(source)
            } else {
                let mut children = std::mem::take(&mut self.children);
                self.plan.children(source, &mut children);
                let mut own = [0; WIDTH];
                own[..children.len()].copy_from_slice(&children);
                let count = children.len();
                self.children = children;
                self.node(&own[..count])
            };
            self.nodes[index].child[slot] = word;
        }
        inner_word(index)
    }

    /// List what a leaf holds.
    fn leaf(&mut self, source: u32) -> u32 {
        self.gathered.clear();
        self.plan.gather(source, &mut self.gathered);
        if self.input.is_solid(&self.gathered[0]) {
            let first = self.solids.len();
            self.solids.extend(self.gathered.iter().map(PrimRef::primitive));
            return solid_word(first, self.gathered.len());
        }
        // A split triangle may have several pieces here.
        self.gathered.sort_unstable_by_key(PrimRef::primitive);
        self.gathered.dedup_by_key(|r| r.primitive());
        let first = self.blocks.len();
        for four in self.gathered.chunks(LANES) {
            self.blocks
                .push(std::array::from_fn(|k| four[k.min(four.len() - 1)].primitive() as u32));
        }
        block_word(first, self.blocks.len() - first)
    }
}

fn write_node(listed: &Listed, nodes: &[BinaryNode], pad: f32) -> Node {
    let (inf, neg) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
    let mut node =
        Node { bounds: [inf, neg, inf, neg, inf, neg], child: listed.child, order: [0; WIDTH] };
    let mut center = [[f32::MAX; WIDTH]; 3];
    for slot in (0..WIDTH).filter(|&s| listed.source[s] != EMPTY_SLOT) {
        let b = &nodes[listed.source[slot] as usize];
        for (axis, center) in center.iter_mut().enumerate() {
            node.bounds[2 * axis][slot] = b.min[axis] - pad;
            node.bounds[2 * axis + 1][slot] = b.max[axis] + pad;
            center[slot] = b.min[axis] + b.max[axis];
        }
    }
    // Opposite octants see the children in opposite orders; where empty slots come does not matter.
    for octant in 0..4 {
        let sign = |axis: u32| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let along: [f32; WIDTH] = std::array::from_fn(|s| {
            sign(0) * center[0][s] + sign(1) * center[1][s] + sign(2) * center[2][s]
        });
        for slot in 0..WIDTH {
            let farther = (0..WIDTH)
                .filter(|&o| along[o] > along[slot] || along[o] == along[slot] && o < slot)
                .count();
            node.order[farther] |= (slot as u32) << (3 * octant);
            node.order[WIDTH - 1 - farther] |= (slot as u32) << (3 * (7 - octant));
        }
    }
    node
}

fn write_block(triangles: &[u32; LANES], all: &[Triangle]) -> Block {
    let mut block = Block::VOID;
    for lane in 0..LANES {
        let Some(t) = all.get(triangles[lane] as usize) else { continue };
        // A repeated triangle fills a lane as a point, which is never hit.
        let repeated = lane > 0 && triangles[lane] == triangles[lane - 1];
        let v = if repeated { [t.v[0]; 3] } else { t.v };
        for (row, value) in v.iter().flat_map(|p| p.to_array()).enumerate() {
            block.rows[row][lane] = value;
        }
        block.id[lane] = t.id;
    }
    block
}
