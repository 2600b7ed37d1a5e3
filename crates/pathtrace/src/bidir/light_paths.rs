//! The light paths of a pass: traced once, connected with the camera, and kept for the paths from the eye.

use gi_core::bsdf::Transport;
use gi_core::film::Components;
use gi_core::filter::FilterTable;
use gi_core::geometry::Surface;
use gi_core::grid::{Grid, Item};
use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::scene::Scene;
use gi_core::walk::{LightEvent, LightWalk, Roulette, shading_correction, walk_in_order};
use glam::Vec3;
use rayon::prelude::*;

use super::camera::Splat;
use super::eye::Found;
use super::trail::Trail;
use super::vertex::{Site, Vertex, facing};
use super::weight::Partials;
use super::{Bidirectional, CHUNK, light_sampler};

/// The light paths of a pass.
pub(crate) struct LightPaths {
    /// By task, in the order of the paths.
    chunks: Vec<Vec<LightVertex>>,
    /// For each path, its first vertex in its task's list; one entry more than paths per task.
    first: Vec<Vec<u32>>,
}

/// A vertex of a light path where it can be connected.
pub(crate) struct LightVertex {
    /// Number of the path.
    path: u32,
    place: Place,
    /// Unit direction back along the path.
    wo: Vec3,
    /// Power that arrives, not divided by the number of paths.
    power: Rgb,
    partials: Partials,
    segments: u32,
    non_delta: u32,
    /// Whether the last scattering before it was by a delta lobe.
    after_delta: bool,
    /// Whether it scatters only to the side of its shading normal that the light comes from.
    is_opaque: bool,
    /// What it brings to a pixel.
    splat: Option<Splat>,
}

enum Place {
    Surface { surface: Surface, medium: Option<MediumId> },
    Medium { p: Vec3, medium: MediumId },
}

/// Light that has reached a surface, to be merged with paths from the eye. A query waits for memory, so everything that
/// merging needs lies together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Photon {
    pub(crate) ng: Vec3,
    /// Unit direction back to where the light came from.
    pub(crate) wi: Vec3,
    /// Power, not divided by the number of paths.
    pub(crate) power: Rgb,
    /// Number of segments from the light.
    pub(crate) segments: u32,
    /// Scatterings before that were not by delta lobes, and whether there were only delta lobes.
    pub(crate) kind: (u32, bool),
    pub(crate) partials: Partials,
}

impl LightVertex {
    /// Call `visit` with the vertex. Its BSDF is evaluated for the call.
    pub(crate) fn visit<R>(&self, scene: &Scene, visit: impl FnOnce(&Vertex) -> R) -> R {
        let bsdf;
        let site = match &self.place {
            Place::Surface { surface, medium } => {
                bsdf = scene.bsdf(surface, self.wo, Transport::Power);
                Site::Surface { surface, bsdf: &bsdf, medium: *medium }
            }
            Place::Medium { p, medium } => Site::Medium { p: *p, medium: *medium },
        };
        visit(&Vertex {
            scene,
            site,
            transport: Transport::Power,
            wo: self.wo,
            carried: self.power,
            partials: self.partials,
            segments: self.segments,
            non_delta: self.non_delta,
        })
    }

    /// The photon that the path leaves here, as [`gi_core::walk::Photon::at`] has it; `None` in media.
    fn photon(&self) -> Option<Item<Photon>> {
        let Place::Surface { surface, .. } = &self.place else { return None };
        let LightVertex { wo: wi, segments, partials, .. } = *self;
        let power = self.power * shading_correction(wi, surface.ng, surface.ns());
        let kind = (self.non_delta, segments > 1 && self.non_delta == 0);
        let value = Photon { ng: surface.ng, wi, power, segments, kind, partials };
        Some(Item { p: surface.p, value })
    }

    /// The flat primitive that it lies on.
    pub(crate) fn flat(&self, scene: &Scene) -> Option<u32> {
        match &self.place {
            Place::Surface { surface, .. } => scene.flat_at(surface),
            Place::Medium { .. } => None,
        }
    }

    /// Whether nothing is scattered toward `d`, as is known without evaluating the BSDF.
    #[inline]
    pub(crate) fn faces_away(&self, d: Vec3) -> bool {
        match &self.place {
            Place::Surface { surface, .. } if self.is_opaque => {
                surface.ns().dot(self.wo) * surface.ns().dot(d) < 0.0
            }
            _ => false,
        }
    }

    /// Its position.
    pub(crate) fn p(&self) -> Vec3 {
        match &self.place {
            Place::Surface { surface, .. } => surface.p,
            Place::Medium { p, .. } => *p,
        }
    }

    /// Number of segments from the light.
    pub(crate) fn segments(&self) -> u32 {
        self.segments
    }
}

impl LightPaths {
    /// Trace the paths of a pass.
    pub(crate) fn trace(of: &Bidirectional, pass: u32, filter: &FilterTable) -> Self {
        let paths = of.light_paths;
        let chunks =
            walk_in_order(paths, CHUNK, |path, left| of.light_path(pass, path, filter, left));
        let first =
            chunks.par_iter().enumerate().map(|(k, chunk)| first_of_paths(chunk, k as u32 * CHUNK));
        let first = first.collect();
        LightPaths { chunks, first }
    }

    /// The vertices of a path.
    pub(crate) fn path(&self, path: u32) -> &[LightVertex] {
        let (chunk, within) = ((path / CHUNK) as usize, (path % CHUNK) as usize);
        let first = &self.first[chunk];
        &self.chunks[chunk][first[within] as usize..first[within + 1] as usize]
    }

    /// The light that the paths bring to the pixels, in row order. The sums do not depend on the number of threads.
    pub(crate) fn splats(&self, of: &Bidirectional, pixels: usize) -> Vec<Components> {
        let mut picture = vec![Components::default(); pixels];
        self.for_each_splat(of.ways.light_paths, |pixel, found| {
            let (non_delta, then_delta) = found.kind;
            *picture[pixel].of_path(non_delta, then_delta) += found.radiance * found.weight;
        });
        picture
    }

    /// Call `visit` with every pixel that a path lights, and the light (t = 1), in the order of the paths.
    pub(crate) fn for_each_splat(&self, light_paths: f32, mut visit: impl FnMut(usize, Found)) {
        for v in self.chunks.iter().flatten() {
            let Some(Splat { pixel, radiance, weight }) = v.splat else { continue };
            let (s, t, radiance) = (v.segments + 1, 1, radiance / light_paths);
            let kind = (v.non_delta + 1, v.non_delta == 0 && v.after_delta);
            visit(pixel as usize, Found { s, t, merged: false, radiance, weight, kind });
        }
    }

    /// Number of vertices that are kept, and the memory that they need in bytes.
    pub(crate) fn memory(&self) -> (u64, u64) {
        let vertices = self.chunks.iter().map(Vec::len).sum::<usize>() as u64;
        (vertices, vertices * size_of::<LightVertex>() as u64)
    }

    /// The photons of all paths in a grid, for searches within `radius`.
    pub(crate) fn grid(&self, radius: f32) -> Grid<Photon> {
        let of_chunk = |vertices: &Vec<LightVertex>| -> Vec<Item<Photon>> {
            vertices.iter().filter_map(LightVertex::photon).collect()
        };
        let photons: Vec<_> = self.chunks.par_iter().map(of_chunk).collect();
        // A search then covers two cells along an axis.
        Grid::build(&photons, 2.0 * radius)
    }
}

impl<'a> Bidirectional<'a> {
    /// Walk one light path. Connect its vertices with the camera, and keep them.
    fn light_path(&self, pass: u32, path: u32, filter: &FilterTable, left: &mut Vec<LightVertex>) {
        let scene = self.setting.scene;
        let sampler = light_sampler(&self.setting, pass, path);
        let Some(mut walk) = LightWalk::begin(scene, sampler) else { return };
        walk.use_media();
        let roulette = Roulette::ByAlbedo { from: self.limits.rr_depth };
        let emission = *walk.emission();
        let mut trail = Trail::new(emission.p);
        while let Some(event) = &walk.next_event() {
            let (depth, p) = (event.depth(), event.p());
            // Segments from the light to here; a connection would be one more.
            if !self.limits.goes_on(depth + 1) {
                return;
            }
            let (site, wo, carried) = match event {
                LightEvent::Surface(v) => {
                    let (surface, bsdf, medium) = (&v.surface, &v.bsdf, v.medium);
                    (Site::Surface { surface, bsdf, medium }, v.wo, v.power)
                }
                LightEvent::Medium(v) => (Site::Medium { p, medium: v.medium }, v.wo, v.power),
            };
            let facing = facing(site, wo);
            let partials = trail.reach(&self.ways, facing, p, || {
                let end = scene.lights().end_of_emission(&emission, p);
                Partials::of_light(&self.ways, &end, facing)
            });
            let vertex = Vertex {
                scene,
                site,
                transport: Transport::Power,
                wo,
                carried,
                partials,
                segments: depth + 1,
                non_delta: event.non_delta(),
            };
            if vertex.connects() {
                let splat = self.connect_camera(&vertex, filter, walk.sampler());
                left.push(keep(path, event, &vertex, splat));
            }
            let goes_on = match event {
                LightEvent::Surface(v) => walk.scatter(v, roulette),
                LightEvent::Medium(v) => walk.scatter_within(v, roulette),
            };
            if !goes_on {
                return;
            }
            if walk.depth() > depth {
                trail.turn(self, &vertex, walk.turned());
            }
        }
    }
}

/// For each path of a task, and one more, its first vertex in the task's list. `from` is the number of the first path.
fn first_of_paths(chunk: &[LightVertex], from: u32) -> Vec<u32> {
    let mut first = Vec::with_capacity(CHUNK as usize + 1);
    for (k, v) in chunk.iter().enumerate() {
        first.resize((v.path - from) as usize + 1, k as u32);
    }
    first.resize(CHUNK as usize + 1, chunk.len() as u32);
    first
}

/// A vertex as it is kept.
fn keep(path: u32, event: &LightEvent, vertex: &Vertex, splat: Option<Splat>) -> LightVertex {
    let (place, after_delta) = match event {
        LightEvent::Surface(v) => {
            (Place::Surface { surface: v.surface, medium: v.medium }, v.after_delta)
        }
        LightEvent::Medium(v) => (Place::Medium { p: v.p, medium: v.medium }, v.after_delta),
    };
    let is_opaque = match vertex.site {
        Site::Surface { surface, bsdf, .. } => {
            bsdf.opaque_normal().is_some_and(|n| n == surface.ns() || n == -surface.ns())
        }
        Site::Medium { .. } => false,
    };
    LightVertex {
        path,
        place,
        wo: vertex.wo,
        power: vertex.carried,
        partials: vertex.partials,
        segments: vertex.segments,
        non_delta: vertex.non_delta,
        after_delta,
        is_opaque,
        splat,
    }
}
