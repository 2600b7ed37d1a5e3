//! The parts of the build that use `obvhs`: the compact binary node, splitting of large triangles, and reinsertion.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle as Corners;
use rayon::prelude::*;

use super::Triangle;
use super::input::{Box4, PrimRef};

/// A node of the binary tree, 32 bytes. If `prim_count` is 0, it is an inner node with its children at `first_index`
/// and `first_index + 1`; otherwise a leaf with `prim_count` references from `first_index` on.
pub(super) type BinaryNode = obvhs::bvh2::node::Bvh2Node;

/// Zeroed nodes, as many as a binary tree with `leaves` one-reference leaves has.
pub(super) fn zeroed_nodes(leaves: usize) -> Vec<BinaryNode> {
    Bvh2::zeroed(leaves).nodes
}

/// Triangles are candidates for splitting if their boxes exceed this multiple of the mean half area: obvhs's own
/// threshold.
const LARGE: f32 = 3.0;
/// Number of summands of a partial sum; fixed, so that the mean does not depend on the number of threads.
const CHUNK: usize = 1 << 13;

/// Number of triangles that one task cuts.
const CUT_CHUNK: usize = 1 << 9;

/// Cut the boxes of large triangles into smaller pieces; one reference becomes several.
pub(super) fn split_large(refs: &mut Vec<PrimRef>, triangles: &[Triangle]) {
    let triangle_count = triangles.len();
    if triangle_count < 2 {
        return;
    }
    let area = |r: &PrimRef| Box4 { min: r.min, max: r.max }.half_area();
    let partial = |chunk: &[PrimRef]| {
        chunk.iter().map(area).fold((0.0, 0.0f32), |(s, m), a| (s + f64::from(a), m.max(a)))
    };
    let sums: Vec<(f64, f32)> = refs[..triangle_count].par_chunks(CHUNK).map(partial).collect();
    let (sum, largest) = sums.into_iter().fold((0.0, 0.0f32), |(s, m), (a, b)| (s + a, m.max(b)));
    let mean = (sum / triangle_count as f64) as f32;
    if !mean.is_finite() {
        return;
    }
    let large: Vec<usize> =
        (0..triangle_count).filter(|&i| area(&refs[i]) > LARGE * mean).collect();
    // Each triangle is cut independently, so that chunks give the same pieces as all triangles at once.
    let pieces: Vec<Vec<PrimRef>> =
        large.par_chunks(CUT_CHUNK).map(|l| cut(l, refs, triangles, mean, largest)).collect();
    for (owners, pieces) in large.chunks(CUT_CHUNK).zip(pieces) {
        let (first, more) = pieces.split_at(owners.len());
        owners.iter().zip(first).for_each(|(&i, piece)| refs[i] = *piece);
        refs.extend_from_slice(more);
    }
}

/// The pieces of some triangles: first one piece of each triangle in order, then the others.
fn cut(
    large: &[usize],
    refs: &[PrimRef],
    triangles: &[Triangle],
    mean: f32,
    largest: f32,
) -> Vec<PrimRef> {
    let mut boxes: Vec<Aabb> = large.iter().map(|&i| to_aabb(&refs[i])).collect();
    let corners: Vec<Corners> = large.iter().map(|&i| to_corners(&triangles[i])).collect();
    let mut owner: Vec<u32> = (0..large.len() as u32).collect();
    split_aabbs_preset(&mut boxes, &mut owner, &corners, mean, largest);
    let piece =
        |(b, &o): (&Aabb, &u32)| PrimRef::new(b.min.into(), b.max.into(), large[o as usize]);
    boxes.iter().zip(&owner).map(piece).collect()
}

fn to_aabb(r: &PrimRef) -> Aabb {
    Aabb::new(r.min.truncate().into(), r.max.truncate().into())
}

fn to_corners(t: &Triangle) -> Corners {
    Corners { v0: t.v[0].into(), v1: t.v[1].into(), v2: t.v[2].into() }
}

/// Fraction of the nodes that the first round tries to move.
const REINSERTED: f32 = 0.05;
/// Number of rounds, each with a smaller fraction: 1, 1/3, 1/5 ... Sixteen rounds give no faster tree.
const ROUNDS: usize = 6;

/// Move subtrees to better places \[Meister18\], the largest first. The candidates are chosen here, because the
/// optimiser would only take them from the front of the array.
pub(super) fn reinsert(nodes: Vec<BinaryNode>) -> Vec<BinaryNode> {
    let all = (1..nodes.len() as u32).into_par_iter().filter(|&i| !is_hole(&nodes[i as usize]));
    let mut ranked: Vec<u64> = all.map(|i| rank(&nodes, i)).collect();
    let first_round = (ranked.len() as f32 * REINSERTED) as usize;
    let mut tree = Bvh2 { nodes, ..Bvh2::default() };
    let mut optimizer = ReinsertionOptimizer::default();
    for round in 0..ROUNDS {
        let count = (first_round / (2 * round + 1)).max(1);
        // Boxes change as subtrees move, but small ones are unlikely to become candidates.
        keep_first(&mut ranked, 2 * count);
        ranked.iter_mut().for_each(|r| *r = rank(&tree.nodes, *r as u32));
        let mut best = ranked.clone();
        keep_first(&mut best, count);
        best.sort_unstable();
        let candidates: Vec<u32> = best.iter().map(|&r| r as u32).collect();
        optimizer.run_with_candidates(&mut tree, &candidates, 1);
    }
    tree.nodes
}

/// Keep only the smallest `count`.
fn keep_first(ranked: &mut Vec<u64>, count: usize) {
    if count < ranked.len() {
        ranked.select_nth_unstable(count);
        ranked.truncate(count);
    }
}

/// A key that orders nodes from large to small, without ties; its low half is the index.
fn rank(nodes: &[BinaryNode], i: u32) -> u64 {
    let area = nodes[i as usize].aabb().half_area();
    u64::from(!area.to_bits()) << 32 | u64::from(i)
}

/// Filler for the places that a leaf with several references leaves unused.
pub(super) fn hole() -> BinaryNode {
    BinaryNode::new(Aabb::INVALID, 1, u32::MAX)
}

fn is_hole(node: &BinaryNode) -> bool {
    node.prim_count != 0 && node.first_index == u32::MAX
}
