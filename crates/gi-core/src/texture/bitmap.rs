use std::sync::{LazyLock, OnceLock};

use glam::Vec2;

use crate::math::{Rgb, floor_i32};

/// How texels are stored; row by row from the top.
#[derive(Clone, Debug)]
pub enum Texels {
    /// Bytes in sRGB encoding, decoded at lookup.
    Srgb8(Vec<[u8; 3]>),
    /// Bytes that are linear numbers ("raw"): 255 is one.
    Linear8(Vec<[u8; 3]>),
    /// Linear floats.
    Float(Vec<Rgb>),
}

/// The picture outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture is repeated.
    #[default]
    Repeat,
    /// The picture is mirrored.
    Mirror,
    /// The border pixels are repeated.
    Clamp,
}

/// How a value between texels is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Lookup {
    /// By interpolation of the four nearest texels.
    #[default]
    Bilinear,
    /// From the nearest texel.
    Nearest,
}

/// A picture over the unit square; (0, 0) is its top left corner.
#[derive(Clone, Debug)]
pub struct Bitmap {
    width: usize,
    height: usize,
    /// Number of tiles per row.
    tiles_across: usize,
    tiles: Tiles,
    wrap: Wrap,
    lookup: Lookup,
    mean: OnceLock<Rgb>,
    range: OnceLock<[Rgb; 2]>,
}

/// Side of a tile in texels; a power of two. Neighbouring texels of two rows are mostly in the same tile, so that a
/// lookup waits for memory once.
const SIDE: usize = 4;

/// The texels of a tile, row by row.
type Tile<T> = [T; SIDE * SIDE];

/// Texels in tiles; those beyond the picture's border are not used.
#[derive(Clone, Debug)]
enum Tiles {
    /// Bytes, the fourth not used, and their linear values.
    Bytes(Vec<ByteTile>, &'static [f32; 256]),
    /// Linear floats.
    Float(Vec<Tile<Rgb>>),
}

/// A tile that is exactly one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct ByteTile(Tile<[u8; 4]>);

/// Bring texels into the order of tiles.
fn tiled<T: Copy>(width: usize, texels: &[T], empty: T) -> Vec<Tile<T>> {
    let across = width.div_ceil(SIDE);
    let rows = texels.len() / width;
    let mut tiles = vec![[empty; SIDE * SIDE]; across * rows.div_ceil(SIDE)];
    for (y, row) in texels.chunks_exact(width).enumerate() {
        for (x, &texel) in row.iter().enumerate() {
            tiles[y / SIDE * across + x / SIDE][y % SIDE * SIDE + x % SIDE] = texel;
        }
    }
    tiles
}

/// The values of bytes that are linear numbers.
static RAW_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| i as f32 * (1.0 / 255.0)));

/// The sRGB curve from bytes to linear [IEC 61966-2-1].
static SRGB_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

/// Decode one sRGB value in [0, 1].
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

impl Bitmap {
    /// A picture of `width` x `height` texels.
    ///
    /// # Panics
    /// If the number of texels is zero or not the product of width and height.
    pub fn new(width: usize, height: usize, texels: Texels, wrap: Wrap, lookup: Lookup) -> Self {
        let count = match &texels {
            Texels::Srgb8(t) | Texels::Linear8(t) => t.len(),
            Texels::Float(t) => t.len(),
        };
        assert!(width * height == count && count > 0, "{width} x {height} texels, {count} given");
        let bytes = |texels: &[[u8; 3]]| {
            let four = texels.iter().map(|&[r, g, b]| [r, g, b, 0]).collect::<Vec<_>>();
            tiled(width, &four, [0; 4]).into_iter().map(ByteTile).collect()
        };
        let tiles = match texels {
            Texels::Srgb8(t) => Tiles::Bytes(bytes(&t), &SRGB_TO_LINEAR),
            Texels::Linear8(t) => Tiles::Bytes(bytes(&t), &RAW_TO_LINEAR),
            Texels::Float(t) => Tiles::Float(tiled(width, &t, Rgb::BLACK)),
        };
        let (tiles_across, mean, range) = (width.div_ceil(SIDE), OnceLock::new(), OnceLock::new());
        Bitmap { width, height, tiles_across, tiles, wrap, lookup, mean, range }
    }

    /// The memory that the texels take, in bytes.
    pub fn bytes(&self) -> u64 {
        let bytes = match &self.tiles {
            Tiles::Bytes(tiles, _) => size_of_val(&tiles[..]),
            Tiles::Float(tiles) => size_of_val(&tiles[..]),
        };
        bytes as u64
    }

    /// Number of texels per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// What lies beyond the borders.
    pub fn wrap(&self) -> Wrap {
        self.wrap
    }

    /// How the value between texels is found.
    pub fn lookup(&self) -> Lookup {
        self.lookup
    }

    /// The texel in column `x` of row `y`, linear.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> Rgb {
        let tile = y / SIDE * self.tiles_across + x / SIDE;
        let within = y % SIDE * SIDE + x % SIDE;
        match &self.tiles {
            Tiles::Bytes(tiles, linear) => {
                let [r, g, b, _] = tiles[tile].0[within];
                Rgb::new(linear[r as usize], linear[g as usize], linear[b as usize])
            }
            Tiles::Float(tiles) => tiles[tile][within],
        }
    }

    /// All texels, row by row from the top.
    pub fn texels(&self) -> impl Iterator<Item = Rgb> {
        (0..self.height).flat_map(move |y| (0..self.width).map(move |x| self.texel(x, y)))
    }

    /// The value at `uv`.
    pub fn eval(&self, uv: Vec2) -> Rgb {
        let p = self.place(uv);
        match self.lookup {
            Lookup::Nearest => {
                let (x, y) = (floor_i32(p.x), floor_i32(p.y));
                self.texel(self.wrapped(x, self.width), self.wrapped(y, self.height))
            }
            Lookup::Bilinear => {
                let ([[a, b], [c, d]], [fx, fy]) = self.cell(p);
                a.lerp(b, fx).lerp(c.lerp(d, fx), fy)
            }
        }
    }

    /// Derivatives of the value at `uv` along u and v: those of the bilinear interpolation, and zero for [`Lookup::Nearest`].
    pub fn gradient(&self, uv: Vec2) -> [Rgb; 2] {
        if self.lookup == Lookup::Nearest {
            return [Rgb::BLACK; 2];
        }
        let ([[a, b], [c, d]], [fx, fy]) = self.cell(self.place(uv));
        let (du, dv) = ((b - a).lerp(d - c, fy), (c - a).lerp(d - b, fx));
        [du * self.width as f32, dv * self.height as f32]
    }

    /// The same picture with every texel changed by `change`, stored as floats.
    pub fn map(&self, change: impl Fn(Rgb) -> Rgb) -> Self {
        let texels = Texels::Float(self.texels().map(change).collect());
        Bitmap::new(self.width, self.height, texels, self.wrap, self.lookup)
    }

    /// Texel coordinates of `uv`: texel (x, y) covers [x, x + 1] times [y, y + 1].
    #[inline]
    fn place(&self, uv: Vec2) -> Vec2 {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let p = uv * size;
        let safe = p.x.abs() < FAR && p.y.abs() < FAR; // neither is NaN
        if safe { p } else { self.near(uv) * size }
    }

    /// The four texels around `p` (texel coordinates) in two rows, and the bilinear weights of the right column and the lower row.
    #[inline]
    fn cell(&self, p: Vec2) -> ([[Rgb; 2]; 2], [f32; 2]) {
        let ((x, fx), (y, fy)) = (floor(p.x - 0.5), floor(p.y - 0.5));
        let column = |x| self.wrapped(x, self.width);
        let row = |y| self.wrapped(y, self.height);
        let (left, right) = (column(x), column(x.wrapping_add(1)));
        let (upper, lower) = (row(y), row(y.wrapping_add(1)));
        let in_row = |y| [self.texel(left, y), self.texel(right, y)];
        ([in_row(upper), in_row(lower)], [fx, fy])
    }

    /// The same place of the repeated picture near the unit square, for coordinates far from it: at that distance
    /// neighbouring floats are many texels apart, and the texel's number would overflow. 0 if there is no such place.
    #[cold]
    fn near(&self, uv: Vec2) -> Vec2 {
        let period = match self.wrap {
            Wrap::Repeat => 1.0,
            Wrap::Mirror => 2.0,
            Wrap::Clamp => return uv.map(|x| if x.is_nan() { 0.0 } else { x.clamp(-1.0, 2.0) }),
        };
        uv.map(|x| if x.is_finite() { x.rem_euclid(period) } else { 0.0 })
    }

    /// The smallest and the largest value of each channel.
    pub fn range(&self) -> [Rgb; 2] {
        *self.range.get_or_init(|| {
            let join =
                |a: [Rgb; 2], b: [Rgb; 2]| [a[0].zip(b[0], f32::min), a[1].zip(b[1], f32::max)];
            self.texels().map(|texel| [texel, texel]).reduce(join).expect("a picture has texels")
        })
    }

    /// Mean of all texels.
    pub fn mean(&self) -> Rgb {
        *self.mean.get_or_init(|| self.compute_mean())
    }

    fn compute_mean(&self) -> Rgb {
        let mut sum = [0f64; 3];
        for texel in self.texels() {
            let t = texel.to_array();
            (0..3).for_each(|k| sum[k] += f64::from(t[k]));
        }
        Rgb::from(sum.map(|s| (s / (self.width * self.height) as f64) as f32))
    }

    /// Map a texel coordinate to 0..n.
    #[inline]
    fn wrapped(&self, i: i32, n: usize) -> usize {
        let size = n as i32; // at most 2^26
        if (0..size).contains(&i) {
            return i as usize;
        }
        let inside = match self.wrap {
            Wrap::Repeat => i.rem_euclid(size),
            Wrap::Clamp => i.clamp(0, size - 1),
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * size);
                if j < size { j } else { 2 * size - 1 - j }
            }
        };
        inside as usize
    }
}

/// Texel coordinates from here on are moved near the picture first: they might overflow.
const FAR: f32 = 1e9;

/// The largest integer up to `x`, and the fractional part.
#[inline]
fn floor(x: f32) -> (i32, f32) {
    let below = floor_i32(x);
    (below, x - below as f32)
}

#[cfg(test)]
mod tests;
