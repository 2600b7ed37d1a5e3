//! A lobe at a point: its frame, its bent normal, and its weight in a blend.

use glam::Vec3;

use super::bend::Bend;
use super::lobe::Lobe;
use super::{Scatter, Transport};
use crate::math::{Frame, Rgb};

/// A lobe in its own frame, with its weight in a blend.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component<'a> {
    pub(super) lobe: Lobe<'a>,
    pub(super) frame: Frame,
    pub(super) weight: f32,
    /// Index of its material in the scene.
    pub(super) material: u32,
    /// Set if a map bends its normal. On paths from the eye, `frame` is already the frame that the eye sees.
    pub(super) bend: Option<Bend>,
    /// Set if only a part of the lobe counts. Sampling is unchanged.
    pub(super) part: Option<Part>,
}

/// Factors on a lobe. Delta lobes ignore them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Factor on its diffuse part, see [`Lobe::diffuse_f`].
    pub(super) diffuse: Rgb,
    /// Factor on the rest of the lobe.
    pub(super) rest: Rgb,
}

impl Part {
    const ALL: Part = Part { diffuse: Rgb::WHITE, rest: Rgb::WHITE };
}

/// The direction of a path, and the unit geometric normal at the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) transport: Transport,
    pub(super) ng: Vec3,
}

impl Component<'static> {
    /// A component that scatters nothing.
    pub(super) const EMPTY: Self = Component {
        lobe: Lobe::Diffuse { albedo: Rgb::BLACK },
        frame: Frame { s: Vec3::X, t: Vec3::Y, n: Vec3::Z },
        weight: 1.0,
        material: 0,
        bend: None,
        part: None,
    };
}

impl Component<'_> {
    /// f of the part of the lobe that counts. Directions are local.
    #[inline]
    fn lobe_f(&self, wo: Vec3, wi: Vec3, transport: Transport) -> Rgb {
        let f = self.lobe.f(wo, wi, transport);
        match self.part {
            None => f,
            Some(Part { diffuse, rest }) => {
                // Where the lobe is below its mean, which is the diffuse part, the rest is zero.
                let base = self.lobe.diffuse_f(wo, wi).zip(f, f32::min);
                base * diffuse + (f - base) * rest
            }
        }
    }

    /// Whether it is narrower than `min_roughness` and not a delta lobe.
    #[inline]
    pub(super) fn is_sharp(&self, min_roughness: f32) -> bool {
        self.lobe.roughness() < min_roughness && self.part.is_none_or(|p| !p.rest.is_black())
    }

    /// The same lobe with factors: `broad` on its diffuse part, and on the rest `sharp` if the lobe is narrower than
    /// `min_roughness`, else `broad`.
    pub(super) fn weighed(mut self, min_roughness: f32, broad: Rgb, sharp: Rgb) -> Self {
        let Part { diffuse, rest } = self.part.unwrap_or(Part::ALL);
        let factor = if self.is_sharp(min_roughness) { sharp } else { broad };
        self.part = Some(Part { diffuse: diffuse * broad, rest: rest * factor });
        self
    }

    /// Whether it scatters any light toward `wo`, except by delta lobes.
    pub(super) fn scatters(&self, wo: Vec3) -> bool {
        match self.part {
            _ if self.lobe.is_delta() => false,
            None => true,
            Some(Part { diffuse, rest }) => {
                let local = self.frame.to_local(wo);
                !rest.is_black() || !(diffuse * self.lobe.diffuse_albedo(local)).is_black()
            }
        }
    }

    /// f times the cosine of the arriving light with the lobe's normal. On light paths the light arrives along `wo`,
    /// and its power is measured with the geometric normal: |cos(wo, n) cos(wi, ng) / cos(wo, ng)| replaces the cosine
    /// of `wi` [Veach97, 5.3.2].
    #[inline]
    pub(super) fn f_cos(&self, wo: Vec3, wi: Vec3, way: Way) -> Rgb {
        let (frame, unshadowed) = match (&self.bend, way.transport) {
            (None, _) => (self.frame, 1.0),
            (Some(bend), Transport::Radiance) => (self.frame, bend.unshadowed(&self.frame, wo, wi)),
            (Some(bend), Transport::Power) => {
                let frame = bend.seen_from(self.frame, wi);
                (frame, bend.unshadowed(&frame, wi, wo))
            }
        };
        let (local_wo, local_wi) = (frame.to_local(wo), frame.to_local(wi));
        let cos = local_wi.z.abs() * adjoint(&frame, wo, wi, way);
        self.lobe_f(local_wo, local_wi, way.transport) * (cos * unshadowed * self.weight)
    }

    /// [`Component::f_cos`] and [`Component::pdf_w`] together, for a lobe that is not bent.
    #[inline]
    pub(super) fn f_cos_pdf(&self, wo: Vec3, wi: Vec3, way: Way) -> (Rgb, f32) {
        let (local_wo, local_wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        let cos = local_wi.z.abs() * adjoint(&self.frame, wo, wi, way);
        let (f, pdf_w) = self.lobe.f_pdf(local_wo, local_wi, way.transport);
        let f =
            if self.part.is_some() { self.lobe_f(local_wo, local_wi, way.transport) } else { f };
        (f * (cos * self.weight), pdf_w * self.weight)
    }

    /// [`Component::f_cos`] divided by the cosine of `wi` with the normal that defines irradiance: the unbent shading
    /// normal, or the geometric normal on light paths.
    #[inline]
    pub(super) fn f(&self, wo: Vec3, wi: Vec3, way: Way) -> Rgb {
        let normal = match (&self.bend, way.transport) {
            (None, Transport::Radiance) => {
                let local = (self.frame.to_local(wo), self.frame.to_local(wi));
                return self.lobe_f(local.0, local.1, way.transport) * self.weight;
            }
            (Some(bend), Transport::Radiance) => bend.unbent(),
            (_, Transport::Power) => way.ng,
        };
        let cos = wi.dot(normal).abs();
        if cos > 0.0 { self.f_cos(wo, wi, way) / cos } else { Rgb::BLACK }
    }

    /// Density per solid angle with which [`Component::sample`] returns `wi`, times the weight in the blend.
    #[inline]
    pub(super) fn pdf_w(&self, wo: Vec3, wi: Vec3, way: Way) -> f32 {
        let within = |frame: &Frame| self.lobe.pdf_w(frame.to_local(wo), frame.to_local(wi));
        let pdf_w = match self.flippable(way) {
            None => within(&self.frame),
            Some((bend, share)) => {
                (1.0 - share) * within(&self.frame) + share * within(&bend.flipped(self.frame))
            }
        };
        pdf_w * self.weight
    }

    /// Sample a direction. The weight does not yet include the weight in the blend.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u_choice: f32, u: [f32; 2], way: Way) -> Option<Scatter> {
        if let Some(flippable) = self.flippable(way) {
            return self.sample_flippable(wo, u_choice, u, way, flippable);
        }
        let frame = &self.frame;
        let mut s = self.sample_in(frame, wo, u_choice, u, way)?;
        if s.null {
            return Some(s);
        }
        if self.part.is_some() && !s.delta {
            let whole = Component { weight: 1.0, ..*self };
            s.weight = whole.f_cos(wo, s.wi, way) / s.pdf_w;
            return Some(s);
        }
        if let Some(bend) = &self.bend {
            let [eye, light] = match way.transport {
                Transport::Radiance => [wo, s.wi],
                Transport::Power => [s.wi, wo],
            };
            s.weight *= bend.unshadowed(frame, eye, light);
        }
        if way.transport == Transport::Power {
            s.weight *= adjoint(frame, wo, s.wi, way);
        }
        Some(s)
    }

    /// Sample a direction of the world with the lobe in this frame.
    #[inline]
    fn sample_in(
        &self,
        frame: &Frame,
        wo: Vec3,
        u_choice: f32,
        u: [f32; 2],
        way: Way,
    ) -> Option<Scatter> {
        let mut s = self.lobe.sample(frame.to_local(wo), u_choice, u, way.transport)?;
        // Rounding in the frame would bend a path at every surface that it passes straight through.
        s.wi = if s.null { -wo } else { frame.to_world(s.wi) };
        Some(s)
    }

    /// On light paths, the path continues toward the eye, so the sampled direction decides whether the normal is
    /// flipped. Therefore the frame is sampled first.
    fn sample_flippable(
        &self,
        wo: Vec3,
        u_choice: f32,
        u: [f32; 2],
        way: Way,
        (bend, share): (&Bend, f32),
    ) -> Option<Scatter> {
        let (frame, u_choice, chosen) = if u_choice < share {
            (bend.flipped(self.frame), u_choice / share, share)
        } else {
            (self.frame, (u_choice - share) / (1.0 - share), 1.0 - share)
        };
        let u_choice = u_choice.min(1.0 - f32::EPSILON);
        let mut s = self.sample_in(&frame, wo, u_choice, u, way)?;
        if s.null {
            return Some(s);
        }
        if s.delta {
            let sees_it = bend.seen_from(self.frame, s.wi).n == frame.n;
            s.weight *= bend.unshadowed(&frame, s.wi, wo) * adjoint(&frame, wo, s.wi, way) / chosen;
            s.pdf_w *= chosen;
            return sees_it.then_some(s);
        }
        let whole = Component { weight: 1.0, ..*self };
        let pdf_w = whole.pdf_w(wo, s.wi, way);
        s.weight = whole.f_cos(wo, s.wi, way) / pdf_w;
        (pdf_w > 0.0).then_some(Scatter { pdf_w, ..s })
    }

    /// If the frame depends on the direction in which a light path continues: its bending, and the probability of the
    /// flipped frame.
    #[inline]
    fn flippable(&self, way: Way) -> Option<(&Bend, f32)> {
        let bend = self.bend.as_ref().filter(|_| way.transport == Transport::Power)?;
        Some((bend, bend.share_flipped(&self.frame))).filter(|(_, share)| *share > 0.0)
    }

    /// Fraction of diffuse light that a bent lobe receives.
    pub(super) fn mean_unshadowed(&self) -> f32 {
        self.bend.as_ref().map_or(1.0, Bend::mean_unshadowed)
    }
}

/// Factor on the cosine of `wi` with the frame's normal on light paths, see [`Component::f_cos`].
#[inline]
fn adjoint(frame: &Frame, wo: Vec3, wi: Vec3, Way { transport, ng }: Way) -> f32 {
    if transport == Transport::Radiance || frame.n == ng || frame.n == -ng {
        return 1.0;
    }
    let denominator = (wo.dot(ng) * wi.dot(frame.n)).abs();
    if denominator > 0.0 { (wo.dot(frame.n) * wi.dot(ng)).abs() / denominator } else { 0.0 }
}
