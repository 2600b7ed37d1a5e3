//! A subpath while it is walked: what its next vertex must know of it.

use glam::Vec3;

use super::Bidirectional;
use super::vertex::Vertex;
use super::weight::{Partials, Ways};

/// The end of a subpath.
pub(crate) struct Trail {
    /// The last vertex that has turned the path; at first, the point on the lens or on the light.
    pub(crate) from: Vec3,
    /// The partials that left it; `None` at first.
    pub(crate) leaving: Option<Partials>,
    /// Number of scatterings that were not by delta lobes.
    pub(crate) non_delta: u32,
    /// Whether the last scattering was by a delta lobe.
    pub(crate) after_delta: bool,
}

impl Trail {
    /// A subpath that begins at a point.
    pub(crate) fn new(from: Vec3) -> Self {
        Trail { from, leaving: None, non_delta: 0, after_delta: false }
    }

    /// The partials at the next vertex, at `p`. `first` computes those of the first vertex.
    pub(crate) fn reach(
        &self,
        ways: &Ways,
        facing: f32,
        p: Vec3,
        first: impl FnOnce() -> Partials,
    ) -> Partials {
        match &self.leaving {
            Some(leaving) => leaving.reach(ways, facing, self.from.distance_squared(p)),
            None => first(),
        }
    }

    /// The path has left `vertex` in a direction that was sampled with this density, see
    /// [`gi_core::eye::EyeWalk::turned`].
    pub(crate) fn turn(
        &mut self,
        of: &Bidirectional,
        vertex: &Vertex,
        turned: (Vec3, Option<f32>),
    ) {
        self.from = vertex.p();
        self.leaving = Some(of.leave(vertex, turned));
        self.after_delta = turned.1.is_none();
        self.non_delta += u32::from(!self.after_delta);
    }
}

impl Bidirectional<'_> {
    /// The partials of a path that leaves `vertex` in a direction that was sampled with this density.
    pub(crate) fn leave(&self, vertex: &Vertex, (d, pdf_w): (Vec3, Option<f32>)) -> Partials {
        let facing = vertex.facing(d);
        match pdf_w {
            Some(pdf_w) => {
                let densities = [pdf_w, vertex.reverse_pdf_w(d)];
                vertex.partials.scatter(&self.ways, facing, densities, vertex.merges())
            }
            None => vertex.partials.scatter_delta(&self.ways, facing),
        }
    }
}
