//! Connections of light paths with the camera (t = 1).

use gi_core::filter::FilterTable;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;

use super::Bidirectional;
use super::vertex::Vertex;
use super::weight;
use crate::to_camera::project;

/// Light that a light path brings to a pixel.
#[derive(Clone, Copy)]
pub(crate) struct Splat {
    pub(crate) pixel: u32,
    /// Not divided by the number of paths.
    pub(crate) radiance: Rgb,
    pub(crate) weight: f32,
}

impl Bidirectional<'_> {
    /// Connect a vertex with the camera (t = 1).
    pub(crate) fn connect_camera(
        &self,
        vertex: &Vertex,
        filter: &FilterTable,
        sampler: &mut Sampler,
    ) -> Option<Splat> {
        let camera = self.setting.camera;
        let (c, pixel, filtered) = project(camera, vertex.p(), filter, sampler)?;
        let (f_cos, _) = vertex.f_cos_pdf(c.wi);
        let radiance = vertex.carried * f_cos * (c.importance * filtered);
        if radiance.is_black() {
            return None;
        }
        let radiance = radiance * vertex.transmittance_to(c.end, c.wi, None);
        let joint = vertex.joint(c.wi, c.importance);
        let direct = vertex.segments == 1;
        let weight = weight::camera(&self.ways, &vertex.partials, &joint, direct);
        (!radiance.is_black()).then_some(Splat { pixel, radiance, weight })
    }
}
