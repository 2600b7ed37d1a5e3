//! Pictures that photon mapping draws of itself.

use gi_core::canvas::{Canvas, seen_at};
use gi_core::film::Film;
use gi_core::math::{Bounds, Rgb};
use gi_core::technique::{Picture, Setting};
use glam::{Vec2, Vec3};

use crate::PhotonMapping;
use crate::estimate::Estimator;
use crate::photon::Kind;
use crate::shoot::{Source, Wanted, kind};

/// What can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// The first 200 photon paths [slide 22].
    Paths,
    /// The photons of both maps as dots, a picture each [slides 23, 26].
    Photons,
    /// The cells of the tree over the global map [slide 25].
    Cells,
}

/// Paths that are drawn.
const PATHS: u64 = 200;
/// Levels of cells that are drawn.
const LEVELS: u32 = 8;
/// What lies under the drawing is darkened to this share.
const GROUND: f32 = 0.35;

/// Colours of the kinds: yellow, orange-red, blue.
fn colour(kind: Kind) -> Rgb {
    match kind {
        Kind::Direct => Rgb::new(1.0, 0.8, 0.2),
        Kind::Caustic => Rgb::new(1.0, 0.2, 0.05),
        Kind::Indirect => Rgb::new(0.15, 0.45, 1.0),
    }
}

impl PhotonMapping<'_> {
    /// All that the parameters ask for.
    pub(crate) fn draw(&self, film: &Film) -> Vec<Picture> {
        let mut pictures = Vec::new();
        let mut push = |name: &str, canvas: Canvas| {
            let view = canvas.into_pixels();
            pictures.push(Picture { name: name.into(), channels: Vec::new(), view });
        };
        let ground =
            || Canvas::over(film.size(), film.radiance().into_iter().map(|c| c * GROUND).collect());
        for show in &self.params.show {
            match show {
                Show::Paths => push("paths", self.paths(ground())),
                Show::Photons => {
                    push("photons", self.dots(ground(), &self.global));
                    if let Some(caustic) = &self.caustic {
                        push("caustic-photons", self.dots(ground(), caustic));
                    }
                }
                Show::Cells => push("cells", self.cells(ground())),
            }
        }
        pictures
    }

    /// Photons that the eye sees directly, as dots.
    fn dots(&self, mut canvas: Canvas, from: &Estimator) -> Canvas {
        let Setting { scene, camera, .. } = self.setting;
        for stored in from.map.photons() {
            let payload = stored.photon.payload;
            if let Some(at) = seen_at(scene, camera, stored.photon.p(), payload.normal()) {
                canvas.disc(at, 0.6, colour(payload.kind()));
            }
        }
        canvas
    }

    /// Photon paths, their segments in the colour of the photon at their end; what stands before them hides nothing.
    fn paths(&self, mut canvas: Canvas) -> Canvas {
        let scene = self.setting.scene;
        let max_segments = self.params.max_depth.map(|most| most.saturating_sub(1));
        let source = Source { scene, seed: self.setting.seed, max_segments };
        for path in 0..PATHS {
            let mut from = None;
            source.walk(Wanted::Global, path, &mut |start, vertex| {
                let a = from.unwrap_or(start);
                self.line(&mut canvas, a, vertex.surface.p, 0.8, colour(kind(vertex)));
                from = Some(vertex.surface.p);
            });
        }
        canvas
    }

    /// The tree's cells down to eight levels, as wires.
    fn cells(&self, mut canvas: Canvas) -> Canvas {
        let photons = self.global.map.photons().map(|s| s.photon.p());
        for cell in self.global.map.cells(Bounds::of(photons), LEVELS) {
            let corner = |k: usize| {
                let pick =
                    |axis: usize| if k >> axis & 1 == 0 { cell.min[axis] } else { cell.max[axis] };
                Vec3::new(pick(0), pick(1), pick(2))
            };
            for k in 0..8usize {
                for axis in (0..3).filter(|axis| k >> axis & 1 == 0) {
                    let (a, b) = (corner(k), corner(k | 1 << axis));
                    self.line(&mut canvas, a, b, 0.6, Rgb::new(0.2, 0.9, 0.4));
                }
            }
        }
        canvas
    }

    /// A line between two points of the world.
    fn line(&self, canvas: &mut Canvas, a: Vec3, b: Vec3, width: f32, colour: Rgb) {
        let place = |p: Vec3| {
            let c = self.setting.camera.connect(p, [0.5; 2], f32::MAX)?;
            Some(Vec2::from_array(c.film))
        };
        if let (Some(a), Some(b)) = (place(a), place(b)) {
            canvas.line(a, b, width, colour);
        }
    }
}
