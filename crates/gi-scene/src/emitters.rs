//! Emitter plugins that are not surfaces.

use gi_core::light::LightSource;
use gi_core::math::Rgb;
use gi_core::texture::Bitmap;
use glam::Vec3;

use crate::builder::Builder;
use crate::document::Node;
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
        let scale = node.light_scale("scale", 1.0);
        let (Some(image), Some(file)) =
            (self.assets.bitmap(node.id), self.assets.bitmap_file(node.id))
        else {
            return;
        };
        let is_square = node.doc.is_pbrt && node.bool("equal_area", false);
        let origin = match is_square {
            true => LightOrigin::Itself,
            false => LightOrigin::Picture(file.path.clone()),
        };
        let (image, negative) = self.origins.as_light(&image, file, node.report);
        if let Some(at) = negative {
            warn_negative(node, file, at);
        }
        // The light has a copy of its own.
        let claim = node.report.budget.claim(file.path.display());
        let bytes = if is_square { equal_area::bytes(&image) } else { image.bytes() };
        if let Err(why) = claim.keep(bytes) {
            return node.error(format!("cannot copy `{}`: {why}", file.path.display()), "");
        }
        let brightest = texels::brightest(&image, &file.path);
        if !node.check_light("scale", Rgb::grey(scale * brightest)) {
            return;
        }
        let image = match is_square {
            true => equal_area::resampled(&image),
            false => Bitmap::clone(&image),
        };
        self.push_light(LightSource::Environment { image, scale, to_world }, origin);
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
    Some(LightSource::Directional { direction: direction(node, "direction")?, irradiance })
}
