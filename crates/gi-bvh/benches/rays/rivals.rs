//! obvhs's own traversals with their best settings: triangles copied in tree order, large ones split first.

use std::time::Duration;

use gi_bvh::ray::Ray;
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use crate::meshes::Mesh;

/// An obvhs tree and its triangles in leaf order.
pub(crate) struct Obvhs<T> {
    tree: T,
    triangles: Vec<RtTriangle>,
    primitive: Vec<u32>,
}

fn parameters() -> BvhBuildParams {
    BvhBuildParams { pre_split: true, ..BvhBuildParams::medium_build() }
}

fn corners(mesh: &Mesh) -> Vec<Triangle> {
    let corner = |i: u32| mesh.vertices[i as usize].into();
    mesh.faces
        .iter()
        .map(|f| Triangle { v0: corner(f[0]), v1: corner(f[1]), v2: corner(f[2]) })
        .collect()
}

fn convert(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(ray.o.into(), ray.d.into(), ray.tmin, ray.tmax)
}

macro_rules! rival {
    ($tree:ident, $build:ident) => {
        impl Obvhs<$tree> {
            /// Build the tree.
            pub(crate) fn new(mesh: &Mesh) -> Self {
                let all = corners(mesh);
                let tree = $build(&all, parameters(), &mut Duration::default());
                let primitive = tree.primitive_indices.clone();
                let triangles =
                    primitive.iter().map(|&i| RtTriangle::from(&all[i as usize])).collect();
                Obvhs { tree, triangles, primitive }
            }

            /// Parameter and primitive of the nearest hit.
            #[inline]
            pub(crate) fn closest(&self, ray: &Ray) -> Option<(f32, u32)> {
                let mut hit = RayHit { t: ray.tmax, ..RayHit::none() };
                self.tree.ray_traverse(convert(ray), &mut hit, |ray, k| {
                    self.triangles[k].intersect(ray)
                });
                let met = hit.primitive_id != u32::MAX;
                met.then(|| (hit.t, self.primitive[hit.primitive_id as usize]))
            }

            /// Whether anything is hit.
            #[inline]
            pub(crate) fn occluded(&self, ray: &Ray) -> bool {
                !self
                    .tree
                    .ray_traverse_miss(convert(ray), |ray, k| self.triangles[k].intersect(ray))
            }
        }
    };
}

rival!(CwBvh, build_cwbvh_from_tris);
rival!(Bvh2, build_bvh2_from_tris);
