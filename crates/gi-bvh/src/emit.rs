//! Writes the wide tree: lists its nodes and blocks in depth-first order, then fills them in parallel.

use rayon::prelude::*;

use super::Triangle;
use super::collapse::{Pieces, Plan};
use super::input::{Input, PrimRef};
use super::layout::{
    Block, LANES, MAX_LEAF_INDEX, Node, SENTINEL, Tree, WIDTH, block_word, inner_word, is_leaf,
    is_solid, moved_word, solid_word,
};
use super::optimise::BinaryNode;
use super::{BuildError, solid::PlacedSolid};

/// Smallest number of items per task.
const GRAIN: usize = 256;

/// A node to write: the binary nodes that become its children, and their words.
#[derive(Clone, Copy)]
struct Listed {
    source: [u32; WIDTH],
    child: [u32; WIDTH],
}

const EMPTY_SLOT: u32 = u32::MAX;

/// A part of the tree in its final order; its words count from the start of the part.
#[derive(Default)]
struct List {
    nodes: Vec<Listed>,
    /// The triangles of each block; the last one is repeated to fill the block.
    blocks: Vec<[u32; LANES]>,
    /// The solids, by primitive, in leaf order.
    solids: Vec<usize>,
    gathered: Vec<PrimRef>,
}

/// Write the wide tree that `nodes` collapse into; each box is padded by `pad`.
pub(super) fn emit(nodes: &[BinaryNode], input: &mut Input, pad: f32) -> Result<Tree, BuildError> {
    let list = whole(&Plan::new(nodes, input), input);
    if list.blocks.len() > MAX_LEAF_INDEX {
        return Err(BuildError::TooMany);
    }
    let listed = list.nodes.par_iter().with_min_len(GRAIN);
    let written: Vec<Node> = listed.map(|l| write_node(l, nodes, pad)).collect();
    let ids = list.blocks.par_iter().with_min_len(GRAIN);
    let blocks: Vec<Block> = ids.map(|ids| write_block(ids, input.triangles)).collect();
    let take = |i: &usize| input.solids[i - input.triangles.len()].take();
    let solids: Vec<PlacedSolid> = list.solids.iter().filter_map(take).collect();
    Ok(Tree { nodes: written, blocks, solids })
}

/// List the whole tree. The root is always a node, so that a leaf is reached only through its box.
fn whole(plan: &Plan, input: &Input) -> List {
    let mut list = List { blocks: vec![[u32::MAX; LANES]], ..List::default() };
    let mut children = Pieces::default();
    match plan.root_is_leaf() {
        None => {}
        Some(true) => children.push(0),
        Some(false) => children = plan.children(0),
    }
    list.node(plan, input, children, 0);
    list
}

/// Depth to which children are listed by separate tasks.
const TASK_DEPTH: u32 = 3;

impl List {
    /// List a node with these children, and everything below it.
    fn node(&mut self, plan: &Plan, input: &Input, children: Pieces, depth: u32) -> u32 {
        let index = self.nodes.len();
        let mut source = [EMPTY_SLOT; WIDTH];
        source[..children.len()].copy_from_slice(&children);
        self.nodes.push(Listed { source, child: [SENTINEL; WIDTH] });
        let below = |list: &mut List, source: u32| {
            if plan.is_leaf(source) {
                list.leaf(plan, input, source)
            } else {
                list.node(plan, input, plan.children(source), depth + 1)
            }
        };
        if depth < TASK_DEPTH {
            let part = |&source: &u32| {
                let mut list = List::default();
                let word = below(&mut list, source);
                (list, word)
            };
            let parts: Vec<(List, u32)> = children.par_iter().map(part).collect();
            for (slot, (part, word)) in parts.into_iter().enumerate() {
                self.nodes[index].child[slot] = self.append(part, word);
            }
        } else {
            for (slot, &source) in children.iter().enumerate() {
                self.nodes[index].child[slot] = below(self, source);
            }
        }
        inner_word(index)
    }

    /// Append another list; returns `word`, which points into that list, adjusted to this one.
    fn append(&mut self, part: List, word: u32) -> u32 {
        let (nodes, blocks, solids) = (self.nodes.len(), self.blocks.len(), self.solids.len());
        let moved = |word: u32| {
            let by = if !is_leaf(word) {
                nodes
            } else if is_solid(word) {
                solids
            } else {
                blocks
            };
            moved_word(word, by)
        };
        self.nodes.extend(part.nodes.iter().map(|l| Listed { child: l.child.map(moved), ..*l }));
        self.blocks.extend(part.blocks);
        self.solids.extend(part.solids);
        moved(word)
    }

    /// List the contents of a leaf.
    fn leaf(&mut self, plan: &Plan, input: &Input, source: u32) -> u32 {
        self.gathered.clear();
        plan.gather(source, &mut self.gathered);
        if input.is_solid(&self.gathered[0]) {
            let first = self.solids.len();
            self.solids.extend(self.gathered.iter().map(PrimRef::primitive));
            return solid_word(first, self.gathered.len());
        }
        // Several pieces of one split triangle may be in this leaf.
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
    // Opposite octants visit the children in opposite orders; the place of empty slots does not matter.
    for octant in 0..4 {
        let sign = |axis: u32| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let place =
            |s: usize| sign(0) * center[0][s] + sign(1) * center[1][s] + sign(2) * center[2][s];
        let places = ranks(std::array::from_fn(place));
        for (slot, &farther) in (0..).zip(&places) {
            node.order[farther as usize] |= slot << (3 * octant);
            node.order[WIDTH - 1 - farther as usize] |= slot << (3 * (7 - octant));
        }
    }
    node
}

/// For each of eight numbers, the count of larger ones; nearly equal numbers are ordered by position.
fn ranks(along: [f32; WIDTH]) -> [u32; WIDTH] {
    // Integers that sort like the floats, with the position in the low bits: gives a permutation, and compares in SIMD
    // lanes.
    let key = |s: usize| {
        let bits = along[s].to_bits() as i32;
        (bits ^ ((bits >> 31) as u32 >> 1) as i32) & !7 | s as i32
    };
    let keys: [i32; WIDTH] = std::array::from_fn(key);
    let mut larger = [0; WIDTH];
    for other in keys {
        for (larger, own) in larger.iter_mut().zip(keys) {
            *larger += u32::from(other > own);
        }
    }
    larger
}

fn write_block(triangles: &[u32; LANES], all: &[Triangle]) -> Block {
    let mut block = Block::VOID;
    for lane in 0..LANES {
        let Some(t) = all.get(triangles[lane] as usize) else { continue };
        // A repeated triangle fills a lane as a single point, which is never hit.
        let repeated = lane > 0 && triangles[lane] == triangles[lane - 1];
        let v = if repeated { [t.v[0]; 3] } else { t.v };
        for (row, value) in v.iter().flat_map(|p| p.to_array()).enumerate() {
            block.rows[row][lane] = value;
        }
        block.id[lane] = t.id;
    }
    block
}
