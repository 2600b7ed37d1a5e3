//! Colours and spectra, reduced to linear Rec. 709.
//!
//! pbrt-v4 scales the spectrum of every light to a luminance of one before it applies the light's own factors. An RGB
//! colour keeps its values: `rgb L [r g b]` emits the radiance (r, g, b).

use gi_core::math::Rgb;
use glam::{DMat3, DVec3};

use super::Translator;
use super::params::{Param, Params};
use super::types::{Text, Type, Values};
use crate::document::Meaning;
use crate::files;
use crate::materials::ior;
use crate::spectrum::{Spectrum, xyz_to_rgb};
use crate::value;

/// The colour space of RGB colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ColorSpace {
    #[default]
    Srgb,
    Rec2020,
    DciP3,
    Aces,
}

impl ColorSpace {
    /// The names of all colour spaces.
    pub(super) const NAMES: [&'static str; 4] = ["srgb", "rec2020", "dci-p3", "aces2065-1"];

    /// The colour space of that name.
    pub(super) fn named(name: &str) -> Option<ColorSpace> {
        let all = [ColorSpace::Srgb, ColorSpace::Rec2020, ColorSpace::DciP3, ColorSpace::Aces];
        let k = Self::NAMES.iter().position(|n| n.eq_ignore_ascii_case(name))?;
        Some(all[k])
    }

    /// Chromaticities of red, green, blue and white \[ITU-R BT.2020, SMPTE RP 431-2, SMPTE ST 2065-1\].
    fn chromaticities(self) -> [[f64; 2]; 4] {
        const D65: [f64; 2] = [0.3127, 0.3290];
        match self {
            ColorSpace::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], D65],
            ColorSpace::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65],
            ColorSpace::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65],
            ColorSpace::Aces => {
                [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]]
            }
        }
    }

    /// The colour of its white as light.
    pub(super) fn white(self) -> Rgb {
        self.to_rec709([1.0; 3], Meaning::Light)
    }

    /// A colour in linear Rec. 709. White as a factor stays white, whatever the white point.
    fn to_rec709(self, [r, g, b]: [f64; 3], meaning: Meaning) -> Rgb {
        if self == ColorSpace::Srgb {
            return Rgb::new(r as f32, g as f32, b as f32);
        }
        let [red, green, blue, white] = self.chromaticities().map(xyz_of);
        let primaries = DMat3::from_cols(red, green, blue);
        let weights = primaries.inverse() * white;
        let rgb_of = |c: DVec3| xyz_to_rgb((primaries * (weights * c)).to_array());
        let color = rgb_of(DVec3::new(r, g, b));
        match meaning {
            Meaning::Light => color.map(|v| v.max(0.0)),
            Meaning::Factor => color.zip(rgb_of(DVec3::ONE), |c, w| (c / w).max(0.0)),
        }
    }
}

/// XYZ of a chromaticity, with a luminance of one.
fn xyz_of([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Chromaticities of the standard illuminants \[CIE 15\] and of the white of ACES.
const ILLUMINANTS: [(&str, [f64; 2]); 16] = [
    ("stdillum-A", [0.44758, 0.40745]),
    ("stdillum-D50", [0.34567, 0.35851]),
    ("stdillum-D65", [0.31272, 0.32903]),
    ("stdillum-F1", [0.31310, 0.33727]),
    ("stdillum-F2", [0.37208, 0.37529]),
    ("stdillum-F3", [0.40910, 0.39430]),
    ("stdillum-F4", [0.44018, 0.40329]),
    ("stdillum-F5", [0.31379, 0.34531]),
    ("stdillum-F6", [0.37790, 0.38835]),
    ("stdillum-F7", [0.31292, 0.32933]),
    ("stdillum-F8", [0.34588, 0.35875]),
    ("stdillum-F9", [0.37417, 0.37281]),
    ("stdillum-F10", [0.34609, 0.35986]),
    ("stdillum-F11", [0.38052, 0.37713]),
    ("stdillum-F12", [0.43695, 0.40441]),
    ("illum-acesD60", [0.32168, 0.33767]),
];

/// Glasses: index of refraction at the helium line, from their makers' catalogues.
const GLASSES: [(&str, f32); 7] = [
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.67),
    ("glass-FK51A", 1.48656),
    ("glass-LASF9", 1.85025),
    ("glass-F5", 1.67271),
    ("glass-F10", 1.72828),
    ("glass-F11", 1.78472),
];

/// Brass, which Mitsuba's list of conductors lacks: (eta, k) as commonly tabulated.
const BRASS: [Rgb; 2] = [Rgb::new(0.444, 0.527, 1.094), Rgb::new(3.695, 2.765, 1.829)];

/// The colour of a spectrum that pbrt knows by name.
fn named(name: &str, meaning: Meaning) -> Option<Rgb> {
    if let Some((_, xy)) = ILLUMINANTS.iter().find(|(known, _)| *known == name) {
        let color = xyz_to_rgb(xyz_of(*xy).to_array());
        return Some(if meaning == Meaning::Light { color } else { Rgb::WHITE });
    }
    // pbrt lists the dense flints under these names, and accepts those of the catalogue too.
    let plain = name.replace("-SF", "-F");
    if let Some((_, eta)) = GLASSES.iter().find(|(known, _)| *known == plain) {
        return Some(Rgb::grey(*eta));
    }
    let (metal, which) = name.strip_prefix("metal-")?.rsplit_once('-')?;
    metal_of(metal, which)
}

/// `eta` or `k` of a metal.
fn metal_of(metal: &str, which: &str) -> Option<Rgb> {
    let [eta, k] = match metal {
        "CuZn" => BRASS,
        _ => {
            let (eta, k) = ior::conductor(metal)?;
            [eta, k]
        }
    };
    match which {
        "eta" => Some(eta),
        "k" => Some(k),
        _ => None,
    }
}

/// The metal of a file such as `spds/Cu.eta.spd` of pbrt-v3, which scenes often come without.
fn metal_file(name: &str) -> Option<Rgb> {
    let file = name.rsplit(['/', '\\']).next()?.strip_suffix(".spd")?;
    let (metal, which) = file.split_once('.')?;
    metal_of(metal, which)
}

/// Light of a luminance of one with the colour of this light.
fn unit_luminance(color: Rgb) -> Rgb {
    let y = color.luminance();
    if y > 0.0 { color / y } else { color }
}

impl Translator<'_> {
    /// A colour that a parameter gives as RGB, spectrum or temperature; `None` if it is not given, or after an error.
    pub(super) fn color(
        &self,
        params: &Params,
        name: &'static str,
        meaning: Meaning,
    ) -> Option<Rgb> {
        let is_color =
            |p: &Param| matches!(p.kind, Type::Rgb | Type::Xyz | Type::Spectrum | Type::Blackbody);
        let p = params.find(name, is_color)?;
        let color = match &p.values {
            Values::Numbers(all) => self.numbers_color(p.kind, all, meaning),
            Values::Texts(all) => self.spectrum_by_name(all.first()?, meaning),
            Values::Bools(_) => Err("booleans are not a colour".to_owned()),
        };
        match color {
            Ok(color) if color.to_array().iter().all(|v| v.abs() <= value::MAX_NUMBER) => {
                Some(color)
            }
            Ok(_) => {
                self.report.error(p.span, format!("`{name}` is too large"), "expected up to 1e15");
                None
            }
            Err(why) => {
                self.report.error(p.span, why, "expected a colour");
                None
            }
        }
    }

    fn numbers_color(&self, kind: Type, all: &[f64], meaning: Meaning) -> Result<Rgb, String> {
        match (kind, all) {
            (Type::Rgb, &[r, g, b]) => Ok(self.state.now.color_space.to_rec709([r, g, b], meaning)),
            (Type::Xyz, &[x, y, z]) => Ok(xyz_to_rgb([x, y, z])),
            (Type::Blackbody, &[kelvin]) => Ok(self.blackbody(kelvin, 1.0)),
            (Type::Blackbody, &[kelvin, scale]) => Ok(self.blackbody(kelvin, scale)),
            (Type::Spectrum, _) if all.len() >= 2 && all.len().is_multiple_of(2) => {
                let pairs = all.chunks_exact(2).map(|p| (p[0] as f32, p[1] as f32));
                self.pairs_color(pairs.collect(), meaning)
            }
            (_, other) => Err(format!("{} numbers are not a colour", other.len())),
        }
    }

    fn pairs_color(&self, pairs: Vec<(f32, f32)>, meaning: Meaning) -> Result<Rgb, String> {
        if !pairs.is_sorted_by(|a, b| a.0 < b.0) {
            return Err("the wavelengths are not in ascending order".into());
        }
        self.note_spectra();
        let spectrum = Spectrum::Pairs(pairs);
        Ok(match meaning {
            Meaning::Factor => spectrum.reflectance(),
            Meaning::Light if self.is_v3 => spectrum.emission(),
            Meaning::Light => unit_luminance(spectrum.emission()),
        })
    }

    /// The colour of a black body: of luminance one in pbrt-v4, of a peak of one in pbrt-v3.
    fn blackbody(&self, kelvin: f64, scale: f64) -> Rgb {
        self.note_spectra();
        if kelvin <= 0.0 {
            return Rgb::BLACK;
        }
        let kelvin = kelvin as f32;
        let emission = Spectrum::Blackbody { kelvin, scale: 1.0 }.emission();
        let peak = if self.is_v3 {
            // Wien's law: the peak is 4.0957e-6 T^5 W / (m^3 sr).
            4.0957e-15 * kelvin.powi(5)
        } else {
            emission.luminance()
        };
        let unit = if peak > 0.0 { emission / peak } else { Rgb::BLACK };
        unit * scale as f32
    }

    /// The colour of a named spectrum, or of a spectrum file.
    fn spectrum_by_name(&self, name: &Text, meaning: Meaning) -> Result<Rgb, String> {
        self.note_spectra();
        if let Some(color) = named(&name.text, meaning) {
            return Ok(color);
        }
        let Some(path) = self.doc.locate(&name.text, name.span, self.report) else {
            return metal_file(&name.text).ok_or_else(|| {
                format!("cannot find `{}`, which is no known spectrum either", name.text)
            });
        };
        self.report.reads(&path);
        let mut claim = self.report.budget.claim(path.display());
        let text = files::read_text(&path, &mut claim)?;
        self.spectrum_files.borrow_mut().bytes(text.as_bytes());
        let lines = text.lines().map(|l| l.split('#').next().unwrap_or_default());
        let words: Vec<&str> = lines.flat_map(value::words).collect();
        let numbers = value::numbers(&words.join(" "))?;
        if numbers.is_empty() || !numbers.len().is_multiple_of(2) {
            return Err(format!("`{}` has {} numbers", name.text, numbers.len()));
        }
        self.pairs_color(numbers.chunks_exact(2).map(|p| (p[0], p[1])).collect(), meaning)
    }

    fn note_spectra(&self) {
        if !self.noted_spectra.replace(true) {
            self.report.warn_nowhere("spectra are reduced to linear Rec. 709 colours");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: [f32; 3]) {
        for (x, y) in a.to_array().into_iter().zip(b) {
            assert!((x - y).abs() < 2e-3, "{a:?} is not {b:?}");
        }
    }

    #[test]
    fn white_keeps_its_colour_as_a_factor_and_has_its_illuminant_as_light() {
        for space in [ColorSpace::Rec2020, ColorSpace::DciP3, ColorSpace::Aces] {
            near(space.to_rec709([0.5; 3], Meaning::Factor), [0.5; 3]);
        }
        near(ColorSpace::Rec2020.to_rec709([1.0; 3], Meaning::Light), [1.0; 3]);
        let warm = ColorSpace::Aces.to_rec709([1.0; 3], Meaning::Light);
        assert!(warm.r > 1.02 && warm.b < 0.96, "{warm:?}");
    }

    #[test]
    fn the_primaries_of_rec_2020_lie_outside_those_of_rec_709() {
        // ITU-R BT.2087: linear BT.2020 to BT.709.
        let green = ColorSpace::Rec2020.to_rec709([0.3, 0.8, 0.3], Meaning::Light);
        let expected = |m: [f32; 3]| m[0] * 0.3 + m[1] * 0.8 + m[2] * 0.3;
        let rows = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083]];
        assert!((green.r - expected(rows[0]).max(0.0)).abs() < 2e-3, "{green:?}");
        assert!((green.g - expected(rows[1])).abs() < 2e-3, "{green:?}");
    }

    #[test]
    fn names_of_spectra_are_known() {
        near(named("stdillum-D65", Meaning::Light).unwrap(), [1.0; 3]);
        let aces = named("illum-acesD60", Meaning::Light).unwrap();
        assert!(
            aces.r > aces.g && aces.g > aces.b && (aces.luminance() - 1.0).abs() < 1e-3,
            "{aces:?}"
        );
        assert_eq!(named("metal-Cu-k", Meaning::Factor), metal_file("spds/Cu.k.spd"));
        assert_eq!(named("glass-SF11", Meaning::Factor), Some(Rgb::grey(1.78472)));
        assert!(named("metal-Cu-z", Meaning::Factor).is_none());
        assert!(named("glass", Meaning::Factor).is_none());
    }
}
