//! A pass with reconstruction cuts: rows of samples at the corners of blocks, and the pixels between two such rows.

use gi_core::eye::EyeVertex;
use gi_core::film::{Film, Sample as PixelSample};
use gi_core::progress;
use gi_core::rng::{bits_to_unit, hash_words};
use gi_core::technique::Setting;
use rayon::prelude::*;

use crate::reconstruct::{Corners, Sample};

/// The blocks of a pass.
pub(crate) struct Blocks<'f, 'a> {
    setting: &'f Setting<'a>,
    /// Side in pixels.
    side: f32,
    /// Position of the picture's corner in the first block. It differs in each pass, so that blocks do not show.
    offset: [f32; 2],
}

impl<'f, 'a> Blocks<'f, 'a> {
    /// The blocks of pass `index`, with `side` pixels on each side.
    pub(crate) fn of_pass(setting: &'f Setting<'a>, side: u32, index: u32) -> Self {
        let side = side as f32;
        let shift = |axis| side * bits_to_unit(hash_words(&[setting.seed, index, axis]));
        Blocks { setting, side, offset: [shift(0), shift(1)] }
    }

    /// The film position of a corner.
    fn corner(&self, i: usize, j: usize) -> [f32; 2] {
        [i as f32 * self.side - self.offset[0], j as f32 * self.side - self.offset[1]]
    }

    /// The block in which a film coordinate lies, and the position in it from 0 to 1.
    fn place(&self, film: f32, axis: usize) -> (usize, f32) {
        let x = ((film + self.offset[axis]) / self.side).max(0.0);
        (x as usize, x.fract())
    }

    fn count(&self, pixels: usize, axis: usize) -> usize {
        self.place(pixels as f32, axis).0 + 1
    }
}

/// Finds the samples around the first point of a path.
pub(crate) type FindCorners<'f, 's> = &'f dyn Fn(&EyeVertex) -> Option<Corners<'s>>;

/// Add a pass to the film. `take` makes the sample of a film position; `light` renders a pixel.
pub(crate) fn add_pass(
    blocks: &Blocks,
    film: &mut Film,
    take: impl Fn([f32; 2]) -> Option<Sample> + Sync,
    light: impl for<'f, 's> Fn([usize; 2], FindCorners<'f, 's>) -> PixelSample + Sync,
) {
    let [w, h] = film.size();
    let columns = blocks.count(w, 0) + 1;
    let row = |j: usize| -> Vec<Option<Sample>> {
        let corners = (0..columns).into_par_iter().with_max_len(1);
        corners.map(|i| take(blocks.corner(i, j))).collect()
    };
    let rows = blocks.count(h, 1);
    progress::begin("rows of blocks", rows as u64);
    let mut above = row(0);
    let mut pixels = Vec::with_capacity(w * h);
    for j in 0..rows {
        if progress::is_abandoned() {
            return;
        }
        let below = row(j + 1);
        let band = (pixels.len() / w..h).take_while(|&y| blocks.place(y as f32 + 0.5, 1).0 == j);
        let band: Vec<usize> = band.flat_map(|y| (0..w).map(move |x| y * w + x)).collect();
        let render = |i: &usize| {
            let pixel = [i % w, i / w];
            light(pixel, &|v: &EyeVertex| corners(blocks, [&above, &below], pixel, v))
        };
        pixels.par_extend(band.par_iter().with_max_len(16).map(render));
        above = below;
        progress::advance(1);
    }
    let pixels: Vec<PixelSample> = pixels;
    film.add_pass(|[x, y]| pixels[y * w + x]);
}

/// The four samples around the first point of a path, if all of them can be used.
fn corners<'s>(
    blocks: &Blocks,
    rows: [&'s [Option<Sample>]; 2],
    [x, y]: [usize; 2],
    v: &EyeVertex,
) -> Option<Corners<'s>> {
    if v.segments > 1 || v.non_delta > 0 {
        return None;
    }
    let setting = blocks.setting;
    let (column, row) = (blocks.place(x as f32 + 0.5, 0).0, blocks.place(y as f32 + 0.5, 1).0);
    // The film position of the point, or that of the pixel if the camera cannot see the point.
    let film = setting.camera.connect(v.surface.p, [0.5; 2], blocks.side).map(|c| c.film);
    let [x, y] = film.unwrap_or([x as f32 + 0.5, y as f32 + 0.5]);
    let within = |film: f32, axis: usize, k: usize| {
        ((film + blocks.offset[axis]) / blocks.side - k as f32).clamp(0.0, 1.0)
    };
    let (u, t) = (within(x, 0, column), within(y, 1, row));
    let corner = |i: usize, j: usize, weight: f32| {
        let sample = rows[j][column + i].as_ref()?;
        sample.serves(setting.scene, &v.surface).then_some((sample, weight))
    };
    Some([
        corner(0, 0, (1.0 - u) * (1.0 - t))?,
        corner(1, 0, u * (1.0 - t))?,
        corner(0, 1, (1.0 - u) * t)?,
        corner(1, 1, u * t)?,
    ])
}
