//! The traversal in plain Rust: for processors without a kernel, and as a reference to test the kernels against.

use std::ops::ControlFlow;

use super::layout::{
    Block, LANES, Node, SENTINEL, STACK, Tree, WIDTH, is_leaf, is_solid, leaf_range,
};
use super::solid::PlacedSolid;
use super::walk::Walk;
use crate::ray::{Hit, Ray};

/// The nearest hit, or with `ANY` the first one found.
pub(super) fn trace<const ANY: bool>(tree: &Tree, ray: &Ray) -> Option<Hit> {
    let mut best = None;
    let walk = Walk::new(ray);
    traverse(tree, ray, &walk, |leaf, ray| {
        match leaf {
            Leaf::Solids(solids) => {
                for solid in solids {
                    if ANY {
                        if let Some(prim) = solid.any(ray) {
                            best = Some(Hit { prim, ..FOUND });
                            return ControlFlow::Break(());
                        }
                    } else if let Some(hit) = solid.closest(ray) {
                        ray.tmax = hit.t;
                        best = Some(hit);
                    }
                }
            }
            Leaf::Triangles(blocks) => {
                for block in blocks {
                    if let Some(hit) = triangles(block, ray, &walk) {
                        ray.tmax = hit.t;
                        best = Some(hit);
                        if ANY {
                            return ControlFlow::Break(());
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    });
    best
}

/// The primitives of a leaf.
pub(super) enum Leaf<'t> {
    Solids(&'t [PlacedSolid]),
    Triangles(&'t [Block]),
}

/// Call `visit` with every leaf that the ray may hit, near ones first. `visit` may shorten the ray, or end the traversal.
pub(super) fn traverse(
    tree: &Tree,
    ray: &Ray,
    walk: &Walk,
    mut visit: impl FnMut(Leaf, &mut Ray) -> ControlFlow<()>,
) {
    let mut ray = *ray;
    let mut stack = [(SENTINEL, f32::NEG_INFINITY); STACK];
    let mut top = 0;
    let mut word = 0;
    loop {
        if !is_leaf(word) {
            let node = &tree.nodes[word as usize];
            let (near, mask) = slabs(node, &ray, walk);
            // Push the children that are hit, the nearest last.
            for order in node.order {
                let slot = (order >> walk.order_shift & 7) as usize;
                stack[top + 1] = (node.child[slot], near[slot]);
                top += usize::from(mask[slot]);
            }
        } else {
            let (first, count) = leaf_range(word);
            let leaf = if is_solid(word) {
                Leaf::Solids(&tree.solids[first..first + count])
            } else {
                Leaf::Triangles(&tree.blocks[first..first + count])
            };
            if visit(leaf, &mut ray).is_break() {
                return;
            }
        }
        // Pop the next child that is not beyond the end of the ray.
        while stack[top].1 > ray.tmax {
            top -= 1;
        }
        if top == 0 {
            return;
        }
        word = stack[top].0;
        top -= 1;
    }
}

/// The result of an any-hit traversal, except for the primitive.
pub(super) const FOUND: Hit =
    Hit { t: 0.0, u: 0.0, v: 0.0, prim: u32::MAX, instance: Hit::NO_INSTANCE };

/// Where the ray enters each child, and whether it intersects it within its interval.
fn slabs(node: &Node, ray: &Ray, walk: &Walk) -> ([f32; WIDTH], [bool; WIDTH]) {
    let mut near = [ray.tmin; WIDTH];
    let mut far = [ray.tmax; WIDTH];
    for axis in 0..3 {
        let (o, inv) = (ray.o[axis], walk.inv[axis]);
        let entry = &node.bounds[2 * axis + walk.negative[axis]];
        let exit = &node.bounds[2 * axis + 1 - walk.negative[axis]];
        for s in 0..WIDTH {
            let (a, b) = ((entry[s] - o) * inv, (exit[s] - o) * inv);
            near[s] = if a > near[s] { a } else { near[s] };
            far[s] = if b < far[s] { b } else { far[s] };
        }
    }
    (near, std::array::from_fn(|s| near[s] <= far[s]))
}

/// The nearest hit of four triangles.
fn triangles(block: &Block, ray: &Ray, walk: &Walk) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    for lane in 0..LANES {
        let tmax = best.map_or(ray.tmax, |h| h.t);
        best = triangle(block, lane, &Ray { tmax, ..*ray }, walk).or(best);
    }
    best
}

/// The hit of one triangle of a block, watertight \[Woop13\].
pub(super) fn triangle(block: &Block, lane: usize, ray: &Ray, walk: &Walk) -> Option<Hit> {
    let [kx, ky, kz] = walk.axes;
    let [sx, sy, sz] = walk.shear;
    // Transform the vertices so that the ray is the z axis.
    let vertex = |v: usize| {
        let at = |axis: usize| block.rows[3 * v + axis][lane] - ray.o[axis];
        let z = at(kz);
        [at(kx) - sx * z, at(ky) - sy * z, z]
    };
    let (a, b, c) = (vertex(0), vertex(1), vertex(2));
    // Edge functions: exactly opposite for the two triangles that share an edge.
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let det = u + (v + w);
    if !inside || det == 0.0 {
        return None;
    }
    let t = (u * a[2] + (v * b[2] + w * c[2])) * sz / det;
    let (prim, instance) = (block.id[lane], Hit::NO_INSTANCE);
    (t > ray.tmin && t <= ray.tmax).then(|| Hit { t, u: v / det, v: w / det, prim, instance })
}
