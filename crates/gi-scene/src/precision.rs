//! Checks whether single precision is enough for the coordinates of a scene.

use gi_core::geometry::{Instance, Shape};
use gi_core::scene::SceneParts;

use crate::diagnostics::Report;

/// Largest rounding error of a coordinate, relative to it.
pub(crate) const ROUNDING: f32 = 1.0 / (1 << 24) as f32;
/// Warn if coordinates are rounded by more than this fraction of the scene's radius. A room with a lamp at 1% of its
/// size from the ceiling, moved away from the origin: at 7e-5 its picture differs by less than 0.1%, at 7e-4 by 0.3%,
/// at 7e-3 by 1% and at 7e-2 by 17%.
const COARSE: f32 = 2e-4;

/// Refuse coordinates that overflowed; warn if coordinates are too coarse. A scene has been moved to its own origin in
/// double precision. What remains are `rounding` (world units), by which mesh files in single precision round their
/// positions, and groups that are far from their own origin.
pub(crate) fn check(parts: &SceneParts, rounding: f32, report: &Report) {
    for shape in parts.shapes.iter().chain(parts.groups.iter().flatten()) {
        let bounds = shape.geometry.bounds();
        let finite = bounds.min.is_finite() && bounds.max.is_finite();
        if !bounds.is_empty() && !finite {
            let name = &shape.name;
            report.error_nowhere(format!(
                "the shape `{name}` is too large: its coordinates overflow single precision"
            ));
        }
    }
    let bounds = parts.bounds();
    if bounds.is_empty() {
        return;
    }
    let radius = 0.5 * bounds.extent().length();
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let rounded = groups(parts).max(rounding).max(farthest * ROUNDING);
    if radius > 0.0 && bounds.center().is_finite() && rounded > COARSE * radius {
        report.warn_nowhere(format!(
            "the scene is {:.1e} units across, and single precision rounds its coordinates by {rounded:.1e}, because they \
             are far from the origin: small gaps may close; move it nearer to the origin",
            2.0 * radius
        ));
    }
}

/// How much the positions of shapes in groups are rounded, in world units.
fn groups(parts: &SceneParts) -> f32 {
    let farthest = |group: &Vec<Shape>| {
        let ends = group.iter().map(|s| s.geometry.bounds()).filter(|b| !b.is_empty());
        ends.map(|b| b.min.abs().max(b.max.abs()).max_element()).fold(0.0, f32::max)
    };
    let of_group: Vec<f32> = parts.groups.iter().map(farthest).collect();
    let scale = |i: &Instance| {
        let m = i.to_world.matrix3;
        [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length()).into_iter().fold(0.0, f32::max)
    };
    let rounded = parts.instances.iter().map(|i| scale(i) * of_group[i.group] * ROUNDING);
    rounded.fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::geometry::Geometry;
    use glam::Vec3;

    fn check_disk(at: f32, radius: f32) -> Result<Vec<String>, String> {
        let report = Report::default();
        let center = Vec3::new(at, 0.0, 0.0);
        let (du, dv) = (radius * Vec3::X, radius * Vec3::Y);
        let disk = Shape::new("disc", Geometry::Disk { center, du, dv }, 0);
        check(&SceneParts { shapes: vec![disk], ..SceneParts::default() }, 0.0, &report);
        report.finish().map_err(|problems| problems.to_string())
    }

    #[test]
    fn a_small_scene_far_away_gives_a_warning() {
        for (at, radius) in [(0.0, 1.0), (1e3, 1.0), (1e6, 1e3), (0.0, 1e-8), (1e-3, 1e-6)] {
            assert_eq!(check_disk(at, radius), Ok(Vec::new()), "{at} {radius}");
        }
        for (at, radius) in [(1e4, 1.0), (-1e6, 1.0), (1e3, 1e-2)] {
            let warnings = check_disk(at, radius).unwrap();
            assert!(warnings[0].contains("nearer to the origin"), "{warnings:?}");
        }
    }

    #[test]
    fn coordinates_that_overflow_are_refused() {
        let shown = check_disk(3e38, 1e38).unwrap_err();
        assert!(shown.contains("`disc` is too large"), "{shown}");
    }
}
