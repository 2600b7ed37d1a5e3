//! Colours of objects: properties, or spectra nested in them.

use gi_core::math::Rgb;

use super::{Class, Node, Value};
use crate::spectrum::{EQUAL_ENERGY, Spectrum};

/// What a colour's spectrum describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// A reflectance or another factor on light, or an index of refraction.
    Factor,
    /// Emitted light.
    Light,
}

impl Node<'_> {
    /// A colour, given as a property or as a `<spectrum type=...>` child.
    pub(crate) fn color(self, name: &'static str, meaning: Meaning) -> Option<Rgb> {
        if let Some(p) = self.find(name) {
            let color = self.value_color(&p.value, meaning);
            if color.is_none() {
                self.wrong_kind(p, "a colour");
            }
            return color;
        }
        let child = self.child_if(name, |n| n.class() == Class::Spectrum)?;
        child.spectrum_child(meaning)
    }

    fn value_color(self, value: &Value, meaning: Meaning) -> Option<Rgb> {
        Some(match value {
            Value::Color(c) => *c,
            Value::Float(x) => Rgb::grey(*x),
            Value::Integer(i) => Rgb::grey(*i as f32),
            // The RGB build of Mitsuba 0.6 reads a single number as grey light, Mitsuba 3 as an equal-energy spectrum.
            Value::Spectrum(Spectrum::Flat(x)) if self.doc.version == 0 => Rgb::grey(*x),
            Value::Spectrum(s) if meaning == Meaning::Light => s.emission(),
            Value::Spectrum(s) => s.reflectance(),
            _ => return None,
        })
    }

    /// The colour of a `<spectrum type=...>` object.
    pub(crate) fn spectrum_child(self, meaning: Meaning) -> Option<Rgb> {
        match self.plugin() {
            "rgb" | "srgb" | "uniform" | "regular" | "irregular" if self.has("value") => {
                self.color("value", meaning)
            }
            "d65" => {
                let scale = self.float("scale", 1.0) * self.float("value", 1.0);
                Some(self.color("color", Meaning::Factor).unwrap_or(Rgb::WHITE) * scale)
            }
            "uniform" => {
                let v = self.float("value", 1.0);
                Some(if meaning == Meaning::Light { EQUAL_ENERGY * v } else { Rgb::grey(v) })
            }
            "blackbody" => {
                let kelvin = self.float("temperature", 5000.0);
                let body = Spectrum::Blackbody { kelvin, scale: self.float("scale", 1.0) };
                Some(body.emission())
            }
            _ => {
                self.unknown_plugin(&["rgb", "uniform", "d65", "blackbody"]);
                None
            }
        }
    }
}
