//! The film: what passes add up to.
//!
//! Pixels lie in tiles of 16 x 16, tiles in Morton order, so that threads own disjoint pieces and neighbours in
//! the picture are neighbours in time. Every pixel adds up its samples in the order of the passes: the same bits for
//! any number of threads.

use glam::Vec3;
use rayon::prelude::*;

use crate::image_io::Layers;
use crate::math::Rgb;

/// Side of a tile in pixels.
const TILE: usize = 16;

/// What one sample of a pixel found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// Radiance by the kind of path that brought it.
    pub radiance: Components,
    /// Albedo of the first surface.
    pub albedo: Rgb,
    /// Shading normal of the first surface; zero where there is none.
    pub normal: Vec3,
    /// Distance to the first surface; 0 where there is none.
    pub depth: f32,
    /// Factor on the radiance from the reconstruction filter; 1 but for filters with negative lobes.
    pub weight: f32,
}

/// Radiance parted by the kind of path; the whole is the sum. In the notation of light paths (E eye, L light,
/// S delta lobe, D any other):
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Components {
    /// E S* L and E S* D L: seen, or after one scattering.
    pub direct: Rgb,
    /// E S* D .* D .* L: after two scatterings or more.
    pub indirect: Rgb,
    /// E S* D S+ L: focused by mirrors and glass onto what the eye sees.
    pub caustic: Rgb,
}

impl Components {
    /// Everything.
    #[inline]
    pub fn all(&self) -> Rgb {
        self.direct + self.indirect + self.caustic
    }

    /// The kind of path that has met `rough` scatterings on its way from the eye and then, up to the light,
    /// delta scatterings or none.
    #[inline]
    pub fn of_path(&mut self, rough: u32, then_delta: bool) -> &mut Rgb {
        match (rough, then_delta) {
            (0, _) | (1, false) => &mut self.direct,
            (1, true) => &mut self.caustic,
            _ => &mut self.indirect,
        }
    }
}

/// Which components a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// The whole.
    #[default]
    All,
    /// [`Components::direct`].
    Direct,
    /// [`Components::indirect`].
    Indirect,
    /// [`Components::caustic`].
    Caustic,
}

impl Show {
    #[inline]
    fn of(self, c: &Components) -> Rgb {
        match self {
            Show::All => c.all(),
            Show::Direct => c.direct,
            Show::Indirect => c.indirect,
            Show::Caustic => c.caustic,
        }
    }
}

/// What a pixel has added up.
#[derive(Clone, Debug, Default)]
struct Pixel {
    count: u32,
    /// Sums of direct, indirect and caustic radiance.
    sums: [[f64; 3]; 3],
    /// Running mean and sum of squared deviations of what is shown \[Welford62\].
    mean: [f64; 3],
    deviation: [f64; 3],
    albedo: Rgb,
    normal: Vec3,
    depth: f32,
}

impl Pixel {
    fn add(&mut self, sample: &Sample, show: Show) {
        self.count += 1;
        let n = f64::from(self.count);
        let parts = [sample.radiance.direct, sample.radiance.indirect, sample.radiance.caustic];
        for (sum, part) in self.sums.iter_mut().zip(parts) {
            let part = part * sample.weight;
            sum.iter_mut().zip(part.to_array()).for_each(|(s, v)| *s += f64::from(v));
        }
        let shown = (show.of(&sample.radiance) * sample.weight).to_array();
        for (k, v) in shown.into_iter().enumerate() {
            let d = f64::from(v) - self.mean[k];
            self.mean[k] += d / n;
            self.deviation[k] += d * (f64::from(v) - self.mean[k]);
        }
        let share = 1.0 / self.count as f32;
        self.albedo = self.albedo.lerp(sample.albedo, share);
        self.normal = self.normal.lerp(sample.normal, share);
        self.depth += (sample.depth - self.depth) * share;
    }
}

/// The picture while it is made.
pub struct Film {
    size: [usize; 2],
    show: Show,
    /// Corners of the tiles, in Morton order.
    tiles: Vec<[usize; 2]>,
    /// Which tile, in that order, covers a place of the grid of tiles.
    tile_at: Vec<u32>,
    pixels: Vec<Pixel>,
    passes: u32,
}

impl Film {
    /// An empty film of `size` pixels across and down.
    pub fn new(size: [usize; 2], show: Show) -> Self {
        let grid = size.map(|n| n.div_ceil(TILE));
        let mut tiles: Vec<[usize; 2]> =
            (0..grid[0] * grid[1]).map(|i| [i % grid[0], i / grid[0]]).collect();
        tiles.sort_by_key(|&[x, y]| morton(x as u32, y as u32));
        let mut tile_at = vec![0; tiles.len()];
        for (k, [x, y]) in tiles.iter().enumerate() {
            tile_at[y * grid[0] + x] = k as u32;
        }
        let pixels = vec![Pixel::default(); tiles.len() * TILE * TILE];
        let tiles = tiles.into_iter().map(|t| t.map(|c| c * TILE)).collect();
        Film { size, show, tiles, tile_at, pixels, passes: 0 }
    }

    /// Pixels across and down.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Number of passes added so far.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Add one sample to every pixel, tiles in parallel. `sample` must be a pure function of the pixel.
    pub fn add_pass(&mut self, sample: impl Fn([usize; 2]) -> Sample + Sync) {
        let ([w, h], show) = (self.size, self.show);
        let tiles = self.pixels.par_chunks_mut(TILE * TILE).zip(&self.tiles);
        tiles.with_max_len(1).for_each(|(pixels, &[x0, y0])| {
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let [x, y] = [x0 + i % TILE, y0 + i / TILE];
                if x < w && y < h {
                    pixel.add(&sample([x, y]), show);
                }
            }
        });
        self.passes += 1;
    }

    /// Everything as named channels: radiance as R G B, its variance (of the mean), direct, indirect and caustic
    /// light, albedo, normal, depth.
    pub fn layers(&self) -> Layers {
        let pixels: Vec<&Pixel> = (0..self.size[0] * self.size[1]).map(|i| self.pixel(i)).collect();
        let mut channels = Vec::new();
        let mut push = |name: String, value: &dyn Fn(&Pixel) -> f64| {
            channels.push((name, pixels.iter().map(|p| value(p) as f32).collect()));
        };
        let n = |p: &Pixel| f64::from(p.count.max(1));
        for (k, c) in ["R", "G", "B"].into_iter().enumerate() {
            push(c.to_string(), &|p| p.mean[k]);
            push(format!("Variance.{c}"), &|p| {
                if p.count > 1 { p.deviation[k] / ((n(p) - 1.0) * n(p)) } else { 0.0 }
            });
            for (j, part) in ["Direct", "Indirect", "Caustic"].into_iter().enumerate() {
                push(format!("{part}.{c}"), &|p| p.sums[j][k] / n(p));
            }
            push(format!("Albedo.{c}"), &|p| f64::from(p.albedo.to_array()[k]));
        }
        for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            push(format!("N.{axis}"), &|p| f64::from(p.normal[k]));
        }
        push("Z".to_string(), &|p| f64::from(p.depth));
        Layers { width: self.size[0], height: self.size[1], channels, metadata: Vec::new() }
    }

    /// The shown radiance, row by row from the top.
    pub fn radiance(&self) -> Vec<Rgb> {
        (0..self.size[0] * self.size[1])
            .map(|i| Rgb::from(self.pixel(i).mean.map(|v| v as f32)))
            .collect()
    }

    /// Pixel `i` of the picture in row order.
    fn pixel(&self, i: usize) -> &Pixel {
        let (x, y) = (i % self.size[0], i / self.size[0]);
        let tile = self.tile_at[(y / TILE) * self.size[0].div_ceil(TILE) + x / TILE] as usize;
        &self.pixels[tile * TILE * TILE + (y % TILE) * TILE + x % TILE]
    }
}

/// Interleave the bits of two coordinates.
fn morton(x: u32, y: u32) -> u64 {
    let spread = |v: u32| (0..32).fold(0u64, |m, b| m | (u64::from(v >> b & 1) << (2 * b)));
    spread(x) | spread(y) << 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_gets_its_own_samples_and_their_variance() {
        let mut film = Film::new([37, 21], Show::All);
        for pass in 0..3u32 {
            film.add_pass(|[x, y]| Sample {
                radiance: Components {
                    direct: Rgb::grey((x + 100 * y) as f32 + pass as f32),
                    ..Default::default()
                },
                weight: 1.0,
                ..Default::default()
            });
        }
        let layers = film.layers();
        let (r, v) =
            (layers.channel("R").expect("R"), layers.channel("Variance.R").expect("variance"));
        for i in 0..37 * 21 {
            assert_eq!(r[i], (i % 37 + 100 * (i / 37)) as f32 + 1.0);
            // Values k, k+1, k+2: variance 1, of the mean of three 1/3.
            assert!((v[i] - 1.0 / 3.0).abs() < 1e-6);
        }
    }

    #[test]
    fn components_are_disjoint_by_path() {
        let mut c = Components::default();
        for (rough, delta) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)]
        {
            *c.of_path(rough, delta) += Rgb::WHITE;
        }
        assert_eq!([c.direct.r, c.caustic.r, c.indirect.r], [3.0, 1.0, 2.0]);
    }
}
