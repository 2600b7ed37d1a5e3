//! Connections of light paths with the camera (t = 1).

use gi_core::camera::Connection;
use gi_core::filter::FilterTable;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use glam::Vec3;

use super::Bidirectional;
use super::vertex::Vertex;
use super::weight;

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
        let (c, pixel, filtered) = self.project(vertex.p(), filter, sampler)?;
        let (f_cos, _) = vertex.f_cos_pdf(c.wi);
        let radiance = vertex.carried * f_cos * (c.importance * filtered);
        if radiance.is_black() {
            return None;
        }
        let radiance = radiance * vertex.transmittance_to(c.end, c.wi, None);
        let weight =
            weight::camera(&self.ways, &vertex.partials, &vertex.joint(c.wi, c.importance));
        (!radiance.is_black()).then_some(Splat { pixel, radiance, weight })
    }

    /// Where the camera sees a point: the connection, the pixel, and the weight of the filter.
    fn project(
        &self,
        p: Vec3,
        filter: &FilterTable,
        sampler: &mut Sampler,
    ) -> Option<(Connection, u32, f32)> {
        let (u_lens, u_filter) = (sampler.next_2d(), sampler.next_2d());
        let camera = self.setting.camera;
        let c = camera.connect(p, u_lens, filter.filter().radius())?;
        let ([x, y], weight) = filter.splat(c.film, u_filter);
        let [w, h] = camera.size();
        let inside = (0..w as i32).contains(&x) && (0..h as i32).contains(&y);
        (inside && weight != 0.0).then(|| (c, (y as usize * w + x as usize) as u32, weight))
    }
}
