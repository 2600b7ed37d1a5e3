//! What the project's web pages share: the viewer for pictures (HTML, style, scripts), its colour maps, and the form in which pictures
//! reach it. `compare` writes a page into a file; a run with `--serve` shows one while it makes passes.
//!
//! A page includes [`VIEWER`] in its HTML, [`STYLE`] and [`SCRIPT`], and a JSON element with the id `data` that holds `maps`: the
//! colour maps of [`maps`]. Its own script follows, and defines:
//!
//! | name | what it is |
//! |---|---|
//! | `QUANTITIES` | what can be shown, by key; `name` is for the user |
//! | `quantities()` | the keys that there is data for, `picture` first |
//! | `scaleFor(picture)` | how a picture is shown in false colours: `{ name, unit, map, end, of }`, where `of(i)` is the number of pixel `i`; null for a picture in its own colours |
//! | `numbersOf(picture, index, i)` | the numbers of pixel `i` for the table below the picture; null hides the row |
//! | `inspectedName()` | the heading of the fourth number |
//!
//! It calls `setSize`, then `showViewer` with the pictures. A picture is `{ label, rgb, version }`: `rgb` holds half floats as
//! [`halves()`] makes them, or is null as long as there are none; `version` changes when they do.
#![forbid(unsafe_code)]

mod halves;
mod template;

pub use halves::{Halves, halves};
pub use template::fill;

/// The viewer's HTML: controls, legend, pictures, and the table of a pixel's numbers.
pub const VIEWER: &str = include_str!("front/viewer.html");

/// The style of a page.
pub const STYLE: &str = include_str!("front/page.css");

/// The viewer's scripts, in the order in which they build on each other.
pub const SCRIPT: [&str; 4] = [
    include_str!("front/numbers.js"),
    include_str!("front/colour.js"),
    include_str!("front/viewer.js"),
    include_str!("front/controls.js"),
];

/// The colour maps by name, each as 256 colours of six hexadecimal digits. `magma` goes from zero up, `signed` has zero in its
/// middle.
pub fn maps() -> [(&'static str, String); 2] {
    let map = |gradient: colorous::Gradient| {
        (0..256).map(|i| format!("{:x}", gradient.eval_rational(i, 256))).collect()
    };
    [("magma", map(colorous::MAGMA)), ("signed", map(colorous::PURPLE_ORANGE))]
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_map_has_256_colours_of_six_digits() {
        for (name, map) in super::maps() {
            assert_eq!(map.len(), 6 * 256, "{name}");
            assert!(map.chars().all(|c| c.is_ascii_hexdigit()), "{name}");
        }
    }
}
