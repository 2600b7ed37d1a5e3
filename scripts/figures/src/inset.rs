//! Enlarged parts of pictures.

use std::str::FromStr;

use crate::picture::pixels_of;

/// A part of a picture that is drawn enlarged, with a frame, into the corner that is farthest from it.
#[derive(Clone, Debug)]
pub(crate) struct Inset {
    /// Left, top, width and height, as fractions of the picture.
    part: [f64; 4],
    zoom: usize,
}

impl FromStr for Inset {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = "expected X,Y,W,H,ZOOM: a part as fractions of the picture, and a whole number";
        let fields: Vec<&str> = text.split(',').collect();
        let [x, y, w, h, zoom] = fields[..] else { return Err(wrong.into()) };
        let part = [x, y, w, h].map(str::parse);
        let [Ok(x), Ok(y), Ok(w), Ok(h)] = part else { return Err(wrong.into()) };
        match zoom.parse() {
            Ok(zoom) if zoom >= 1 => Ok(Inset { part: [x, y, w, h], zoom }),
            _ => Err(wrong.into()),
        }
    }
}

/// An orange frame, which is rare in our pictures; linear.
const FRAME: [f32; 3] = [1.0, 0.3, 0.02];

impl Inset {
    /// Draw the enlarged part, its frame, and a frame around the part. Pixels are linear.
    pub(crate) fn draw(&self, size: [usize; 2], pixels: &mut [[f32; 3]]) -> anyhow::Result<()> {
        let [w, h] = size;
        let [[left, right], [top, bottom]] = pixels_of(self.part, size)?;
        let copy: Vec<Vec<[f32; 3]>> =
            (top..bottom).map(|y| pixels[y * w + left..y * w + right].to_vec()).collect();
        let line = (w / 160).max(1);
        let (width, height) = (self.zoom * (right - left), self.zoom * (bottom - top));
        let (width, height) = (width.min(w - 2 * line), height.min(h - 2 * line));
        // In the corner that is farthest from the part.
        let x = if left + right > w { line } else { w - width - line };
        let y = if top + bottom > h { line } else { h - height - line };
        let mut frame = |[left, top, right, bottom]: [usize; 4]| {
            for y in top.saturating_sub(line)..(bottom + line).min(h) {
                for x in left.saturating_sub(line)..(right + line).min(w) {
                    if !((left..right).contains(&x) && (top..bottom).contains(&y)) {
                        pixels[y * w + x] = FRAME;
                    }
                }
            }
        };
        frame([left, top, right, bottom]);
        frame([x, y, x + width, y + height]);
        for dy in 0..height {
            for dx in 0..width {
                pixels[(y + dy) * w + x + dx] = copy[dy / self.zoom][dx / self.zoom];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_enlarged_in_the_opposite_corner() {
        let inset: Inset = "0,0,0.25,0.25,2".parse().expect("an inset");
        let mut pixels = vec![[0.5; 3]; 16 * 16];
        pixels[0] = [0.9; 3];
        inset.draw([16, 16], &mut pixels).expect("drawn");
        // Four pixels become eight, and end a line's width before the corner.
        let white: Vec<usize> = (0..256).filter(|i| pixels[*i] == [0.9; 3]).collect();
        assert_eq!(white, [0, 7 * 16 + 7, 7 * 16 + 8, 8 * 16 + 7, 8 * 16 + 8]);
        assert_eq!(pixels[15 * 16 + 15], FRAME);
        for wrong in ["0,0,1,1", "0,0,1,1,0", "a,0,1,1,2"] {
            assert!(wrong.parse::<Inset>().is_err(), "{wrong}");
        }
        let outside: Inset = "0.9,0,0.2,0.1,2".parse().expect("numbers");
        assert!(outside.draw([16, 16], &mut pixels).is_err());
    }
}
