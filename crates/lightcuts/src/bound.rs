//! Upper bounds of the light that a cluster of lights brings to a point [slide 61, Walter05, 3.3], or to a cluster of
//! points [Walter06, 4.2]. The smallest distance bounds the geometry term, box and cone bound the cosine at the lights,
//! [`gi_core::bsdf::Bsdf::bound`] bounds the material. The bound of visibility is 1.

use gi_core::bsdf::{Bsdf, ScatterBound, Toward};
use gi_core::geometry::Surface;
use gi_core::math::{Bounds, Frame, INV_PI, Rgb, safe_sqrt};
use gi_core::medium::Phase;
use glam::Vec3;
use vpl::Scatterer;

use crate::tree::{Family, Node, Tree};

/// What receives light: a point, or a cluster of points.
pub trait Receives {
    /// The directions from it into a box.
    fn toward(&self, bounds: &Bounds) -> Toward;

    /// Upper bound of the BSDF over these directions. Of a cluster: of the sum over its points, each multiplied by its
    /// strength.
    fn scatter(&self, toward: &Toward) -> ScatterBound;

    /// The clamp of the geometry term of lights on surfaces, per squared world unit. `None` without a clamp, and if shading normals
    /// are not the geometric ones: then f times the clamp does not bound the light.
    fn clamp(&self) -> Option<f32>;
}

/// A point of a surface or a medium that receives light, in the form that bounds need.
#[derive(Clone, Copy)]
pub struct Site<'s, 'a> {
    /// Position, world.
    pub p: Vec3,
    /// Unit direction back to the eye.
    pub wo: Vec3,
    /// What scatters there.
    pub scatterer: Scatterer<'s, 'a>,
    /// The clamp of the geometry term of lights on surfaces, per squared world unit.
    pub most: f32,
    /// Whether shading uses the geometric normal: then f times the clamp is a bound of the clamped light.
    flat: bool,
    /// f of a purely Lambertian surface and the frame of its normal, for a cheaper bound.
    lambert: Option<(Rgb, Frame)>,
}

impl<'s, 'a> Site<'s, 'a> {
    /// A point of a surface.
    pub fn new(surface: &'s Surface, wo: Vec3, bsdf: &'s Bsdf<'a>, most: f32) -> Self {
        let lambert = bsdf
            .diffuse_only(wo)
            .map(|part| (part.albedo * (INV_PI * SAFETY), Frame::from_normal(part.normal)));
        let scatterer = Scatterer::Surface(surface, bsdf);
        Site { p: surface.p, wo, scatterer, most, flat: bsdf.is_flat(), lambert }
    }

    /// A point of a medium. Lights on surfaces do not count there, so there is no clamp.
    pub fn in_medium(p: Vec3, wo: Vec3, phase: Phase) -> Self {
        let scatterer = Scatterer::Medium(phase);
        Site { p, wo, scatterer, most: f32::INFINITY, flat: false, lambert: None }
    }

    /// Whether shading uses the geometric normal.
    pub(crate) fn is_flat(&self) -> bool {
        self.flat
    }

    /// Whether it is on a purely Lambertian surface.
    pub fn is_lambertian(&self) -> bool {
        self.lambert.is_some()
    }

    /// f of a purely Lambertian surface, with a margin for rounding, and the unit normal on the side of `wo`.
    pub(crate) fn lambert(&self) -> Option<(Rgb, Vec3)> {
        self.lambert.map(|(f, frame)| (f, frame.n))
    }
}

impl Receives for Site<'_, '_> {
    #[inline(always)]
    fn toward(&self, bounds: &Bounds) -> Toward {
        Toward::new(self.p, bounds)
    }

    #[inline(always)]
    fn scatter(&self, toward: &Toward) -> ScatterBound {
        match (&self.lambert, self.scatterer) {
            (Some((f, frame)), _) => {
                ScatterBound { f: *f, f_cos: *f * toward.max_cos(frame).max(0.0) }
            }
            (None, Scatterer::Surface(_, bsdf)) => bsdf.bound(self.wo, toward),
            (None, Scatterer::Medium(phase)) => {
                let most = |n: Vec3| toward.max_cos(&Frame::from_normal(n));
                let bound = Rgb::grey(phase.bound(|| most(-self.wo), || most(self.wo)));
                ScatterBound { f: bound, f_cos: bound }
            }
        }
    }

    #[inline(always)]
    fn clamp(&self) -> Option<f32> {
        (self.flat && self.most < f32::INFINITY).then_some(self.most)
    }
}

/// The factors of the bound for the lights of a cluster.
pub struct Terms {
    /// Directions to the lights.
    pub toward: Toward,
    /// The bound of the BSDF at the point.
    pub scatter: ScatterBound,
    /// Bound of the cosine at the lights, or of the fraction that glossy lights scatter. The bound is this times
    /// `scatter.f_cos` over the squared distance.
    pub emitted: f32,
    /// The same divided by the cosine at the lights, for the clamped geometry term.
    pub emitted_over_cos: f32,
}

impl Terms {
    /// The factors for the lights of a node; `None` if none of them can bring light.
    #[inline(always)]
    pub fn new(tree: &Tree, k: u32, at: &impl Receives) -> Option<Self> {
        let node = tree.node(k);
        // Parallel light comes from a box of directions.
        let toward = match tree.family {
            Family::Directional => Toward::new(Vec3::ZERO, &node.bounds),
            _ => at.toward(&node.bounds),
        };
        let (emitted, emitted_over_cos) = match tree.family {
            Family::Omni | Family::Directional => (1.0, f32::INFINITY),
            // Light leaves opposite to the direction in which the point sees the light.
            Family::Oriented => (max_cos(&toward, -node.cone.axis, node.cone.cos), 1.0),
            Family::Glossy => {
                let gain = tree.gain(k);
                let gain_toward = gain.toward(&toward);
                let mut cos = max_cos(&toward, -node.cone.axis, node.cone.cos);
                if gain.both_sides {
                    cos = cos.max(max_cos(&toward, node.cone.axis, node.cone.cos));
                }
                (gain_toward.most.min(gain_toward.over_cos * cos), gain_toward.over_cos)
            }
        };
        if emitted <= 0.0 {
            return None;
        }
        let scatter = at.scatter(&toward);
        let some = !scatter.f_cos.is_black();
        some.then_some(Terms { toward, scatter, emitted, emitted_over_cos })
    }

    /// The bound of the light from the node, per channel.
    #[inline(always)]
    pub fn bound(&self, tree: &Tree, node: &Node, at: &impl Receives) -> Rgb {
        let falloff = match tree.family {
            Family::Directional => 1.0,
            _ => 1.0 / self.toward.min_distance_sq().max(LEAST_DISTANCE_SQ),
        };
        let mut bound = self.scatter.f_cos * (self.emitted * falloff);
        if !tree.is_direct()
            && self.emitted_over_cos < f32::INFINITY
            && let Some(most) = at.clamp()
        {
            let left = self.scatter.f * (self.emitted_over_cos * most);
            bound = bound.zip(left, f32::min);
        }
        node.power * bound * SAFETY
    }
}

/// Margin for rounding in sums of powers and in evaluations.
const SAFETY: f32 = 1.0 + 1e-4;
/// Smallest squared distance: keeps the bound finite if the point lies in the box.
const LEAST_DISTANCE_SQ: f32 = 1e-30;

/// The largest cosine, at least 0, of these directions with normals within a cone.
#[inline]
pub(crate) fn max_cos(toward: &Toward, axis: Vec3, cone_cos: f32) -> f32 {
    let cos = toward.max_cos(&Frame::from_normal(axis));
    if cone_cos == 1.0 {
        return cos.max(0.0);
    }
    if cos >= cone_cos {
        return 1.0;
    }
    let sines = safe_sqrt((1.0 - cos * cos) * (1.0 - cone_cos * cone_cos));
    (cos * cone_cos + sines + COS_ROUNDING).max(0.0)
}

/// Rounding of the cosine of a difference of angles.
const COS_ROUNDING: f32 = 1e-6;

/// Upper bound of a node's error, as luminance. The truth lies between 0 and the bound, so the error is at most
/// the larger of the estimate and the bound minus the estimate. (The paper uses the bound itself, which is up to twice as
/// large.)
#[inline]
pub fn error(estimate: Rgb, bound: Rgb) -> f32 {
    let (estimate, bound) = (estimate.luminance(), bound.luminance());
    // Zero times infinity gives no information.
    let bound = if bound.is_nan() { f32::MAX } else { bound };
    estimate.max(bound - estimate)
}

#[cfg(test)]
mod tests;
