//! Error bounds of clusters against their true errors.

use gi_core::canvas::{Canvas, Legend, number, text_width};
use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::points::{csv, row};
use gi_core::technique::Picture;
use glam::Vec2;
use rayon::prelude::*;

use super::common::Subject;
use crate::cut::Cluster;
use crate::light::At;

/// A cluster of a pixel's cut.
pub(super) struct Checked {
    pixel: [usize; 2],
    lights: usize,
    /// Luminances of the point's total light, of the cluster's estimate and of its true light, and the bound of the
    /// error.
    total: f32,
    estimate: f32,
    truth: f32,
    bound: f32,
}

/// Number of pixels along the longer side of the grid that is checked.
const GRID: usize = 16;

/// Check the clusters of the cuts of a grid of pixels against their lights, one by one.
fn check<'a>(subject: &Subject<'_, 'a>, size: [usize; 2]) -> Vec<Checked> {
    let step = size[0].max(size[1]).div_ceil(GRID).max(1);
    let middles = |n: usize| (step / 2..n).step_by(step);
    let pixels: Vec<[usize; 2]> =
        middles(size[1]).flat_map(|y| middles(size[0]).map(move |x| [x, y])).collect();
    let of_pixel = |pixel: &[usize; 2]| {
        let look = |at: &At<'_, '_, 'a>| of_cut(subject, at, *pixel);
        subject.view.at_pixel(*pixel, look).unwrap_or_default()
    };
    pixels.par_iter().flat_map_iter(of_pixel).collect()
}

fn of_cut<'a>(subject: &Subject<'_, 'a>, at: &At<'_, '_, 'a>, pixel: [usize; 2]) -> Vec<Checked> {
    let (lights, cut) = (subject.lights, subject.cut(at));
    let check = |c: &Cluster| {
        let tree = &lights.forest.trees[c.tree as usize];
        let members = tree.members(c.node);
        let truth: Rgb = members.iter().map(|&k| lights.one(at, k)).sum();
        Checked {
            pixel,
            lights: members.len(),
            total: cut.total as f32,
            estimate: (c.unit * tree.node(c.node).power).luminance(),
            truth: truth.luminance(),
            bound: c.error,
        }
    };
    cut.clusters().iter().filter(|c| c.error > 0.0).map(check).collect()
}

/// The clusters of the cuts of some pixels, as a table.
pub(super) fn bounds_csv(subject: &Subject) -> Vec<u8> {
    let line = |c: Checked| {
        let ([x, y], error) = (c.pixel, (c.estimate - c.truth).abs());
        format!("{x},{y},{},{}", c.lights, row([c.total, c.estimate, c.truth, error, c.bound]))
    };
    let checked = check(subject, subject.view.setting.camera.size());
    csv("x,y,lights,total,estimate,truth,error,bound", checked.into_iter().map(line))
}

/// Decades of relative error that the plot shows, up to one.
const DECADES: i32 = 7;

/// Orange dots and line, and a blue line for the threshold.
const CLUSTER: Rgb = Rgb::new(1.0, 0.6, 0.1);
const THRESHOLD: Rgb = Rgb::new(0.1, 0.5, 1.0);

/// Errors (horizontal) against bounds (vertical), relative to the point's total light, in decades. Above the diagonal,
/// bounds hold.
pub(super) fn picture(subject: &Subject, film: &Film) -> Picture {
    let [w, h] = film.size();
    let mut canvas = Canvas::over([w, h], vec![Rgb::BLACK; w * h]);
    let letter = (w as f32 / 42.0).clamp(5.0, 20.0);
    // The axes leave room for their numbers at the left and below.
    let (left, bottom) = (5.0 * letter, h as f32 - 2.4 * letter);
    let place = |error: f32, bound: f32| {
        let along = |v: f32| (1.0 + v.max(1e-30).log10() / DECADES as f32).clamp(0.0, 1.0);
        Vec2::new(left + along(error) * (w as f32 - left), bottom * (1.0 - along(bound)))
    };
    let (low, grey) = (10f32.powi(-DECADES), Rgb::grey(0.6));
    for decade in 0..=DECADES {
        let at = 10f32.powi(-decade);
        canvas.line(place(at, low), place(at, 1.0), 0.5, Rgb::grey(0.05));
        canvas.line(place(low, at), place(1.0, at), 0.5, Rgb::grey(0.05));
        if decade % 2 == 0 {
            let (name, half) = (number(at), 0.5 * letter);
            let x = place(at, low).x.min(w as f32 - 0.5 * text_width(&name, letter) - 1.0);
            canvas.text_centred(Vec2::new(x, h as f32 - half), letter, grey, &name);
            let y = (place(low, at).y + half).max(letter + 1.0);
            canvas.text(Vec2::new(half, y), letter, grey, &name);
        }
    }
    canvas.line(place(low, low), place(1.0, 1.0), 1.0, Rgb::WHITE);
    let threshold = subject.view.params.cut.error;
    canvas.line(place(low, threshold), place(1.0, threshold), 1.0, THRESHOLD);
    for c in check(subject, [w, h]) {
        let relative = |v: f32| v / c.total.max(f32::MIN_POSITIVE);
        let at = place(relative((c.estimate - c.truth).abs()), relative(c.bound));
        canvas.disc(at, 0.7, CLUSTER);
    }
    let (name, view) = ("bounds".into(), canvas.into_pixels());
    let allowed = format!("largest bound allowed ({})", number(threshold));
    let colours =
        [(CLUSTER, "a cluster"), (Rgb::WHITE, "bound = error"), (THRESHOLD, allowed.as_str())];
    let title =
        "Bound (upward) against true error (to the right), as fractions of the total light:";
    Picture { name, channels: Vec::new(), view, legend: Some(Legend::named(title, colours)) }
}
