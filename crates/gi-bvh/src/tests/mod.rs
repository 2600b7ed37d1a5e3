//! Tests of the tree: against brute force, with unusual rays, and with unusual input.

mod agree;
mod awkward;
mod building;
mod leaks;

use glam::{Affine3A, Mat3, Vec3};

use super::dispatch::{Isa, Kernel};
use super::*;
use crate::random::Pcg;

impl Pcg {
    /// Uniform in 0..n (n > 0); for n below 2^24, the bias is negligible.
    fn next_below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next_u32()) * u64::from(n)) >> 32) as u32
    }
}

/// Uniform in the cube from -1 to 1.
fn in_cube(rng: &mut Pcg) -> Vec3 {
    Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0
}

/// Uniform on the unit sphere.
fn on_sphere(rng: &mut Pcg) -> Vec3 {
    let z = 2.0 * rng.next_f32() - 1.0;
    let (s, c) = (rng.next_f32() * std::f32::consts::TAU).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * c, r * s, z)
}

/// Triangles of about `size`, scattered in the cube from -1 to 1.
fn soup(rng: &mut Pcg, count: u32, size: f32) -> Vec<Triangle> {
    let corner = |rng: &mut Pcg, c: Vec3| c + in_cube(rng) * size;
    (0..count)
        .map(|id| {
            let c = in_cube(rng);
            Triangle { v: [c, corner(rng, c), corner(rng, c)], id }
        })
        .collect()
}

/// Triangles from vertices and faces, numbered in order.
fn mesh(vertices: &[Vec3], faces: &[[usize; 3]]) -> Vec<Triangle> {
    (0..).zip(faces).map(|(id, f)| Triangle { v: f.map(|i| vertices[i]), id }).collect()
}

/// The closed box from `min` to `max`, two triangles per side.
fn closed_box(min: Vec3, max: Vec3) -> Vec<Triangle> {
    let pick = |k: usize, axis: usize| if k >> axis & 1 == 1 { max[axis] } else { min[axis] };
    let vertices: Vec<Vec3> =
        (0..8).map(|k| Vec3::new(pick(k, 0), pick(k, 1), pick(k, 2))).collect();
    let quads =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let faces: Vec<[usize; 3]> =
        quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    mesh(&vertices, &faces)
}

/// The unit sphere from an octahedron, each side subdivided in four `levels` times; corners are shared exactly.
fn icosphere(levels: u32) -> Vec<Triangle> {
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    for k in 0..8 {
        let sign = |bit: u32| if k >> bit & 1 == 1 { -1.0 } else { 1.0 };
        triangles.push([Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)]);
    }
    for _ in 0..levels {
        // The sum of two corners does not depend on their order, so the triangles on both sides of an edge get the same
        // point.
        let middle = |a: Vec3, b: Vec3| (a + b).normalize();
        let cut = |t: &[Vec3; 3]| {
            let [a, b, c] = [middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])];
            [[t[0], a, c], [a, t[1], b], [c, b, t[2]], [a, b, c]]
        };
        triangles = triangles.iter().flat_map(cut).collect();
    }
    (0..).zip(triangles).map(|(id, v)| Triangle { v, id }).collect()
}

fn mapped(triangles: &[Triangle], f: impl Fn(Vec3) -> Vec3) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle { v: t.v.map(&f), id: t.id }).collect()
}

fn build(triangles: &[Triangle]) -> Bvh {
    Bvh::build(triangles, &[]).expect("sound input")
}

/// Run a check with the same tree for every kernel that this machine supports.
fn for_each_kernel(mut bvh: Bvh, mut check: impl FnMut(&Bvh, Isa)) {
    for isa in Isa::available() {
        bvh.kernel = Kernel::new(isa, !bvh.tree.solids.is_empty());
        check(&bvh, isa);
    }
}

/// A random affine transform without tiny scales, mirrored half the time.
fn placement(rng: &mut Pcg) -> Affine3A {
    loop {
        let m = Mat3::from_cols(in_cube(rng), in_cube(rng), in_cube(rng));
        if m.determinant().abs() > 0.1 {
            return Affine3A::from_mat3_translation(m, in_cube(rng));
        }
    }
}
