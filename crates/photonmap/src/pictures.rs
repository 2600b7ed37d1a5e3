//! Technique pictures of photon mapping.

use gi_core::canvas::{Canvas, seen_at, seen_within};
use gi_core::film::Film;
use gi_core::geometry::Surface;
use gi_core::math::{Bounds, Frame, Rgb};
use gi_core::ray::Ray;
use gi_core::technique::{Picture, Setting};
use gi_core::warp;
use glam::{Vec2, Vec3};

use crate::estimate::{Estimator, facing};
use crate::gather::Gatherer;
use crate::maps::source;
use crate::params::Figure;
use crate::photon::PhotonKind;
use crate::rays::Rays;
use crate::shoot::{Step, Wanted};
use crate::volume::VolumeMaps;

/// Number of paths that are drawn.
const PATHS: u64 = 200;
/// Number of tree levels that are drawn.
const LEVELS: u32 = 8;
/// Minimum number of pixels per drawn photon in media.
const PIXELS_PER_DOT: usize = 16;
/// The picture under the drawing is darkened by this factor.
const GROUND: f32 = 0.35;

/// Colours of the kinds: yellow, orange-red, blue.
fn colour(kind: PhotonKind) -> Rgb {
    match kind {
        PhotonKind::Direct => Rgb::new(1.0, 0.8, 0.2),
        PhotonKind::Caustic => Rgb::new(1.0, 0.2, 0.05),
        PhotonKind::Indirect => Rgb::new(0.15, 0.45, 1.0),
    }
}

impl Gatherer<'_, '_> {
    /// All pictures that the parameters ask for.
    pub(crate) fn draw(&self, film: &Film) -> Vec<Picture> {
        let mut pictures = Vec::new();
        let mut push = |name: &str, canvas: Canvas| {
            let view = canvas.into_pixels();
            pictures.push(Picture { name: name.into(), channels: Vec::new(), view });
        };
        let ground =
            || Canvas::over(film.size(), film.radiance().into_iter().map(|c| c * GROUND).collect());
        for show in &self.params.figures {
            match show {
                Figure::Paths => push("paths", self.paths(ground())),
                Figure::Photons => {
                    push("photons", self.dots(ground(), &self.maps.global));
                    if let Some(caustic) = &self.maps.caustic {
                        push("caustic-photons", self.dots(ground(), caustic));
                    }
                    if let Some(volume) = self.maps.volume() {
                        push("volume-photons", self.dots_within(ground(), volume));
                    }
                }
                Figure::Cells => push("cells", self.cells(ground())),
                Figure::Gathering => {
                    let [w, h] = film.size();
                    let Some(seen) = self.seen(self.params.probe.unwrap_or([w / 2, h / 2])) else {
                        continue;
                    };
                    push("caustic-gather", self.caustic_gather(ground(), &seen));
                    push("final-gather", self.gather_rays(ground(), &seen));
                }
            }
        }
        pictures
    }

    /// Photons that the eye sees directly, as dots.
    fn dots(&self, mut canvas: Canvas, from: &Estimator) -> Canvas {
        let Setting { scene, camera, .. } = *self.setting;
        for stored in from.map.photons() {
            let payload = stored.photon.payload;
            if let Some(at) = seen_at(scene, camera, stored.photon.p(), payload.normal()) {
                canvas.disc(at, 0.6, colour(payload.kind()));
            }
        }
        canvas
    }

    /// Photons in media that no opaque surface hides, as dots. If there are many, only every n-th is drawn, in the order of the trees,
    /// so that their relative density stays the same.
    fn dots_within(&self, mut canvas: Canvas, from: &VolumeMaps) -> Canvas {
        let Setting { scene, camera, .. } = *self.setting;
        let [w, h] = canvas.size();
        let step = (PIXELS_PER_DOT * from.len()).div_ceil(w * h).max(1);
        for stored in from.photons().flatten().step_by(step) {
            if let Some(at) = seen_within(scene, camera, stored.photon.p()) {
                canvas.disc(at, 0.6, colour(stored.photon.payload.kind()));
            }
        }
        canvas
    }

    /// Photon paths. Each segment has the colour of the photon at its end. Nothing hides them.
    fn paths(&self, mut canvas: Canvas) -> Canvas {
        let source = source(self.setting, self.params);
        for path in 0..PATHS {
            let mut from = None;
            source.walk(Wanted::Global, path, &mut |Step { start, event, .. }| {
                let a = from.unwrap_or(start);
                self.line(&mut canvas, a, event.p(), 0.8, colour(event.kind()));
                from = Some(event.p());
            });
        }
        canvas
    }

    /// The surface in the middle of a pixel, and its normal on the side of the eye.
    fn seen(&self, [x, y]: [usize; 2]) -> Option<(Surface, Vec3)> {
        let ray = self.setting.camera.ray([x as f32 + 0.5, y as f32 + 0.5], [0.5; 2]);
        let (surface, _) = self.setting.scene.intersect(&ray)?;
        let n = facing(&surface, -ray.d);
        Some((surface, n))
    }

    /// The caustic photons of an estimate, and the last segments of their paths.
    fn caustic_gather(&self, mut canvas: Canvas, (surface, n): &(Surface, Vec3)) -> Canvas {
        let Some(map) = &self.maps.caustic else { return canvas };
        let scene = self.setting.scene;
        let radius_sq = map.irradiance(surface.p, *n, u8::MAX).found.radius_sq;
        let near = |p: Vec3| p.distance_squared(surface.p) <= radius_sq;
        for stored in map.map.photons().filter(|s| near(s.photon.p())) {
            let (p, back) = (stored.photon.p(), stored.photon.payload.direction());
            let o = scene.tree().offset_origin(p, stored.photon.payload.normal(), back);
            let from = scene.intersect(&Ray::new(o, back)).map_or(p, |(s, _)| s.p);
            self.line(&mut canvas, from, p, 0.7, colour(PhotonKind::Caustic));
        }
        self.dot(&mut canvas, surface.p);
        canvas
    }

    /// The gather rays of one pass, up to the first surface.
    fn gather_rays(&self, mut canvas: Canvas, (surface, n): &(Surface, Vec3)) -> Canvas {
        let (scene, count) = (self.setting.scene, self.params.gather_rays);
        let (frame, rays) =
            (Frame::from_normal(*n), Rays { seed: self.setting.seed, stream: 0, pass: 0 });
        for k in 0..count {
            let wi = frame.to_world(warp::cosine_hemisphere(rays.direction(k, count)));
            if let Some((met, _)) = scene.intersect(&scene.spawn(surface, wi)) {
                self.line(&mut canvas, surface.p, met.p, 0.7, colour(PhotonKind::Indirect));
                self.dot(&mut canvas, met.p);
            }
        }
        self.dot(&mut canvas, surface.p);
        canvas
    }

    /// A point of the world as a white dot. Nothing hides it.
    fn dot(&self, canvas: &mut Canvas, p: Vec3) {
        if let Some(c) = self.setting.camera.connect(p, [0.5; 2], f32::MAX) {
            canvas.disc(Vec2::from_array(c.film), 1.8, Rgb::WHITE);
        }
    }

    /// The tree's cells down to eight levels, as wires.
    fn cells(&self, mut canvas: Canvas) -> Canvas {
        let photons = self.maps.global.map.photons().map(|s| s.photon.p());
        for cell in self.maps.global.map.cells(Bounds::of(photons), LEVELS) {
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
