//! Colours of objects: properties, or spectra nested in them.

use gi_core::math::Rgb;

use super::{Class, Node, Value};
use crate::spectrum::{EQUAL_ENERGY, Spectrum};
use crate::value;

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

    /// One number or three that are no colour, as they are.
    pub(crate) fn raw(self, name: &'static str) -> Option<Rgb> {
        match &self.find(name)?.value {
            Value::Vector(v) => Some(Rgb::from(v.as_vec3().to_array())),
            _ => self.color(name, Meaning::Factor),
        }
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
            // Mitsuba 2 names the colour `color`, and the product of a colour and daylight `srgb_d65`.
            "srgb" if self.has("color") => self.color("color", meaning),
            "d65" | "srgb_d65" => {
                let scale = self.float("scale", 1.0) * self.float("value", 1.0);
                Some(self.color("color", Meaning::Factor).unwrap_or(Rgb::WHITE) * scale)
            }
            "regular" | "irregular" | "interpolated" => {
                let spectrum = self.samples()?;
                Some(if meaning == Meaning::Light {
                    spectrum.emission()
                } else {
                    spectrum.reflectance()
                })
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
                self.unknown_plugin(&[
                    "rgb",
                    "uniform",
                    "d65",
                    "blackbody",
                    "regular",
                    "irregular",
                ]);
                None
            }
        }
    }

    /// The spectrum of `regular` and `irregular`: lists of numbers. Mitsuba 2 calls `regular` `interpolated` and its ends
    /// `lambda_min` and `lambda_max`. `None` if an error was reported.
    fn samples(self) -> Option<Spectrum> {
        let list = |name| match self.text(name).map(value::numbers) {
            Some(Ok(numbers)) if !numbers.is_empty() => Some(numbers),
            Some(Err(why)) => {
                self.report.error(self.span_of(name), why, "expected numbers");
                None
            }
            _ => {
                self.error(format!("`{}` without `{name}`", self.plugin()), "");
                None
            }
        };
        let values = list("values")?;
        let wavelengths = if self.plugin() == "irregular" {
            list("wavelengths")?
        } else {
            let end = |new, old, default| self.float(new, self.float(old, default));
            let (first, last) = (
                end("wavelength_min", "lambda_min", 360.0),
                end("wavelength_max", "lambda_max", 830.0),
            );
            let steps = (values.len() - 1).max(1) as f32;
            (0..values.len()).map(|k| first + (last - first) * k as f32 / steps).collect()
        };
        if wavelengths.len() != values.len() || !wavelengths.is_sorted_by(|a, b| a < b) {
            let message = format!("{} wavelengths for {} values", wavelengths.len(), values.len());
            self.error(message, "expected one wavelength per value, in ascending order");
            return None;
        }
        Some(Spectrum::Pairs(wavelengths.into_iter().zip(values).collect()))
    }
}
