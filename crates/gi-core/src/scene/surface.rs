//! Computes the surface point of a hit.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::Scene;
use super::primitives::Primitive;
use crate::geometry::{Geometry, Mesh, Surface, Tangents};
use crate::light::EmitterPoint;
use crate::math::{Frame, INV_PI};
use crate::ray::{Hit, Ray};

/// A point with its normals, in the space of its shape.
struct Local {
    p: Vec3,
    ng: Vec3,
    ns: Vec3,
    uv: Vec2,
}

impl Scene {
    /// The surface point that `ray` hit.
    #[inline(always)]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let primitive = &self.primitives.all[hit.prim as usize];
        let shape_id = primitive.shape;
        let shape = &self.shapes[shape_id as usize];
        let instance = self.instances.get(hit.instance as usize);
        let barycentric = Vec2::new(hit.u, hit.v);
        let mut local = match &shape.geometry {
            Geometry::Mesh(mesh) => self.on_mesh(mesh, primitive, barycentric),
            solid => {
                let p = ray.at(hit.t);
                on_solid(solid, instance.map_or(p, |i| i.to_local.transform_point3(p)), barycentric)
            }
        };
        if let Some(i) = instance {
            local.p = i.to_world.transform_point3(local.p);
            local.ng = (i.normal_to_world * local.ng).normalize();
            local.ns = (i.normal_to_world * local.ns).normalize();
        }
        let (ng, ns) =
            if shape.flip_normals { (-local.ng, -local.ns) } else { (local.ng, local.ns) };
        Surface {
            p: local.p,
            ng,
            frame: Frame::from_normal(ns),
            uv: local.uv,
            shape: shape_id,
            prim: hit.prim,
            barycentric,
            instance: hit.instance,
        }
    }

    /// The point of a triangle of `mesh` with these weights of its second and third corner.
    #[inline(always)]
    fn on_mesh(&self, mesh: &Mesh, primitive: &Primitive, b: Vec2) -> Local {
        let [v0, v1, v2] = primitive.corners.map(|i| &self.primitives.vertices[i as usize]);
        let b0 = 1.0 - b.x - b.y;
        let p = v0.p * b0 + v1.p * b.x + v2.p * b.y;
        let ng = primitive.normal;
        let uv = if mesh.uvs.is_empty() { b } else { v0.uv * b0 + v1.uv * b.x + v2.uv * b.y };
        if mesh.normals.is_empty() {
            return Local { p, ng, ns: ng, uv };
        }
        let ns = v0.normal * b0 + v1.normal * b.x + v2.normal * b.y;
        let ns = ns.try_normalize().unwrap_or(ng);
        Local { p, ng: if ng.dot(ns) < 0.0 { -ng } else { ng }, ns, uv }
    }

    /// Derivatives of the position with respect to the texture coordinates. Without texture coordinates, any two
    /// tangents.
    pub fn tangents(&self, surface: &Surface) -> Tangents {
        let shape = &self.shapes[surface.shape as usize];
        let instance = self.instances.get(surface.instance as usize);
        let local = |p: Vec3| instance.map_or(p, |i| i.to_local.transform_point3(p));
        let tangents = match &shape.geometry {
            Geometry::Mesh(mesh) => mesh_tangents(
                mesh,
                (surface.prim - self.first_primitive(surface.shape as usize)) as usize,
            ),
            Geometry::Sphere { center, radius, axes } => {
                let q = axes.to_local(local(surface.p) - *center);
                let across = (q.x * q.x + q.y * q.y).sqrt().max(1e-6 * radius);
                let (cos, sin) = (q.x / across, q.y / across);
                let dpdu = axes.to_world(Vec3::new(-q.y, q.x, 0.0) * (2.0 * PI));
                let dpdv = axes.to_world(Vec3::new(q.z * cos, q.z * sin, -across) * PI);
                Some(Tangents { dpdu, dpdv })
            }
            Geometry::Disk { du, dv, .. } => {
                // u is the radius, v the angle.
                let q = surface.barycentric;
                let unit = q.normalize_or(Vec2::X);
                let dpdu = *du * unit.x + *dv * unit.y;
                Some(Tangents { dpdu, dpdv: (*dv * q.x - *du * q.y) * (2.0 * PI) })
            }
            Geometry::Cylinder { p0, p1, .. } => {
                let axis = *p1 - *p0;
                let out = local(surface.p) - *p0;
                let out = out - axis * (out.dot(axis) / axis.length_squared());
                Some(Tangents { dpdu: axis.normalize().cross(out) * (2.0 * PI), dpdv: axis })
            }
        };
        match (tangents, instance) {
            (Some(t), None) => t,
            (Some(t), Some(i)) => Tangents {
                dpdu: i.to_world.transform_vector3(t.dpdu),
                dpdv: i.to_world.transform_vector3(t.dpdv),
            },
            (None, _) => Tangents { dpdu: surface.frame.s, dpdv: surface.frame.t },
        }
    }

    /// Texture coordinates at a point of an emitting primitive.
    pub(super) fn texture_coordinates(
        &self,
        shape: u32,
        primitive: u32,
        point: &EmitterPoint,
    ) -> Vec2 {
        match &self.shapes[shape as usize].geometry {
            Geometry::Mesh(mesh) => mesh_uv(mesh, primitive as usize, point.uv),
            solid => on_solid(solid, point.p, point.uv).uv,
        }
    }
}

fn mesh_uv(mesh: &Mesh, k: usize, b: Vec2) -> Vec2 {
    if mesh.uvs.is_empty() {
        return b;
    }
    let [i0, i1, i2] = mesh.triangles[k].map(|i| mesh.uvs[i as usize]);
    i0 * (1.0 - b.x - b.y) + i1 * b.x + i2 * b.y
}

fn mesh_tangents(mesh: &Mesh, k: usize) -> Option<Tangents> {
    let [p0, p1, p2] = mesh.corners(k);
    let (e1, e2) = (p1 - p0, p2 - p0);
    if mesh.uvs.is_empty() {
        return Some(Tangents { dpdu: e1, dpdv: e2 });
    }
    let [t0, t1, t2] = mesh.triangles[k].map(|i| mesh.uvs[i as usize]);
    let (d1, d2) = (t1 - t0, t2 - t0);
    let det = d1.perp_dot(d2);
    let t = Tangents { dpdu: (e1 * d2.y - e2 * d1.y) / det, dpdv: (e2 * d1.x - e1 * d2.x) / det };
    (t.dpdu.is_finite() && t.dpdv.is_finite()).then_some(t)
}

/// Project a point near a solid onto it.
fn on_solid(solid: &Geometry, p: Vec3, b: Vec2) -> Local {
    match solid {
        Geometry::Sphere { center, radius, axes } => {
            let n = (p - *center).normalize();
            let l = axes.to_local(n);
            let uv = Vec2::new(turn(l.y, l.x), l.z.clamp(-1.0, 1.0).acos() * INV_PI);
            Local { p: *center + n * *radius, ng: n, ns: n, uv }
        }
        Geometry::Disk { center, du, dv } => {
            let n = du.cross(*dv).normalize();
            Local {
                p: *center + *du * b.x + *dv * b.y,
                ng: n,
                ns: n,
                uv: Vec2::new(b.length(), turn(b.y, b.x)),
            }
        }
        Geometry::Cylinder { p0, p1, radius } => {
            let axis = *p1 - *p0;
            let foot = *p0 + axis * b.x;
            let out = p - foot;
            let n = (out - axis * (out.dot(axis) / axis.length_squared())).normalize();
            let frame = Frame::from_normal(axis.normalize());
            let l = frame.to_local(n);
            Local { p: foot + n * *radius, ng: n, ns: n, uv: Vec2::new(turn(l.y, l.x), b.x) }
        }
        Geometry::Mesh(_) => unreachable!("meshes have triangles"),
    }
}

/// The angle of (x, y) as a fraction of a turn in [0, 1).
fn turn(y: f32, x: f32) -> f32 {
    let phi = y.atan2(x) * 0.5 * INV_PI;
    if phi < 0.0 { phi + 1.0 } else { phi }
}
