//! Save and restore a film, and merge two films.

use rayon::prelude::*;

use super::Film;
use super::pixel::Pixel;
use crate::bytes::{Reader, Writer};

impl Film {
    /// All sums of the film, bit for bit.
    pub fn save_state(&self) -> Vec<u8> {
        let mut w = Writer::default();
        self.size().into_iter().for_each(|n| w.u64(n as u64));
        w.u32(self.passes);
        self.pixels.iter().for_each(|p| p.write(&mut w));
        w.into_bytes()
    }

    /// Restore the state that [`Film::save_state`] wrote for a film of the same size, filter and component.
    ///
    /// # Errors
    /// The bytes belong to another size, or are damaged. The film is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(bytes);
        let size = [r.u64()?, r.u64()?];
        if size != self.size().map(|n| n as u64) {
            return Err(format!("its film has {} x {} pixels", size[0], size[1]));
        }
        let passes = r.u32()?;
        let pixels = r.take(self.pixels.len() * Pixel::BYTES)?;
        r.end()?;
        let pixels =
            pixels.par_chunks_exact(Pixel::BYTES).map(|b| Pixel::read(&mut Reader::new(b)));
        let pixels = pixels.collect::<Result<Vec<_>, _>>()?;
        if passes > u32::MAX / 2 || pixels.iter().any(|pixel| pixel.passes > passes) {
            return Err("its film has an impossible number of passes".into());
        }
        (self.passes, self.pixels) = (passes, pixels);
        Ok(())
    }

    /// Add the passes of another film of the same size, filter and component.
    pub fn merge(&mut self, other: &Film) {
        assert_eq!(self.size(), other.size(), "films of one picture");
        self.passes += other.passes;
        self.pixels.par_iter_mut().zip(&other.pixels).for_each(|(p, q)| p.merge(q));
    }
}

#[cfg(test)]
mod tests {
    use crate::film::{Components, Film, Sample, Show};
    use crate::filter::Filter;
    use crate::math::Rgb;
    use glam::Vec3;

    /// Passes `range` of a picture whose samples are functions of pixel and pass.
    fn passes(film: &mut Film, range: std::ops::Range<u32>) {
        for pass in range {
            film.add_pass(|[x, y]| {
                let v =
                    crate::rng::bits_to_unit(crate::rng::hash_words(&[x as u32, y as u32, pass]));
                Sample {
                    radiance: Components { caustic: Rgb::new(v, v * v, 1.0), ..Default::default() },
                    albedo: Rgb::grey(v),
                    normal: Vec3::splat(v),
                    depth: 9.0 * v,
                    offset: [v - 0.5, 0.1],
                }
            });
        }
    }

    #[test]
    fn a_film_goes_on_where_it_stopped_bit_for_bit_and_merges_to_the_same_picture() {
        for filter in [Filter::Box, Filter::Gaussian { stddev: 0.5 }] {
            let new = || Film::new([19, 7], filter, Show::All);
            let (mut whole, mut first, mut second, mut resumed) = (new(), new(), new(), new());
            passes(&mut whole, 0..7);
            passes(&mut first, 0..3);
            let state = first.save_state();
            resumed.restore(&state).expect("its own state");
            passes(&mut resumed, 3..7);
            assert!(resumed.layers() == whole.layers());
            passes(&mut second, 3..7);
            first.merge(&second);
            assert_eq!(first.passes(), 7);
            assert!(first.layers() == whole.layers());
            // In the other order too.
            let mut backward = new();
            backward.merge(&second);
            backward.merge(&{
                let mut first = new();
                passes(&mut first, 0..3);
                first
            });
            assert!(backward.layers() == whole.layers());
            let mut other = Film::new([7, 19], filter, Show::All);
            assert!(other.restore(&state).unwrap_err().contains("19 x 7"));
            assert!(new().restore(&state[..state.len() - 1]).unwrap_err().contains("too early"));
        }
    }
}
