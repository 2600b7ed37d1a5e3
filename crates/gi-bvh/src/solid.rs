//! Primitives that are not triangles: spheres, disks, open cylinders, and instances of other trees.

use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec3};

use super::{BuildError, Bvh};
use crate::bounds::Bounds;
use crate::ray::{Hit, Ray};

/// A primitive that is not a triangle.
#[derive(Clone, Debug)]
pub enum Solid {
    /// A sphere, hit from outside and inside; u = v = 0.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius.
        radius: f32,
    },
    /// All points center + a du + b dv with a^2 + b^2 <= 1: an ellipse; (u, v) = (a, b).
    Disk {
        /// Its centre.
        center: Vec3,
        /// One conjugate half-axis.
        du: Vec3,
        /// The other, any vector independent of `du`.
        dv: Vec3,
    },
    /// A round cylinder without caps, hit from both sides; u = the height in \[0, 1\] from `p0` to `p1`, v = 0.
    Cylinder {
        /// Centre of the foot.
        p0: Vec3,
        /// Centre of the top.
        p1: Vec3,
        /// Its radius.
        radius: f32,
    },
    /// Another tree with an affine transform (any scale, also mirrored). A hit contains `index` and the inner tree's
    /// primitive.
    Instance {
        /// The instanced tree; it must not contain instances.
        tree: Arc<Bvh>,
        /// Its transform.
        to_world: Affine3A,
        /// Value of [`Hit::instance`].
        index: u32,
    },
}

/// A solid prepared for ray tests.
pub(super) struct PlacedSolid {
    shape: Shape,
    id: u32,
}

enum Shape {
    Sphere {
        center: Vec3,
        radius: f32,
    },
    /// `to_a` and `to_b` are dual to the half-axes: to_a.du = 1, to_a.dv = 0.
    Disk {
        center: Vec3,
        normal: Vec3,
        to_a: Vec3,
        to_b: Vec3,
    },
    Cylinder {
        foot: Vec3,
        axis: Vec3,
        height: f32,
        radius: f32,
    },
    Instance {
        tree: Arc<Bvh>,
        to_local: Affine3A,
        index: u32,
    },
}

impl PlacedSolid {
    /// Prepare a solid and compute its box; `None` if no ray could hit it.
    pub(super) fn new(solid: &Solid, id: u32) -> Result<Option<(Self, Bounds)>, BuildError> {
        let placed = match *solid {
            Solid::Sphere { center, radius } => sphere(center, radius),
            Solid::Disk { center, du, dv } => disk(center, du, dv),
            Solid::Cylinder { p0, p1, radius } => cylinder(p0, p1, radius),
            Solid::Instance { ref tree, to_world, index } => instance(tree, to_world, index, id)?,
        };
        Ok(placed.map(|(shape, bounds)| (PlacedSolid { shape, id }, bounds)))
    }

    /// The nearest hit in the ray's interval.
    pub(super) fn closest(&self, ray: &Ray) -> Option<Hit> {
        let met = |(t, u, v)| Hit { t, u, v, prim: self.id, instance: Hit::NO_INSTANCE };
        match self.shape {
            Shape::Sphere { center, radius } => meet_sphere(ray, center, radius).map(met),
            Shape::Disk { center, normal, to_a, to_b } => {
                meet_disk(ray, center, normal, to_a, to_b).map(met)
            }
            Shape::Cylinder { foot, axis, height, radius } => {
                meet_cylinder(ray, foot, axis, height, radius).map(met)
            }
            Shape::Instance { ref tree, to_local, index } => {
                tree.closest(&localised(ray, &to_local)).map(|hit| Hit { instance: index, ..hit })
            }
        }
    }

    /// A primitive that is hit in the ray's interval.
    pub(super) fn any(&self, ray: &Ray) -> Option<u32> {
        match self.shape {
            Shape::Instance { ref tree, to_local, .. } => tree.any(&localised(ray, &to_local)),
            _ => self.closest(ray).map(|hit| hit.prim),
        }
    }

    /// The tree of an instance, the ray in its coordinates, and its index; `None` for other solids.
    pub(super) fn inner(&self, ray: &Ray) -> Option<(&Bvh, Ray, u32)> {
        match &self.shape {
            Shape::Instance { tree, to_local, index } => {
                Some((tree, localised(ray, to_local), *index))
            }
            _ => None,
        }
    }

    pub(super) fn is_instance(&self) -> bool {
        matches!(self.shape, Shape::Instance { .. })
    }
}

/// The ray in local coordinates. Its direction is not normalised, so that t is the same in both spaces.
fn localised(ray: &Ray, to_local: &Affine3A) -> Ray {
    Ray { o: to_local.transform_point3(ray.o), d: to_local.transform_vector3(ray.d), ..*ray }
}

type Placement = Option<(Shape, Bounds)>;

fn sphere(center: Vec3, radius: f32) -> Placement {
    let radius = radius.abs();
    let r = Vec3::splat(radius);
    let bounds = Bounds { min: center - r, max: center + r };
    (radius != 0.0).then_some((Shape::Sphere { center, radius }, bounds))
}

fn disk(center: Vec3, du: Vec3, dv: Vec3) -> Placement {
    let normal = du.cross(dv);
    let n2 = normal.length_squared();
    let to_a = dv.cross(normal) / n2;
    let to_b = normal.cross(du) / n2;
    // The half-width of an ellipse along an axis is the length of the half-axes' components on that axis.
    let reach = Vec3::from_array(std::array::from_fn(|k| du[k].hypot(dv[k])));
    let bounds = Bounds { min: center - reach, max: center + reach };
    (n2 != 0.0).then_some((Shape::Disk { center, normal, to_a, to_b }, bounds))
}

fn cylinder(p0: Vec3, p1: Vec3, radius: f32) -> Placement {
    let (radius, height) = (radius.abs(), (p1 - p0).length());
    let axis = (p1 - p0) / height;
    let reach = Vec3::from_array(std::array::from_fn(|k| {
        radius * (1.0 - axis[k] * axis[k]).max(0.0).sqrt()
    }));
    let bounds = Bounds { min: p0.min(p1) - reach, max: p0.max(p1) + reach };
    let holds_points = radius != 0.0 && height != 0.0;
    holds_points.then_some((Shape::Cylinder { foot: p0, axis, height, radius }, bounds))
}

fn instance(
    tree: &Arc<Bvh>,
    to_world: Affine3A,
    index: u32,
    id: u32,
) -> Result<Placement, BuildError> {
    if tree.tree.solids.iter().any(PlacedSolid::is_instance) {
        return Err(BuildError::NestedInstance { id });
    }
    let to_local = to_world.inverse();
    if to_world.is_finite() && !to_local.is_finite() {
        return Err(BuildError::Singular { id });
    }
    let inner = tree.bounds();
    if inner.is_empty() {
        return Ok(None);
    }
    // Include the rounding error of a local ray, which is relative to the local coordinates.
    let linear = to_world.matrix3;
    let lengths = Mat3A::from_cols(linear.x_axis.abs(), linear.y_axis.abs(), linear.z_axis.abs());
    let local = Vec3::splat(inner.min.abs().max(inner.max.abs()).max_element());
    let slack = (lengths * local + Vec3::from(to_world.translation.abs())) * super::PAD;
    let outer = inner.transformed(&to_world);
    let bounds = Bounds { min: outer.min - slack, max: outer.max + slack };
    Ok(Some((Shape::Instance { tree: Arc::clone(tree), to_local, index }, bounds)))
}

/// The first of two parameters that is in the ray's interval and passes a test.
fn first_of(
    ray: &Ray,
    ts: [f32; 2],
    mut accept: impl FnMut(f32) -> Option<(f32, f32, f32)>,
) -> Option<(f32, f32, f32)> {
    let near = if ts[0] <= ts[1] { ts } else { [ts[1], ts[0]] };
    near.into_iter().filter(|&t| t > ray.tmin && t <= ray.tmax).find_map(&mut accept)
}

/// Solve a t^2 - 2 b t + c = 0 without cancellation, given the discriminant b^2 - a c.
fn roots(a: f32, b: f32, c: f32, discriminant: f32) -> Option<[f32; 2]> {
    if !(discriminant >= 0.0 && a > 0.0) {
        return None;
    }
    let q = b + discriminant.sqrt().copysign(b);
    Some([c / q, q / a])
}

/// The discriminant is computed from the point of the line nearest to the centre \[Haines19\], which keeps precision
/// for distant origins.
fn meet_sphere(ray: &Ray, center: Vec3, radius: f32) -> Option<(f32, f32, f32)> {
    let f = ray.o - center;
    let a = ray.d.length_squared();
    let b = -f.dot(ray.d);
    let nearest = f + ray.d * (b / a);
    let discriminant = a * (radius * radius - nearest.length_squared());
    let c = (f.length() - radius) * (f.length() + radius);
    first_of(ray, roots(a, b, c, discriminant)?, |t| Some((t, 0.0, 0.0)))
}

fn meet_disk(
    ray: &Ray,
    center: Vec3,
    normal: Vec3,
    to_a: Vec3,
    to_b: Vec3,
) -> Option<(f32, f32, f32)> {
    let t = (center - ray.o).dot(normal) / ray.d.dot(normal);
    let p = ray.o - center + ray.d * t;
    let (a, b) = (p.dot(to_a), p.dot(to_b));
    let inside = t > ray.tmin && t <= ray.tmax && a * a + b * b <= 1.0;
    inside.then_some((t, a, b))
}

fn meet_cylinder(
    ray: &Ray,
    foot: Vec3,
    axis: Vec3,
    height: f32,
    radius: f32,
) -> Option<(f32, f32, f32)> {
    // Work in the plane perpendicular to the axis, where the cylinder is a circle.
    let f = ray.o - foot;
    let across = |x: Vec3| x - axis * x.dot(axis);
    let (fp, dp) = (across(f), across(ray.d));
    let a = dp.length_squared();
    let b = -fp.dot(dp);
    let nearest = fp + dp * (b / a);
    let discriminant = a * (radius * radius - nearest.length_squared());
    let c = (fp.length() - radius) * (fp.length() + radius);
    first_of(ray, roots(a, b, c, discriminant)?, |t| {
        let u = (f + ray.d * t).dot(axis) / height;
        (0.0..=1.0).contains(&u).then_some((t, u, 0.0))
    })
}
