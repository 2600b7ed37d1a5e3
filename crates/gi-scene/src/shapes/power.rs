//! Area lights whose power is given instead of their radiance.

use std::f32::consts::PI;

use gi_core::geometry::Geometry;
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use crate::document::{Class, Node};

/// Scale an emission so that the shape emits the `power` of its emitter, if that is given: pbrt divides by the area, by
/// pi, by the number of sides, and by a picture's mean luminance.
pub(super) fn normalize(node: Node<'_>, geometry: &Geometry, radiance: &mut Texture) {
    let emitters = node.children(Class::Emitter);
    let Some(emitter) = emitters.first() else { return };
    let Some(power) = emitter.float_opt("power") else { return };
    let of_picture = match &*radiance {
        Texture::Constant(_) => 1.0,
        other => other.mean().luminance(),
    };
    let sides = if emitter.bool("two_sided", false) { 2.0 } else { 1.0 };
    let factor = power / (PI * sides * area(geometry) * of_picture);
    if factor.is_finite() {
        *radiance = radiance.clone().scaled(Rgb::grey(factor));
    } else {
        emitter.error(format!("the power {power} of a shape without area"), "");
    }
}

fn area(geometry: &Geometry) -> f32 {
    match geometry {
        Geometry::Mesh(mesh) => {
            let areas = (0..mesh.triangles.len()).map(|k| mesh.area_vector(k).length());
            0.5 * areas.map(f64::from).sum::<f64>() as f32
        }
        Geometry::Sphere { radius, .. } => 4.0 * PI * radius * radius,
        Geometry::Disk { du, dv, .. } => PI * du.cross(*dv).length(),
        Geometry::Cylinder { p0, p1, radius } => 2.0 * PI * radius * p0.distance(*p1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::solids;
    use glam::{DAffine3, Vec3};

    #[test]
    fn areas_are_those_of_the_formulas() {
        let near = |a: f32, b: f32| assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
        near(area(&Geometry::Mesh(solids::cube(&DAffine3::IDENTITY))), 24.0);
        let (center, du, dv) = (Vec3::ZERO, 2.0 * Vec3::X, 3.0 * Vec3::Y);
        near(area(&Geometry::Disk { center, du, dv }), 6.0 * PI);
        let (p0, p1) = (Vec3::ZERO, Vec3::new(0.0, 3.0, 4.0));
        near(area(&Geometry::Cylinder { p0, p1, radius: 2.0 }), 20.0 * PI);
    }
}
