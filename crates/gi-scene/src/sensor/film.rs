//! The film of a sensor: the size of the picture, the part of the film that it shows, and the filter.

use gi_core::camera::{CameraSpec, Projection};
use gi_core::filter::Filter;
use glam::{Vec2, Vec3};

use crate::document::{Class, Node};

/// Default film size.
pub(super) const DEFAULT_SIZE: [usize; 2] = [768, 576];
/// Largest width or height: a larger film would not fit into memory.
const MAX_SIZE: i64 = 1 << 15;
/// Largest standard deviation of a Gaussian filter, pixels: a wider one only blurs, and each sample adds to thousands
/// of pixels.
const MAX_STDDEV: f32 = 4.0;
/// Largest absolute value of Mitchell's parameters. They are useful in [0, 1]; far beyond, the weights cancel.
const MAX_MITCHELL: f32 = 10.0;
/// Largest radius of a Lanczos filter, pixels.
const MAX_LOBES: i64 = 8;

/// The part of a film that the picture shows, in fractions of the film's width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crop {
    offset: Vec2,
    pub(super) size: Vec2,
}

impl Crop {
    /// The whole film.
    pub(super) const WHOLE: Crop = Crop { offset: Vec2::ZERO, size: Vec2::ONE };

    /// The camera of the part, from that of the whole film: its angle of view is narrower, and its centre is elsewhere.
    pub(super) fn apply(self, whole: CameraSpec) -> CameraSpec {
        let mut part = whole;
        if self == Crop::WHOLE {
            return part;
        }
        match &mut part.projection {
            Projection::Perspective { fov_x, .. } => {
                *fov_x = 2.0 * ((0.5 * *fov_x).tan() * self.size.x).atan();
            }
            Projection::Orthographic => {
                let narrower = Vec3::new(self.size.x, self.size.x, 1.0);
                part.to_world.matrix3 *= glam::Mat3A::from_diagonal(narrower);
            }
        }
        let center = self.offset + 0.5 * self.size - 0.5;
        part.principal_point_offset = (part.principal_point_offset + center) / self.size;
        part
    }
}

/// The size of the picture, and the part of the film that it shows.
pub(super) fn size(film: Node<'_>) -> ([usize; 2], Crop) {
    let [w, h] = DEFAULT_SIZE.map(|d| d as i64);
    let size = [film.int_opt("width").unwrap_or(w), film.int_opt("height").unwrap_or(h)];
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
        return (DEFAULT_SIZE, Crop::WHOLE);
    }
    crop(film, size)
}

/// The part of a film that its `crop_*` properties choose.
fn crop(film: Node<'_>, [w, h]: [i64; 2]) -> ([usize; 2], Crop) {
    let offset = ["crop_offset_x", "crop_offset_y"].map(|name| film.int_opt(name).unwrap_or(0));
    let size = [film.int_opt("crop_width").unwrap_or(w), film.int_opt("crop_height").unwrap_or(h)];
    let fits = |k: usize, whole: i64| {
        offset[k] >= 0
            && size[k] > 0
            && size[k].checked_add(offset[k]).is_some_and(|end| end <= whole)
    };
    if !fits(0, w) || !fits(1, h) {
        let ([x, y], [cw, ch]) = (offset, size);
        let message =
            format!("a crop of {cw} x {ch} pixels from ({x}, {y}) of a film of {w} x {h}");
        film.error(message, "expected a part of the film");
        return ([w as usize, h as usize], Crop::WHOLE);
    }
    let whole = Vec2::new(w as f32, h as f32);
    let [offset, part] = [offset, size].map(|[x, y]| Vec2::new(x as f32, y as f32) / whole);
    (size.map(|s| s as usize), Crop { offset, size: part })
}

/// The filter of a film.
pub(super) fn filter(film: Node<'_>) -> Filter {
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
