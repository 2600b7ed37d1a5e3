//! Pictures of the caches, of the basis and of BRDFs.

use std::f32::consts::{PI, TAU};

use gi_core::canvas::{Canvas, Legend};
use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::technique::{Picture, Setting};
use gi_core::warp;
use glam::{Vec2, Vec3};
use lightcache::figures::CacheFigure;

pub use crate::params::Figure;

use crate::brdf::{BrdfRow, BrdfTable};
use crate::caches::Caches;
use crate::params::Params;
use crate::sh::{Basis, Coefficients, MAX_FUNCTIONS, Window, index};
use crate::surfaces::Surfaces;

/// What figures show.
pub(crate) struct Subject<'s> {
    pub(crate) setting: &'s Setting<'s>,
    pub(crate) params: &'s Params,
    pub(crate) surfaces: &'s Surfaces,
    pub(crate) caches: &'s Caches,
    /// The dot product of a BRDF and light.
    pub(crate) dot: fn(&BrdfRow, &Coefficients) -> Rgb,
}

impl Figure {
    /// Draw the figure; a scene without glossy lobes has no BRDF to show.
    pub(crate) fn draw(self, subject: &Subject, film: &Film) -> Vec<Picture> {
        match self {
            Figure::Records => records(subject, film),
            Figure::Basis => {
                let view = basis(subject.params.basis, film.size());
                let title = "Rows: l = 0 to 4. Left to right: m = -l to l.";
                vec![named("basis", view, Legend::named(title, SIGNS))]
            }
            Figure::Brdf => {
                let exact = [(Rgb::BLACK, "BRDF times cosine")];
                let legend = Legend::named("", exact.into_iter().chain(SIGNS));
                let view = brdf(subject, film.size());
                view.map(|view| named("brdf", view, legend)).into_iter().collect()
            }
            Figure::Samples => {
                let view = samples(subject, film.size());
                let colours = [
                    (NEGATIVE, "sampled by the cosine"),
                    (POSITIVE, "by the BRDF times the cosine"),
                    (Rgb::BLACK, "BRDF times cosine"),
                ];
                let title = format!("{DIRECTIONS} directions each:");
                let legend = Legend::named(&title, colours);
                view.map(|view| named("samples", view, legend)).into_iter().collect()
            }
        }
    }
}

fn named(name: &str, view: Vec<Rgb>, legend: Legend) -> Picture {
    Picture { name: name.into(), channels: Vec::new(), view, legend: Some(legend) }
}

fn records(subject: &Subject, film: &Film) -> Vec<Picture> {
    let caches = subject.caches;
    let diffuse = CacheFigure::Records.draw(subject.setting, &caches.diffuse, film);
    let glossy = CacheFigure::Records.draw(subject.setting, &caches.glossy, film);
    vec![diffuse, Picture { name: "glossy-records".into(), ..glossy }]
}

/// Blue and orange, which colour-blind readers can distinguish.
const POSITIVE: Rgb = Rgb::new(0.02, 0.15, 0.6);
const NEGATIVE: Rgb = Rgb::new(0.85, 0.3, 0.02);
const SIGNS: [(Rgb, &str); 2] = [(POSITIVE, "positive"), (NEGATIVE, "negative")];
/// Number of bands that are drawn.
const BANDS: usize = 5;

/// One row per band, m from -l to l. Each function is the surface |y(w)| w, seen from slightly above.
fn basis(basis: Basis, [w, h]: [usize; 2]) -> Vec<Rgb> {
    let mut pixels = vec![Rgb::WHITE; w * h];
    let cell = (w as f32 / (2 * BANDS - 1) as f32).min(h as f32 / BANDS as f32);
    // The eye looks along -z of this frame.
    let towards = Vec3::new(0.35, -0.8, 0.45).normalize();
    let right = Vec3::Z.cross(towards).normalize();
    let up = towards.cross(right);
    for l in 0..BANDS {
        for m in -(l as isize)..=l as isize {
            let middle = Vec2::new(0.5 * w as f32 + m as f32 * cell, (l as f32 + 0.5) * cell);
            let value = |d: Vec3| {
                let mut y = [0.0; MAX_FUNCTIONS];
                basis.evaluate(BANDS, d, &mut y);
                y[index(l, m)]
            };
            let circle = Circle { middle, radius: 0.5 * cell };
            draw_lobe(&mut pixels, [w, h], circle, &value, [right, up, towards]);
        }
    }
    pixels
}

/// The part of a picture that a lobe fills.
struct Circle {
    middle: Vec2,
    radius: f32,
}

/// Draw the surface of the points |value(d)| d with a depth buffer. Its points are dense enough to cover every pixel.
fn draw_lobe(
    pixels: &mut [Rgb],
    [w, h]: [usize; 2],
    Circle { middle, radius }: Circle,
    value: &dyn Fn(Vec3) -> f32,
    [right, up, towards]: [Vec3; 3],
) {
    let steps = (10.0 * radius) as usize + 8;
    let direction = |i: usize, j: usize| {
        let (theta, phi) =
            (PI * (i as f32 + 0.5) / steps as f32, TAU * j as f32 / (2 * steps) as f32);
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let largest = (0..steps / 4 * steps / 2)
        .map(|k| value(direction(4 * k / (steps / 2), 4 * (k % (steps / 2)))).abs())
        .fold(f32::MIN_POSITIVE, f32::max);
    let mut depth = vec![f32::NEG_INFINITY; w * h];
    let point = |i: usize, j: usize| {
        let d = direction(i, j);
        d * (value(d).abs() / largest)
    };
    for i in 0..steps {
        for j in 0..2 * steps {
            let (d, p) = (direction(i, j), point(i, j));
            let at = middle + Vec2::new(p.dot(right), -p.dot(up)) * (0.95 * radius);
            if at.x < 0.0 || at.y < 0.0 || at.x as usize >= w || at.y as usize >= h {
                continue;
            }
            let (k, z) = (at.y as usize * w + at.x as usize, p.dot(towards));
            if z > depth[k] {
                depth[k] = z;
                let n = (point(i + 1, j) - p).cross(point(i, j + 1) - p).normalize_or(towards);
                let light = 0.35 + 0.65 * n.dot(towards).abs();
                pixels[k] = if value(d) >= 0.0 { POSITIVE } else { NEGATIVE } * (1.6 * light);
            }
        }
    }
}

/// Outgoing direction in [`brdf`] and [`samples`]: 45 degrees.
const OUT: Vec3 = Vec3::new(std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2);

/// Polar curves of f_r cos over incoming directions in the plane of the outgoing direction. Each cell shows the BRDF in
/// black and its approximation of one order from 1 to 10 in blue, or orange where it is negative.
fn brdf(subject: &Subject, [w, h]: [usize; 2]) -> Option<Vec<Rgb>> {
    let params = subject.params;
    let (material, _) = subject.surfaces.tables().next()?;
    let lobe = subject.setting.scene.glossy_lobe(material)?;
    let mut canvas = Canvas::over([w, h], vec![Rgb::WHITE; w * h]);
    let (columns, rows) = (5, 2);
    let cell = Vec2::new(w as f32 / columns as f32, h as f32 / rows as f32);
    let direction = |k: usize| {
        let (sin, cos) = (TAU * k as f32 / STEPS as f32).sin_cos();
        Vec3::new(cos, 0.0, sin)
    };
    let exact = |d: Vec3| if d.z > 0.0 { lobe.f_cos(OUT, d).mean() } else { 0.0 };
    let largest = (0..STEPS).map(|k| exact(direction(k))).fold(f32::MIN_POSITIVE, f32::max);
    let reach = 0.9 * cell.x.min(cell.y) / largest;
    for order in 1..=columns * rows {
        let table = BrdfTable::new(&lobe, params.basis, Window::None, order);
        let k = order - 1;
        let middle = cell * Vec2::new((k % columns) as f32 + 0.75, (k / columns) as f32 + 0.75);
        canvas.line(
            middle - Vec2::X * 0.7 * cell.x,
            middle + Vec2::X * 0.2 * cell.x,
            1.0,
            Rgb::grey(0.7),
        );
        let letter = (w as f32 / 50.0).clamp(5.0, 20.0);
        let label = middle + Vec2::new(-0.65 * cell.x, 2.0 * letter);
        canvas.text(label, letter, Rgb::BLACK, &format!("order {order}"));
        let at = |d: Vec3, v: f32| middle + Vec2::new(d.x, -d.z) * (v.abs() * reach);
        let approximated = |d: Vec3| (subject.dot)(&table.at(OUT.z), &table.light_from(d)).mean();
        for k in 0..STEPS {
            let (a, b) = (direction(k), direction(k + 1));
            canvas.line(at(a, exact(a)), at(b, exact(b)), 1.0, Rgb::BLACK);
            let (va, vb) = (approximated(a), approximated(b));
            let colour = if va >= 0.0 { POSITIVE } else { NEGATIVE };
            canvas.line(at(a, va), at(b, vb), 1.5, colour);
        }
    }
    Some(canvas.into_pixels())
}

/// Number of segments of a curve.
const STEPS: usize = 360;

/// Number of sampled directions in a drawing.
const DIRECTIONS: u32 = 300;

/// The BRDF of [`brdf`] from the side, with sampled directions: by the cosine on the left, by the BRDF on the right.
fn samples(subject: &Subject, [w, h]: [usize; 2]) -> Option<Vec<Rgb>> {
    let scene = subject.setting.scene;
    let (material, _) = subject.surfaces.tables().next()?;
    let lobe = scene.glossy_lobe(material)?;
    let mut canvas = Canvas::over([w, h], vec![Rgb::WHITE; w * h]);
    let reach = (0.22 * w as f32).min(0.42 * h as f32);
    let exact = |d: Vec3| lobe.f_cos(OUT, d).mean();
    let elevation = |k: usize| {
        let (sin, cos) = (PI * k as f32 / STEPS as f32).sin_cos();
        Vec3::new(cos, 0.0, sin)
    };
    let largest = (0..STEPS).map(|k| exact(elevation(k))).fold(f32::MIN_POSITIVE, f32::max);
    for (side, colour) in [NEGATIVE, POSITIVE].into_iter().enumerate() {
        let middle = Vec2::new((0.25 + 0.5 * side as f32) * w as f32, 0.5 * h as f32 + 0.5 * reach);
        let at = |d: Vec3| middle + Vec2::new(d.x, -d.z) * reach;
        canvas.line(at(-Vec3::X), at(Vec3::X), 1.0, Rgb::grey(0.6));
        canvas.line(at(Vec3::ZERO), at(OUT), 1.5, Rgb::grey(0.3));
        for k in 0..DIRECTIONS {
            let u = Sampler::new(subject.setting.seed, side as u32, k).next_2d();
            let drawn = match side {
                0 => Some(warp::cosine_hemisphere(u)),
                _ => lobe.sample(OUT, u).map(|(d, _)| d),
            };
            if let Some(d) = drawn.filter(|d| d.z > 0.0) {
                canvas.line(at(0.94 * d), at(d), 1.2, colour);
            }
        }
        for k in 0..STEPS {
            let (a, b) = (elevation(k), elevation(k + 1));
            canvas.line(
                at(a * (exact(a) / largest)),
                at(b * (exact(b) / largest)),
                1.5,
                Rgb::BLACK,
            );
        }
    }
    Some(canvas.into_pixels())
}
