//! The film as a picture.

use rayon::prelude::*;

use super::pixel::Pixel;
use super::{Film, Show};
use crate::image_io::Layers;
use crate::math::Rgb;

/// A channel: its name, and its value in a pixel.
type Channel = (String, Box<dyn Fn(&Pixel) -> f64 + Sync>);

impl Film {
    /// All named channels: radiance as R G B, its variance (of the mean), direct, indirect and caustic light, albedo,
    /// normal and depth. If the picture shows one component only, the layers of the others are left out.
    pub fn layers(&self) -> Layers {
        let ([width, height], channels) = (self.size(), channels(self.show));
        let mut values = vec![vec![0.0; width * height]; channels.len()];
        // The rows of all channels, row by row: threads fill them, and read each pixel only once.
        let mut rows: Vec<Vec<&mut [f32]>> = (0..height).map(|_| Vec::new()).collect();
        for plane in &mut values {
            rows.iter_mut().zip(plane.chunks_mut(width)).for_each(|(row, part)| row.push(part));
        }
        rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            for x in 0..width {
                let pixel = self.pixel([x, y]);
                for (part, (_, value)) in row.iter_mut().zip(&channels) {
                    part[x] = value(pixel) as f32;
                }
            }
        });
        let names = channels.into_iter().map(|(name, _)| name);
        Layers { width, height, channels: names.zip(values).collect(), metadata: Vec::new() }
    }

    /// The shown radiance, row by row from the top.
    pub fn radiance(&self) -> Vec<Rgb> {
        let [width, height] = self.size();
        let shown = |p: &Pixel| Rgb::from([0, 1, 2].map(|k| p.shown(k, self.show) as f32));
        (0..width * height).map(|i| shown(self.pixel([i % width, i / width]))).collect()
    }

    fn pixel(&self, at: [usize; 2]) -> &Pixel {
        &self.pixels[self.tiles.place(at)]
    }
}

/// The channels of a picture that shows `show`.
fn channels(show: Show) -> Vec<Channel> {
    let mut channels: Vec<Channel> = Vec::new();
    let mut push = |name: String, value: Box<dyn Fn(&Pixel) -> f64 + Sync>| {
        channels.push((name, value));
    };
    for (k, c) in ["R", "G", "B"].into_iter().enumerate() {
        push(c.to_string(), Box::new(move |p| p.shown(k, show)));
        push(format!("Variance.{c}"), Box::new(move |p| p.variance(k, show)));
        let parts =
            [("Direct", Show::Direct), ("Indirect", Show::Indirect), ("Caustic", Show::Caustic)];
        for (j, (part, alone)) in parts.into_iter().enumerate() {
            if show == Show::All || show == alone {
                push(format!("{part}.{c}"), Box::new(move |p| p.component(j, k)));
            }
        }
        push(format!("Albedo.{c}"), Box::new(move |p| p.albedo(k)));
    }
    for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
        push(format!("N.{axis}"), Box::new(move |p| p.normal(k)));
    }
    push("Z".to_string(), Box::new(|p| p.depth()));
    channels
}
