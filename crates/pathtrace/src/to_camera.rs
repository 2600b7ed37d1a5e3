//! What paths from the lights need to reach the camera.

use gi_core::camera::{Camera, Connection};
use gi_core::filter::FilterTable;
use gi_core::math::Rgb;
use gi_core::medium::{MediumId, Tracking};
use gi_core::ray::Ray;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use glam::Vec3;

/// Connect a point to the camera. Returns the connection, the index of a pixel that the filter reaches, and the filter's
/// weight there.
pub(crate) fn project(
    camera: &Camera,
    p: Vec3,
    filter: &FilterTable,
    sampler: &mut Sampler,
) -> Option<(Connection, u32, f32)> {
    let (u_lens, u_filter) = (sampler.next_2d(), sampler.next_2d());
    let c = camera.connect(p, u_lens, filter.filter().radius())?;
    let ([x, y], weight) = filter.splat(c.film, u_filter);
    let [w, h] = camera.size();
    let inside = (0..w as i32).contains(&x) && (0..h as i32).contains(&y);
    (inside && weight != 0.0).then(|| (c, (y as usize * w + x as usize) as u32, weight))
}

/// Transmittance, random if the density of a medium varies, along a ray that starts in `medium` and ends on the flat primitive `end`.
pub(crate) fn transmittance(
    scene: &Scene,
    ray: Ray,
    end: Option<u32>,
    medium: Option<MediumId>,
    random: &mut Tracking,
) -> Rgb {
    if scene.has_media() {
        scene.transmittance_through_media_to(ray, end, medium, random)
    } else {
        scene.transmittance_to(ray, end)
    }
}
