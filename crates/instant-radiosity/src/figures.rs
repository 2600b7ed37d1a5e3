//! Pictures of the virtual lights.

use gi_core::bsdf::Transport;
use gi_core::canvas::{Canvas, Legend, seen_at, viridis};
use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::technique::{Picture, Setting};
use glam::Vec2;
use vpl::{Kind, Receiver, Vpls};

pub use crate::params::Figure;

impl Figure {
    /// Draw the figure. `pixel` is the pixel whose connections are drawn; `None` is the middle of the picture.
    pub(crate) fn draw(
        self,
        setting: &Setting,
        vpls: &Vpls,
        film: &Film,
        pixel: Option<[usize; 2]>,
    ) -> Picture {
        let (name, (view, legend)) = match self {
            Figure::Vpls => ("vpls", lights(setting, vpls, film)),
            Figure::Connections => ("connections", connections(setting, vpls, film, pixel)),
        };
        Picture { name: name.into(), channels: Vec::new(), view, legend: Some(legend) }
    }
}

fn background(film: &Film) -> Canvas {
    let pixels = film.radiance().into_iter().map(|c| c.map(|v| v.clamp(0.0, 1.0)) * 0.35);
    Canvas::over(film.size(), pixels.collect())
}

/// Radius of a dot in pixels.
fn dot(film: &Film) -> f32 {
    (film.size()[0] as f32 / 250.0).max(1.0)
}

fn lights(setting: &Setting, vpls: &Vpls, film: &Film) -> (Vec<Rgb>, Legend) {
    let mut canvas = background(film);
    // Lights on light sources are white. The colour of the others is the number of segments of their path; long paths share the last one.
    let named: Vec<(Rgb, String)> = (0..=MOST_SEGMENTS)
        .map(|k| match k {
            0 => (Rgb::WHITE, "on a light source".into()),
            1 => (depth_colour(k), "after 1 segment".into()),
            MOST_SEGMENTS => (depth_colour(k), format!("{k} or more")),
            _ => (depth_colour(k), k.to_string()),
        })
        .collect();
    for v in vpls.lights.iter().filter(|v| v.kind != Kind::Directional) {
        if let Some(at) = seen_at(setting.scene, setting.camera, v.p, v.n) {
            canvas.disc(at, dot(film), depth_colour(v.depth));
        }
    }
    let title = format!("{} virtual lights:", vpls.lights.len());
    let legend = Legend::named(&title, named.iter().map(|(c, name)| (*c, name.as_str())));
    (canvas.into_pixels(), legend)
}

/// Lights after more segments have the colour of this number.
const MOST_SEGMENTS: u32 = 4;

/// The colour of a light after a number of segments from the source.
fn depth_colour(segments: u32) -> Rgb {
    match segments {
        0 => Rgb::WHITE,
        k => viridis(1.0 - (k.min(MOST_SEGMENTS) as f32 - 0.6) / MOST_SEGMENTS as f32),
    }
}

fn connections(
    setting: &Setting,
    vpls: &Vpls,
    film: &Film,
    pixel: Option<[usize; 2]>,
) -> (Vec<Rgb>, Legend) {
    let legend = Legend::named(
        "Shadow rays of one point:",
        [(OPEN, "reaches the light"), (BLOCKED, "occluded"), (Rgb::WHITE, "the point")],
    );
    let mut canvas = background(film);
    let size = film.size();
    let [x, y] = pixel.unwrap_or(size.map(|n| n / 2)).map(|c| c as f32 + 0.5);
    let ray = setting.camera.ray([x, y], [0.5; 2]);
    let Some((surface, _)) = setting.scene.intersect(&ray) else {
        return (canvas.into_pixels(), legend);
    };
    let wo = -ray.d;
    let bsdf = setting.scene.bsdf(&surface, wo, Transport::Radiance);
    let at = Receiver::new(&surface, wo, &bsdf);
    let from = Vec2::new(x, y);
    let margin = size[0] as f32;
    for v in &vpls.lights {
        let Some(c) = vpls.connect(setting.scene, v, &at) else { continue };
        let end = if v.kind == Kind::Directional {
            surface.p + c.wi * setting.scene.radius()
        } else {
            v.p
        };
        let Some(to) = setting.camera.connect(end, [0.5; 2], margin) else { continue };
        let open = !c.transmittance(setting.scene).is_black();
        let colour = if open { OPEN } else { BLOCKED };
        canvas.line(from, Vec2::from_array(to.film), 0.3 * dot(film), colour);
        canvas.disc(Vec2::from_array(to.film), 0.7 * dot(film), colour);
    }
    canvas.disc(from, 1.5 * dot(film), Rgb::WHITE);
    (canvas.into_pixels(), legend)
}

/// A green and a vermilion that colour-blind readers can distinguish.
const OPEN: Rgb = Rgb::new(0.0, 0.35, 0.17);
const BLOCKED: Rgb = Rgb::new(0.66, 0.12, 0.0);
