//! The sensor: camera, film and filter.

mod film;

use gi_core::camera::{CameraSpec, Projection};
use gi_core::filter::Filter;
use gi_core::scene::SceneParts;
use glam::{Affine3A, Mat3, Vec2, Vec3};

use crate::diagnostics::Report;
use crate::document::{Class, Document, Node};
use crate::options::Options;
use crate::value::MAX_NUMBER;
use film::Crop;

/// Diagonal of 36 x 24 mm film, to which focal lengths refer, millimetres.
const FILM_DIAGONAL: f32 = 43.266_615;
/// Focal length of a sensor that gives neither a focal length nor an angle, millimetres.
const DEFAULT_FOCAL_LENGTH: f32 = 50.0;

/// The camera and filter of a scene; `None` if it has no sensor, or if an error was reported.
pub(crate) fn read(
    doc: &Document,
    report: &Report,
    options: &Options,
    parts: &SceneParts,
) -> Option<(CameraSpec, Filter)> {
    let sensor = chosen(doc, report, options.sensor)?;
    let films = sensor.children(Class::Film);
    let filter = films.first().map_or(Filter::Gaussian { stddev: 0.5 }, |film| film::filter(*film));
    // Read the film even if its size is overridden, so that its errors are reported.
    let (film_size, crop) =
        films.first().map_or((film::DEFAULT_SIZE, Crop::WHOLE), |film| film::size(*film));
    let size = options.size.unwrap_or(film_size);
    let principal_point_offset = Vec2::new(
        sensor.float("principal_point_offset_x", 0.0),
        sensor.float("principal_point_offset_y", 0.0),
    );
    sensor.children(Class::Ignored);
    sensor.children(Class::Medium);
    sensor.ignore(&["shutter_open", "shutter_close", "focus_distance", "aperture_radius"]);
    let whole = Vec2::from_array(size.map(|s| s as f32)) / crop.size;
    let (projection, to_world) = projection(sensor, whole.x / whole.y)?;
    note_far_clip(sensor, to_world, parts);
    let near = sensor.within("near_clip", 0.0, 0.0..=MAX_NUMBER);
    let whole = CameraSpec { to_world, projection, size, near, principal_point_offset };
    Some((crop.apply(whole), filter))
}

/// The sensor that the user asked for, or the first one.
fn chosen<'a>(doc: &'a Document, report: &'a Report, index: Option<usize>) -> Option<Node<'a>> {
    let sensors = doc.nodes(report).next()?.children(Class::Sensor);
    match (index, sensors.as_slice()) {
        (None, [_, second, ..]) => second.warn(
            "the scene has several sensors: the first is used, number 0; --sensor 1 chooses this one",
        ),
        (Some(index), all) if index >= all.len() => {
            let n = all.len();
            let message = match n {
                0 => "the scene has no sensor".to_owned(),
                1 => "the scene has one sensor, number 0".to_owned(),
                _ => format!("the scene has {n} sensors, numbered 0 to {}", n - 1),
            };
            report.error_nowhere(format!("--sensor {index}: {message}"));
            return None;
        }
        _ => {}
    }
    sensors.get(index.unwrap_or(0)).copied()
}

/// Warn if the scene reaches beyond the sensor's far plane, which is ignored.
fn note_far_clip(sensor: Node<'_>, to_world: Affine3A, parts: &SceneParts) {
    let Some(far) = sensor.float_opt("far_clip") else { return };
    let camera = Vec3::from(to_world.translation);
    let bounds = crate::framing::bounds_of(parts);
    let farthest = (bounds.min - camera).abs().max((bounds.max - camera).abs()).length();
    if farthest.is_finite() && farthest > far {
        let message = format!("`far_clip` {far} is ignored: objects beyond it are visible");
        sensor.report.warn(sensor.span_of("far_clip"), message);
    }
}

/// `aspect` is that of the whole film, width over height.
fn projection(sensor: Node<'_>, aspect: f32) -> Option<(Projection, Affine3A)> {
    let m = sensor.to_world().as_affine3a();
    if !m.inverse().is_finite() {
        let span = sensor.span_of("to_world");
        sensor.report.error(span, "the camera's `to_world` cannot be inverted", "");
        return None;
    }
    let lens = match sensor.plugin() {
        "orthographic" => return Some((Projection::Orthographic, m)),
        "perspective" | "pinhole" => 0.0,
        "thinlens" => sensor.within("aperture_radius", 0.0, 0.0..=MAX_NUMBER),
        "perspective_rdist" => {
            sensor.warn("`perspective_rdist` is approximated by `perspective`");
            0.0
        }
        _ => {
            sensor.unknown_plugin(&["perspective", "thinlens", "orthographic"]);
            return None;
        }
    };
    let fov_x = fov_x(sensor, aspect)?;
    let focus_distance =
        if lens > 0.0 { sensor.above_zero("focus_distance", 1.0, MAX_NUMBER) } else { 1.0 };
    // Scale does not matter for a perspective camera: keep only its position, rotation and mirroring.
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis]
        .map(|c| crate::transform::unit(c.into()).0);
    let rotation = Mat3::from_cols(columns[0], columns[1], columns[2]);
    let to_world = Affine3A::from_mat3_translation(rotation, m.translation.into());
    Some((Projection::Perspective { fov_x, aperture_radius: lens, focus_distance }, to_world))
}

/// The horizontal angle of view, radians.
pub(crate) fn fov_x(sensor: Node<'_>, aspect: f32) -> Option<f32> {
    let (half_tangent, axis) = match sensor.float_opt("fov") {
        Some(degrees) if 0.0 < degrees && degrees < 180.0 => {
            ((0.5 * degrees.to_radians()).tan(), sensor.text("fov_axis").unwrap_or("x"))
        }
        Some(degrees) => {
            sensor.report.error(
                sensor.span_of("fov"),
                format!("fov {degrees}"),
                "expected 0 to 180",
            );
            return None;
        }
        None => (FILM_DIAGONAL / (2.0 * focal_length(sensor)?), "diagonal"),
    };
    if axis == "x" && sensor.has("fov") {
        return Some(sensor.float("fov", 0.0).to_radians()); // avoids the rounding of tan and atan
    }
    // Ratio of the half extent along x to that along the named axis.
    let to_x = match axis {
        "x" => 1.0,
        "y" => aspect,
        "diagonal" => aspect / (1.0 + aspect * aspect).sqrt(),
        "smaller" => aspect.max(1.0),
        "larger" => aspect.min(1.0),
        other => {
            let known = ["x", "y", "diagonal", "smaller", "larger"];
            let help = sensor.report.suggestion(other, known);
            let span = sensor.span_of("fov_axis");
            let message = format!("unknown axis `{other}`");
            sensor.report.error_help(
                span,
                message,
                "expected x, y, diagonal, smaller or larger",
                help,
            );
            return None;
        }
    };
    Some(2.0 * (half_tangent * to_x).atan())
}

/// Focal length in millimetres, from "50mm" or 50.
fn focal_length(sensor: Node<'_>) -> Option<f32> {
    if !sensor.has("focal_length") {
        return Some(DEFAULT_FOCAL_LENGTH);
    }
    let length = match sensor.text_opt("focal_length") {
        Some(text) => text.trim().trim_end_matches("mm").trim().parse().ok(),
        None => sensor.float_opt("focal_length"),
    };
    let positive = length.filter(|l| *l > 0.0);
    if positive.is_none() {
        let span = sensor.span_of("focal_length");
        sensor.report.error(
            span,
            "this is not a focal length",
            "expected millimetres, such as `50mm`",
        );
    }
    positive
}
