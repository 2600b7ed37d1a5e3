//! What the technique shows of itself.

mod bounds;
mod clusters;
mod cuts;

use std::path::Path;

use gi_core::bsdf::Transport;
use gi_core::canvas::{Canvas, viridis};
use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::technique::Picture;
use rayon::prelude::*;
use vpl::{MIN_ROUGHNESS, to_file};

use crate::light::{At, Lights};
use crate::{Lightcuts, Params};

pub use bounds::bounds_csv;
pub use cuts::cuts_csv;

pub use crate::params::Figure;

impl Figure {
    /// Draw.
    pub(crate) fn draw<'a>(
        self,
        technique: &Lightcuts<'a>,
        lights: &Lights<'_, 'a>,
        film: &Film,
    ) -> Vec<Picture> {
        match self {
            Figure::CutSize => vec![cut_size(technique, lights, film)],
            Figure::Bounds => vec![bounds::picture(technique, lights, film)],
            Figure::Clusters => clusters::clusters(technique, lights, film),
            Figure::Tree => vec![clusters::tree(technique, lights, film)],
            Figure::Cuts => cuts::pictures(technique, lights, film),
        }
    }
}

impl<'a> Lightcuts<'a> {
    /// The contents of a file that the parameters ask for.
    pub(crate) fn file(&self, path: &Path) -> Vec<u8> {
        let Params { bounds_out, cuts_out, .. } = &self.params;
        if bounds_out.as_deref() == Some(path) {
            return bounds_csv(self).into_bytes();
        }
        if cuts_out.as_deref() == Some(path) {
            return cuts_csv(self).into_bytes();
        }
        to_file(path, &self.vpls.lights, self.setting.scene.origin())
    }

    /// What `look` says of the point that the middle of a pixel shows; `None` where there is nothing to light.
    pub(crate) fn looking_at<T>(
        &self,
        [x, y]: [usize; 2],
        look: impl FnOnce(&At<'_, '_, 'a>) -> T,
    ) -> Option<T> {
        let scene = self.setting.scene;
        let ray = self.setting.camera.ray([x as f32 + 0.5, y as f32 + 0.5], [0.5; 2]);
        let (surface, _) = scene.intersect(&ray)?;
        let bsdf = scene.bsdf(&surface, -ray.d, Transport::Radiance);
        let bsdf = bsdf.broad(-ray.d, MIN_ROUGHNESS)?;
        Some(look(&self.at(&surface, -ray.d, &bsdf, (1, 0))?))
    }
}

fn background(film: &Film) -> Canvas {
    let pixels = film.radiance().into_iter().map(|c| c.map(|v| v.clamp(0.0, 1.0)) * 0.35);
    Canvas::over(film.size(), pixels.collect())
}

fn cut_size<'a>(technique: &Lightcuts<'a>, lights: &Lights<'_, 'a>, film: &Film) -> Picture {
    let [w, h] = film.size();
    let size = |i: usize| {
        let light = |at: &At<'_, '_, 'a>| {
            let lit = lights.light(at, &technique.params.cut);
            [lit.size as f32, lit.rays as f32]
        };
        technique.looking_at([i % w, i / w], light).unwrap_or([0.0; 2])
    };
    let sizes: Vec<[f32; 2]> = (0..w * h).into_par_iter().map(size).collect();
    let largest = sizes.iter().map(|s| s[0]).fold(1.0, f32::max);
    let channel = |k: usize| sizes.iter().map(|s| s[k]).collect::<Vec<f32>>();
    Picture {
        name: "cut-size".into(),
        channels: vec![("Clusters".into(), channel(0)), ("Rays".into(), channel(1))],
        view: sizes.iter().map(|s| viridis(s[0] / largest)).collect(),
    }
}

/// A colour that neighbours in a list do not share.
fn colour(k: usize) -> Rgb {
    let hue = (k as f32 * 0.618_034).fract() * 6.0;
    let part = |shift: f32| ((hue + shift) % 6.0 - 3.0).abs().clamp(1.0, 2.0) - 1.0;
    Rgb::new(part(0.0), part(4.0), part(2.0)) * 0.8 + Rgb::grey(0.1)
}
