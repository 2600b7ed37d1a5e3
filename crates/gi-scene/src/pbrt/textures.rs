//! Textures: `constant`, `imagemap`, `checkerboard` and `scale`; others are replaced by a constant, with a warning.

use gi_core::math::Rgb;
use glam::{DAffine3, DVec3};

use super::Translator;
use super::params::{Param, Params};
use super::types::Text;
use super::types::Type;
use crate::diagnostics::Span;
use crate::document::{Class, Meaning, ObjectId, Value};
use crate::value::MAX_NUMBER;

/// The supported textures, and those that are approximated.
const KNOWN: [&str; 14] = [
    "constant",
    "imagemap",
    "checkerboard",
    "scale",
    "mix",
    "directionmix",
    "bilerp",
    "dots",
    "fbm",
    "wrinkled",
    "windy",
    "marble",
    "ptex",
    "uv",
];

/// A parameter that may vary over a surface.
#[derive(Clone, Debug)]
pub(super) enum Factor {
    Constant(Rgb),
    /// The name of a texture, and whether it is a texture of numbers.
    Texture(Text, bool),
}

impl Factor {
    pub(super) fn grey(v: f64) -> Self {
        Factor::Constant(Rgb::grey(v as f32))
    }

    pub(super) fn is_texture(&self) -> bool {
        matches!(self, Factor::Texture(..))
    }
}

/// What is known about a texture of the file.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// Its id in the document.
    key: String,
    /// Its value, if it is constant.
    constant: Option<Rgb>,
}

impl Translator<'_> {
    /// A colour that may be a texture, if given.
    pub(super) fn factor(&self, params: &Params, name: &'static str) -> Option<Factor> {
        if let Some(texture) = params.texture(name) {
            return self.folded(texture, false);
        }
        if let Some(color) = self.color(params, name, Meaning::Factor) {
            return Some(Factor::Constant(color));
        }
        params.number(name, self.report).map(Factor::grey)
    }

    /// A number that may be a texture, if given.
    pub(super) fn scalar(&self, params: &Params, name: &'static str) -> Option<Factor> {
        if let Some(texture) = params.texture(name) {
            return self.folded(texture, true);
        }
        params.number(name, self.report).map(Factor::grey)
    }

    /// A texture by its name; its value if it is constant. `None` if it does not exist and pbrt-v3 would go on.
    fn folded(&self, name: &Text, is_float: bool) -> Option<Factor> {
        match self.texture_named(&name.text, is_float) {
            Some(Known { constant: Some(constant), .. }) => Some(Factor::Constant(*constant)),
            None if self.is_v3 => {
                let message = format!("no texture is named `{}`: the default is used", name.text);
                self.report.warn(name.span, message);
                None
            }
            _ => Some(Factor::Texture(name.clone(), is_float)),
        }
    }

    /// A texture of this kind; otherwise of the other kind.
    fn texture_named(&self, name: &str, is_float: bool) -> Option<&Known> {
        let [first, second] = [is_float, !is_float].map(|kind| &self.textures[usize::from(kind)]);
        first.get(name).or_else(|| second.get(name))
    }

    /// Give an object a parameter that may be a texture.
    pub(super) fn set_factor(&mut self, object: ObjectId, name: &str, factor: &Factor, span: Span) {
        match factor {
            Factor::Constant(c) => self.doc.set(object, name, span, Value::Color(*c)),
            Factor::Texture(text, is_float) => {
                let known =
                    self.texture_named(&text.text, *is_float).map(|known| known.key.clone());
                let key = known.unwrap_or_else(|| {
                    // pbrt-v4 accepts textures that are defined later.
                    let key = key(&text.text, *is_float, 0);
                    self.wanted.push((key.clone(), text.clone(), "texture"));
                    key
                });
                self.doc.refer(object, name, text.span, &key);
            }
        }
    }

    /// `Texture`: define a texture by its name.
    pub(super) fn define_texture(&mut self, name: &Text, kind: &Text, params: &Params) {
        let is_float = match kind.text.as_str() {
            "float" => true,
            "spectrum" | "color" => false,
            other => {
                let message = format!("a texture of `{other}`");
                self.report.error(kind.span, message, "expected `float` or `spectrum`");
                return;
            }
        };
        let taken = self.textures[usize::from(is_float)].contains_key(&name.text);
        if taken && !self.is_v3 {
            let message = format!("a texture named `{}` exists already", name.text);
            self.report.error(name.span, message, "");
            return;
        }
        // In pbrt-v3 a texture replaces the one before it, but not in what uses that one already.
        let version = if taken { self.next_number() } else { 0 };
        let key = key(&name.text, is_float, version);
        let made = self.texture(params, is_float);
        params.report_unused(self.report);
        let Some(factor) = made else { return };
        let constant = match factor {
            Made::Constant(c) => Some(c),
            Made::Object(object) => {
                self.doc.register(object, &key, None);
                self.doc.nest(self.scene, "", object);
                None
            }
            Made::Same(other, other_float) => {
                let other = self.texture_named(&other.text, other_float).cloned();
                if let Some(known) = other {
                    self.textures[usize::from(is_float)].insert(name.text.clone(), known);
                }
                return;
            }
        };
        self.textures[usize::from(is_float)].insert(name.text.clone(), Known { key, constant });
    }

    fn texture(&mut self, params: &Params, is_float: bool) -> Option<Made> {
        let read = |this: &Self, name, default: f64| {
            let factor =
                if is_float { this.scalar(params, name) } else { this.factor(params, name) };
            factor.unwrap_or(Factor::grey(default))
        };
        let approximated = |this: &Self, by: &str| {
            let kind = &params.plugin;
            this.report.warn(params.span, format!("texture `{kind}` is approximated by {by}"));
        };
        Some(match params.plugin.as_str() {
            "constant" => Made::of(read(self, "value", 1.0)),
            "imagemap" => Made::Object(self.imagemap(params)?),
            "checkerboard" => {
                if params.integer("dimension", self.report) == Some(3) {
                    approximated(self, "the one in two dimensions");
                }
                params.ignore(&["aamode"]);
                let tiles = [read(self, "tex1", 1.0), read(self, "tex2", 0.0)];
                Made::Object(self.checkerboard(params, &tiles))
            }
            "scale" => {
                let first = if self.is_v3 { "tex1" } else { "tex" };
                let second = if self.is_v3 { "tex2" } else { "scale" };
                let pair = [
                    read(self, first, 1.0),
                    self.factor(params, second).unwrap_or(Factor::grey(1.0)),
                ];
                self.product(params, pair)
            }
            "mix" | "directionmix" => {
                params.ignore(&["dir"]);
                let amount = self.scalar(params, "amount").unwrap_or(Factor::grey(0.5));
                self.mixed(params, [read(self, "tex1", 0.0), read(self, "tex2", 1.0)], &amount)
            }
            "bilerp" => {
                approximated(self, "its mean");
                let corners = [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)];
                let sum = corners.map(|(name, default)| match read(self, name, default) {
                    Factor::Constant(c) => c,
                    Factor::Texture(..) => Rgb::grey(0.5),
                });
                Made::Constant((sum[0] + sum[1] + sum[2] + sum[3]) * 0.25)
            }
            "dots" => {
                approximated(self, "its `outside`");
                params.ignore(&["inside"]);
                Made::of(read(self, "outside", 0.0))
            }
            "fbm" | "wrinkled" | "windy" | "ptex" | "marble" => {
                approximated(self, "the constant 0.5");
                params.ignore(&["octaves", "roughness", "scale", "variation"]);
                params.ignore(&["filename", "encoding"]);
                Made::Constant(Rgb::grey(0.5))
            }
            "uv" => {
                approximated(self, "its mean");
                Made::Constant(Rgb::new(0.5, 0.5, 0.0))
            }
            _ => {
                params.unknown_plugin(&KNOWN, self.report);
                return None;
            }
        })
    }

    /// A texture object without parameters.
    pub(super) fn plain_texture(&mut self, params: &Params, plugin: &str) -> ObjectId {
        self.doc.add(Class::Texture, "texture", plugin, params.span)
    }

    /// A texture times a factor.
    pub(super) fn scaled(&mut self, texture: ObjectId, factor: Rgb, span: Span) -> ObjectId {
        let scale = self.doc.add(Class::Texture, "texture", "scale", span);
        self.doc.set(scale, "scale", span, Value::Color(factor));
        self.doc.nest(scale, "", texture);
        scale
    }

    fn checkerboard(&mut self, params: &Params, tiles: &[Factor; 2]) -> ObjectId {
        let texture = self.doc.add(Class::Texture, "texture", "checkerboard", params.span);
        // A period of Mitsuba's has two squares.
        let half = DAffine3::from_scale(DVec3::new(0.5, 0.5, 1.0));
        let to_uv = half * self.mapping(params, false);
        self.doc.set(texture, "to_uv", params.span, Value::transform(to_uv));
        for (name, tile) in ["color0", "color1"].into_iter().zip(tiles) {
            self.set_factor(texture, name, tile, params.span);
        }
        texture
    }

    fn product(&mut self, params: &Params, pair: [Factor; 2]) -> Made {
        match pair {
            [Factor::Constant(a), Factor::Constant(b)] => {
                Made::Constant((a * b).map(|v| v.clamp(-MAX_NUMBER, MAX_NUMBER)))
            }
            [Factor::Texture(texture, kind), Factor::Constant(c)]
            | [Factor::Constant(c), Factor::Texture(texture, kind)] => {
                let scale = self.doc.add(Class::Texture, "texture", "scale", params.span);
                self.doc.set(scale, "scale", params.span, Value::Color(c));
                self.set_factor(scale, "", &Factor::Texture(texture, kind), params.span);
                Made::Object(scale)
            }
            [Factor::Texture(first, kind), Factor::Texture(..)] => {
                let message = "the product of two textures is approximated by the first";
                self.report.warn(params.span, message);
                Made::Same(first, kind)
            }
        }
    }

    fn mixed(&mut self, params: &Params, pair: [Factor; 2], amount: &Factor) -> Made {
        let weight = match amount {
            Factor::Constant(c) => c.mean().clamp(0.0, 1.0),
            Factor::Texture(..) => 0.5,
        };
        if let ([Factor::Constant(a), Factor::Constant(b)], false) = (&pair, amount.is_texture()) {
            return Made::Constant(a.lerp(*b, weight));
        }
        let message = "the mixture of textures is approximated by the one with the greater weight";
        self.report.warn(params.span, message);
        let [first, second] = pair;
        Made::of(if weight <= 0.5 { first } else { second })
    }
}

/// A texture that was just read.
enum Made {
    Constant(Rgb),
    Object(ObjectId),
    /// The same as another texture of the file.
    Same(Text, bool),
}

impl Made {
    fn of(factor: Factor) -> Self {
        match factor {
            Factor::Constant(c) => Made::Constant(c),
            Factor::Texture(name, kind) => Made::Same(name, kind),
        }
    }
}

/// A texture's id in the document.
fn key(name: &str, is_float: bool, version: usize) -> String {
    let kind = if is_float { "float" } else { "spectrum" };
    format!("{kind} texture {version} {name}")
}

/// Whether a parameter is a texture.
pub(super) fn is_texture(p: &Param) -> bool {
    p.kind == Type::Texture
}
