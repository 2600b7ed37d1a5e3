//! Checks the primitives and turns them into tagged boxes.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::layout::MAX_LEAF_INDEX;
use super::solid::PlacedSolid;
use super::{BuildError, Solid, Triangle};
use crate::bounds::Bounds;

/// Largest coordinate: with larger ones, products in the triangle test overflow.
const LARGEST: f32 = 1e12;
/// Largest number of primitives, counting the pieces of split triangles.
const MOST: usize = MAX_LEAF_INDEX;
/// Set in every tag, so that its bits are those of a normal float: arithmetic on denormals is slow.
const TAG_BIT: u32 = 0x4000_0000;
/// Smallest number of items per task.
const GRAIN: usize = 1 << 13;

/// A box in SIMD-friendly form; the fourth lanes are unused.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    pub min: Vec4,
    pub max: Vec4,
}

impl Box4 {
    pub(super) const EMPTY: Box4 = Box4 { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn grow(&mut self, min: Vec4, max: Vec4) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    /// Half the surface area.
    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + (d.x + d.y) * d.z
    }
}

/// The box of a primitive or of a piece of one; the primitive's index is in `max.w`.
#[derive(Clone, Copy)]
pub(super) struct PrimRef {
    pub min: Vec4,
    pub max: Vec4,
}

impl PrimRef {
    pub(super) fn new(min: Vec3, max: Vec3, primitive: usize) -> Self {
        debug_assert!(primitive < TAG_BIT as usize);
        PrimRef {
            min: min.extend(0.0),
            max: max.extend(f32::from_bits(primitive as u32 | TAG_BIT)),
        }
    }

    /// The primitive's index: triangles first, then solids.
    #[inline(always)]
    pub(super) fn primitive(&self) -> usize {
        (self.max.w.to_bits() & !TAG_BIT) as usize
    }

    /// Twice the centre.
    #[inline(always)]
    pub(super) fn center2(&self) -> Vec4 {
        self.min + self.max
    }
}

/// The checked primitives of a tree under construction.
pub(super) struct Input<'a> {
    pub triangles: &'a [Triangle],
    /// Solids by index after the triangles, as in [`PrimRef::primitive`]; `None` for a solid that no ray can hit.
    pub solids: Vec<Option<PlacedSolid>>,
    pub refs: Vec<PrimRef>,
    pub bounds: Bounds,
}

impl<'a> Input<'a> {
    pub(super) fn new(
        triangles: &'a [Triangle],
        solids: &[(Solid, u32)],
    ) -> Result<Self, BuildError> {
        if triangles.len() + solids.len() > MOST {
            return Err(BuildError::TooMany);
        }
        let mut refs = triangle_refs(triangles)?;
        let mut placed = Vec::with_capacity(solids.len());
        for (i, (solid, id)) in solids.iter().enumerate() {
            let (solid, bounds) = PlacedSolid::new(solid, *id)?.unzip();
            if let Some(b) = bounds {
                check(b.min, b.max, *id)?;
                refs.push(PrimRef::new(b.min, b.max, triangles.len() + i));
            }
            placed.push(solid);
        }
        let all = extent(&refs);
        let bounds = Bounds { min: all.min.truncate(), max: all.max.truncate() };
        Ok(Input { triangles, solids: placed, refs, bounds })
    }

    /// Whether a reference is to a solid.
    #[inline]
    pub(super) fn is_solid(&self, r: &PrimRef) -> bool {
        r.primitive() >= self.triangles.len()
    }
}

/// The boxes of all triangles; the first triangle that is not finite or too large is an error.
fn triangle_refs(triangles: &[Triangle]) -> Result<Vec<PrimRef>, BuildError> {
    let fits = |t: &Triangle| t.v.iter().all(|p| p.abs().cmple(Vec3::splat(LARGEST)).all());
    let all_fit = AtomicBool::new(true);
    let reference = |(i, t): (usize, &Triangle)| {
        if !fits(t) {
            all_fit.store(false, Ordering::Relaxed);
        }
        PrimRef::new(t.v[0].min(t.v[1]).min(t.v[2]), t.v[0].max(t.v[1]).max(t.v[2]), i)
    };
    let refs = triangles.par_iter().with_min_len(GRAIN).enumerate().map(reference).collect();
    if all_fit.into_inner() {
        return Ok(refs);
    }
    match triangles.iter().find(|t| !fits(t)) {
        Some(t) if t.v.iter().all(|p| p.is_finite()) => Err(BuildError::TooLarge { id: t.id }),
        Some(t) => Err(BuildError::NonFinite { id: t.id }),
        None => Ok(refs),
    }
}

fn check(min: Vec3, max: Vec3, id: u32) -> Result<(), BuildError> {
    if !(min.is_finite() && max.is_finite()) {
        return Err(BuildError::NonFinite { id });
    }
    let fits = min.abs().max(max.abs()).max_element() <= LARGEST;
    if fits { Ok(()) } else { Err(BuildError::TooLarge { id }) }
}

/// The box around some references.
pub(super) fn extent(refs: &[PrimRef]) -> Box4 {
    let merge = |mut a: Box4, b: Box4| {
        a.grow(b.min, b.max);
        a
    };
    refs.par_chunks(GRAIN)
        .map(|chunk| {
            let mut b = Box4::EMPTY;
            chunk.iter().for_each(|r| b.grow(r.min, r.max));
            b
        })
        .reduce(|| Box4::EMPTY, merge)
}
