//! The pyramid of all ways to find light, each as a picture of its own [Veach97, fig. 10.2].

use gi_core::canvas::Legend;
use gi_core::film::{Film, PerPixel};
use gi_core::math::Rgb;
use gi_core::technique::Picture;

use super::eye::Found;
use super::{Bidirectional, PassPaths};

/// Number of segments of the longest paths that are shown.
const LONGEST: u32 = 5;
/// Mean radiance of a row of the pyramid.
const ROW_MEAN: f32 = 0.5;
/// Number of ways to connect paths of 1 to [`LONGEST`] segments; a path of n segments has n + 1.
const WAYS: usize = (LONGEST * (LONGEST + 3) / 2) as usize;

/// What each way finds in a pixel.
#[derive(Clone, Debug, Default)]
struct Ways {
    /// Sums, not weighted and weighted.
    found: [[Rgb; 2]; WAYS],
    /// Number of paths from the eye.
    paths: u32,
}

impl Ways {
    fn add(&mut self, found: &Found) {
        if let (false, Some(k)) = (found.merged, index(found.s, found.t)) {
            self.found[k][0] += found.radiance;
            self.found[k][1] += found.radiance * found.weight;
        }
    }
}

/// The index of the way with s vertices on the light's side and t on the eye's, by the number of segments first.
fn index(s: u32, t: u32) -> Option<usize> {
    let segments = s + t - 1;
    (segments <= LONGEST).then(|| ((segments - 1) * (segments + 2) / 2 + s) as usize)
}

/// What each way finds in the passes so far. Merged paths are left out.
pub(crate) struct Pyramid {
    pixels: PerPixel<Ways>,
    /// Number of passes whose light paths are in it.
    passes: u32,
}

impl Pyramid {
    /// Nothing yet, for a picture of `size` pixels.
    pub(crate) fn new(size: [usize; 2]) -> Self {
        Pyramid { pixels: PerPixel::new(size, |_| Ways::default()), passes: 0 }
    }

    /// Add the paths of a pass to the film, as [`Bidirectional::pass`] does, and to the pyramid.
    pub(crate) fn pass(
        &mut self,
        (of, index): (&Bidirectional, u32),
        film: &mut Film,
        paths: &PassPaths,
    ) {
        let (before, [w, _]) = (film.passes(), film.size());
        film.add_pass_with(&mut self.pixels, |pixel, ways| {
            ways.paths += 1;
            of.sample(pixel, index, paths, &mut |found| ways.add(found))
        });
        // If the pass was abandoned, light paths are missing, and the film is without it.
        if film.passes() > before {
            paths.light.for_each_splat(of.ways.light_paths, |pixel, found| {
                self.pixels.get_mut([pixel % w, pixel / w]).add(&found);
            });
            self.passes += 1;
        }
    }

    /// A picture per way, and the pyramid of all, not weighted and weighted.
    pub(crate) fn draw(&self, [w, h]: [usize; 2]) -> Vec<Picture> {
        let view = |which: usize, s: u32, t: u32| {
            let k = index(s, t).expect("a way of the pyramid");
            // Light that is connected with the camera comes from the light paths of whole passes.
            let samples = |ways: &Ways| if t == 1 { self.passes } else { ways.paths };
            let mean = |ways: &Ways| ways.found[k][which] / samples(ways).max(1) as f32;
            self.pixels.rows().map(mean).collect::<Vec<Rgb>>()
        };
        let picture = |name, view| Picture { name, channels: Vec::new(), view, legend: None };
        let mut pictures = Vec::new();
        let exposures = (1..=LONGEST).map(|segments| {
            exposure(&(0..=segments).map(|s| view(1, s, segments + 1 - s)).collect::<Vec<_>>())
        });
        let exposures = exposures.collect::<Vec<f32>>();
        let times =
            exposures.iter().map(|x| format!("x{}", x.round())).collect::<Vec<_>>().join(" ");
        let title = format!(
            "Rows: 1 to {LONGEST} segments, exposure {times}. Left to right: s = 0, 1, 2, ... light vertices"
        );
        for (which, suffix) in ["-unweighted", ""].into_iter().enumerate() {
            let mut all = vec![Rgb::BLACK; w * h];
            for (segments, &exposure) in (1..=LONGEST).zip(&exposures) {
                for s in 0..=segments {
                    let view = view(which, s, segments + 1 - s);
                    place(&mut all, &view, [w, h], [s, segments], exposure);
                    pictures.push(picture(format!("s{s}t{}{suffix}", segments + 1 - s), view));
                }
            }
            let legend = Some(Legend::named(&title, []));
            pictures.push(Picture { legend, ..picture(format!("pyramid{suffix}"), all) });
        }
        pictures
    }
}

/// The factor that brings the mean radiance of paths of one length to [`ROW_MEAN`], or 1 if that is less: long paths are dim. `views`
/// are the weighted views of all ways, and their sum is the light of these paths.
fn exposure(views: &[Vec<Rgb>]) -> f32 {
    let sum: f64 = views.iter().flatten().map(|radiance| f64::from(radiance.luminance())).sum();
    let mean = sum / views[0].len() as f64;
    if mean > 0.0 { (f64::from(ROW_MEAN) / mean).max(1.0) as f32 } else { 1.0 }
}

/// Draw the view of the way with s vertices on the light's side into the pyramid: a row per number of segments, s from left to
/// right, each row centred, radiance times `exposure`.
fn place(
    all: &mut [Rgb],
    view: &[Rgb],
    [w, h]: [usize; 2],
    [s, segments]: [u32; 2],
    exposure: f32,
) {
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
            all[(top + y) * w + left + x] = square * (exposure / (side * side) as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use gi_core::film::Show;
    use gi_core::options::PathLimits;
    use gi_core::technique::Technique;
    use gi_tests::World;

    use super::*;
    use crate::PathTracer;
    use crate::params::{Figure, Mode, Params};

    #[test]
    fn the_ways_of_the_pyramid_add_up_to_the_picture_and_do_not_change_it() {
        let world = World::load("cornell-box.xml", [24, 20], &[]);
        let limits = PathLimits { max_depth: Some(LONGEST), ..PathLimits::default() };
        let plain = Params { mode: Mode::Bdpt, limits, ..Params::default() };
        let shown = Params { figures: vec![Figure::Strategies], ..plain.clone() };
        let film = world.render::<PathTracer>(&plain, 4, 1, Show::All);
        let (tracer, same) = world.run::<PathTracer>(&shown, 4, 1, Show::All);
        let channels = |film: &Film| {
            ["R", "G", "B"].map(|c| film.layers().channel(c).expect("a channel").to_vec())
        };
        assert_eq!(channels(&film), channels(&same));
        let weighted = tracer
            .pictures(&film)
            .into_iter()
            .filter(|p| !p.name.ends_with("-unweighted") && !p.name.starts_with("pyramid"));
        let mut sum = vec![Rgb::BLACK; 24 * 20];
        for picture in weighted {
            sum.iter_mut().zip(&picture.view).for_each(|(s, v)| *s += *v);
        }
        for (i, sum) in sum.iter().enumerate() {
            let pixel = channels(&film).map(|c| c[i]);
            let error = (sum.g - pixel[1]).abs();
            assert!(error <= 1e-4 * (0.1 + pixel[1]), "pixel {i}: {sum:?}, not {pixel:?}");
        }
    }

    #[test]
    fn rows_of_the_pyramid_are_brightened_to_one_mean_and_never_darkened() {
        let views = |level: f32| vec![vec![Rgb::grey(level); 4], vec![Rgb::grey(level); 4]];
        assert_eq!(exposure(&views(0.025)), ROW_MEAN / 0.05);
        assert_eq!(exposure(&views(30.0)), 1.0);
        assert_eq!(exposure(&views(0.0)), 1.0);
    }

    #[test]
    fn the_pyramid_has_each_way_at_its_place() {
        let size = [13, 12];
        let mut all = vec![Rgb::BLACK; 13 * 12];
        let mut level = 0.0;
        for segments in 1..=LONGEST {
            for s in 0..=segments {
                level += 1.0;
                let view = [Rgb::grey(level); 13 * 12];
                place(&mut all, &view, size, [s, segments], 1.0);
            }
        }
        // 20 ways of 2 x 2 pixels, none over another.
        assert_eq!(all.iter().filter(|v| !v.is_black()).count(), 20 * 4);
        let row = |y: usize| all[13 * y..13 * (y + 1)].iter().map(|v| v.r).collect::<Vec<f32>>();
        assert_eq!(row(0)[3..9], [0.0, 1.0, 1.0, 2.0, 2.0, 0.0]);
        assert_eq!(row(9)[..3], [15.0, 15.0, 16.0]);
    }
}
