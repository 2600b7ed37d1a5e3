//! Media whose density varies: Mitsuba's `heterogeneous` and pbrt's `uniformgrid`.

use std::sync::Arc;

use gi_core::math::{Bounds, Rgb};
use gi_core::medium::{Between, Cells, Domain, Grid, Medium, Outside, Varying, Volume};
use glam::{Affine3A, Vec3};

use super::{albedo_of, phase};
use crate::builder::Builder;
use crate::document::{Class, Meaning, Node};

/// Largest optical thickness of a medium: extinction times the diagonal of its box. Tracking takes time in proportion.
const THICKEST: f32 = 1e6;

/// A grid that a scene file itself contains.
#[derive(Debug)]
pub(crate) struct InlineGrid {
    pub(crate) size: [usize; 3],
    pub(crate) cells: Cells,
}

/// A volume, and the space of its unit cube.
struct Placed {
    volume: Volume,
    /// World space to the unit cube that contains the volume.
    to_cube: Affine3A,
}

impl Builder<'_> {
    /// A medium whose density varies; `None` if an error was reported.
    pub(super) fn heterogeneous(&mut self, node: Node<'_>) -> Option<Medium> {
        node.ignore(&["has_spectral_extinction", "sample_emitters", "strategy", "method"]);
        let claim = self.report.budget.claim("bounds of media");
        if let Err(why) = claim.keep(Varying::MAX_BYTES) {
            node.error(why, "");
            return None;
        }
        let inline = node.doc.inline_grids.borrow_mut().remove(&node.id);
        let (sigma_t, albedo, domain) = match inline {
            Some(grid) => uniform_grid(node, grid)?,
            None => self.volumes(node)?,
        };
        let span = sigma_t.most().max();
        let varying = Varying::new(sigma_t, albedo, domain);
        let most = varying.albedo().most();
        if most.max() > 1.0 {
            let message = format!("an albedo of {}: the medium amplifies light", most.max());
            node.error(message, "expected at most 1");
            return None;
        }
        let thickness = span * domain.bounds().extent().length();
        if thickness.is_nan() || thickness > THICKEST {
            let message =
                format!("a medium that is too dense: its optical thickness is {thickness:.1e}");
            node.error(message, "expected at most 1e6: give a smaller `scale`");
            return None;
        }
        Some(Medium::heterogeneous(varying, phase(node)))
    }

    /// Mitsuba's: extinction, albedo, and the box that contains them.
    fn volumes(&mut self, node: Node<'_>) -> Option<(Volume, Volume, Domain)> {
        let is_old = node.doc.version == 0;
        // Mitsuba 0.6 calls it `density`.
        let name = if is_old { "density" } else { "sigma_t" };
        let scale = node.within("scale", 1.0, 0.0..=crate::value::MAX_NUMBER);
        let sigma_t = self.volume(node, name, 1.0)?;
        let albedo = self.volume(node, "albedo", 0.75)?;
        let domain = match is_old {
            true => Domain::Cube(sigma_t.to_cube),
            false => Domain::BoxAround(sigma_t.to_cube),
        };
        let sigma_t = match sigma_t.volume {
            Volume::Constant(value) => Volume::Constant(value * scale),
            Volume::Grid { grid, to_local, factor } => {
                Volume::Grid { grid, to_local, factor: factor * scale }
            }
        };
        Some((sigma_t, albedo.volume, domain))
    }

    /// The volume of this name, or the colour of this name everywhere.
    fn volume(&mut self, node: Node<'_>, name: &'static str, default: f32) -> Option<Placed> {
        let unit = Affine3A::from_translation(node.doc.local.borrow().origin.as_vec3());
        let Some(volume) = node.child_if(name, |n| n.class() == Class::Volume) else {
            let color = node.color(name, Meaning::Factor).unwrap_or(Rgb::grey(default));
            let value = coefficient(node, name, color)?;
            return Some(Placed { volume: Volume::Constant(value), to_cube: unit });
        };
        let to_cube = volume.to_world().as_affine3a().inverse();
        if !to_cube.is_finite() {
            let message = "the volume is flat: its `to_world` cannot be inverted";
            volume.report.error(volume.span_of("to_world"), message, "");
            return None;
        }
        match volume.plugin() {
            "constvolume" => {
                let color = volume.color("value", Meaning::Factor).unwrap_or(Rgb::WHITE);
                let value = coefficient(volume, "value", color)?;
                Some(Placed { volume: Volume::Constant(value), to_cube })
            }
            "gridvolume" => self.grid(volume, to_cube),
            _ => {
                volume.unknown_plugin(&["constvolume", "gridvolume"]);
                None
            }
        }
    }

    /// A grid from a file. `to_cube` is the inverse of its `to_world`.
    fn grid(&mut self, node: Node<'_>, to_cube: Affine3A) -> Option<Placed> {
        node.ignore(&["raw", "accel", "max_value", "send_data"]);
        let is_old = node.doc.version == 0;
        let file = self.assets.volume(node.id)?;
        let between = one_of(
            node,
            "filter_type",
            [("trilinear", Between::Trilinear), ("nearest", Between::Nearest)],
        )?;
        let outside = one_of(
            node,
            "wrap_mode",
            [("clamp", Outside::Clamp), ("repeat", Outside::Repeat), ("mirror", Outside::Mirror)],
        )?;
        let to_cube = match node.bool("use_grid_bbox", is_old) {
            true => unit_cube(node, file.bounds)? * to_cube,
            false => to_cube,
        };
        let to_local = match is_old {
            true => between_outer_centres(file.size) * to_cube,
            false => to_cube,
        };
        let grid = Grid::new(file.size, file.cells.clone(), outside, between)?;
        let grid = Arc::new(grid);
        Some(Placed { volume: Volume::Grid { grid, to_local, factor: Rgb::WHITE }, to_cube })
    }
}

/// pbrt's: scattering and absorption coefficients, times `scale` and the grid's value.
fn uniform_grid(node: Node<'_>, inline: InlineGrid) -> Option<(Volume, Volume, Domain)> {
    let scale = node.within("scale", 1.0, 0.0..=crate::value::MAX_NUMBER);
    let coefficients = ["sigma_s", "sigma_a"].map(|name| {
        let color = node.color(name, Meaning::Factor).unwrap_or(Rgb::WHITE);
        coefficient(node, name, color)
    });
    let [s, a] = coefficients;
    let (s, t) = (s?, s? + a?);
    let to_local = node.to_world().as_affine3a().inverse();
    if !to_local.is_finite() {
        node.error("the medium is flat", "expected different coordinates in `p0` and `p1`");
        return None;
    }
    let InlineGrid { size, cells } = inline;
    let grid = Arc::new(Grid::new(size, cells, Outside::Zero, Between::Trilinear)?);
    let sigma_t = Volume::Grid { grid, to_local, factor: t * scale };
    Some((sigma_t, Volume::Constant(albedo_of(s, t)), Domain::Cube(to_local)))
}

/// A colour whose channels are not negative.
fn coefficient(node: Node<'_>, name: &'static str, color: Rgb) -> Option<Rgb> {
    if color.to_array().into_iter().all(crate::volumes::is_valid) {
        return Some(color);
    }
    let message = format!("`{name}` is {} {} {}", color.r, color.g, color.b);
    node.report.error(node.place_of(name), message, "expected 0 to 1e15");
    None
}

/// The choice that a property names; the first one if it is not given.
fn one_of<T: Copy, const N: usize>(
    node: Node<'_>,
    name: &'static str,
    choices: [(&str, T); N],
) -> Option<T> {
    let Some(text) = node.text(name) else { return Some(choices[0].1) };
    let found = choices.iter().find(|(known, _)| *known == text);
    if found.is_none() {
        let help = node.report.suggestion(text, choices.iter().map(|(known, _)| *known));
        let message = format!("unknown `{name}` `{text}`");
        let known = choices.map(|(known, _)| format!("`{known}`")).join(" or ");
        node.report.error_help(node.span_of(name), message, &format!("expected {known}"), help);
    }
    found.map(|(_, choice)| *choice)
}

/// Maps a box to the unit cube.
fn unit_cube(node: Node<'_>, bounds: Bounds) -> Option<Affine3A> {
    let scale = bounds.extent().recip();
    let map = Affine3A::from_scale(scale) * Affine3A::from_translation(-bounds.min);
    if map.is_finite() {
        return Some(map);
    }
    let message = format!("the file's box is flat: from {} to {}", bounds.min, bounds.max);
    node.error(message, "expected a box: set `use_grid_bbox` to false to ignore it");
    None
}

/// Maps the unit cube to the box between the centres of a grid's outer cells: that is where Mitsuba 0.6 puts them.
fn between_outer_centres(size: [usize; 3]) -> Affine3A {
    let n = Vec3::from_array(size.map(|n| n as f32));
    Affine3A::from_translation(0.5 / n) * Affine3A::from_scale((n - 1.0) / n)
}
