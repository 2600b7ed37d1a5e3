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
    let view = |which: usize, s: u32, t: u32| {
        let k = index(s, t).expect("a way of the pyramid");
        pixels.iter().map(|pixel| pixel[k][which] * scale).collect::<Vec<Rgb>>()
    };
    let picture = |name, view| Picture { name, channels: Vec::new(), view };
    let mut pictures = Vec::new();
    for (which, suffix) in ["-unweighted", ""].into_iter().enumerate() {
        let mut all = vec![Rgb::BLACK; w * h];
        for segments in 1..=LONGEST {
            for s in 0..=segments {
                let t = segments + 1 - s;
                let view = view(which, s, t);
                place(&mut all, &view, [w, h], [s, segments]);
                pictures.push(picture(format!("s{s}t{t}{suffix}"), view));
            }
        }
        pictures.push(picture(format!("pyramid{suffix}"), all));
    }
    pictures
}

/// Draw the view of the way with s vertices on the light's side into the pyramid: a row per number of segments, s from left to
/// right, each row centred.
fn place(all: &mut [Rgb], view: &[Rgb], [w, h]: [usize; 2], [s, segments]: [u32; 2]) {
    let (columns, rows) = (LONGEST as usize + 1, LONGEST as usize);
    // Each pixel of the small picture is the mean of a square of pixels.
    let side = columns.max(rows);
    let (small_w, small_h) = (w / side, h / side);
    let left = (w - (segments as usize + 1) * small_w) / 2 + s as usize * small_w;
    let top = (segments as usize - 1) * h / rows + (h / rows - small_h) / 2;
    for y in 0..small_h {
        for x in 0..small_w {
            let square = (0..side * side)
                .map(|k| view[(y * side + k / side) * w + x * side + k % side])
                .sum::<Rgb>();
            all[(top + y) * w + left + x] = square / (side * side) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pyramid_has_each_way_at_its_place() {
        let size = [13, 12];
        let mut all = vec![Rgb::BLACK; 13 * 12];
        let mut level = 0.0;
        for segments in 1..=LONGEST {
            for s in 0..=segments {
                level += 1.0;
                place(&mut all, &[Rgb::grey(level); 13 * 12], size, [s, segments]);
            }
        }
        // 20 ways of 2 x 2 pixels, none over another.
        assert_eq!(all.iter().filter(|v| !v.is_black()).count(), 20 * 4);
        let row = |y: usize| all[13 * y..13 * (y + 1)].iter().map(|v| v.r).collect::<Vec<f32>>();
        assert_eq!(row(0)[3..9], [0.0, 1.0, 1.0, 2.0, 2.0, 0.0]);
        assert_eq!(row(9)[..3], [15.0, 15.0, 16.0]);
    }
}
