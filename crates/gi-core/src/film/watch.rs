//! A pass that others can watch: the tiles that are finished, without the filter.

use std::sync::{Arc, Mutex, PoisonError};

use super::tiles::AREA;
use super::{Film, Tiles};
use crate::image_io::Layers;
use crate::math::Rgb;

/// The radiance of the finished tiles of a pass. The other pixels are black.
pub struct WatchedPass {
    tiles: Tiles,
    /// In the order of the film's pixels, and the number of finished tiles.
    finished: Mutex<(Vec<Rgb>, usize)>,
}

impl Film {
    /// Let others watch the next pass.
    pub fn watch(&mut self) -> Arc<WatchedPass> {
        let pixels = vec![Rgb::BLACK; self.tiles.pixels()];
        let watched = WatchedPass { tiles: self.tiles.clone(), finished: Mutex::new((pixels, 0)) };
        self.watched.insert(Arc::new(watched)).clone()
    }
}

impl WatchedPass {
    /// Show a finished tile, which begins at `corner`.
    pub(super) fn show(&self, corner: [usize; 2], pixels: &[Rgb; AREA]) {
        let first = self.tiles.place(corner);
        let mut finished = self.finished.lock().unwrap_or_else(PoisonError::into_inner);
        finished.0[first..first + AREA].copy_from_slice(pixels);
        finished.1 += 1;
    }

    /// The picture so far as channels R, G and B; `None` before the first tile.
    pub fn layers(&self) -> Option<Layers> {
        let [width, height] = self.tiles.size;
        let finished = self.finished.lock().unwrap_or_else(PoisonError::into_inner);
        let places = (0..width * height).map(|i| self.tiles.place([i % width, i / width]));
        let rows = places.map(|place| finished.0[place].to_array());
        (finished.1 > 0).then(|| Layers::of_rgb([width, height], rows))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

    use super::*;
    use crate::film::{Components, Sample, Show};
    use crate::filter::Filter;

    #[test]
    fn a_watched_pass_shows_its_finished_tiles_without_the_filter() {
        let (size, value) = ([40, 20], |[x, y]: [usize; 2]| (1 + x + 100 * y) as f32);
        for filter in [Filter::Box, Filter::Gaussian { stddev: 0.5 }] {
            let mut film = Film::new(size, filter, Show::Direct);
            let watched = film.watch();
            assert!(watched.layers().is_none());
            let partly = AtomicUsize::new(0);
            film.add_pass(|at| {
                // Other pixels are still to come: those that are shown have their value.
                if let Some(layers) = watched.layers() {
                    partly.fetch_add(1, SeqCst);
                    let red = layers.channel("R").expect("red").iter().enumerate();
                    let of = |i| value([i % size[0], i / size[0]]);
                    assert!(red.clone().all(|(i, v)| *v == 0.0 || *v == of(i)));
                    assert!(red.clone().any(|(_, v)| *v == 0.0));
                }
                let direct = Rgb::new(value(at), value(at), value(at));
                let radiance = Components { direct, indirect: Rgb::WHITE, ..Default::default() };
                Sample { radiance, offset: [0.3, -0.2], ..Sample::default() }
            });
            assert!(partly.into_inner() > 0);
            let layers = watched.layers().expect("a picture");
            let expected: Vec<f32> = (0..800).map(|i| value([i % 40, i / 40])).collect();
            assert_eq!(layers.channel("G"), Some(&expected[..]));
            // The next pass is not watched.
            film.add_pass(|_| Sample::default());
            assert_eq!(watched.layers().expect("a picture").channel("G"), Some(&expected[..]));
        }
    }
}
