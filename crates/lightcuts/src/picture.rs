//! A pass with reconstruction cuts: rows of samples at the corners of blocks, and the pixels between two rows of them.

use gi_core::bsdf::Transport;
use gi_core::eye::EyeVertex;
use gi_core::film::{Film, Sample as PixelSample};
use gi_core::progress;
use gi_core::rng::{bits_to_unit, hash_words};
use rayon::prelude::*;
use vpl::MIN_ROUGHNESS;

use crate::Lightcuts;
use crate::light::Lights;
use crate::reconstruct::{Corners, Sample};

/// The blocks of a pass.
struct Blocks {
    /// Side, pixels.
    side: f32,
    /// How far the picture's corner lies in the first block: another place each pass, so that blocks do not show.
    offset: [f32; 2],
}

impl Blocks {
    /// Where a corner is on the film.
    fn corner(&self, i: usize, j: usize) -> [f32; 2] {
        [i as f32 * self.side - self.offset[0], j as f32 * self.side - self.offset[1]]
    }

    /// The block that a film coordinate lies in, and where in it from 0 to 1.
    fn place(&self, film: f32, axis: usize) -> (usize, f32) {
        let x = ((film + self.offset[axis]) / self.side).max(0.0);
        (x as usize, x.fract())
    }

    fn count(&self, pixels: usize, axis: usize) -> usize {
        self.place(pixels as f32, axis).0 + 1
    }
}

/// Add a pass to the film.
pub(crate) fn add_pass(technique: &Lightcuts, lights: &Lights, index: u32, film: &mut Film) {
    let side = technique.params.reconstruction.block as f32;
    let seed = technique.setting.seed;
    let shift = |axis| side * bits_to_unit(hash_words(&[seed, index, axis]));
    let blocks = Blocks { side, offset: [shift(0), shift(1)] };
    let [w, h] = film.size();
    let columns = blocks.count(w, 0) + 1;
    let row = |j: usize| -> Vec<Option<Sample>> {
        (0..columns)
            .into_par_iter()
            .with_max_len(1)
            .map(|i| take(technique, lights, blocks.corner(i, j)))
            .collect()
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
        let light = |i: &usize| {
            let pixel = [i % w, i / w];
            let corners = |v: &EyeVertex| corners(technique, &blocks, [&above, &below], pixel, v);
            technique.sample_pixel(lights, pixel, index, corners)
        };
        pixels.par_extend(band.par_iter().with_max_len(16).map(light));
        above = below;
        progress::advance(1);
    }
    let pixels: Vec<PixelSample> = pixels;
    film.add_pass(|[x, y]| pixels[y * w + x]);
}

/// The cut of a corner; `None` where there is nothing to light.
fn take(technique: &Lightcuts, lights: &Lights, film: [f32; 2]) -> Option<Sample> {
    let ray = technique.setting.camera.ray(film, [0.5; 2]);
    let (surface, _) = lights.scene.intersect(&ray)?;
    let wo = -ray.d;
    let bsdf = lights.scene.bsdf(&surface, wo, Transport::Radiance).broad(wo, MIN_ROUGHNESS)?;
    let at = technique.at(&surface, wo, &bsdf, (1, 0))?;
    let sample = Sample::take(lights, &surface, &at, &technique.params.cut);
    technique.tally.sampled(sample.rays);
    Some(sample)
}

/// The four samples round the first point of a path, if all of them serve.
fn corners<'s>(
    technique: &Lightcuts,
    blocks: &Blocks,
    rows: [&'s [Option<Sample>]; 2],
    [x, y]: [usize; 2],
    v: &EyeVertex,
) -> Option<Corners<'s>> {
    if v.segments > 1 || v.non_delta > 0 {
        return None;
    }
    let Lightcuts { setting, .. } = technique;
    let (column, row) = (blocks.place(x as f32 + 0.5, 0).0, blocks.place(y as f32 + 0.5, 1).0);
    // Where in the block the picture shows the point; beside it a little where the pixel is.
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
