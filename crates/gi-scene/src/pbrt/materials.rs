//! Materials: named and current ones, and what is common to all kinds.

use std::rc::Rc;

use gi_core::math::Rgb;

use super::Translator;
use super::params::Params;
use super::textures::{Factor, is_texture};
use super::types::Text;
use crate::document::{Class, ObjectId, Value};

/// The supported materials; those after `interface` are pbrt-v3's.
pub(super) const KNOWN: [&str; 24] = [
    "diffuse",
    "coateddiffuse",
    "conductor",
    "coatedconductor",
    "dielectric",
    "thindielectric",
    "diffusetransmission",
    "mix",
    "subsurface",
    "hair",
    "measured",
    "interface",
    "none",
    "matte",
    "plastic",
    "metal",
    "mirror",
    "glass",
    "uber",
    "substrate",
    "translucent",
    "disney",
    "kdsubsurface",
    "fourier",
];

/// A BSDF of the document.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bsdf {
    pub(super) object: ObjectId,
    /// Whether it scatters light at both of its sides by itself. Others are made two-sided, as all are in pbrt.
    pub(super) two_sided: bool,
}

impl Bsdf {
    pub(super) fn opaque(object: ObjectId) -> Self {
        Bsdf { object, two_sided: false }
    }

    pub(super) fn two_sided(object: ObjectId) -> Self {
        Bsdf { object, two_sided: true }
    }
}

/// The names of a material's roughness parameters: the common one and those along the two axes.
pub(super) type RoughnessNames = [&'static str; 3];

pub(super) const ROUGHNESS: RoughnessNames = ["roughness", "uroughness", "vroughness"];

impl Translator<'_> {
    /// `Material`: the material of the shapes that follow.
    pub(super) fn current_material(&mut self, params: &Params) {
        let key: Rc<str> = format!("material {}", self.next_number()).into();
        self.make_material(&params.plugin, params, &key, None);
        self.state.now.material = Some(key);
    }

    /// `MakeNamedMaterial`: a material that others refer to.
    pub(super) fn named_material(&mut self, params: &Params) {
        let name = params.plugin.as_str();
        let taken = self.materials.contains_key(name);
        if taken && !self.is_v3 {
            let message = format!("a material named `{name}` exists already");
            self.report.error(params.span, message, "");
            return;
        }
        let key = if taken { format!("material {}", self.next_number()).into() } else { key(name) };
        match params.text("type") {
            Some(kind) => {
                let kind = kind.text.clone();
                self.make_material(&kind, params, &key, Some(name));
            }
            None => self.report.error(params.span, "a material without a `string type`", ""),
        }
        self.materials.insert(name.to_owned(), key);
    }

    /// `NamedMaterial`: use a named material for the shapes that follow.
    pub(super) fn use_material(&mut self, name: &Text) {
        if self.is_v3 && !self.materials.contains_key(&name.text) {
            // Many old scenes have such names, and pbrt-v3 goes on.
            let message = format!("no material is named `{}`: the one before stays", name.text);
            return self.report.warn(name.span, message);
        }
        self.state.now.material = Some(self.material_key(name));
    }

    /// The id of a named material, which may be defined later.
    fn material_key(&mut self, name: &Text) -> Rc<str> {
        match self.materials.get(&name.text) {
            Some(known) => known.clone(),
            None => {
                let key = key(&name.text);
                self.wanted.push((key.to_string(), name.clone(), "material"));
                key
            }
        }
    }

    /// Make a child of a named material.
    pub(super) fn refer_to_material(&mut self, parent: ObjectId, name: &Text) {
        let key = self.material_key(name);
        self.doc.refer(parent, "", name.span, &key);
    }

    fn make_material(&mut self, kind: &str, params: &Params, key: &Rc<str>, shown: Option<&str>) {
        let bsdf = self.bsdf(kind, params);
        let failed = bsdf.is_none();
        // After an error, something stands in for the material, so that no reference to it is reported too.
        let bsdf = bsdf.unwrap_or_else(|| Bsdf::opaque(self.plain(params, "diffuse")));
        let bsdf = self.bent(params, bsdf);
        let mut outer = bsdf.object;
        if !bsdf.two_sided {
            outer = self.plain(params, "twosided");
            self.doc.nest(outer, "", bsdf.object);
        }
        let opaque = |f: &Factor| matches!(f, Factor::Constant(c) if *c == Rgb::WHITE);
        let opacity = self.factor(params, "opacity").filter(|f| kind == "uber" && !opaque(f));
        if let Some(opacity) = opacity {
            let mask = self.plain(params, "mask");
            self.set_factor(mask, "opacity", &opacity, params.span);
            self.doc.nest(mask, "", outer);
            outer = mask;
        }
        if !failed {
            params.report_unused(self.report);
        }
        self.doc.register(outer, key, shown);
        self.doc.nest(self.scene, "", outer);
        if params.find_any(is_texture) {
            self.textured.insert(key.clone());
        }
    }

    /// An object for a BSDF without parameters.
    pub(super) fn plain(&mut self, params: &Params, plugin: &str) -> ObjectId {
        self.doc.add(Class::Bsdf, "material", plugin, params.span)
    }

    /// A BSDF with its normals bent by a normal map or a displacement.
    fn bent(&mut self, params: &Params, bsdf: Bsdf) -> Bsdf {
        let (report, span) = (self.report, params.span);
        if let Some(file) = params.text("normalmap") {
            let map = self.doc.add(Class::Texture, "texture", "bitmap", span);
            self.doc.set(map, "filename", file.span, Value::Text(file.text.clone()));
            self.doc.set(map, "raw", span, Value::Bool(true));
            self.doc.set(map, "to_uv", span, Value::transform(super::pictures::downward()));
            return self.bent_by(params, "normalmap", map, bsdf);
        }
        let name = if params.has("displacement") { "displacement" } else { "bumpmap" };
        match self.scalar(params, name) {
            Some(height @ Factor::Texture(..)) => {
                let scale = self.doc.add(Class::Texture, "texture", "scale", span);
                self.set_factor(scale, "", &height, span);
                self.bent_by(params, "bumpmap", scale, bsdf)
            }
            Some(Factor::Constant(_)) => {
                report.warn(params.span_of(name), "a constant displacement has no effect");
                bsdf
            }
            None => bsdf,
        }
    }

    fn bent_by(&mut self, params: &Params, plugin: &str, map: ObjectId, bsdf: Bsdf) -> Bsdf {
        let outer = self.plain(params, plugin);
        self.doc.nest(outer, "", map);
        self.doc.nest(outer, "", bsdf.object);
        Bsdf { object: outer, ..bsdf }
    }

    /// The roughness along both axes; `None` if the surface is smooth.
    pub(super) fn roughness(
        &self,
        params: &Params,
        names: RoughnessNames,
        default: f64,
    ) -> Option<[Factor; 2]> {
        let [both, u, v] = names;
        let both = self.scalar(params, both).unwrap_or(Factor::grey(default));
        let along = |name| self.scalar(params, name).unwrap_or_else(|| both.clone());
        let pair = [along(u), along(v)];
        let smooth = |f: &Factor| matches!(f, Factor::Constant(c) if c.is_black());
        (!pair.iter().all(smooth)).then_some(pair)
    }

    /// Give a rough BSDF its microfacets.
    pub(super) fn set_roughness(&mut self, object: ObjectId, params: &Params, pair: &[Factor; 2]) {
        let span = params.span;
        self.doc.set(object, "distribution", span, Value::Text("ggx".into()));
        for (name, factor) in ["alpha_u", "alpha_v"].into_iter().zip(pair) {
            self.set_factor(object, name, factor, span);
        }
        if params.bool("remaproughness", true, self.report) {
            let version = if self.is_v3 { "pbrt-v3" } else { "pbrt-v4" };
            self.doc.set(object, "remap", span, Value::Text(version.into()));
        }
    }

    /// Set the index of refraction: a number, or a spectrum, which becomes one number.
    pub(super) fn set_index(&mut self, object: ObjectId, params: &Params, names: &[&'static str]) {
        let given = names.iter().find(|name| params.has(name)).copied();
        let factor = given.and_then(|name| self.factor(params, name));
        let span = given.map_or(params.span, |name| params.span_of(name));
        let eta = match factor {
            Some(Factor::Constant(c)) if c.r == c.g && c.g == c.b => c.r,
            Some(Factor::Constant(c)) => c.mean(),
            Some(Factor::Texture(..)) => {
                self.report.warn(span, "a textured index of refraction is replaced by 1.5");
                1.5
            }
            None => 1.5,
        };
        // pbrt reads zero as one.
        let eta = if eta == 0.0 { 1.0 } else { eta };
        self.doc.set(object, "int_ior", span, Value::Float(eta));
        self.doc.set(object, "ext_ior", span, Value::Float(1.0));
    }

    /// Set a parameter to a factor, or to a default.
    pub(super) fn set_or(
        &mut self,
        object: ObjectId,
        params: &Params,
        name: &'static str,
        as_name: &str,
        default: f64,
    ) {
        let factor = self.factor(params, name).unwrap_or(Factor::grey(default));
        let span = params.span_of(name);
        self.set_factor(object, as_name, &factor, span);
    }

    /// Warn that a material is approximated.
    pub(super) fn note_approximation(&self, params: &Params, kind: &str, by: &str) {
        self.report.warn(params.span, format!("material `{kind}` is approximated by {by}"));
    }
}

/// The id of a named material.
fn key(name: &str) -> Rc<str> {
    format!("material named {name}").into()
}
