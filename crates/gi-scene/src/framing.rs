//! The camera of a scene that brings none: as the command line says, and so that all is seen.

use gi_core::camera::CameraSpec;
use gi_core::math::Bounds;
use gi_core::scene::SceneParts;
use glam::Vec3;

use crate::diagnostics::Report;
use crate::load::CameraOverride;

/// Angle of view of a camera that is chosen, degrees.
const DEFAULT_FOV: f32 = 45.0;
/// Farther away than this, single precision cannot tell a scene from a point.
const MAX_DISTANCE: f32 = 1e12;
/// Sine of the angle between the view and "up" below which they count as parallel.
const PARALLEL: f32 = 1e-6;

/// A camera as the options say; what they do not say is chosen so that everything is in view from +z.
/// `None` after a reported problem.
pub(crate) fn frame(
    parts: &SceneParts,
    camera: &CameraOverride,
    size: [usize; 2],
    report: &Report,
) -> Option<CameraSpec> {
    if !check(camera, report) {
        return None;
    }
    let boxes = parts.shapes.iter().map(|s| s.geometry.bounds());
    let bounds = boxes.fold(Bounds::EMPTY, Bounds::union);
    let center = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
    let radius = (0.5 * bounds.extent().length()).max(1e-3);
    let fov = camera.fov.unwrap_or(DEFAULT_FOV).to_radians();
    let narrow = ((0.5 * fov).tan() * (size[1] as f32 / size[0] as f32).min(1.0)).atan();
    let target = camera.target.unwrap_or(center);
    let origin = camera.origin.unwrap_or(target + Vec3::Z * (radius / narrow.sin()));
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

/// Note that a scene with a sensor takes no other camera.
pub(crate) fn warn_unused(camera: &CameraOverride, report: &Report) {
    let given = [
        ("--origin", camera.origin.is_some()),
        ("--target", camera.target.is_some()),
        ("--up", camera.up.is_some()),
        ("--fov", camera.fov.is_some()),
    ];
    for (name, _) in given.iter().filter(|(_, given)| *given) {
        report.warn_nowhere(format!(
            "{name} has no effect on an XML scene: its sensor says where the camera stands"
        ));
    }
}

/// Whether the numbers can be those of a camera; a reported problem if not.
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
        fail("--up 0,0,0: expected a direction".to_owned());
    }
    fine
}

/// What is up in the picture; +y unless given, and another direction if the camera looks along that.
fn up(given: Option<Vec3>, view: Vec3, report: &Report) -> Option<Vec3> {
    let up = given.unwrap_or(Vec3::Y).try_normalize().unwrap_or(Vec3::ZERO);
    if up.cross(view).length() >= PARALLEL {
        return Some(up);
    }
    if let Some(up) = given {
        let up = list(up);
        report.error_nowhere(format!("--up {up} lies along the view: give another direction"));
        return None;
    }
    let other = view.any_orthonormal_vector();
    let chosen = list(other);
    report.warn_nowhere(format!("the camera looks along y: {chosen} is up; --up says otherwise"));
    Some(other)
}

fn list(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}
