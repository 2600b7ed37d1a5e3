//! Emitter plugins that are not surfaces.

use gi_core::light::LightSource;
use gi_core::math::Rgb;
use gi_core::texture::Bitmap;
use glam::Vec3;

use crate::builder::Builder;
use crate::document::{Meaning, Node};
use crate::origins::LightOrigin;
use crate::rotation::rotation;
use crate::textures::{note_gamma, warn_negative};
use crate::{equal_area, sky, texels};

mod pictures;
mod spots;

use spots::collimated;

/// Plugins that are supported at the top level.
const KNOWN: [&str; 10] = [
    "point",
    "spot",
    "directional",
    "constant",
    "envmap",
    "sun",
    "sky",
    "sunsky",
    "projector",
    "collimated",
];

impl Builder<'_> {
    /// Add the light that an emitter describes.
    pub(crate) fn light(&mut self, node: Node<'_>) {
        node.ignore(&["sampling_weight"]);
        let light = match node.plugin() {
            "point" => Some(point(node)),
            "spot" => self.spot(node),
            "projector" => self.projector(node),
            "collimated" => collimated(node),
            "goniometric" if node.doc.is_pbrt => self.goniometric(node),
            "projection" if node.doc.is_pbrt => self.projection(node),
            "directional" => directional(node),
            "constant" => Some(LightSource::Constant { radiance: light_color(node, "radiance") }),
            "envmap" => return self.environment(node),
            "sun" | "sky" | "sunsky" => return sky::add(self, node),
            "area" => {
                // A shape may refer to an area light at the top level.
                if !self.used_emitters.contains(&node.id) {
                    node.warn("an area light that belongs to no shape: ignored");
                }
                None
            }
            _ => {
                node.unknown_plugin(&KNOWN);
                None
            }
        };
        if let Some(light) = light {
            self.push_light(light, LightOrigin::Itself);
        }
    }

    fn environment(&mut self, node: Node<'_>) {
        node.ignore(&["filename", "cache", "mis_compensation"]);
        note_gamma(node);
        let to_world = rotation(node);
        warn_scaled(node);
        let scale = node.light_scale("scale", 1.0);
        let (Some(image), Some(file)) =
            (self.assets.bitmap(node.id), self.assets.bitmap_file(node.id))
        else {
            return;
        };
        let mut is_square = node.doc.is_pbrt && node.bool("equal_area", false);
        if is_square && image.width() == 2 * image.height() {
            node.warn(format!(
                "`{}` is twice as wide as high: it is read as latitude and longitude, not as a square of equal area",
                file.path.display()
            ));
            is_square = false;
        }
        let tint = match node.doc.is_pbrt {
            true => node.color("tint", Meaning::Light).filter(|tint| *tint != Rgb::WHITE),
            false => None,
        };
        let origin = match is_square || tint.is_some() {
            true => LightOrigin::Itself,
            false => LightOrigin::Picture(file.path.clone()),
        };
        let (image, negative) = self.origins.as_light(&image, file, node.report);
        if let Some(at) = negative {
            warn_negative(node, file, at);
        }
        // The light has a copy of its own.
        let claim = node.report.budget.claim(file.path.display());
        let bytes = match (is_square, tint) {
            (true, _) => equal_area::bytes(&image),
            (false, Some(_)) => (image.width() * image.height() * size_of::<Rgb>()) as u64,
            (false, None) => image.bytes(),
        };
        if let Err(why) = claim.keep(bytes) {
            return node.error(format!("cannot copy `{}`: {why}", file.path.display()), "");
        }
        let brightest = texels::brightest(&image, &file.path);
        if !node.check_light("scale", Rgb::grey(scale * brightest)) {
            return;
        }
        let image = match (is_square, tint) {
            (true, _) => equal_area::resampled(&image),
            (false, Some(tint)) => image.map(|texel| texel * tint),
            (false, None) => Bitmap::clone(&image),
        };
        self.push_light(LightSource::Environment { image, scale, to_world }, origin);
    }
}

/// Warn of a scale in a light's `to_world`, which Mitsuba 3.9.1 multiplies the light by, or stretches its picture with.
fn warn_scaled(node: Node<'_>) {
    let m = node.transform("to_world").matrix3;
    let is_unit = |axis: Vec3| (axis.length() - 1.0).abs() < 1e-3;
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(Vec3::from);
    if !node.doc.is_pbrt && !axes.into_iter().all(is_unit) {
        node.warn("the scale in the light's `to_world` is ignored");
    }
}

/// A light's colour; grey with value 1 if not given.
fn light_color(node: Node<'_>, name: &'static str) -> Rgb {
    node.light(name).unwrap_or(Rgb::WHITE)
}

/// A position, from `position` or `to_world`.
fn place(node: Node<'_>) -> Vec3 {
    let m = node.to_world();
    node.point("position").map_or(m.translation, |p| m.transform_point3(p)).as_vec3()
}

fn point(node: Node<'_>) -> LightSource {
    LightSource::Point { position: place(node), intensity: light_color(node, "intensity") }
}

/// A unit direction: the local +z axis, or `name` if given.
fn direction(node: Node<'_>, name: &'static str) -> Option<Vec3> {
    let axis = node.vector(name).unwrap_or(Vec3::Z);
    let (unit, length) = crate::transform::unit(node.transform("to_world").transform_vector3(axis));
    if !(length > 0.0 && length.is_finite()) {
        node.error("the direction is zero", "");
        return None;
    }
    Some(unit)
}

fn directional(node: Node<'_>) -> Option<LightSource> {
    let irradiance = light_color(node, "irradiance");
    warn_scaled(node);
    Some(LightSource::Directional { direction: direction(node, "direction")?, irradiance })
}
