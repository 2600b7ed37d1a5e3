//! The film as a picture.

use super::pixel::Pixel;
use super::{Film, Show};
use crate::image_io::Layers;
use crate::math::Rgb;

impl Film {
    /// All named channels: radiance as R G B, its variance (of the mean), direct, indirect and caustic light, albedo, normal and
    /// depth. If the picture shows one component only, the layers of the others are left out.
    pub fn layers(&self) -> Layers {
        let pixels: Vec<&Pixel> =
            (0..self.size()[0] * self.size()[1]).map(|i| self.pixel(i)).collect();
        let mut channels = Vec::new();
        let mut push = |name: String, value: &dyn Fn(&Pixel) -> f64| {
            channels.push((name, pixels.iter().map(|p| value(p) as f32).collect()));
        };
        let show = self.show;
        for (k, c) in ["R", "G", "B"].into_iter().enumerate() {
            push(c.to_string(), &|p| p.shown(k, show));
            push(format!("Variance.{c}"), &|p| p.variance(k, show));
            let parts = [
                ("Direct", Show::Direct),
                ("Indirect", Show::Indirect),
                ("Caustic", Show::Caustic),
            ];
            for (j, (part, alone)) in parts.into_iter().enumerate() {
                if show == Show::All || show == alone {
                    push(format!("{part}.{c}"), &|p| p.component(j, k));
                }
            }
            push(format!("Albedo.{c}"), &|p| f64::from(p.albedo.to_array()[k]));
        }
        for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            push(format!("N.{axis}"), &|p| f64::from(p.normal[k]));
        }
        push("Z".to_string(), &|p| f64::from(p.depth));
        Layers { width: self.size()[0], height: self.size()[1], channels, metadata: Vec::new() }
    }

    /// The shown radiance, row by row from the top.
    pub fn radiance(&self) -> Vec<Rgb> {
        let shown = |p: &Pixel| Rgb::from([0, 1, 2].map(|k| p.shown(k, self.show) as f32));
        (0..self.size()[0] * self.size()[1]).map(|i| shown(self.pixel(i))).collect()
    }

    /// Pixel `i` of the picture in row order.
    fn pixel(&self, i: usize) -> &Pixel {
        let w = self.size()[0];
        &self.pixels[self.tiles.place([i % w, i / w])]
    }
}
