//! Technique pictures of photon mapping.

use gi_core::canvas::{Canvas, Legend, fill, seen_at, seen_within, viridis};
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

/// The kinds of photons, with what their light has met since the source.
const KINDS: [(PhotonKind, &str); 3] = [
    (PhotonKind::Direct, "direct from the light"),
    (PhotonKind::Caustic, "through mirror or glass only"),
    (PhotonKind::Indirect, "scattered by a diffuse surface"),
];

fn kinds_legend(title: &str) -> Legend {
    Legend::named(title, KINDS.map(|(kind, name)| (colour(kind), name)))
}

fn paths_legend() -> Legend {
    kinds_legend(&format!(
        "The first {PATHS} photon paths. A segment has the colour of the photon at its end:"
    ))
}

fn photons_legend(count: usize) -> Legend {
    kinds_legend(&format!("{count} photons, of which the visible ones are drawn:"))
}

fn caustic_legend() -> Legend {
    let colours = [(colour(PhotonKind::Caustic), "last segment of a photon path")];
    Legend::named("One caustic estimate:", colours.into_iter().chain([(Rgb::WHITE, "its point")]))
}

fn gather_legend() -> Legend {
    let ray = (colour(PhotonKind::Indirect), "gather ray");
    Legend::named("One final gather:", [ray, (Rgb::WHITE, "start and ends of the rays")])
}

/// The numbers of photons of the drawn cells, and the colours of the drawing.
fn cells_legend(counts: &[usize]) -> Legend {
    let (cells, least) = (counts.len(), counts.iter().min().unwrap_or(&0));
    let each = match counts.iter().max().unwrap_or(&0) {
        most if most == least => format!("{least}"),
        most => format!("{least} to {most}"),
    };
    let title = format!("At most {LEVELS} levels of splits. {cells} cells of {each} photons each:");
    let colours = [
        (viridis(0.0), "first split (thick)"),
        (viridis(0.9), "last split (thin)"),
        (colour(PhotonKind::Caustic), "photon on the floor"),
        (ABOVE, "above it"),
    ];
    Legend::named(&title, colours)
}

/// Grey photons above the floor.
const ABOVE: Rgb = Rgb::grey(0.3);

/// Colours of the kinds: yellow, red, blue.
fn colour(kind: PhotonKind) -> Rgb {
    match kind {
        PhotonKind::Direct => Rgb::new(1.0, 0.8, 0.2),
        PhotonKind::Caustic => Rgb::new(1.0, 0.03, 0.03),
        PhotonKind::Indirect => Rgb::new(0.15, 0.45, 1.0),
    }
}

impl Gatherer<'_, '_> {
    /// All pictures that the parameters ask for.
    pub(crate) fn draw(&self, film: &Film) -> Vec<Picture> {
        let (mut pictures, mut cells) = (Vec::new(), Vec::new());
        let mut push = |name: &str, canvas: Canvas, legend: Legend| {
            let (view, legend) = (canvas.into_pixels(), Some(legend));
            pictures.push(Picture { name: name.into(), channels: Vec::new(), view, legend });
        };
        let ground =
            || Canvas::over(film.size(), film.radiance().into_iter().map(|c| c * GROUND).collect());
        for show in &self.params.figures {
            match show {
                Figure::Paths => push("paths", self.paths(ground()), paths_legend()),
                Figure::Photons => {
                    let map = &self.maps.global;
                    push("photons", self.dots(ground(), map), photons_legend(map.map.len()));
                    if let Some(caustic) = &self.maps.caustic {
                        let legend = photons_legend(caustic.map.len());
                        push("caustic-photons", self.dots(ground(), caustic), legend);
                    }
                    if let Some(volume) = self.maps.volume() {
                        let legend = photons_legend(volume.len());
                        push("volume-photons", self.dots_within(ground(), volume), legend);
                    }
                }
                Figure::Cells => cells.push(self.cells(film.size())),
                Figure::Gathering => {
                    let [w, h] = film.size();
                    let Some(seen) = self.seen(self.params.probe.unwrap_or([w / 2, h / 2])) else {
                        continue;
                    };
                    push("caustic-gather", self.caustic_gather(ground(), &seen), caustic_legend());
                    push("final-gather", self.gather_rays(ground(), &seen), gather_legend());
                }
            }
        }
        pictures.extend(cells);
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
            canvas.disc(Vec2::from_array(c.film), 1.8 * unit(canvas), Rgb::WHITE);
        }
    }

    /// The tree's cells at the bottom of the scene, where they contain the lowest photons, with all photons in them, seen from above.
    /// The lines of the first splits are the thickest. The channel `photons` has the number of photons of the cell at each pixel.
    fn cells(&self, size: [usize; 2]) -> Picture {
        let [w, h] = size;
        let mut canvas = Canvas::over(size, vec![Rgb::WHITE; w * h]);
        let photons: Vec<Vec3> = self.maps.global.map.photons().map(|s| s.photon.p()).collect();
        let bounds = Bounds::of(photons.iter().copied());
        let extent = (bounds.max - bounds.min).max(Vec3::splat(f32::MIN_POSITIVE));
        let pixels_per_unit = 0.95 * (w as f32 / extent.x).min(h as f32 / extent.z);
        let middle = 0.5 * (bounds.min + bounds.max);
        let at = |x: f32, z: f32| {
            Vec2::new(
                0.5 * w as f32 + (x - middle.x) * pixels_per_unit,
                0.5 * h as f32 + (z - middle.z) * pixels_per_unit,
            )
        };
        let (unit, ground) = (w as f32 / 400.0, bounds.min.y + 1e-3 * extent.y);
        let (mut lowest, mut channel) = (Vec::new(), vec![0.0; w * h]);
        for level in (0..=LEVELS).rev() {
            let colour = viridis(0.9 * level as f32 / LEVELS as f32);
            let width = unit * (0.7 + 0.35 * (LEVELS - level) as f32);
            let cells = self.maps.global.map.cells(bounds, level);
            for (Bounds { min, max }, count) in cells.into_iter().filter(|c| c.0.min.y <= ground) {
                let corners = [(min.x, min.z), (max.x, min.z), (max.x, max.z), (min.x, max.z)];
                let corners = corners.map(|(x, z)| at(x, z));
                (0..4).for_each(|k| canvas.line(corners[k], corners[(k + 1) % 4], width, colour));
                if level == LEVELS {
                    fill(&mut channel, size, corners[0], corners[2], count as f32);
                    lowest.push((Bounds { min, max }, count));
                }
            }
        }
        let inside =
            |p: Vec3| lowest.iter().any(|(c, _)| p.cmpge(c.min).all() && p.cmple(c.max).all());
        for p in photons.iter().filter(|p| inside(**p)) {
            let shade = if p.y <= ground { colour(PhotonKind::Caustic) } else { ABOVE };
            canvas.disc(at(p.x, p.z), 1.3 * unit, shade);
        }
        let counts: Vec<usize> = lowest.iter().map(|(_, count)| *count).collect();
        let legend = cells_legend(&counts);
        let (channels, view) = (vec![("photons".to_string(), channel)], canvas.into_pixels());
        Picture { name: "cells".into(), channels, view, legend: Some(legend) }
    }

    /// A line between two points of the world.
    fn line(&self, canvas: &mut Canvas, a: Vec3, b: Vec3, width: f32, colour: Rgb) {
        let place = |p: Vec3| {
            let c = self.setting.camera.connect(p, [0.5; 2], f32::MAX)?;
            Some(Vec2::from_array(c.film))
        };
        if let (Some(a), Some(b)) = (place(a), place(b)) {
            canvas.line(a, b, width * unit(canvas), colour);
        }
    }
}

/// Scale of line widths and dot radii. It is 1 up to a picture width of 640 pixels, and grows in proportion to larger widths.
fn unit(canvas: &Canvas) -> f32 {
    (canvas.size()[0] as f32 / 640.0).max(1.0)
}
