//! Reads material libraries (MTL) into entries. A statement that would change the picture but is not supported gives a
//! warning.

use gi_core::math::Rgb;

use crate::diagnostics::{Report, Span};
use crate::spectrum::xyz_to_rgb;
use crate::statements::{Statement, statements, without_comment};
use crate::value::{self, MAX_NUMBER};

/// A material as its library defines it.
#[derive(Clone, Debug, Default)]
pub(super) struct Entry {
    pub(super) name: String,
    /// Where the definition begins; `None` if no library defines the material.
    pub(super) span: Option<Span>,
    /// `Kd`, in [0, 1].
    pub(super) diffuse: Option<Rgb>,
    /// `Ks`, in [0, 1].
    pub(super) specular: Option<Rgb>,
    /// `Ke`.
    pub(super) emission: Option<Rgb>,
    /// `Tf`, in [0, 1].
    pub(super) filter: Option<Rgb>,
    /// `Ns`.
    pub(super) exponent: Option<f32>,
    /// `Ni`.
    pub(super) index: Option<f32>,
    /// `d`, or 1 - `Tr`.
    pub(super) opacity: Option<f32>,
    /// `illum`.
    pub(super) illumination: Option<i64>,
    /// `map_Kd`.
    pub(super) diffuse_map: Option<Map>,
    /// `map_Ke`.
    pub(super) emission_map: Option<Map>,
    /// `map_d`.
    pub(super) opacity_map: Option<Map>,
}

/// The arguments of a `map_*` statement: options and a file name.
#[derive(Clone, Debug)]
pub(super) struct Map {
    pub(super) text: String,
    pub(super) span: Span,
}

/// Statements without effect in a path tracer: ambient light, and filtering options of old displays.
const WITHOUT_EFFECT: [&str; 6] = ["ka", "map_ka", "map_aat", "sharpness", "xalpha", "map_kaat"];
/// Unsupported statements that would change the picture, most of them only with a value other than zero.
const IGNORED: [&str; 25] = [
    "map_ks", "map_ns", "map_ni", "map_tf", "map_tr", "map_refl", "refl", "bump", "map_bump",
    "norm", "map_norm", "map_kn", "disp", "map_disp", "decal", "pr", "map_pr", "pm", "map_pm",
    "ps", "map_ps", "pc", "pcr", "aniso", "anisor",
];

/// Read a library's text; `file` is its index in the report.
pub(super) fn parse(text: &str, file: usize, report: &Report) -> Vec<Entry> {
    let mut reader = Reader { report, file, entries: Vec::new() };
    statements(text.as_bytes()).for_each(|statement| reader.statement(&statement));
    reader.entries
}

struct Reader<'a> {
    report: &'a Report,
    file: usize,
    entries: Vec<Entry>,
}

impl Reader<'_> {
    fn statement(&mut self, statement: &Statement<'_>) {
        let span = Span { file: self.file, start: statement.range.start, end: statement.range.end };
        let (keyword, rest) = statement.split();
        let lower = keyword.to_ascii_lowercase();
        if lower == "newmtl" {
            let entry = Entry { name: rest.to_owned(), span: Some(span), ..Entry::default() };
            return self.entries.push(entry);
        }
        let Some(mut entry) = self.entries.pop() else {
            let message = format!("`{keyword}` before the first `newmtl`: ignored");
            return self.report.warn(span, message);
        };
        if let Err(why) = self.assign(&mut entry, &lower, keyword, rest, span) {
            // One absurd value must not refuse the whole file.
            let message = format!("material `{}`: `{keyword}`: {why}: ignored", entry.name);
            self.report.warn(span, message);
        }
        self.entries.push(entry);
    }

    /// Store the value of a statement in an entry.
    fn assign(
        &self,
        entry: &mut Entry,
        lower: &str,
        keyword: &str,
        rest: &str,
        span: Span,
    ) -> Result<(), String> {
        let place = Place { reader: self, keyword, span };
        // Exporters write `map_Kd` without a file name if there is no picture.
        let map = || (!rest.is_empty()).then(|| Map { text: rest.to_owned(), span });
        match lower {
            "kd" => entry.diffuse = place.share(rest)?.or(entry.diffuse),
            "ks" => entry.specular = place.share(rest)?.or(entry.specular),
            "tf" => entry.filter = place.share(rest)?.or(entry.filter),
            "ke" => entry.emission = place.light(rest, &entry.name)?.or(entry.emission),
            "ns" => entry.exponent = place.number(rest)?.or(entry.exponent),
            "ni" => entry.index = place.number(rest)?.or(entry.index),
            "d" => entry.opacity = place.opacity(rest)?.or(entry.opacity),
            // Some exporters write both `d` and `Tr`: `d` wins.
            "tr" => entry.opacity = entry.opacity.or(place.number(rest)?.map(|t| 1.0 - t)),
            "illum" => entry.illumination = place.illumination(rest)?,
            "map_kd" => entry.diffuse_map = map(),
            "map_ke" => entry.emission_map = map(),
            "map_d" => entry.opacity_map = map(),
            _ if WITHOUT_EFFECT.contains(&lower) => {}
            _ if IGNORED.contains(&lower) => place.ignored(rest),
            _ => place.warn(format!("unknown statement `{keyword}`: ignored")),
        }
        Ok(())
    }
}

/// The statement that is being read.
struct Place<'a> {
    reader: &'a Reader<'a>,
    keyword: &'a str,
    span: Span,
}

impl Place<'_> {
    fn warn(&self, message: impl AsRef<str>) {
        self.reader.report.warn(self.span, message);
    }

    fn ignored(&self, rest: &str) {
        let numbers = value::numbers(without_comment(rest));
        let nothing = rest.is_empty() || numbers.is_ok_and(|n| n.iter().all(|x| *x == 0.0));
        if !nothing {
            self.warn(format!("`{}` is ignored", self.keyword));
        }
    }

    /// One number; `None`, with a warning, if it is missing.
    fn number(&self, rest: &str) -> Result<Option<f32>, String> {
        match value::words(without_comment(rest)).next() {
            Some(word) => value::number(word).map(Some),
            None => {
                self.warn(format!("`{}` without a number: ignored", self.keyword));
                Ok(None)
            }
        }
    }

    /// `d`, optionally with `-halo`.
    fn opacity(&self, rest: &str) -> Result<Option<f32>, String> {
        let Some(halo) = rest.strip_prefix("-halo") else { return self.number(rest) };
        let opacity = self.number(halo)?;
        if opacity.is_some_and(|d| d < 1.0) {
            self.warn("`-halo` is ignored: the opacity is the same from all sides");
        }
        Ok(opacity)
    }

    /// An integer, which some exporters write as `2.0`.
    fn illumination(&self, rest: &str) -> Result<Option<i64>, String> {
        let Some(model) = self.number(rest)? else { return Ok(None) };
        if model.fract() == 0.0 && (0.0..=10.0).contains(&model) {
            return Ok(Some(model as i64));
        }
        self.warn(format!("`illum {model}` is not an illumination model (0 to 10): ignored"));
        Ok(None)
    }

    /// A colour: three numbers, one number for all three channels, or `xyz` and three numbers. `None` after a warning.
    fn color(&self, rest: &str) -> Result<Option<Rgb>, String> {
        let rest = without_comment(rest);
        let mut words = rest.split_whitespace();
        let first = words.next().unwrap_or_default().to_ascii_lowercase();
        if first == "spectral" {
            self.warn(format!("`{} spectral` is not supported: ignored", self.keyword));
            return Ok(None);
        }
        let xyz = first == "xyz";
        let numbers = value::numbers(if xyz { &rest["xyz".len()..] } else { rest })?;
        let values = match numbers.as_slice() {
            [] => {
                self.warn(format!("`{}` without a colour: ignored", self.keyword));
                return Ok(None);
            }
            [x] => [*x; 3],
            [x, y] => {
                let message = format!(
                    "`{}` has two numbers instead of one or three: the second is used as the third too",
                    self.keyword
                );
                self.warn(message);
                [*x, *y, *y]
            }
            [x, y, z, ..] => [*x, *y, *z],
        };
        Ok(Some(if xyz { xyz_to_rgb(values.map(f64::from)) } else { Rgb::from(values) }))
    }

    /// A reflectance or transmittance, in [0, 1].
    fn share(&self, rest: &str) -> Result<Option<Rgb>, String> {
        let Some(color) = self.color(rest)? else { return Ok(None) };
        let clamped = color.map(|v| v.clamp(0.0, 1.0));
        if clamped != color {
            self.warn(format!("`{}` is outside [0, 1]: clamped", self.keyword));
        }
        Ok(Some(clamped))
    }

    /// Emitted light.
    fn light(&self, rest: &str, material: &str) -> Result<Option<Rgb>, String> {
        let Some(color) = self.color(rest)? else { return Ok(None) };
        if color.to_array().iter().all(|v| (0.0..=MAX_NUMBER).contains(v)) {
            return Ok(Some(color));
        }
        let [r, g, b] = color.to_array();
        let message =
            format!("material `{material}`: light `Ke {r} {g} {b}` is not in 0 to 1e15: ignored");
        self.reader.report.warn(self.span, message);
        Ok(None)
    }
}

#[cfg(test)]
mod tests;
