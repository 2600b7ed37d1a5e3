//! The camera options of the command line: choose a camera if the scene has none, or move the scene's camera.

use gi_core::camera::{CameraSpec, Projection};
use gi_core::math::Bounds;
use gi_core::scene::SceneParts;
use glam::Vec3;

use crate::diagnostics::Report;
use crate::options::CameraOverride;

/// Horizontal angle of view of a chosen camera, degrees.
const DEFAULT_FOV: f32 = 45.0;
/// Largest coordinate: beyond it, single precision cannot resolve a scene.
const MAX_DISTANCE: f32 = 1e12;
/// The view and "up" count as parallel if the sine of the angle between them is smaller.
const PARALLEL: f32 = 1e-6;

/// A camera from the options. Everything that they leave open is chosen so that the whole scene is visible from +z.
/// `None` if an error was reported.
pub(crate) fn frame(
    parts: &SceneParts,
    camera: &CameraOverride,
    size: [usize; 2],
    report: &Report,
) -> Option<CameraSpec> {
    if !check(camera, report) {
        return None;
    }
    let bounds = bounds_of(parts);
    let center = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
    let radius = (0.5 * bounds.extent().length()).max(1e-3);
    let fov = camera.fov.unwrap_or(DEFAULT_FOV).to_radians();
    let narrow = ((0.5 * fov).tan() * (size[1] as f32 / size[0] as f32).min(1.0)).atan();
    let CameraOverride { origin, target, .. } = camera.relative_to(parts.origin);
    let target = target.unwrap_or(center);
    let origin = origin.unwrap_or(target + Vec3::Z * (radius / narrow.sin()));
    let target = if origin == target { origin - Vec3::Z } else { target };
    let Some(view) = (target - origin).try_normalize() else {
        let (from, to) = (list(origin), list(target));
        report.error_nowhere(format!(
            "the camera cannot look from {from} to {to}: give --origin, --target or a wider --fov"
        ));
        return None;
    };
    let up = up(camera.up, view, report)?;
    Some(CameraSpec::look_at(origin, target, up, fov, size))
}

/// The bounding box of all shapes outside groups.
pub(crate) fn bounds_of(parts: &SceneParts) -> Bounds {
    let boxes = parts.shapes.iter().map(|s| s.geometry.bounds());
    boxes.fold(Bounds::EMPTY, Bounds::union)
}

/// The scene's own camera, moved, turned and zoomed by the options. Everything that they leave open stays.
/// `None` if an error was reported. `own_origin` is that of the scene.
pub(crate) fn moved(
    seen: CameraSpec,
    camera: &CameraOverride,
    own_origin: Vec3,
    report: &Report,
) -> Option<CameraSpec> {
    if !check(camera, report) {
        return None;
    }
    let CameraOverride { origin, target, up: upward, fov } = camera.relative_to(own_origin);
    let mut moved = seen;
    if let Some(fov) = fov {
        match &mut moved.projection {
            Projection::Perspective { fov_x, .. } => *fov_x = fov.to_radians(),
            Projection::Orthographic => {
                report.warn_nowhere("--fov has no effect on an orthographic sensor");
            }
        }
    }
    if origin.is_none() && target.is_none() && upward.is_none() {
        return Some(moved);
    }
    let own = moved.to_world;
    let origin = origin.unwrap_or(own.translation.into());
    let own_view = Vec3::from(own.matrix3.z_axis).normalize();
    let Some(view) = target.map_or(Some(own_view), |t| (t - origin).try_normalize()) else {
        report.error_nowhere(format!(
            "--target {} is the position of the camera: give another one, or --origin",
            list(origin + own_origin)
        ));
        return None;
    };
    let own_up = Vec3::from(own.matrix3.y_axis).normalize();
    let up = if upward.is_none() && own_up.cross(view).length() < PARALLEL {
        // Straight up or down: the old viewing direction becomes up, as on a map.
        report.warn_nowhere(format!(
            "the camera looks along its up direction: {} is up instead; --up changes that",
            list(own_view)
        ));
        own_view
    } else {
        up(upward.or(Some(own_up)), view, report)?
    };
    let turned = CameraSpec::look_at(origin, origin + view, up, 1.0, moved.size).to_world;
    // Keep mirroring and scaling, everything in the sensor's axes besides rotation.
    let own_turn =
        CameraSpec::look_at(Vec3::ZERO, own_view, own.matrix3.y_axis.into(), 1.0, moved.size);
    let rest = own_turn.to_world.matrix3.inverse() * own.matrix3;
    moved.to_world.matrix3 = turned.matrix3 * rest;
    moved.to_world.translation = turned.translation;
    Some(moved)
}

impl CameraOverride {
    /// The same camera in coordinates relative to the scene's own origin.
    fn relative_to(&self, own_origin: Vec3) -> CameraOverride {
        let relative = |p: Vec3| (p.as_dvec3() - own_origin.as_dvec3()).as_vec3();
        CameraOverride {
            origin: self.origin.map(relative),
            target: self.target.map(relative),
            ..*self
        }
    }
}

/// Whether the numbers describe a valid camera; reports an error if not.
fn check(camera: &CameraOverride, report: &Report) -> bool {
    let mut fine = true;
    let mut fail = |message: String| {
        report.error_nowhere(message);
        fine = false;
    };
    if let Some(fov) = camera.fov.filter(|fov| !(0.0 < *fov && *fov < 180.0)) {
        fail(format!("--fov {fov}: expected more than 0 and less than 180 degrees"));
    }
    let points = [("--origin", camera.origin), ("--target", camera.target), ("--up", camera.up)];
    for (name, point) in points {
        if let Some(p) = point.filter(|p| !(p.abs().max_element() <= MAX_DISTANCE && p.is_finite()))
        {
            fail(format!("{name} {}: expected finite numbers up to 1e12", list(p)));
        }
    }
    if let (Some(origin), Some(target)) = (camera.origin, camera.target)
        && origin == target
    {
        let at = list(origin);
        fail(format!("--origin and --target are both {at}: the camera looks at itself"));
    }
    if camera.up == Some(Vec3::ZERO) {
        fail("--up 0,0,0: expected a non-zero direction".to_owned());
    }
    fine
}

/// The up direction: as given, +y by default, and another axis if the camera looks along +y.
fn up(given: Option<Vec3>, view: Vec3, report: &Report) -> Option<Vec3> {
    let up = given.unwrap_or(Vec3::Y).try_normalize().unwrap_or(Vec3::ZERO);
    if up.cross(view).length() >= PARALLEL {
        return Some(up);
    }
    if let Some(up) = given {
        let up = list(up);
        report.error_nowhere(format!("--up {up} is parallel to the view: give another direction"));
        return None;
    }
    let other = view.any_orthonormal_vector();
    let chosen = list(other);
    report.warn_nowhere(format!("the camera looks along y: {chosen} is up; --up changes that"));
    Some(other)
}

fn list(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}
