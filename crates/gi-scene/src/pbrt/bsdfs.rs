//! The materials of pbrt-v4.

use gi_core::math::Rgb;

use super::Translator;
use super::materials::{Bsdf, KNOWN, ROUGHNESS, RoughnessNames};
use super::params::Params;
use super::textures::Factor;
use crate::document::Value;
use crate::materials::ior;

impl Translator<'_> {
    /// The BSDF of a material; `None` after an error.
    pub(super) fn bsdf(&mut self, kind: &str, params: &Params) -> Option<Bsdf> {
        Some(match kind {
            "diffuse" => {
                let diffuse = self.plain(params, "diffuse");
                self.set_or(diffuse, params, "reflectance", "reflectance", 0.5);
                Bsdf::opaque(diffuse)
            }
            "coateddiffuse" => self.coated_diffuse(params),
            "conductor" => self.conductor(params, ["eta", "k", "reflectance"], ROUGHNESS),
            "coatedconductor" => self.coated_conductor(params),
            "dielectric" => self.dielectric(params, &["eta"]),
            "thindielectric" => {
                let thin = self.plain(params, "thindielectric");
                self.set_index(thin, params, &["eta"]);
                Bsdf::two_sided(thin)
            }
            "diffusetransmission" => {
                let [r, t] = ["reflectance", "transmittance"]
                    .map(|name| self.factor(params, name).unwrap_or(Factor::grey(0.25)));
                let scale = params.number("scale", self.report).unwrap_or(1.0);
                self.note_approximation(params, kind, "`principledthin`");
                self.sheet(params, [r, t], scale as f32)
            }
            "mix" => return self.mix(params),
            "subsurface" | "kdsubsurface" => {
                self.note_approximation(params, kind, "a coated diffuse surface");
                self.subsurface(params)
            }
            "hair" | "measured" | "fourier" => self.diffuse_instead(params, kind),
            "interface" | "none" | "" => Bsdf::two_sided(self.plain(params, "null")),
            _ => match self.v3_bsdf(kind, params) {
                Some(bsdf) => bsdf,
                None if self.is_v3 => {
                    // As in pbrt-v3.
                    let message = format!("unknown material `{kind}`: it is replaced by `matte`");
                    self.report.warn(params.span, message);
                    Bsdf::opaque(self.plain(params, "diffuse"))
                }
                None => {
                    self.unknown_material(kind, params);
                    return None;
                }
            },
        })
    }

    /// A diffuse surface in place of a material that is not supported.
    fn diffuse_instead(&mut self, params: &Params, kind: &str) -> Bsdf {
        self.note_approximation(params, kind, "a diffuse surface");
        params.ignore(&["filename", "bsdffile", "sigma_a", "color", "reflectance"]);
        params.ignore(&["eumelanin", "pheomelanin", "eta", "beta_m", "beta_n", "alpha"]);
        let diffuse = self.plain(params, "diffuse");
        let color = if kind == "hair" { Rgb::new(0.3, 0.2, 0.12) } else { Rgb::grey(0.5) };
        self.doc.set(diffuse, "reflectance", params.span, Value::Color(color));
        Bsdf::opaque(diffuse)
    }

    fn unknown_material(&self, kind: &str, params: &Params) {
        let help = self
            .report
            .suggestion(kind, KNOWN)
            .or_else(|| Some(format!("known are: {}", KNOWN.join(", "))));
        let span = params.text("type").map_or(params.span, |text| text.span);
        self.report.error_help(
            span,
            format!("unknown material `{kind}`"),
            "expected a material",
            help,
        );
    }

    /// A diffuse base under a dielectric coat. Mitsuba's `plastic` is the same without the coat's thickness; light that
    /// the coat reflects back is tinted each time.
    fn coated_diffuse(&mut self, params: &Params) -> Bsdf {
        params.ignore(&["thickness", "maxdepth", "nsamples", "g"]);
        let absorbs = match self.factor(params, "albedo") {
            Some(Factor::Constant(c)) => !c.is_black(),
            Some(Factor::Texture(..)) => true,
            None => false,
        };
        if absorbs {
            let message = "the medium inside the coat is ignored";
            self.report.warn(params.span_of("albedo"), message);
        }
        let rough = self.roughness(params, ROUGHNESS, 0.0);
        let plastic = self.plain(params, if rough.is_some() { "roughplastic" } else { "plastic" });
        self.set_or(plastic, params, "reflectance", "diffuse_reflectance", 0.5);
        self.set_index(plastic, params, &["eta"]);
        self.doc.set(plastic, "nonlinear", params.span, Value::Bool(true));
        match rough {
            Some(pair) => self.set_roughness(plastic, params, &pair),
            None => params.ignore(&["remaproughness"]),
        }
        Bsdf::opaque(plastic)
    }

    fn coated_conductor(&mut self, params: &Params) -> Bsdf {
        let how = "the conductor alone, as bright along the normal as with its coat";
        self.note_approximation(params, "coatedconductor", how);
        params.ignore(&["interface.roughness", "interface.uroughness", "interface.vroughness"]);
        params.ignore(&["thickness", "maxdepth", "nsamples", "g", "albedo"]);
        let names = ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"];
        let inner = self.conductor(params, ["conductor.eta", "conductor.k", "reflectance"], names);
        let coat = self.plain(params, "coating");
        self.set_index(coat, params, &["interface.eta"]);
        self.doc.nest(coat, "", inner.object);
        Bsdf::opaque(coat)
    }

    /// A conductor, from an index of refraction or from its reflectance at normal incidence.
    pub(super) fn conductor(
        &mut self,
        params: &Params,
        [eta_name, k_name, reflectance]: [&'static str; 3],
        names: RoughnessNames,
    ) -> Bsdf {
        let span = params.span;
        let default = if self.is_v3 { 0.01 } else { 0.0 };
        let rough = self.roughness(params, names, default);
        let plugin = if rough.is_some() { "roughconductor" } else { "conductor" };
        let conductor = self.plain(params, plugin);
        let copper = ior::conductor("Cu").unwrap_or((Rgb::WHITE, Rgb::WHITE));
        let (eta, k) = match self.factor(params, reflectance) {
            Some(Factor::Constant(r)) => {
                // pbrt: eta = 1, and k such that the reflectance at normal incidence is r.
                (
                    Rgb::WHITE,
                    r.map(|r| 2.0 * (r.clamp(0.0, 0.9999) / (1.0 - r.clamp(0.0, 0.9999))).sqrt()),
                )
            }
            Some(texture @ Factor::Texture(..)) => {
                self.set_factor(conductor, "specular_reflectance", &texture, span);
                (Rgb::BLACK, Rgb::WHITE)
            }
            None => (
                self.constant(params, eta_name).unwrap_or(copper.0),
                self.constant(params, k_name).unwrap_or(copper.1),
            ),
        };
        self.doc.set(conductor, "eta", span, Value::Color(eta));
        self.doc.set(conductor, "k", span, Value::Color(k));
        match rough {
            Some(pair) => self.set_roughness(conductor, params, &pair),
            None => params.ignore(&["remaproughness"]),
        }
        Bsdf::opaque(conductor)
    }

    /// A factor that must be constant; a texture is ignored with a warning.
    pub(super) fn constant(&self, params: &Params, name: &'static str) -> Option<Rgb> {
        match self.factor(params, name)? {
            Factor::Constant(c) => Some(c),
            Factor::Texture(text, _) => {
                let message = format!("the texture of `{name}` is ignored: the default is used");
                self.report.warn(text.span, message);
                None
            }
        }
    }

    pub(super) fn dielectric(&mut self, params: &Params, index: &[&'static str]) -> Bsdf {
        let rough = self.roughness(params, ROUGHNESS, 0.0);
        let plugin = if rough.is_some() { "roughdielectric" } else { "dielectric" };
        let dielectric = self.plain(params, plugin);
        self.set_index(dielectric, params, index);
        match rough {
            Some(pair) => self.set_roughness(dielectric, params, &pair),
            None => params.ignore(&["remaproughness"]),
        }
        Bsdf::two_sided(dielectric)
    }

    /// A sheet that reflects and transmits light diffusely. Mitsuba's `principledthin` has one colour for both, and the
    /// fraction that is transmitted.
    pub(super) fn sheet(&mut self, params: &Params, pair: [Factor; 2], scale: f32) -> Bsdf {
        let span = params.span;
        let sheet = self.plain(params, "principledthin");
        let (color, transmitted) = match pair {
            [Factor::Constant(r), Factor::Constant(t)] => {
                let sum = (r + t) * scale;
                let part = t.mean() / (r + t).mean().max(1e-6);
                (Factor::Constant(sum.map(|v| v.min(1.0))), part)
            }
            [texture @ Factor::Texture(..), Factor::Constant(t)] if t.is_black() => (texture, 0.0),
            [Factor::Constant(r), texture @ Factor::Texture(..)] if r.is_black() => (texture, 1.0),
            [texture @ Factor::Texture(..), _] | [_, texture] => (texture, 0.5),
        };
        let doubled = color.is_texture() && transmitted == 0.5;
        if doubled || (color.is_texture() && scale != 1.0) {
            let factor = if doubled { 2.0 * scale } else { scale };
            let texture = self.plain_texture(params, "scale");
            self.doc.set(texture, "scale", span, Value::Color(Rgb::grey(factor)));
            self.set_factor(texture, "", &color, span);
            self.doc.nest(sheet, "base_color", texture);
        } else {
            self.set_factor(sheet, "base_color", &color, span);
        }
        self.doc.set(sheet, "diff_trans", span, Value::Float(2.0 * transmitted));
        self.doc.set(sheet, "eta", span, Value::Float(1.0));
        Bsdf::two_sided(sheet)
    }

    fn mix(&mut self, params: &Params) -> Option<Bsdf> {
        let blend = self.plain(params, "blendbsdf");
        let names = match params.texts("materials") {
            Some([first, second]) => [first.clone(), second.clone()],
            Some(_) => {
                let span = params.span_of("materials");
                self.report.error(span, "`materials` does not name two", "expected two names");
                return None;
            }
            // In pbrt-v3, `amount` is the weight of the first one.
            None => match (params.text("namedmaterial2"), params.text("namedmaterial1")) {
                (Some(second), Some(first)) => [second.clone(), first.clone()],
                _ => {
                    self.report.error(params.span, "`mix` without `string materials`", "");
                    return None;
                }
            },
        };
        self.set_or(blend, params, "amount", "weight", 0.5);
        names.iter().for_each(|name| self.refer_to_material(blend, name));
        Some(Bsdf::two_sided(blend))
    }

    /// A body that scatters light inside: the coat over the albedo that its coefficients give \[Jensen01 eq. 15\].
    fn subsurface(&mut self, params: &Params) -> Bsdf {
        params.ignore(&["mfp", "scale", "Kr", "Kt"]);
        let eta = params.number("eta", self.report).unwrap_or(1.33) as f32;
        let plastic = self.coated_diffuse(params);
        if params.has("reflectance") || params.has("Kd") {
            if params.has("Kd") {
                self.set_or(plastic.object, params, "Kd", "diffuse_reflectance", 0.5);
            }
            return plastic;
        }
        let named = params.text("name").and_then(|name| super::media::preset(&name.text));
        let (s, a) = named.unwrap_or((Rgb::new(2.55, 3.21, 3.77), Rgb::new(0.0011, 0.0024, 0.014)));
        let s = self.constant(params, "sigma_s").unwrap_or(s);
        let a = self.constant(params, "sigma_a").unwrap_or(a);
        let g = params.number("g", self.report).unwrap_or(0.0) as f32;
        let albedo = s.zip(a, |s, a| diffuse_albedo(s * (1.0 - g), a, eta));
        self.doc.set(plastic.object, "diffuse_reflectance", params.span, Value::Color(albedo));
        plastic
    }
}

/// Diffuse albedo of a half-space with these coefficients \[Jensen01 eq. 15\].
fn diffuse_albedo(sigma_s: f32, sigma_a: f32, eta: f32) -> f32 {
    let total = sigma_s + sigma_a;
    if !(total > 0.0 && eta > 0.0) {
        return 0.0;
    }
    let alpha = sigma_s / total;
    let fdr = -1.44 / (eta * eta) + 0.71 / eta + 0.668 + 0.0636 * eta;
    let a = (1.0 + fdr) / (1.0 - fdr);
    let root = (3.0 * (1.0 - alpha).max(0.0)).sqrt();
    (0.5 * alpha * (1.0 + (-4.0 / 3.0 * a * root).exp()) * (-root).exp()).clamp(0.0, 1.0)
}
