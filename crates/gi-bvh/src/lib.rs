//! Ray tracing: an 8-wide bounding volume hierarchy with full-precision boxes over blocks of four triangles.
//! It is the only crate of the project with unsafe code, which the vector kernels need.
//!
//! The build splits by the binned surface-area heuristic (`sah`), cuts large triangles and reinserts subtrees
//! (`optimise`), collapses to eight children by dynamic programming (`collapse`) and writes the tree (`emit`). A kernel
//! for the current processor traverses it (`dispatch`). Triangles are watertight: no ray passes through a shared edge.
//! Every box is padded by a tiny fraction of the scene's size, more than the rounding errors of the box and triangle
//! tests.
//!
//! Spheres, disks, cylinders and instances are leaves of the same tree; they cost nothing in a scene of triangles only.

mod bins;
mod bounds;
mod collapse;
mod collect;
mod dispatch;
mod emit;
mod input;
#[cfg(target_arch = "x86_64")]
mod kernel_x86;
mod layout;
mod offset;
mod optimise;
#[cfg_attr(target_arch = "x86_64", allow(dead_code))]
mod portable;
#[cfg(test)]
mod random;
pub mod ray;
mod sah;
mod solid;
mod tame;
#[cfg(test)]
mod tests;
mod walk;

use std::fmt;

use glam::Vec3;

pub use bounds::Bounds;
pub use dispatch::{ISA_VARIABLE, check_instruction_set, instruction_set};
pub use solid::Solid;

use dispatch::Kernel;
use input::Input;
use layout::{Block, MAX_DEPTH, Node, Tree};
use ray::{Hit, Ray};
use sah::Method;
use tame::{REACH, Tamed, is_tame};

/// Padding of every box, relative to the largest coordinate. It covers the rounding of the slab and triangle tests for
/// ray origins within [`REACH`] times that coordinate.
const PAD: f32 = 1.0 / 1_048_576.0;

/// A triangle to build the tree from.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Its corners; u and v of a hit are the weights of the second and the third.
    pub v: [Vec3; 3],
    /// Reported as [`Hit::prim`].
    pub id: u32,
}

/// Why a tree cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildError {
    /// A coordinate is infinite or not a number.
    NonFinite {
        /// The primitive's identifier.
        id: u32,
    },
    /// A coordinate is larger than 1e12, too large for single precision.
    TooLarge {
        /// The primitive's identifier.
        id: u32,
    },
    /// More primitives than the tree can address.
    TooMany,
    /// An instance of a tree that itself contains instances.
    NestedInstance {
        /// The primitive's identifier.
        id: u32,
    },
    /// An instance whose transform is not invertible.
    Singular {
        /// The primitive's identifier.
        id: u32,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BuildError::NonFinite { id } => {
                write!(f, "primitive {id} has a coordinate that is not finite")
            }
            BuildError::TooLarge { id } => {
                write!(f, "primitive {id} has a coordinate larger than 1e12")
            }
            BuildError::TooMany => write!(f, "too many primitives"),
            BuildError::NestedInstance { id } => {
                write!(f, "instance {id} is of a tree that contains instances itself")
            }
            BuildError::Singular { id } => {
                write!(f, "instance {id} has a transform that is not invertible")
            }
        }
    }
}

impl std::error::Error for BuildError {}

/// A bounding volume hierarchy.
pub struct Bvh {
    tree: Tree,
    kernel: Kernel,
    bounds: Bounds,
    /// Largest distance of a ray's origin from the world's origin at which the ray is traced unchanged.
    reach: f32,
    depth: u32,
}

impl Bvh {
    /// Build a tree; the result does not depend on the number of threads. Primitives that cannot be hit (triangles
    /// without area, spheres of radius 0) are allowed. A tree without primitives is never hit.
    pub fn build(triangles: &[Triangle], solids: &[(Solid, u32)]) -> Result<Bvh, BuildError> {
        let bvh = Self::build_by(Method::Cheapest, triangles, solids)?;
        if bvh.depth <= MAX_DEPTH {
            return Ok(bvh);
        }
        // Too deep for the traversal stack. Only reinsertion causes this, on unusual input.
        let bvh = Self::build_by(Method::Halves, triangles, solids)?;
        assert!(bvh.depth <= MAX_DEPTH, "a balanced tree is {} deep", bvh.depth);
        Ok(bvh)
    }

    fn build_by(
        method: Method,
        triangles: &[Triangle],
        solids: &[(Solid, u32)],
    ) -> Result<Bvh, BuildError> {
        let mut input = Input::new(triangles, solids)?;
        let bounds = input.bounds;
        optimise::split_large(&mut input.refs, triangles);
        let mut nodes = sah::build(&mut input, method);
        if method == Method::Cheapest {
            nodes = optimise::reinsert(nodes);
        }
        let largest = if bounds.is_empty() {
            0.0
        } else {
            bounds.min.abs().max(bounds.max.abs()).max_element()
        };
        let tree = emit::emit(&nodes, &mut input, largest * PAD)?;
        let (depth, kernel) = (tree.checked_depth(), Kernel::best(!tree.solids.is_empty()));
        Ok(Bvh { tree, kernel, bounds, reach: largest * REACH, depth })
    }

    /// The nearest primitive that the ray hits in (tmin, tmax].
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        if is_tame(ray, self.reach) {
            self.kernel.closest(&self.tree, ray)
        } else {
            self.closest_wild(ray)
        }
    }

    /// Whether the ray hits anything in (tmin, tmax].
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray).is_some()
    }

    /// A primitive that the ray hits in (tmin, tmax], not necessarily the nearest.
    #[inline]
    pub fn any(&self, ray: &Ray) -> Option<u32> {
        if is_tame(ray, self.reach) { self.kernel.any(&self.tree, ray) } else { self.any_wild(ray) }
    }

    #[cold]
    fn closest_wild(&self, ray: &Ray) -> Option<Hit> {
        let tamed = &Tamed::new(ray, self.bounds)?;
        let mut hit = self.kernel.closest(&self.tree, &tamed.ray)?;
        hit.t = tamed.untame(hit.t);
        Some(hit)
    }

    #[cold]
    fn any_wild(&self, ray: &Ray) -> Option<u32> {
        self.kernel.any(&self.tree, &Tamed::new(ray, self.bounds)?.ray)
    }

    /// The box around everything in the tree.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Memory of the tree in bytes, without the trees that it instances.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val(&self.tree.nodes[..])
            + size_of_val(&self.tree.blocks[..])
            + size_of_val(&self.tree.solids[..])
    }

    /// Number of wide nodes.
    pub fn node_count(&self) -> usize {
        self.tree.nodes.len()
    }

    /// Number of nodes on the longest path from the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }
}

impl fmt::Debug for Bvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bvh")
            .field("nodes", &self.tree.nodes.len())
            .field("blocks", &self.tree.blocks.len())
            .field("solids", &self.tree.solids.len())
            .field("depth", &self.depth)
            .finish_non_exhaustive()
    }
}

const _: () = assert!(size_of::<Node>() == 256 && size_of::<Block>() == 160);
