//! The colour spaces of FLIP, and the distance in them.

use super::Color;

/// Linear Rec. 709 to XYZ, computed exactly from the published chromaticities.
pub(super) const TO_XYZ: [Color; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

pub(super) fn apply(m: &[Color; 3], c: Color) -> Color {
    m.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2])
}

pub(super) fn to_xyz(rgb: Color) -> Color {
    apply(&TO_XYZ, rgb)
}

/// XYZ to linear Rec. 709: Cramer's rule on [`TO_XYZ`].
pub(super) fn to_rgb(xyz: Color) -> Color {
    let [a, b, c] = [0, 1, 2].map(|k| TO_XYZ.map(|row| row[k])); // columns
    let cross = |u: Color, v: Color| {
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let dot = |u: Color, v: Color| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let det = dot(a, cross(b, c));
    [dot(xyz, cross(b, c)) / det, dot(a, cross(xyz, c)) / det, dot(a, cross(b, xyz)) / det]
}

pub(super) fn white() -> Color {
    to_xyz([1.0; 3])
}

/// Linear RGB to an opponent space that is linear in RGB, so that filtering there filters light.
pub(super) fn to_opponent(rgb: Color) -> Color {
    let (c, w) = (to_xyz(rgb), white());
    let [x, y, z] = [c[0] / w[0], c[1] / w[1], c[2] / w[2]];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Back to XYZ.
pub(super) fn from_opponent([l, cx, cz]: Color) -> Color {
    let y = (l + 16.0) / 116.0;
    let w = white();
    [(y + cx / 500.0) * w[0], y * w[1], (y - cz / 200.0) * w[2]]
}

pub(super) fn to_lab(xyz: Color) -> Color {
    const DELTA: f64 = 6.0 / 29.0;
    let f =
        |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let w = white();
    let [x, y, z] = [f(xyz[0] / w[0]), f(xyz[1] / w[1]), f(xyz[2] / w[2])];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Hunt's effect: colours look less colourful where it is dark.
pub(super) fn hunt([l, a, b]: Color) -> Color {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// City-block distance in lightness, Euclidean in colour.
pub(super) fn hyab(p: Color, q: Color) -> f64 {
    (p[0] - q[0]).abs() + (p[1] - q[1]).hypot(p[2] - q[2])
}
