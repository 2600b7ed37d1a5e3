//! Moves scenes that are far from the world's origin, where single precision is inaccurate.

use glam::{Vec3, Vec3A};

use super::SceneParts;
use crate::geometry::{Geometry, Shape};
use crate::light::LightSource;
use crate::math::Bounds;

/// A scene farther from the origin than this many of its radii is moved to the origin.
const FAR: f32 = 8.0;

impl SceneParts {
    /// Move a scene that is far from the world's origin to it. Returns the offset by which the camera must be moved
    /// too. The offset of ray origins grows with the coordinates: at ten kilometres it is centimetres, which changes
    /// the picture.
    pub fn recentre(&mut self) -> Vec3 {
        let bounds = self.bounds();
        if bounds.is_empty() {
            return Vec3::ZERO;
        }
        let (center, radius) = (bounds.center(), 0.5 * bounds.extent().length());
        if !center.is_finite() || center.length() <= FAR * radius {
            return Vec3::ZERO;
        }
        self.shapes.iter_mut().for_each(|s| s.geometry.shift(-center));
        self.instances.iter_mut().for_each(|i| i.to_world.translation -= Vec3A::from(center));
        for light in &mut self.lights {
            if let LightSource::Point { position, .. }
            | LightSource::Spot { position, .. }
            | LightSource::Projector { position, .. } = light
            {
                *position -= center;
            }
        }
        for varying in self.media.iter_mut().filter_map(|m| m.varying.as_mut()) {
            varying.shift(-center);
        }
        self.origin += center;
        -center
    }

    /// Bounding box of all shapes and instances.
    pub fn bounds(&self) -> Bounds {
        let around = |shapes: &[Shape]| {
            shapes.iter().map(|s| s.geometry.bounds()).fold(Bounds::EMPTY, Bounds::union)
        };
        let instances =
            self.instances.iter().map(|i| around(&self.groups[i.group]).transformed(&i.to_world));
        instances.fold(around(&self.shapes), Bounds::union)
    }
}

impl Geometry {
    /// Translate everything by `by`.
    fn shift(&mut self, by: Vec3) {
        match self {
            Geometry::Mesh(mesh) => mesh.positions.iter_mut().for_each(|p| *p += by),
            Geometry::Sphere { center, .. } | Geometry::Disk { center, .. } => *center += by,
            Geometry::Cylinder { p0, p1, .. } => {
                *p0 += by;
                *p1 += by;
            }
        }
    }
}
