//! The pyramid of all ways to find light, each as a picture of its own [Veach97, fig. 10.2].

use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::technique::{Picture, Setting};
use rayon::prelude::*;

use super::Bidirectional;
use super::eye::Found;
use crate::params::Params;

/// Number of segments of the longest paths that are shown.
const LONGEST: u32 = 5;
/// Number of ways to connect paths of 1 to [`LONGEST`] segments; a path of n segments has n + 1.
const WAYS: usize = (LONGEST * (LONGEST + 3) / 2) as usize;

/// What each way finds in a pixel: not weighted, and weighted.
type Ways = [[Rgb; 2]; WAYS];

/// The index of the way with s vertices on the light's side and t on the eye's, by the number of segments first.
fn index(s: u32, t: u32) -> Option<usize> {
    let segments = s + t - 1;
    (segments <= LONGEST).then(|| ((segments - 1) * (segments + 2) / 2 + s) as usize)
}

/// Render as many passes as `film` has, and draw what each way contributes. Merged paths are left out.
pub(crate) fn draw(setting: Setting, params: &Params, film: &Film) -> Vec<Picture> {
    let [w, h] = film.size();
    let mut pixels: Vec<Ways> = vec![[[Rgb::BLACK; 2]; WAYS]; w * h];
    let add = |pixel: &mut Ways, found: &Found| {
        if let (false, Some(k)) = (found.merged, index(found.s, found.t)) {
            pixel[k][0] += found.radiance;
            pixel[k][1] += found.radiance * found.weight;
        }
    };
    for pass in 0..film.passes() {
        let of = Bidirectional::new(setting, params, pass);
        let paths = of.trace(pass, film.filter());
        pixels.par_iter_mut().enumerate().for_each(|(i, pixel)| {
            of.eye_path([i % w, i / w], pass, &paths, &mut |found| add(pixel, &found));
        });
        paths.light.for_each_splat(of.ways.light_paths, |pixel, found| {
            add(&mut pixels[pixel], &found);
        });
    }
    let scale = 1.0 / film.passes().max(1) as f32;
    let ways = (1..=LONGEST).flat_map(|n| (0..=n).map(move |s| (s, n + 1 - s)));
    let drawn = ways.flat_map(|(s, t)| {
        [("-unweighted", 0), ("", 1)]
            .map(|(suffix, which)| (format!("s{s}t{t}{suffix}"), which, s, t))
    });
    drawn
        .filter_map(|(name, which, s, t)| {
            let k = index(s, t)?;
            let view = pixels.iter().map(|pixel| pixel[k][which] * scale).collect();
            Some(Picture { name, channels: Vec::new(), view })
        })
        .collect()
}
