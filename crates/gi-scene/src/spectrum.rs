//! Converts spectra to linear Rec. 709.

mod observer;

use gi_core::math::Rgb;

use observer::matching;

/// Range of visible wavelengths, nanometres (Mitsuba's limits).
const RANGE: (f32, f32) = (360.0, 830.0);
/// Step of the quadrature, nanometres. The matching curves change over tens of nanometres.
const STEP: f32 = 1.0;

/// The equal-energy spectrum of value 1 in linear Rec. 709 (Mitsuba's figures, from the tabulated observer). Mitsuba 3
/// gives emission this colour if it is a single number.
pub(crate) const EQUAL_ENERGY: Rgb = Rgb::new(1.204_794, 0.948_291, 0.908_916);

/// A spectrum as given in a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Spectrum {
    /// The same at all wavelengths.
    Flat(f32),
    /// `(nanometres, value)` in rising order; linear in between, zero outside.
    Pairs(Vec<(f32, f32)>),
    /// A black body at this temperature, times a factor; W / (m^2 sr nm).
    Blackbody { kelvin: f32, scale: f32 },
}

impl Spectrum {
    /// The value at a wavelength in nanometres.
    fn at(&self, nm: f32) -> f32 {
        match self {
            Spectrum::Flat(v) => *v,
            Spectrum::Pairs(pairs) => interpolate(pairs, nm),
            Spectrum::Blackbody { kelvin, scale } => scale * planck(nm, *kelvin),
        }
    }

    /// The colour of light with this spectrum.
    pub(crate) fn emission(&self) -> Rgb {
        match self {
            Spectrum::Flat(v) => EQUAL_ENERGY * *v,
            // Narrow spectra lie outside the gamut of Rec. 709: clamp to the nearest colour inside.
            _ => {
                let rgb = xyz_to_rgb(integrate(|nm| self.at(nm)));
                if self.is_negative() { rgb } else { rgb.map(|v| v.max(0.0)) }
            }
        }
    }

    /// Whether any value is negative.
    fn is_negative(&self) -> bool {
        match self {
            Spectrum::Flat(v) => *v < 0.0,
            Spectrum::Pairs(pairs) => pairs.iter().any(|p| p.1 < 0.0),
            Spectrum::Blackbody { kelvin, scale } => *kelvin < 0.0 || *scale < 0.0,
        }
    }

    /// The colour of a surface (or of an index of refraction) with this spectrum: the reflected colour of daylight D65,
    /// divided by that of D65. A constant spectrum gives grey.
    pub(crate) fn reflectance(&self) -> Rgb {
        match self {
            Spectrum::Flat(v) => Rgb::grey(*v),
            _ => {
                let lit = xyz_to_rgb(integrate(|nm| self.at(nm) * daylight(nm)));
                let white = xyz_to_rgb(integrate(daylight));
                lit.zip(white, |a, b| (a / b).max(0.0))
            }
        }
    }
}

/// Linear interpolation in rising pairs; zero outside.
fn interpolate(pairs: &[(f32, f32)], x: f32) -> f32 {
    let next = pairs.partition_point(|p| p.0 <= x);
    match (pairs.get(next.wrapping_sub(1)), pairs.get(next)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        (Some(a), None) if a.0 == x => a.1,
        _ => 0.0,
    }
}

/// Planck's law, W / (m^2 sr nm).
fn planck(nm: f32, kelvin: f32) -> f32 {
    const C1: f64 = 1.191_042_97e-16; // 2 h c^2, W m^2 / sr
    const C2: f64 = 1.438_776_88e-2; // h c / k, m K
    let m = f64::from(nm) * 1e-9;
    (1e-9 * C1 / (m.powi(5) * ((C2 / (m * f64::from(kelvin))).exp() - 1.0))) as f32
}

/// XYZ of a spectrum, divided by the integral of the luminosity curve.
fn integrate(spectrum: impl Fn(f32) -> f32) -> [f64; 3] {
    let steps = ((RANGE.1 - RANGE.0) / STEP) as usize;
    let (mut xyz, mut unit) = ([0f64; 3], 0f64);
    for i in 0..steps {
        let nm = RANGE.0 + (i as f32 + 0.5) * STEP;
        let (m, s) = (matching(nm), f64::from(spectrum(nm)));
        (0..3).for_each(|k| xyz[k] += s * f64::from(m[k]));
        unit += f64::from(m[1]);
    }
    xyz.map(|v| v / unit)
}

/// XYZ to linear Rec. 709 \[ITU-R BT.709, D65\].
pub(crate) fn xyz_to_rgb([x, y, z]: [f64; 3]) -> Rgb {
    Rgb::new(
        (3.240_479 * x - 1.537_150 * y - 0.498_535 * z) as f32,
        (-0.969_256 * x + 1.875_991 * y + 0.041_556 * z) as f32,
        (0.055_648 * x - 0.204_043 * y + 1.057_311 * z) as f32,
    )
}

/// Relative power of daylight D65 \[CIE 15\], every ten nanometres from 360.
const D65: [f32; 48] = [
    46.64, 52.09, 49.98, 54.65, 82.75, 91.49, 93.43, 86.68, 104.87, 117.01, 117.81, 114.86, 115.92,
    108.81, 109.35, 107.80, 104.79, 107.69, 104.41, 104.05, 100.00, 96.33, 95.79, 88.69, 90.01,
    89.60, 87.70, 83.29, 83.70, 80.03, 80.21, 82.28, 78.28, 69.72, 71.61, 74.35, 61.60, 69.89,
    75.09, 63.59, 46.42, 66.81, 63.38, 64.30, 59.45, 51.96, 57.44, 60.31,
];

fn daylight(nm: f32) -> f32 {
    let t = ((nm - 360.0) / 10.0).clamp(0.0, 46.999);
    let i = t as usize;
    D65[i] + (D65[i + 1] - D65[i]) * (t - i as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: [f32; 3], tolerance: f32) {
        for (x, y) in a.to_array().into_iter().zip(b) {
            assert!((x - y).abs() <= tolerance, "{a:?} is not {b:?}");
        }
    }

    #[test]
    fn a_constant_reflectance_is_grey() {
        assert_eq!(Spectrum::Flat(0.3).reflectance(), Rgb::grey(0.3));
        let flat = Spectrum::Pairs(vec![(300.0, 0.3), (900.0, 0.3)]);
        near(flat.reflectance(), [0.3; 3], 1e-4);
    }

    #[test]
    fn constant_emission_has_the_colour_of_equal_energy() {
        let flat = Spectrum::Pairs(vec![(300.0, 2.0), (900.0, 2.0)]);
        near(flat.emission(), (EQUAL_ENERGY * 2.0).to_array(), 1e-3);
    }

    #[test]
    fn a_lamp_given_by_wavelengths_has_the_colour_of_mitsuba() {
        // Values from Mitsuba 3.9.1. A former fit of the observer was 0.4 % high in green.
        let lamp = Spectrum::Pairs(vec![(400.0, 0.0), (500.0, 0.8), (600.0, 1.56), (700.0, 1.84)]);
        near(lamp.emission(), [2.071_08, 1.085_46, 0.277_115], 1e-3);
    }

    #[test]
    fn daylight_is_white() {
        let xyz = integrate(daylight);
        let (x, y) = (xyz[0] / xyz.iter().sum::<f64>(), xyz[1] / xyz.iter().sum::<f64>());
        assert!((x - 0.3127).abs() < 2e-3 && (y - 0.3290).abs() < 2e-3, "{x} {y}");
    }

    #[test]
    fn a_black_body_radiates_as_planck_says() {
        // Wien's law: the peak of 5000 K is at 579.6 nm, where B = 4.0957e-6 T^5 W / (m^3 sr).
        let peak = planck(579.6, 5000.0);
        assert!((peak / 12_799.0 - 1.0).abs() < 1e-3, "{peak}");
        assert!(planck(560.0, 5000.0) < peak && planck(600.0, 5000.0) < peak);
    }
}
