//! Turns a material into its lobes at a point.

use glam::Vec3;

use super::bend::Bend;
use super::prepared::PreparedMaterial;
use super::{Bsdf, Component, Lobe, MAX_COMPONENTS, Parts, Transport, Way};
use crate::geometry::{Surface, Tangents};
use crate::material::{BentNormals, Material};
use crate::math::Frame;
use crate::texture::Texture;

/// The data that are needed to resolve a material.
struct Context<'a, 's> {
    materials: &'a [PreparedMaterial],
    surface: &'s Surface,
    tangents: &'s dyn Fn() -> Tangents,
    wo: Vec3,
    /// `wo` on paths from the eye; `None` on light paths.
    eye: Option<Vec3>,
}

impl<'a> Bsdf<'a> {
    /// The BSDF of material `id` at `surface`, seen from `wo`. `tangents` computes the derivatives of the surface; it
    /// is called only if a material needs them.
    #[inline]
    pub(crate) fn resolve(
        materials: &'a [PreparedMaterial],
        id: usize,
        surface: &Surface,
        tangents: &dyn Fn() -> Tangents,
        wo: Vec3,
        transport: Transport,
    ) -> Self {
        // The usual case first: one lobe, perhaps on both sides.
        let (mut id, mut frame) = (id, surface.frame);
        if let Material::TwoSided { front, back } = materials[id].material {
            (id, frame) = side(front, back, frame, wo);
        }
        let eye = (transport == Transport::Radiance).then_some(wo);
        let context = Context { materials, surface, tangents, wo, eye };
        let way = Way { transport, ng: surface.ng };
        if let Some(lobe) = materials[id].lobe_at(surface.uv) {
            let frame = context.oriented(&materials[id], frame);
            let material = id as u32;
            let parts = Parts::One(Component {
                lobe,
                frame,
                weight: 1.0,
                material,
                bend: None,
                part: None,
            });
            return Bsdf { parts, way };
        }
        let mut collected = Collected { components: [Component::EMPTY; MAX_COMPONENTS], count: 0 };
        context.collect(id, Place { frame, weight: 1.0, bend: None }, &mut collected);
        let Collected { components, count } = collected;
        let parts = match count {
            0 => Parts::One(Component::EMPTY),
            1 => Parts::One(components[0]),
            _ => Parts::Blend {
                components: components[..count].into(),
                total: components[..count].iter().map(|c| c.weight).sum(),
            },
        };
        Bsdf { parts, way }
    }
}

/// The position of a lobe in the tree of a material.
#[derive(Clone, Copy)]
struct Place {
    frame: Frame,
    /// Its weight.
    weight: f32,
    bend: Option<Bend>,
}

struct Collected<'a> {
    components: [Component<'a>; MAX_COMPONENTS],
    count: usize,
}

impl<'a> Context<'a, '_> {
    /// Walk the tree of a material and collect its lobes.
    fn collect(&self, id: usize, at: Place, out: &mut Collected<'a>) {
        if at.weight <= 0.0 {
            return;
        }
        let prepared = &self.materials[id];
        let uv = self.surface.uv;
        let share = |share: f32| Place { weight: at.weight * share, ..at };
        match &prepared.material {
            Material::TwoSided { front, back } => {
                let (inner, frame) = side(*front, *back, at.frame, self.wo);
                let turned = frame.n != at.frame.n;
                let bend = at.bend.map(|b| if turned { b.turned() } else { b });
                self.collect(inner, Place { frame, bend, ..at }, out);
            }
            Material::Mask { opacity, inner } => {
                let opacity = opacity.scalar(uv).clamp(0.0, 1.0);
                self.collect(*inner, share(opacity), out);
                out.push(Lobe::Null, share(1.0 - opacity), id);
            }
            Material::Blend { weight, first, second } => {
                let weight = weight.scalar(uv).clamp(0.0, 1.0);
                self.collect(*first, share(1.0 - weight), out);
                self.collect(*second, share(weight), out);
            }
            Material::Bump { height, inner, normals } => {
                self.collect(*inner, self.bent(at, self.bumped(at.frame, height), *normals), out);
            }
            Material::NormalMap { map, inner, normals } => {
                self.collect(*inner, self.bent(at, self.mapped(at.frame, map), *normals), out);
            }
            _ => {
                if let Some(lobe) = prepared.lobe_at(uv) {
                    let frame = self.oriented(prepared, at.frame);
                    out.push(lobe, Place { frame, ..at }, id);
                }
            }
        }
    }

    /// The same position with a bent frame, which is flipped toward the eye if it faces away from it.
    fn bent(&self, at: Place, frame: Frame, how: BentNormals) -> Place {
        let bend = Bend::new(at.frame.n, frame.n, how);
        let frame = self.eye.map_or(frame, |eye| bend.seen_from(frame, eye));
        Place { frame, bend: Some(bend), ..at }
    }

    /// Align the frame with the texture coordinates for an anisotropic lobe, and flip that of a sheet to the side of
    /// `wo`.
    #[inline]
    fn oriented(&self, prepared: &PreparedMaterial, frame: Frame) -> Frame {
        let frame = match prepared.material {
            // Both sides of a sheet are the same.
            Material::PrincipledThin(_) if self.wo.dot(frame.n) < 0.0 => opposite(frame),
            _ => frame,
        };
        if prepared.needs_tangents {
            Frame::from_normal_tangent(frame.n, (self.tangents)().dpdu)
        } else {
            frame
        }
    }

    /// The normal from a normal map.
    fn mapped(&self, frame: Frame, map: &Texture) -> Frame {
        let (c, along) = (map.eval(self.surface.uv), (self.tangents)().dpdu);
        let local = Vec3::new(c.r, c.g, c.b) * 2.0 - 1.0;
        let n = Frame::from_normal_tangent(frame.n, along).to_world(local);
        Frame::from_normal_tangent(n.try_normalize().unwrap_or(frame.n), along)
    }

    /// Bend the normal by the slope of a height field \[Blinn78\].
    fn bumped(&self, frame: Frame, height: &Texture) -> Frame {
        let Tangents { dpdu, dpdv } = (self.tangents)();
        let slope = height.scalar_gradient(self.surface.uv);
        let raised = |dp: Vec3, slope: f32| dp + frame.n * (slope - frame.n.dot(dp));
        let (u, v) = (raised(dpdu, slope.x), raised(dpdv, slope.y));
        let Some(n) = u.cross(v).try_normalize() else { return frame };
        let n = if n.dot(frame.n) < 0.0 { -n } else { n };
        Frame::from_normal_tangent(n, u)
    }
}

impl<'a> Collected<'a> {
    fn push(&mut self, lobe: Lobe<'a>, Place { frame, weight, bend }: Place, material: usize) {
        if weight > 0.0 && self.count < MAX_COMPONENTS {
            let material = material as u32;
            self.components[self.count] =
                Component { lobe, frame, weight, material, bend, part: None };
            self.count += 1;
        }
    }
}

/// The material on the side of `wo` of a two-sided material, and the frame with its normal on that side.
#[inline]
fn side(front: usize, back: usize, frame: Frame, wo: Vec3) -> (usize, Frame) {
    if wo.dot(frame.n) >= 0.0 { (front, frame) } else { (back, opposite(frame)) }
}

/// The frame of the other side.
#[inline]
fn opposite(frame: Frame) -> Frame {
    Frame { s: frame.s, t: -frame.t, n: -frame.n }
}
