//! The materials of pbrt-v3 that pbrt-v4 has no more.

use gi_core::math::Rgb;

use super::Translator;
use super::materials::{Bsdf, ROUGHNESS};
use super::params::Params;
use super::textures::Factor;
use crate::document::Value;

impl Translator<'_> {
    /// The BSDF of a material of pbrt-v3; `None` if there is no such material.
    pub(super) fn v3_bsdf(&mut self, kind: &str, params: &Params) -> Option<Bsdf> {
        Some(match kind {
            "matte" => self.matte(params),
            "plastic" => {
                self.note_approximation(params, kind, "`roughplastic`");
                self.glossy(params, [0.25, 0.25], None)
            }
            "metal" => self.conductor(params, ["eta", "k", "reflectance"], ROUGHNESS),
            "mirror" => {
                let mirror = self.plain(params, "conductor");
                self.set_or(mirror, params, "Kr", "specular_reflectance", 0.9);
                Bsdf::opaque(mirror)
            }
            "glass" => {
                let bsdf = self.dielectric(params, &["eta", "index"]);
                self.set_or(bsdf.object, params, "Kr", "specular_reflectance", 1.0);
                self.set_or(bsdf.object, params, "Kt", "specular_transmittance", 1.0);
                bsdf
            }
            "uber" => self.uber(params),
            "substrate" => {
                self.note_approximation(params, kind, "`roughplastic`");
                let at_normal = match self.factor(params, "Ks") {
                    Some(Factor::Constant(c)) => c.mean(),
                    Some(Factor::Texture(..)) | None => 0.5,
                };
                self.glossy(params, [0.5, 1.0], Some(at_normal))
            }
            "translucent" => {
                self.note_approximation(params, kind, "`principledthin`");
                params.note_ignored(&["Ks"], "the sheet is diffuse", self.report);
                params.ignore(&["roughness", "remaproughness"]);
                let color = self.factor(params, "Kd").unwrap_or(Factor::grey(0.25));
                let part = |name| self.constant(params, name).unwrap_or(Rgb::grey(0.5));
                let pair = [part("reflect"), part("transmit")].map(|part| match &color {
                    Factor::Constant(c) => Factor::Constant(*c * part),
                    texture => texture.clone(),
                });
                self.sheet(params, pair, if color.is_texture() { 0.5 } else { 1.0 })
            }
            "disney" => self.disney(params),
            _ => return None,
        })
    }

    /// `uber`: glass if it transmits more light than it scatters, otherwise a diffuse base under a coat.
    fn uber(&mut self, params: &Params) -> Bsdf {
        let mean = |name, default| match self.factor(params, name) {
            Some(Factor::Constant(c)) => c.mean(),
            Some(Factor::Texture(..)) | None => default,
        };
        let (transmitted, scattered) = (mean("Kt", 0.0), mean("Kd", 0.25) + mean("Ks", 0.25));
        if transmitted > scattered {
            if scattered > 0.0 {
                self.note_approximation(params, "uber", "`dielectric`");
            }
            params.ignore(&["Kd", "Ks", "remaproughness"]);
            params.ignore(&["roughness", "uroughness", "vroughness"]);
            let glass = self.plain(params, "dielectric");
            self.set_or(glass, params, "Kr", "specular_reflectance", 0.0);
            self.set_or(glass, params, "Kt", "specular_transmittance", 0.0);
            self.set_index(glass, params, &["eta", "index"]);
            return Bsdf::two_sided(glass);
        }
        self.note_approximation(params, "uber", "`roughplastic`");
        for (name, why) in [("Kr", "the coat reflects instead"), ("Kt", "the surface is opaque")] {
            match self.factor(params, name) {
                Some(Factor::Constant(c)) if c.is_black() => {}
                _ => params.note_ignored(&[name], why, self.report),
            }
        }
        self.glossy(params, [0.25, 0.25], None)
    }

    fn matte(&mut self, params: &Params) -> Bsdf {
        let sigma = self.constant(params, "sigma").map_or(0.0, |c| c.mean());
        let diffuse = self.plain(params, if sigma > 0.0 { "roughdiffuse" } else { "diffuse" });
        self.set_or(diffuse, params, "Kd", "reflectance", 0.5);
        if sigma > 0.0 {
            // Mitsuba takes the root mean square slope, pbrt the deviation of the angle in degrees.
            let alpha = sigma.to_radians() * std::f32::consts::SQRT_2;
            self.doc.set(diffuse, "alpha", params.span_of("sigma"), Value::Float(alpha));
            self.doc.set(diffuse, "use_fast_approx", params.span, Value::Bool(true));
        }
        Bsdf::opaque(diffuse)
    }

    /// A diffuse base under a rough coat. `at_normal` is the coat's reflectance at normal incidence, if it is given
    /// instead of the index of refraction.
    fn glossy(&mut self, params: &Params, [kd, ks]: [f64; 2], at_normal: Option<f32>) -> Bsdf {
        let rough = self.roughness(params, ROUGHNESS, 0.1);
        let plastic = self.plain(params, if rough.is_some() { "roughplastic" } else { "plastic" });
        self.set_or(plastic, params, "Kd", "diffuse_reflectance", kd);
        match at_normal {
            Some(r) => {
                let root = r.clamp(0.001, 0.25).sqrt();
                let eta = (1.0 + root) / (1.0 - root);
                self.doc.set(plastic, "int_ior", params.span, Value::Float(eta));
                self.doc.set(plastic, "ext_ior", params.span, Value::Float(1.0));
            }
            None => {
                self.set_or(plastic, params, "Ks", "specular_reflectance", ks);
                self.set_index(plastic, params, &["eta", "index"]);
            }
        }
        match rough {
            Some(pair) => self.set_roughness(plastic, params, &pair),
            None => params.ignore(&["remaproughness"]),
        }
        Bsdf::opaque(plastic)
    }

    /// Burley's model, which Mitsuba calls `principled`.
    fn disney(&mut self, params: &Params) -> Bsdf {
        let thin = params.bool("thin", false, self.report);
        let principled = self.plain(params, if thin { "principledthin" } else { "principled" });
        self.set_or(principled, params, "color", "base_color", 0.5);
        self.set_or(principled, params, "roughness", "roughness", 0.5);
        let mut same = vec![
            ("anisotropic", "anisotropic", 0.0),
            ("spectrans", "spec_trans", 0.0),
            ("speculartint", "spec_tint", 0.0),
            ("sheen", "sheen", 0.0),
            ("sheentint", "sheen_tint", 0.5),
            ("flatness", "flatness", 0.0),
        ];
        if thin {
            same.push(("difftrans", "diff_trans", 1.0));
            params.ignore(&["metallic", "clearcoat", "clearcoatgloss"]);
        } else {
            same.push(("metallic", "metallic", 0.0));
            same.push(("clearcoat", "clearcoat", 0.0));
            same.push(("clearcoatgloss", "clearcoat_gloss", 1.0));
            params.ignore(&["difftrans"]);
        }
        for (name, as_name, default) in same {
            self.set_or(principled, params, name, as_name, default);
        }
        let eta = params.number("eta", self.report).unwrap_or(1.5) as f32;
        self.doc.set(principled, "eta", params.span_of("eta"), Value::Float(eta));
        params.note_ignored(&["scatterdistance"], "the base is diffuse", self.report);
        if thin { Bsdf::two_sided(principled) } else { self.refracting(params, principled) }
    }

    /// Glass has two sides already; other surfaces are made two-sided.
    fn refracting(&self, params: &Params, object: usize) -> Bsdf {
        match self.factor(params, "spectrans") {
            Some(Factor::Constant(c)) if c.is_black() => Bsdf::opaque(object),
            Some(_) => Bsdf::two_sided(object),
            None => Bsdf::opaque(object),
        }
    }
}
