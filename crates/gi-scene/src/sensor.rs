//! The sensor: camera, film and filter.

use gi_core::camera::{CameraSpec, Projection};
use gi_core::filter::Filter;
use gi_core::scene::SceneParts;
use glam::{Affine3A, Mat3, Vec2, Vec3};

use crate::diagnostics::Report;
use crate::document::{Class, Document, Node};
use crate::value::MAX_NUMBER;

/// Default film size.
const DEFAULT_SIZE: [usize; 2] = [768, 576];
/// Largest width or height: a larger film would not fit into memory.
const MAX_SIZE: i64 = 1 << 15;
/// Diagonal of 36 x 24 mm film, to which focal lengths refer, millimetres.
const FILM_DIAGONAL: f32 = 43.266_615;
/// Largest standard deviation of a Gaussian filter, pixels: a wider one only blurs, and each sample adds to thousands
/// of pixels.
const MAX_STDDEV: f32 = 4.0;
/// Largest absolute value of Mitchell's parameters. They are useful in [0, 1]; far beyond, the weights cancel.
const MAX_MITCHELL: f32 = 10.0;
/// Largest radius of a Lanczos filter, pixels.
const MAX_LOBES: i64 = 8;
/// Focal length of a sensor that gives neither a focal length nor an angle, millimetres.
const DEFAULT_FOCAL_LENGTH: f32 = 50.0;

/// The camera and filter of a scene; `None` if it has no sensor.
pub(crate) fn read(
    doc: &Document,
    report: &Report,
    size: Option<[usize; 2]>,
    parts: &SceneParts,
) -> Option<(CameraSpec, Filter)> {
    let scene = doc.nodes(report).next()?;
    let sensors = scene.children(Class::Sensor);
    if let [_, second, ..] = sensors.as_slice() {
        second.warn("the scene has several sensors: the first is used");
    }
    let sensor = *sensors.first()?;
    let films = sensor.children(Class::Film);
    let filter = films.first().map_or(Filter::Gaussian { stddev: 0.5 }, |film| filter(*film));
    // Read the film even if its size is overridden, so that its errors are reported.
    let film_size = films.first().map_or(DEFAULT_SIZE, |film| film_size(*film));
    let size = size.unwrap_or(film_size);
    let principal_point_offset = Vec2::new(
        sensor.float("principal_point_offset_x", 0.0),
        sensor.float("principal_point_offset_y", 0.0),
    );
    sensor.children(Class::Ignored);
    sensor.children(Class::Medium);
    sensor.ignore(&["shutter_open", "shutter_close", "focus_distance", "aperture_radius"]);
    let (projection, to_world) = projection(sensor, size)?;
    note_far_clip(sensor, to_world, parts);
    let near = sensor.within("near_clip", 0.0, 0.0..=MAX_NUMBER);
    Some((CameraSpec { to_world, projection, size, near, principal_point_offset }, filter))
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

fn projection(sensor: Node<'_>, size: [usize; 2]) -> Option<(Projection, Affine3A)> {
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
    let fov_x = fov_x(sensor, size[0] as f32 / size[1] as f32)?;
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
fn fov_x(sensor: Node<'_>, aspect: f32) -> Option<f32> {
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

fn film_size(film: Node<'_>) -> [usize; 2] {
    let [w, h] = DEFAULT_SIZE.map(|d| d as i64);
    let size = [film.int_opt("width").unwrap_or(w), film.int_opt("height").unwrap_or(h)];
    for crop in ["crop_width", "crop_height", "crop_offset_x", "crop_offset_y"] {
        if film.has(crop) {
            film.report.warn(
                film.span_of(crop),
                format!("`{crop}` is ignored: the whole picture is rendered"),
            );
        }
    }
    film.ignore(&[
        "file_format",
        "pixel_format",
        "component_format",
        "gamma",
        "banner",
        "attach_log",
        "high_quality_edges",
        "filename",
        "exposure",
        "tonemap_method",
        "key",
        "burn",
        "sample_border",
        "compensate",
        "metadata",
        "variable",
        "digits",
    ]);
    film.children(Class::Filter);
    if film.text("pixel_format").is_some_and(|f| f.to_lowercase().starts_with("luminance")) {
        let message = "`pixel_format` is ignored: the picture is in colour";
        film.report.warn(film.span_of("pixel_format"), message);
    }
    if size.iter().any(|s| !(1..=MAX_SIZE).contains(s)) {
        film.error(format!("a film of {} x {}", size[0], size[1]), "expected 1 to 32768");
        return DEFAULT_SIZE;
    }
    size.map(|s| s as usize)
}

fn filter(film: Node<'_>) -> Filter {
    let filters = film.children(Class::Filter);
    let Some(filter) = filters.first() else { return Filter::Gaussian { stddev: 0.5 } };
    let third = |name| filter.within(name, 1.0 / 3.0, -MAX_MITCHELL..=MAX_MITCHELL);
    match filter.plugin() {
        "box" => Filter::Box,
        "tent" => Filter::Tent,
        "gaussian" => {
            let stddev = filter.above_zero("stddev", 0.5, MAX_STDDEV);
            Filter::Gaussian { stddev }
        }
        "mitchell" => Filter::Mitchell { b: third("b"), c: third("c") },
        "catmullrom" => Filter::CatmullRom,
        "lanczos" => {
            let lobes = filter.int_opt("lobes").unwrap_or(3);
            if !(1..=MAX_LOBES).contains(&lobes) {
                let span = filter.span_of("lobes");
                filter.report.error(span, format!("lobes {lobes}"), "expected 1 to 8");
                return Filter::Box;
            }
            Filter::Lanczos { lobes: lobes as u32 }
        }
        _ => {
            filter.unknown_plugin(&[
                "box",
                "tent",
                "gaussian",
                "mitchell",
                "catmullrom",
                "lanczos",
            ]);
            Filter::Box
        }
    }
}
