//! The film: the sum of all passes.
//!
//! Pixels are stored in tiles of 16 x 16, tiles in Morton order: threads own disjoint tiles, and neighbouring pixels are rendered
//! one after the other. A pass has two halves. First every pixel takes its sample. Then every pixel gathers the samples within
//! reach of the filter, in a fixed order. No pixel is written by two threads, and the bits do not depend on their number.

mod kept;
mod layers;
mod pixel;
mod sample;
mod state;
mod sums;
mod tiles;
mod watch;

use std::sync::Arc;

use rayon::prelude::*;

use crate::filter::{Filter, FilterTable};
use crate::math::Rgb;
pub use crate::options::Show;
use crate::progress;
use kept::{Kept, RADIANCE, keep};
use pixel::Pixel;
pub use sample::{Components, Sample};
pub use tiles::PerPixel;
use tiles::{AREA, TILE, Tiles};
pub use watch::WatchedPass;

/// The picture while it is rendered.
pub struct Film {
    tiles: Tiles,
    filter: FilterTable,
    show: Show,
    pixels: Vec<Pixel>,
    /// This pass's samples, in the order of the pixels.
    kept: Kept,
    passes: u32,
    /// Light that other paths bring to the pixels in the next pass, in row order; empty if there is none.
    brought: Vec<Components>,
    /// Who watches the next pass.
    watched: Option<Arc<WatchedPass>>,
}

impl Film {
    /// An empty film of `size` pixels across and down.
    pub fn new(size: [usize; 2], filter: Filter, show: Show) -> Self {
        let tiles = Tiles::new(size);
        let pixels = vec![Pixel::default(); tiles.pixels()];
        let filter = FilterTable::new(filter);
        let kept = Kept { width: 2 * filter.reach() + 1, floats: Vec::new() };
        let brought = Vec::new();
        Film { tiles, filter, show, pixels, kept, passes: 0, brought, watched: None }
    }

    /// Bytes that a film of this size needs during a pass. [`Film::layers`] needs up to 88 bytes more per pixel.
    ///
    /// The sums of a pixel are the weight, nine sums of radiance, seven second moments for the variance, and seven of the first
    /// surface. Each has 12 bytes, so that merged shards have the bits of a single run.
    /// Samples stay in single precision, and are kept only while the pixels around them are filtered.
    pub fn memory(size: [usize; 2], filter: Filter) -> u64 {
        let reach = FilterTable::new(filter).reach();
        let kept = Kept { width: 2 * reach + 1, floats: Vec::new() }.stride() * size_of::<f32>();
        // The box filter keeps no samples.
        let per_pixel = size_of::<Pixel>() + if reach > 0 { kept } else { 0 };
        let tiles = size.map(|n| n.div_ceil(TILE) as u64);
        tiles[0] * tiles[1] * (AREA * per_pixel) as u64
    }

    /// Free the memory that only a pass needs.
    pub fn end_passes(&mut self) {
        self.kept.floats = Vec::new();
    }

    /// The reconstruction filter.
    pub fn filter(&self) -> &FilterTable {
        &self.filter
    }

    /// Pixels across and down.
    pub fn size(&self) -> [usize; 2] {
        self.tiles.size
    }

    /// Number of passes added so far.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Add light that other paths brought to the pixels, in row order. It counts in the next pass, and is filtered already.
    pub fn bring(&mut self, light: Vec<Components>) {
        let [w, h] = self.size();
        assert_eq!(light.len(), w * h, "the light is of another picture");
        if self.brought.is_empty() {
            self.brought = light;
        } else {
            self.brought.iter_mut().zip(&light).for_each(|(sum, light)| sum.add(light, 1.0));
        }
    }

    /// Take one sample in every pixel, tiles in parallel, and filter. `sample` must be a pure function of the pixel.
    pub fn add_pass(&mut self, sample: impl Fn([usize; 2]) -> Sample + Sync) {
        let mut nothing = vec![(); self.pixels.len()]; // takes no memory
        self.sample_all(&mut nothing, |_| (), |at, (), ()| sample(at));
    }

    /// [`Film::add_pass`] for samples that are taken together: `samples` takes those of a tile, whose pixels it gets. It must be a
    /// pure function of them.
    pub fn add_pass_by_tile(&mut self, samples: impl Fn(&[[usize; 2]]) -> Vec<Sample> + Sync) {
        let mut nothing = vec![(); self.pixels.len()]; // takes no memory
        let begin = |tile: &[[usize; 2]]| samples(tile).into_iter();
        let next = |_, (): &mut (), samples: &mut std::vec::IntoIter<Sample>| {
            samples.next().expect("a sample for each pixel")
        };
        self.sample_all(&mut nothing, begin, next);
    }

    /// [`Film::add_pass`], with data that a technique keeps per pixel.
    pub fn add_pass_with<T: Send>(
        &mut self,
        kept: &mut PerPixel<T>,
        sample: impl Fn([usize; 2], &mut T) -> Sample + Sync,
    ) {
        assert_eq!(kept.tiles.size, self.size(), "what is kept is of another picture");
        self.sample_all(&mut kept.values, |_| (), |at, value, ()| sample(at, value));
    }

    /// Make a pass. `begin` is called for each tile with its pixels, and what it returns is given to `sample` for each of them, in the
    /// same order.
    fn sample_all<T: Send, S>(
        &mut self,
        values: &mut [T],
        begin: impl Fn(&[[usize; 2]]) -> S + Sync,
        sample: impl Fn([usize; 2], &mut T, &mut S) -> Sample + Sync,
    ) {
        self.begin_and_end(|film| film.take_samples(values, begin, sample));
    }

    /// Make a pass. `pass` returns whether it is complete: an abandoned pass is not counted.
    fn begin_and_end(&mut self, pass: impl FnOnce(&mut Self) -> bool) {
        // What the technique has prepared for this pass may be incomplete.
        if !progress::is_abandoned() {
            progress::begin(progress::PIXELS, self.tiles.corners.len() as u64);
            let is_complete = pass(self);
            self.passes += u32::from(is_complete);
            self.watched = None;
        }
        self.brought = Vec::new();
    }

    fn take_samples<T: Send, S>(
        &mut self,
        values: &mut [T],
        begin: impl Fn(&[[usize; 2]]) -> S + Sync,
        sample: impl Fn([usize; 2], &mut T, &mut S) -> Sample + Sync,
    ) -> bool {
        if self.filter.reach() == 0 {
            let values = values.par_chunks_mut(AREA);
            let begin = |values, tile: &_| (values, begin(tile));
            self.for_each_pixel(
                values,
                Tile::Sampled,
                begin,
                |film, at, pixel, i, (values, begun)| {
                    let values: &mut &mut [T] = values;
                    let mut sample = sample(at, &mut values[i], begun);
                    film.add_brought(at, 1.0, &mut sample.radiance);
                    pixel.add_surface(&sample);
                    pixel.add(1.0, &sample.radiance, film.show);
                    film.show.of(&sample.radiance)
                },
            );
            return !progress::is_abandoned();
        }
        let floats = std::mem::take(&mut self.kept.floats);
        let mut kept = Kept { width: self.kept.width, floats };
        let stride = kept.stride();
        kept.floats.resize(self.pixels.len() * stride, 0.0);
        let pieces = kept.floats.par_chunks_mut(AREA * stride).zip(values.par_chunks_mut(AREA));
        let begin = |(runs, values), tile: &_| (runs, values, begin(tile));
        self.for_each_pixel(
            pieces,
            Tile::Sampled,
            begin,
            |film, at, pixel, i, (runs, values, begun)| {
                let (runs, values): (&mut &mut [f32], &mut &mut [T]) = (runs, values);
                let sample = sample(at, &mut values[i], begun);
                pixel.add_surface(&sample);
                keep(&mut runs[i * stride..(i + 1) * stride], &sample, film.filter);
                let mut shown = sample.radiance;
                film.add_brought(at, 1.0, &mut shown);
                film.show.of(&shown)
            },
        );
        // Samples are missing from an abandoned pass; those that were taken are dropped.
        let is_complete = !progress::is_abandoned();
        if is_complete {
            self.for_each_pixel(
                self.nothing(),
                Tile::Filtered,
                |(), _| (),
                |film, at, pixel, _, ()| {
                    let (weight, mut radiance) = film.gather(&kept, at);
                    film.add_brought(at, weight, &mut radiance);
                    pixel.add(weight, &radiance, film.show);
                    film.show.of(&radiance)
                },
            );
        }
        self.kept = kept;
        is_complete
    }

    /// Take samples in every pixel, tiles in parallel, that are filtered already. `sample` returns the sum of the weights
    /// of its samples, and the sum of their radiance multiplied by the weights.
    pub fn add_filtered_pass(&mut self, sample: impl Fn([usize; 2]) -> (f32, Sample) + Sync) {
        self.begin_and_end(|film| {
            film.add_weighted(Tile::Sampled, sample);
            !progress::is_abandoned()
        });
    }

    /// Add the result of `sample` to every pixel without filtering, for pictures that are filtered already.
    pub fn add_unfiltered(&mut self, sample: impl Fn([usize; 2]) -> Sample + Sync) {
        if progress::is_abandoned() {
            return;
        }
        self.add_weighted(Tile::Filtered, |at| (1.0, sample(at)));
        self.brought = Vec::new();
        self.passes += 1;
    }

    /// Add to every pixel a sum of weights, and a sample whose radiance is multiplied by them.
    fn add_weighted(&mut self, tile: Tile, sample: impl Fn([usize; 2]) -> (f32, Sample) + Sync) {
        self.for_each_pixel(
            self.nothing(),
            tile,
            |(), _| (),
            |film, at, pixel, _, ()| {
                let (weight, mut sample) = sample(at);
                film.add_brought(at, weight, &mut sample.radiance);
                pixel.add_surface(&sample);
                pixel.add(weight, &sample.radiance, film.show);
                film.show.of(&sample.radiance)
            },
        );
    }

    /// Call `work` for every pixel, tiles in parallel, with the pixel's position, its index in the tile, and what `begin` makes of the
    /// tile's entry of `extra` and its pixels. `work` returns the radiance of the pixel's sample, for those who watch the pass.
    fn for_each_pixel<E: Send, S>(
        &mut self,
        extra: impl IndexedParallelIterator<Item = E>,
        tile: Tile,
        begin: impl Fn(E, &[[usize; 2]]) -> S + Sync,
        work: impl Fn(&PassContext, [usize; 2], &mut Pixel, usize, &mut S) -> Rgb + Sync,
    ) {
        let frame = PassContext {
            filter: &self.filter,
            show: self.show,
            tiles: &self.tiles,
            brought: &self.brought,
        };
        let tiles = self.pixels.par_chunks_mut(AREA).zip(extra).zip(&self.tiles.corners);
        tiles.with_max_len(1).for_each(|((pixels, extra), &corner)| {
            let sampled = tile == Tile::Sampled;
            if sampled && progress::is_abandoned() {
                return;
            }
            let mut shown = [Rgb::BLACK; AREA];
            let inside = frame.tiles.inside(corner);
            let places: Vec<[usize; 2]> = inside.clone().map(|(_, at)| at).collect();
            let mut begun = begin(extra, &places);
            for (i, at) in inside {
                shown[i] = work(&frame, at, &mut pixels[i], i, &mut begun);
            }
            if let Some(watched) = self.watched.as_ref().filter(|_| sampled) {
                watched.show(corner, &shown);
            }
            progress::advance(u64::from(sampled));
        });
    }

    /// No extra for any tile.
    fn nothing(&self) -> impl IndexedParallelIterator<Item = ()> + use<> {
        rayon::iter::repeat_n((), self.tiles.corners.len())
    }
}

/// What a tile does in a pass.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Tile {
    /// It takes samples. This counts as progress, and stops once the pass is abandoned.
    Sampled,
    /// It adds up samples. This is quick, and always completes.
    Filtered,
}

/// Values that are constant during a pass.
struct PassContext<'a> {
    filter: &'a FilterTable,
    show: Show,
    tiles: &'a Tiles,
    /// [`Film::bring`].
    brought: &'a [Components],
}

impl PassContext<'_> {
    /// Add `weight` times the light that other paths have brought to a pixel.
    #[inline]
    fn add_brought(&self, [x, y]: [usize; 2], weight: f32, radiance: &mut Components) {
        if !self.brought.is_empty() {
            radiance.add(&self.brought[y * self.tiles.size[0] + x], weight);
        }
    }

    /// The filter's weights of all samples round a pixel, and their weighted radiance, row by row.
    fn gather(&self, kept: &Kept, [x, y]: [usize; 2]) -> (f32, Components) {
        let reach = self.filter.reach();
        let ([w, h], mut weight, mut sum) = (self.tiles.size, 0.0, [0.0; RADIANCE]);
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(w);
        // Within one tile, neighbours in a row are neighbours in memory.
        let one_tile = columns.start / TILE == (columns.end - 1) / TILE;
        for j in y.saturating_sub(reach)..(y + reach + 1).min(h) {
            let first = self.tiles.place([columns.start, j]);
            for i in columns.clone() {
                let at =
                    if one_tile { first + i - columns.start } else { self.tiles.place([i, j]) };
                let (along_x, along_y, radiance) = kept.read(at);
                let f = along_x[x + reach - i] * along_y[y + reach - j];
                weight += f;
                sum.iter_mut().zip(radiance).for_each(|(s, r)| *s += f * r);
            }
        }
        let part = |k: usize| Rgb::new(sum[k], sum[k + 1], sum[k + 2]);
        (weight, Components { direct: part(0), indirect: part(3), caustic: part(6) })
    }
}

#[cfg(test)]
mod tests;
