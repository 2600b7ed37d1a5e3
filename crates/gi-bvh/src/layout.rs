//! The tree in memory: wide nodes, triangle blocks, and the words that point at them.

use super::solid::PlacedSolid;

/// Children per node.
pub(super) const WIDTH: usize = 8;
/// Triangles per block.
pub(super) const LANES: usize = 4;
/// Most blocks (or solids) in a leaf.
pub(super) const LEAF_BLOCKS: usize = 8;

/// Largest depth of nodes that the builder creates; see [`STACK`].
pub(super) const MAX_DEPTH: u32 = 70;
/// Entries of a traversal stack. Each level leaves at most seven children waiting, each push writes eight words, and
/// one entry is the sentinel.
pub(super) const STACK: usize = 512;
const _: () = assert!(MAX_DEPTH as usize * (WIDTH - 1) + WIDTH + 1 < STACK);

/// Eight children: their boxes in rows, the words that point at them, and the order in which to visit them.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// min x, max x, min y, max y, min z, max z; empty slots contain the inverted infinite box.
    pub bounds: [[f32; WIDTH]; 6],
    /// The words that point at the children.
    pub child: [u32; WIDTH],
    /// `order[k] >> 3 * octant & 7` is the slot of the k-th child from the far end, for rays of that octant.
    pub order: [u32; WIDTH],
}

/// Four triangles, vertex by vertex and axis by axis.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
pub(super) struct Block {
    /// Row `3 * vertex + axis`.
    pub rows: [[f32; LANES]; 9],
    /// The identifiers to report; padding lanes contain a triangle without area, which is never hit.
    pub id: [u32; LANES],
}

impl Block {
    /// A block that is never hit.
    pub(super) const VOID: Block = Block { rows: [[0.0; LANES]; 9], id: [u32::MAX; LANES] };
}

const LEAF: u32 = 1 << 31;
const SOLID: u32 = 1 << 30;
const LEAF_INDEX_BITS: u32 = 27;

/// Most blocks or solids that a tree can address.
pub(super) const MAX_LEAF_INDEX: usize = 1 << LEAF_INDEX_BITS;

/// The bottom of every traversal stack: a leaf of block 0, which is void.
pub(super) const SENTINEL: u32 = LEAF;

/// The word for inner node `index`.
pub(super) fn inner_word(index: usize) -> u32 {
    debug_assert!(index < SOLID as usize);
    index as u32
}

/// The word for `count` blocks from `first` on.
pub(super) fn block_word(first: usize, count: usize) -> u32 {
    debug_assert!(first < MAX_LEAF_INDEX && (1..=LEAF_BLOCKS).contains(&count));
    LEAF | (first as u32) << 3 | (count as u32 - 1)
}

/// The word for `count` solids from `first` on.
pub(super) fn solid_word(first: usize, count: usize) -> u32 {
    SOLID | block_word(first, count)
}

/// The word for the node or leaf that is `by` places after `word`'s.
pub(super) fn moved_word(word: u32, by: usize) -> u32 {
    if is_leaf(word) { word + ((by as u32) << 3) } else { word + by as u32 }
}

#[inline(always)]
pub(super) fn is_leaf(word: u32) -> bool {
    word & LEAF != 0
}

#[inline(always)]
pub(super) fn is_solid(word: u32) -> bool {
    word & SOLID != 0
}

/// First index and count of a leaf word.
#[inline(always)]
pub(super) fn leaf_range(word: u32) -> (usize, usize) {
    (((word & !(LEAF | SOLID)) >> 3) as usize, (word & 7) as usize + 1)
}

/// The data that the kernels traverse.
pub(super) struct Tree {
    /// Node 0 is the root.
    pub nodes: Vec<Node>,
    /// Block 0 is void.
    pub blocks: Vec<Block>,
    /// All primitives except triangles, in leaf order.
    pub solids: Vec<PlacedSolid>,
}

impl Tree {
    /// Check what the kernels rely on, and return the depth. Every word must point inside its array, and children must
    /// come after their parents, so that a traversal ends and the stack is large enough.
    pub(super) fn checked_depth(&self) -> u32 {
        assert!(!self.nodes.is_empty() && !self.blocks.is_empty());
        let mut depth = vec![1u32; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            for slot in (0..WIDTH).filter(|&s| node.bounds[0][s] <= node.bounds[1][s]) {
                let word = node.child[slot];
                if is_leaf(word) {
                    let (first, count) = leaf_range(word);
                    let len = if is_solid(word) { self.solids.len() } else { self.blocks.len() };
                    assert!(first + count <= len, "leaf outside its array");
                } else {
                    assert!(
                        (i + 1..self.nodes.len()).contains(&(word as usize)),
                        "child before its parent"
                    );
                    depth[word as usize] = depth[word as usize].max(depth[i] + 1);
                }
            }
        }
        depth.into_iter().max().unwrap_or(1)
    }
}
