//! Properties that must lie in a range; otherwise an error is reported at their place.

use std::ops::RangeInclusive;

use gi_core::math::Rgb;

use super::{Meaning, Node};
use crate::value::MAX_NUMBER;

/// Smallest number accepted as positive: the squares of smaller ones underflow.
const SMALLEST: f32 = 1e-12;

impl Node<'_> {
    /// A number in a range. Outside the range, an error is reported and the default is returned.
    pub(crate) fn within(
        self,
        name: &'static str,
        default: f32,
        range: RangeInclusive<f32>,
    ) -> f32 {
        let value = self.float(name, default);
        if range.contains(&value) {
            return value;
        }
        let expected = match (*range.start(), *range.end()) {
            (low, MAX_NUMBER) => format!("expected {low} or more"),
            (low, high) => format!("expected {low} to {high}"),
        };
        self.report.error(self.span_of(name), format!("{name} {value}"), &expected);
        default
    }

    /// A positive number up to `most`. Otherwise an error is reported and the default is returned.
    pub(crate) fn above_zero(self, name: &'static str, default: f32, most: f32) -> f32 {
        let value = self.float(name, default);
        if (SMALLEST..=most).contains(&value) {
            return value;
        }
        let expected = if most == MAX_NUMBER {
            "expected more than 0".to_owned()
        } else {
            format!("expected more than 0 and at most {most}")
        };
        self.report.error(self.span_of(name), format!("{name} {value}"), &expected);
        default
    }

    /// A non-negative factor on emitted light.
    pub(crate) fn light_scale(self, name: &'static str, default: f32) -> f32 {
        let value = self.float(name, default);
        if value < 0.0 {
            self.negative_light(name, &value.to_string());
            return default;
        }
        value
    }

    /// A colour of emitted light, if given: non-negative and at most 1e15.
    pub(crate) fn light(self, name: &'static str) -> Option<Rgb> {
        let color = self.color(name, Meaning::Light)?;
        let fine = self.check_light(name, color);
        fine.then_some(color)
    }

    /// Whether a colour is valid for emitted light; reports an error if it is not.
    pub(crate) fn check_light(self, name: &'static str, color: Rgb) -> bool {
        let [r, g, b] = color.to_array();
        if r.min(g).min(b) < 0.0 {
            self.negative_light(name, &format!("{r} {g} {b}"));
            return false;
        }
        if ![r, g, b].iter().all(|v| *v <= MAX_NUMBER) {
            let message = format!("`{name}` is too large: {r} {g} {b}");
            self.report.error(self.place_of(name), message, "expected at most 1e15");
            return false;
        }
        true
    }

    fn negative_light(self, name: &'static str, value: &str) {
        let message = format!("light cannot be negative: `{name}` is {value}");
        self.report.error(self.place_of(name), message, "expected 0 or more");
    }

    /// Place of the property, or of the child with that name.
    pub(crate) fn place_of(self, name: &'static str) -> crate::diagnostics::Span {
        match self.child(name) {
            Some(child) if !self.has(name) => child.span(),
            _ => self.span_of(name),
        }
    }
}
