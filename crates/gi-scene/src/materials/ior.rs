//! Indices of refraction by name.

use gi_core::math::Rgb;

use crate::document::Node;

/// Dielectrics: index at the sodium line, as listed by Mitsuba.
pub(crate) const DIELECTRICS: [(&str, f32); 24] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("glass-bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// Range of relative indices: wide enough for any material; far outside it, Fresnel's formulas lose all precision.
pub(crate) const RELATIVE: std::ops::RangeInclusive<f32> = 0.1..=10.0;

/// The index of a dielectric.
pub(crate) fn dielectric(name: &str) -> Option<f32> {
    let name = name.to_lowercase();
    DIELECTRICS.iter().find(|(n, _)| *n == name).map(|(_, eta)| *eta)
}

/// Conductors: (eta, k) of the public spectral tables (Palik and others), as Mitsuba 3 reduces them to linear
/// Rec. 709. Values below 1e-7 are written as zero.
#[rustfmt::skip]
pub(crate) const CONDUCTORS: [(&str, [f32; 3], [f32; 3]); 41] = [
    ("a-C", [2.944, 2.2271, 1.9682], [0.88746, 0.7993, 0.81529]),
    ("Ag", [0.15528, 0.11673, 0.13839], [4.8284, 3.1222, 2.1469]),
    ("Al", [1.6575, 0.8804, 0.52124], [9.2238, 6.2695, 4.837]),
    ("AlAs", [3.6053, 3.2329, 2.2163], [0.00067944, 0.0, 0.0075127]),
    ("AlSb", [0.0, 4.1394, 4.6693], [0.0, 0.094009, 1.3006]),
    ("Au", [0.14304, 0.37531, 1.442], [3.983, 2.3856, 1.6034]),
    ("Be", [4.185, 3.185, 2.7841], [3.8355, 3.0101, 2.869]),
    ("Cr", [4.3697, 2.9165, 1.6549], [5.2065, 4.2313, 3.7547]),
    ("CsI", [2.1449, 1.7023, 1.6624], [0.0, 0.0, 0.0]),
    ("Cu", [0.20101, 0.92375, 1.1022], [3.9133, 2.453, 2.1421]),
    ("Cu2O", [3.5518, 2.9499, 2.7519], [0.11421, 0.1939, 0.60613]),
    ("Cu_palik", [0.21323, 0.91972, 1.1024], [3.9219, 2.4573, 2.1366]),
    ("CuO", [3.2475, 2.4478, 2.2102], [0.52109, 0.57003, 0.72218]),
    ("d-C", [2.7087, 2.3188, 2.2289], [0.0, 0.0, 0.0]),
    ("Hg", [2.3989, 1.44, 0.90957], [6.3276, 4.3719, 3.4218]),
    ("HgTe", [4.779, 3.2312, 2.6599], [1.6316, 1.5808, 1.7293]),
    ("Ir", [3.0863, 2.0822, 1.6179], [5.5922, 4.0671, 3.2673]),
    ("K", [0.064043, 0.04641, 0.038185], [2.1042, 1.3489, 0.91313]),
    ("Li", [0.26579, 0.19562, 0.22095], [3.5402, 2.3111, 1.6686]),
    ("MgO", [2.0896, 1.6507, 1.5949], [0.0, 0.0, 0.0]),
    ("Mo", [4.484, 3.5251, 2.7763], [4.1114, 3.4208, 3.1506]),
    ("Na_palik", [0.060269, 0.056141, 0.061988], [3.1793, 2.1125, 1.579]),
    ("Nb", [3.4201, 2.7901, 2.3956], [3.4414, 2.7377, 2.5797]),
    ("Ni_palik", [2.3673, 1.6634, 1.4671], [4.4988, 3.0502, 2.3454]),
    ("Rh", [2.5858, 1.8602, 1.5543], [6.7823, 4.703, 3.9761]),
    ("Se", [4.0583, 2.8429, 2.8209], [0.75405, 0.63844, 0.52181]),
    ("Se-e", [5.7228, 4.1657, 4.0813], [0.87114, 1.1052, 1.5653]),
    ("SiC", [3.1723, 2.526, 2.4794], [7.5377e-7, 0.0, 1.0193e-5]),
    ("SnTe", [4.5242, 1.9816, 1.2816], [0.0, 0.0, 0.0]),
    ("Ta", [2.0627, 2.3929, 2.6279], [2.4084, 1.7415, 1.947]),
    ("Te", [7.3902, 4.4821, 2.6371], [3.256, 3.5271, 3.2921]),
    ("Te-e", [7.5089, 4.2964, 2.37], [5.5839, 4.9472, 3.9976]),
    ("ThF4", [1.8307, 1.4422, 1.3876], [0.0, 0.0, 0.0]),
    ("TiC", [3.7005, 2.8374, 2.5823], [3.2656, 2.3516, 2.1728]),
    ("TiN", [1.6484, 1.1505, 1.3798], [3.3683, 1.9435, 1.1021]),
    ("TiO2", [3.4566, 2.8017, 2.9052], [0.00010526, 0.0, 0.00065289]),
    ("TiO2-e", [3.1066, 2.5132, 2.5824], [2.9752e-5, 0.0, 0.0001827]),
    ("V_palik", [4.2776, 3.5129, 2.7611], [3.4913, 2.8895, 3.1115]),
    ("VC", [3.6576, 2.7527, 2.5327], [3.0683, 2.1987, 1.9632]),
    ("VN", [2.8656, 2.1192, 1.9401], [3.0322, 2.0561, 1.6163]),
    ("W", [4.3708, 3.3002, 2.9984], [3.5006, 2.6049, 2.2732]),
];

/// (eta, k) of a conductor. `none` is a perfect mirror. A suffix like `_palik` names the source of the data; it can be
/// omitted if there is only one source.
pub(crate) fn conductor(name: &str) -> Option<(Rgb, Rgb)> {
    if name.eq_ignore_ascii_case("none") {
        return Some((Rgb::BLACK, Rgb::WHITE));
    }
    let bare = |n: &str| n.trim_end_matches("_palik").to_lowercase();
    let exact = CONDUCTORS.iter().find(|(n, ..)| *n == name);
    let (_, eta, k) = exact.or_else(|| CONDUCTORS.iter().find(|(n, ..)| bare(n) == bare(name)))?;
    Some((Rgb::from(*eta), Rgb::from(*k)))
}

/// (eta, k) of a conductor that a BSDF names; `None` if an error was reported.
pub(super) fn conductor_of(node: Node<'_>, name: &str) -> Option<(Rgb, Rgb)> {
    let found = conductor(name);
    if found.is_none() {
        let names = CONDUCTORS.iter().map(|(n, ..)| *n).chain(["none"]);
        let help = node.report.suggestion(name, names);
        let message = format!("unknown conductor `{name}`");
        node.report.error_help(node.span_of("material"), message, "expected a material", help);
    }
    found
}

/// An index of refraction given as a number or a name; `None` if it is not given, or invalid (and reported).
pub(super) fn interface(node: Node<'_>, name: &'static str) -> Option<f32> {
    if !node.has(name) {
        return None;
    }
    let Some(material) = node.text_opt(name) else { return node.float_opt(name) };
    let found = dielectric(material).or_else(|| material.trim().parse().ok());
    if found.is_none() {
        let names = DIELECTRICS.iter().map(|(n, _)| *n);
        let help = node.report.suggestion(material, names);
        let message = format!("unknown dielectric `{material}`");
        node.report.error_help(
            node.span_of(name),
            message,
            "expected a material or a number",
            help,
        );
    }
    found
}

/// Index inside divided by index outside; `None` if an error was reported.
pub(super) fn relative(node: Node<'_>, inside: &str) -> Option<f32> {
    let default = |name| dielectric(name).expect("a name in the table");
    let inside = interface(node, "int_ior").unwrap_or_else(|| default(inside));
    let outside = interface(node, "ext_ior").unwrap_or_else(|| default("air"));
    let eta = node.float_opt("eta").unwrap_or(inside / outside);
    if RELATIVE.contains(&eta) {
        return Some(eta);
    }
    let name = ["eta", "int_ior", "ext_ior"].into_iter().find(|name| node.has(name));
    let span = name.map_or(node.span(), |name| node.span_of(name));
    let message = format!("the relative index of refraction (inside / outside) is {eta}");
    node.report.error(span, message, "expected 0.1 to 10");
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_with_and_without_their_source() {
        assert_eq!(conductor("none"), Some((Rgb::BLACK, Rgb::WHITE)));
        assert_eq!(conductor("Ag"), conductor("Ag_palik"));
        assert_eq!(conductor("Na"), conductor("Na_palik"));
        assert_ne!(conductor("Cu"), conductor("Cu_palik"));
        assert!(conductor("Unobtainium").is_none());
        assert_eq!(dielectric("BK7"), Some(1.5046));
    }
}
