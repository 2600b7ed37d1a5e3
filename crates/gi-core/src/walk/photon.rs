//! Photons: light that has reached a surface, and how a pass of light paths stores them.

use glam::Vec3;
use rayon::prelude::*;

use super::LightVertex;
use crate::math::Rgb;
use crate::progress;

/// The kind of a photon's path from the light, in the notation of light paths (L light, S delta lobe, D any other
/// lobe). The kinds are those of [`crate::film::Components`], as seen from the photon's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhotonKind {
    /// L: no scattering.
    Direct,
    /// L S+: only delta lobes. The light is focused.
    Caustic,
    /// L .* D .*: at least one other lobe.
    #[default]
    Indirect,
}

impl PhotonKind {
    /// The kind after `depth` scatterings, of which `non_delta` were not by delta lobes.
    #[inline]
    pub fn after(depth: u32, non_delta: u32) -> Self {
        match (depth, non_delta) {
            (0, _) => PhotonKind::Direct,
            (_, 0) => PhotonKind::Caustic,
            _ => PhotonKind::Indirect,
        }
    }
}

/// Light that has reached a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Position, world.
    pub p: Vec3,
    /// Unit geometric normal, on the side that the light came from.
    pub n: Vec3,
    /// Unit direction back to where the light came from.
    pub wi: Vec3,
    /// Power, already divided by all densities and by the number of paths that [`Photon::at`] was given, and corrected
    /// for shading normals.
    pub power: Rgb,
    /// The kind of path from the light.
    pub kind: PhotonKind,
    /// Number of segments from the light to here.
    pub segments: u32,
}

impl Photon {
    /// The photon at `vertex`, if `paths` light paths are traced.
    #[inline]
    pub fn at(vertex: &LightVertex, paths: f32) -> Self {
        let (wi, ng) = (vertex.wo, vertex.surface.ng);
        let correction = shading_correction(wi, ng, vertex.surface.ns());
        Photon {
            p: vertex.surface.p,
            n: ng * 1f32.copysign(wi.dot(ng)),
            wi,
            power: vertex.power * (correction / paths),
            kind: PhotonKind::after(vertex.depth, vertex.non_delta),
            segments: vertex.depth + 1,
        }
    }
}

/// |wi . ns| / |wi . ng|: photons arrive in proportion to the cosine with the geometric normal, but irradiance uses the
/// shading normal [Veach97, 5.3.2]. Zero along the surface.
#[inline]
pub fn shading_correction(wi: Vec3, ng: Vec3, ns: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let cos = wi.dot(ng).abs();
    if cos > 0.0 { wi.dot(ns).abs() / cos } else { 0.0 }
}

/// Walk the paths 0 to `paths` - 1 in parallel, one task per `chunk` of them, and collect the output of `walk`. The
/// order is that of the paths for any number of threads; there is one list per chunk.
pub fn walk_in_order<T: Send>(
    paths: u32,
    chunk: u32,
    walk: impl Fn(u32, &mut Vec<T>) + Sync,
) -> Vec<Vec<T>> {
    progress::begin("light paths", u64::from(paths));
    (0..paths.div_ceil(chunk))
        .into_par_iter()
        .with_max_len(1)
        .map(|k| {
            let mut left = Vec::new();
            if progress::is_abandoned() {
                return left;
            }
            let first = k * chunk;
            let count = chunk.min(paths - first);
            (first..first + count).for_each(|path| walk(path, &mut left));
            progress::advance(u64::from(count));
            left
        })
        .collect()
}
