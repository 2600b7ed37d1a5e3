//! Upper bounds of the principled model's parts, see [`crate::bsdf::bound`].

use super::{Solid, Thin};
use crate::bsdf::Transport;
use crate::bsdf::bound::{Cap, ScatterBound};
use crate::bsdf::fresnel;
use crate::bsdf::microfacet::least_tangent;
use crate::math::{INV_PI, Rgb, sqr};

impl Solid {
    /// Bound the scattering toward a cap; `max_cos_wo` is the largest cosine between `wo` and a direction in it.
    pub(in crate::bsdf) fn bound(
        &self,
        cap: &Cap,
        max_cos_wo: f32,
        transport: Transport,
    ) -> ScatterBound {
        let mut bound = ScatterBound::default();
        if cap.wo.z > 0.0 && cap.cos > 0.0 {
            bound += self.reflected_bound(cap, max_cos_wo);
        }
        if self.glass > 0.0 {
            // Use the cap without its limit on the cosine, because the light may come from either side.
            let both = Cap { cos: 1.0, ..*cap };
            if cap.wo.z < 0.0 {
                let cos = both.min_cos_half().copysign(cap.wo.z);
                let reflected = self.glass * fresnel::dielectric(cos, self.front.eta).reflectance;
                bound += both.reflected(&self.facets, Rgb::grey(reflected));
            }
            bound += both.refracted(&self.facets, self.front.eta, self.transmit, transport);
        }
        bound
    }

    /// All scattering that stays on the side of the normal.
    fn reflected_bound(&self, cap: &Cap, max_cos_wo: f32) -> ScatterBound {
        let min_cos = cap.min_cos_half();
        let mut bound = cap.reflected(&self.facets, self.front.bound(min_cos));
        let [f, f_cos] = self.base.bound(cap.wo.z, cap.cos, [cap.min_cos_wo, max_cos_wo]);
        bound += ScatterBound { f, f_cos };
        let tan_sq = sqr(least_tangent(cap.wo + cap.center, cap.radius));
        let coat = self.coat.bound(cap.wo.z, cap.cos, tan_sq, min_cos, self.front.eta);
        bound + ScatterBound { f: Rgb::grey(coat), f_cos: Rgb::grey(coat * cap.cos) }
    }
}

impl Thin {
    /// Bound the scattering toward a cap above; `max_cos_wo` is the largest cosine between `wo` and a direction in it.
    pub(in crate::bsdf) fn reflected_bound(&self, cap: &Cap, max_cos_wo: f32) -> ScatterBound {
        let [f, f_cos] = self.base.bound(cap.wo.z, cap.cos, [cap.min_cos_wo, max_cos_wo]);
        let fresnel = self.front.bound(cap.min_cos_half()) * self.specular;
        cap.reflected(&self.facets, fresnel) + ScatterBound { f, f_cos }
    }

    /// Bound the transmission to the other side, toward a cap that was mirrored to above.
    pub(in crate::bsdf) fn passing_bound(&self, cap: &Cap) -> ScatterBound {
        let diffuse = self.behind * INV_PI;
        let most = 1.0 - fresnel::dielectric(1.0, self.front.eta).reflectance;
        cap.reflected(&self.passing, self.transmit * most)
            + ScatterBound { f: diffuse, f_cos: diffuse * cap.cos }
    }
}
