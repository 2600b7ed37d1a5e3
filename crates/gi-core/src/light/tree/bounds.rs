//! Bounds of a light or a cluster of lights: where it is, where it emits to, and how much.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use crate::geometry::Shape;
use crate::light::{Emitter, Light};
use crate::math::{Bounds, Cone, Rgb, sqr};

/// Bounds of a cluster of lights [Conty18, 4.1].
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// The box around the lights.
    pub(super) bounds: Bounds,
    /// The cone around their normals and axes.
    pub(super) cone: Cone,
    /// Light leaves within this angle of a direction in the cone, radians.
    pub(super) spread: f32,
    /// Sum of their intensities along their normals or axes, as luminance.
    pub(super) intensity: f32,
}

impl LightBounds {
    /// Bounds of no lights.
    pub(super) const EMPTY: LightBounds = LightBounds {
        bounds: Bounds::EMPTY,
        cone: Cone { axis: Vec3::Z, angle: 0.0 },
        spread: 0.0,
        intensity: 0.0,
    };

    /// A point that emits to all directions.
    fn everywhere(position: Vec3, intensity: f32) -> Self {
        let bounds = Bounds::EMPTY.with(position);
        let cone = Cone { axis: Vec3::Z, angle: PI };
        LightBounds { bounds, cone, spread: FRAC_PI_2, intensity }
    }

    /// Bounds of one light; `None` if it is at infinity or emits nothing.
    pub(super) fn of(light: &Light, shapes: &[Shape]) -> Option<Self> {
        let bounds = match light {
            Light::Area { emitter, shape, .. } => {
                let emission = shapes[*shape as usize].emission.as_ref();
                let radiance = emission.map_or(Rgb::BLACK, |e| e.mean()).luminance();
                let (bounds, cone) = extent(emitter);
                let intensity = radiance * emitter.area();
                LightBounds { bounds, cone, spread: FRAC_PI_2, intensity }
            }
            Light::Point { position, intensity } => {
                LightBounds::everywhere(*position, intensity.luminance())
            }
            // The measure of a cone's directions holds for a spread of up to a right angle.
            Light::Spot { position, cutoff, .. } if *cutoff > FRAC_PI_2 => {
                LightBounds::everywhere(*position, light.mean_intensity())
            }
            Light::Spot { position, frame, cutoff, .. } => LightBounds {
                bounds: Bounds::EMPTY.with(*position),
                cone: Cone::new(frame.n),
                spread: *cutoff,
                intensity: light.mean_intensity(),
            },
            _ => return None,
        };
        (bounds.intensity > 0.0).then_some(bounds)
    }

    /// Bounds of both clusters.
    #[inline]
    pub(super) fn union(&self, other: &Self) -> Self {
        if self.intensity == 0.0 {
            return *other;
        }
        if other.intensity == 0.0 {
            return *self;
        }
        LightBounds {
            bounds: self.bounds.union(other.bounds),
            cone: self.cone.union(&other.cone),
            spread: self.spread.max(other.spread),
            intensity: self.intensity + other.intensity,
        }
    }

    /// The cost of a cluster: intensity times the size of its box times the measure of the directions that it emits to
    /// [Conty18, 4.2]. The size is the squared diagonal instead of the surface area, because importance depends on the
    /// sphere around the box.
    pub(super) fn cost(&self) -> f32 {
        if self.intensity == 0.0 {
            return 0.0;
        }
        self.intensity
            * self.bounds.extent().length_squared()
            * measure(self.cone.angle, self.spread)
    }
}

/// The solid angle within `angle` of an axis, and beyond it the solid angle up to `angle + spread` weighted by a cosine that
/// falls from the rim [Conty18, eq. 1].
fn measure(angle: f32, spread: f32) -> f32 {
    let (sin, cos) = angle.sin_cos();
    let most = (angle + spread).min(PI);
    2.0 * PI * (1.0 - cos)
        + FRAC_PI_2 * (2.0 * most * sin - (angle - 2.0 * most).cos() - 2.0 * angle * sin + cos)
}

/// The box around an emitter, and the cone around its normals.
fn extent(emitter: &Emitter) -> (Bounds, Cone) {
    let all = Cone { axis: Vec3::Z, angle: PI };
    let around = |center: Vec3, half: Vec3| Bounds { min: center - half, max: center + half };
    match *emitter {
        Emitter::Triangle { v, normal, .. } => (Bounds::of(v), Cone::new(normal)),
        Emitter::Sphere { center, radius, .. } => (around(center, Vec3::splat(radius)), all),
        Emitter::Disk { center, axes: [du, dv], normal } => {
            let half = (du * du + dv * dv).map(f32::sqrt);
            (around(center, half), Cone::new(normal))
        }
        Emitter::Cylinder { ends: [p0, p1], radius, .. } => {
            let axis = (p1 - p0).normalize_or_zero();
            let half = axis.map(|a| radius * (1.0 - sqr(a)).max(0.0).sqrt());
            (around(p0, half).union(around(p1, half)), all)
        }
    }
}
