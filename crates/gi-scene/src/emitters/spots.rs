//! Lights that shine from a point into a cone: `spot`, `projector`, `collimated`.

use std::f32::consts::PI;

use gi_core::light::{LightSource, Window};
use gi_core::math::Rgb;
use gi_core::texture::Texture;
use glam::{Vec2, Vec3};

use super::{direction, light_color, warn_scaled};
use crate::builder::Builder;
use crate::document::{Class, Node};

impl Builder<'_> {
    /// A spot light, with or without a picture to project.
    pub(super) fn spot(&mut self, node: Node<'_>) -> Option<LightSource> {
        let plain = plain_spot(node)?;
        let LightSource::Spot { position, direction, mut intensity, cutoff, beam } = plain else {
            return Some(plain);
        };
        let Some(texture) = node.child_if("texture", |n| n.class() == Class::Texture) else {
            return Some(plain);
        };
        let picture = self.texture_object(texture, 0)?;
        warn_scaled(node);
        let (picture, most) = self.at_most_one(texture, picture)?;
        intensity *= most;
        let m = node.transform("to_world");
        let axes = [m.matrix3.x_axis.into(), m.matrix3.y_axis.into(), direction];
        Some(LightSource::Projector {
            position,
            axes,
            intensity,
            cutoff,
            beam,
            picture,
            window: Window::Cone,
        })
    }

    /// A picture of light, divided so that it is at most one, and the divisor. `None` if an error was reported.
    pub(super) fn at_most_one(&self, node: Node<'_>, picture: Texture) -> Option<(Texture, f32)> {
        let [least, most] = self.origins.range(&picture);
        if least < 0.0 {
            node.error(format!("the light's picture is {least} somewhere"), "expected 0 or more");
            return None;
        }
        let most = most.max(1.0);
        Some((picture.scaled(Rgb::grey(1.0 / most)), most))
    }

    /// A projector: a pinhole camera that shines.
    pub(super) fn projector(&mut self, node: Node<'_>) -> Option<LightSource> {
        let picture = self.light_texture(node, "irradiance");
        warn_scaled(node);
        let (picture, most) = self.at_most_one(node, picture)?;
        let aspect = match &picture {
            Texture::Bitmap { bitmap, .. } => bitmap.width() as f32 / bitmap.height() as f32,
            _ => 1.0,
        };
        let half_x = (0.5 * crate::sensor::fov_x(node, aspect)?).tan();
        let half = Vec2::new(half_x, half_x / aspect);
        let m = node.transform("to_world");
        let axes = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(Vec3::from);
        let cutoff = half.length().atan();
        // Mitsuba's scale is pi times the irradiance at distance one.
        let at_corners = PI * most * (1.0 + half.length_squared()).powf(1.5);
        Some(LightSource::Projector {
            position: node.to_world().translation.as_vec3(),
            axes,
            intensity: Rgb::grey(node.light_scale("scale", 1.0) * at_corners),
            cutoff,
            beam: cutoff,
            picture,
            window: Window::Irradiance(half),
        })
    }
}

/// Half angle of the cone that replaces a collimated beam, radians.
const BEAM: f32 = 1e-3;

/// A beam without width: paths from the eye never meet it. A narrow spot of the same power replaces it.
pub(super) fn collimated(node: Node<'_>) -> Option<LightSource> {
    node.warn("`collimated` is approximated by a spot of 0.11 degrees with the same power");
    let solid_angle = 2.0 * PI * 2.0 * (0.5 * BEAM).sin().powi(2);
    Some(LightSource::Spot {
        position: node.to_world().translation.as_vec3(),
        direction: direction(node, "direction")?,
        intensity: light_color(node, "power") / solid_angle,
        cutoff: BEAM,
        beam: BEAM,
    })
}

fn plain_spot(node: Node<'_>) -> Option<LightSource> {
    let cutoff = node.float("cutoff_angle", 20.0);
    let beam = node.float("beam_width", 0.75 * cutoff);
    if !(0.0 < cutoff && cutoff <= 180.0 && 0.0 <= beam && beam <= cutoff) {
        node.error(format!("cutoff {cutoff}, beam {beam}"), "expected 0 <= beam <= cutoff <= 180");
        return None;
    }
    Some(LightSource::Spot {
        position: node.to_world().translation.as_vec3(),
        direction: direction(node, "direction")?,
        intensity: light_color(node, "intensity"),
        cutoff: cutoff.to_radians(),
        beam: beam.to_radians(),
    })
}
