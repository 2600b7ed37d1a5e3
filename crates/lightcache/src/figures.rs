//! Pictures of a cache.

use std::f32::consts::PI;

use gi_core::canvas::{Canvas, Legend, fill, number, seen_at, viridis};
use gi_core::film::Film;
use gi_core::math::{Bounds, Rgb};
use gi_core::technique::{Picture, Setting};
use glam::{Vec2, Vec3};

use crate::cache::Cache;
pub use crate::options::CacheFigure;
use crate::site::{Query, Site, Sited};

impl CacheFigure {
    /// Draw the figure.
    pub fn draw(self, setting: &Setting, cache: &Cache<impl Sited>, film: &Film) -> Picture {
        let named = |name: &str, (view, legend)| Picture {
            name: name.into(),
            channels: Vec::new(),
            view,
            legend: Some(legend),
        };
        match self {
            CacheFigure::Records => records(setting, cache, film),
            CacheFigure::Validity => named("validity", validity(setting, cache, film)),
            CacheFigure::Octree => named("octree", octree(setting, cache, film)),
            CacheFigure::OctreeSlice => octree_slice(cache, film),
            CacheFigure::Weights => weights(setting, cache, film),
        }
    }
}

/// The picture, darkened so that drawings stand out.
fn background(film: &Film, brightness: f32) -> Canvas {
    let pixels = film.radiance().into_iter().map(|c| c.map(|v| v.clamp(0.0, 1.0)) * brightness);
    Canvas::over(film.size(), pixels.collect())
}

/// The records that are visible in the picture, with their positions in it.
fn visible<'c>(setting: &Setting, cache: &'c Cache<impl Sited>) -> Vec<(&'c Site, Vec2)> {
    let place = |s: &'c Site| Some((s, seen_at(setting.scene, setting.camera, s.p, s.n)?));
    cache.records().iter().map(Sited::site).filter_map(place).collect()
}

/// Colours for radii on a logarithmic scale, and their legend. The smallest hundredth of the radii has the first colour.
fn scale(sites: &[(&Site, Vec2)], what: &str) -> (impl Fn(f32) -> Rgb + use<>, Legend) {
    let mut reaches: Vec<f32> = sites.iter().map(|(s, _)| s.reach()).collect();
    reaches.sort_by(f32::total_cmp);
    // The smallest radius of all may be an outlier, which would take half of the colour scale.
    let low = reaches.get(reaches.len() / 100).copied().unwrap_or(1.0);
    let high = reaches.last().copied().unwrap_or(1.0);
    let of = move |r: f32| if high > low { (r / low).ln() / (high / low).ln() } else { 1.0 };
    let title = format!("{} {what}. Radius (units of the scene):", sites.len());
    (move |r| viridis(of(r)), Legend::logarithmic(&title, low, high))
}

fn records(setting: &Setting, cache: &Cache<impl Sited>, film: &Film) -> Picture {
    let mut canvas = background(film, 0.35);
    let shown = visible(setting, cache);
    let (of_radius, legend) = scale(&shown, "visible records");
    let [w, h] = film.size();
    let mut radius = vec![0.0; w * h];
    for (site, at) in &shown {
        canvas.disc(*at, dot(film), of_radius(site.reach()));
        radius[(at.y as usize).min(h - 1) * w + (at.x as usize).min(w - 1)] = site.reach();
    }
    let channels = vec![("radius".to_string(), radius)];
    let (name, view) = ("records".into(), canvas.into_pixels());
    Picture { name, channels, view, legend: Some(legend) }
}

/// Radius of a dot in pixels, so that dots are visible at any picture size.
fn dot(film: &Film) -> f32 {
    (film.size()[0] as f32 / 400.0).max(0.8)
}

/// Number of corners of the polygon that approximates an ellipse.
const CORNERS: usize = 32;

fn validity(setting: &Setting, cache: &Cache<impl Sited>, film: &Film) -> (Vec<Rgb>, Legend) {
    let mut canvas = background(film, 0.35);
    let shown = visible(setting, cache);
    let (of_radius, legend) = scale(&shown, "discs of validity");
    for (site, _) in &shown {
        let across = site.n.cross(site.axis);
        let corner = |k: usize| {
            let (sin, cos) = (2.0 * PI * k as f32 / CORNERS as f32).sin_cos();
            let p = site.p + site.axis * (site.radii[0] * cos) + across * (site.radii[1] * sin);
            project(setting, p)
        };
        let colour = of_radius(site.reach());
        for k in 0..CORNERS {
            if let (Some(a), Some(b)) = (corner(k), corner(k + 1)) {
                canvas.line(a, b, 0.5 * dot(film), colour);
            }
        }
    }
    (canvas.into_pixels(), legend)
}

/// The position of a point in the picture or near it, whether it is visible or not.
fn project(setting: &Setting, p: Vec3) -> Option<Vec2> {
    let margin = setting.camera.size()[0] as f32;
    setting.camera.connect(p, [0.5; 2], margin).map(|c| Vec2::from_array(c.film))
}

fn octree(setting: &Setting, cache: &Cache<impl Sited>, film: &Film) -> (Vec<Rgb>, Legend) {
    let mut canvas = background(film, 0.35);
    for cell in cache.tree().cells().filter(|cell| cell.items > 0) {
        let corner = |k: usize| {
            let pick =
                |axis: usize| if k >> axis & 1 == 0 { cell.cube.min } else { cell.cube.max }[axis];
            project(setting, Vec3::new(pick(0), pick(1), pick(2)))
        };
        for k in 0..8 {
            for axis in (0..3).filter(|axis| k >> axis & 1 == 0) {
                if let (Some(a), Some(b)) = (corner(k), corner(k | 1 << axis)) {
                    canvas.line(a, b, 0.4, CELL);
                }
            }
        }
    }
    for (_, at) in visible(setting, cache) {
        canvas.disc(at, dot(film), Rgb::WHITE);
    }
    let colours = [(CELL, "edge of a cell"), (Rgb::WHITE, "visible record")];
    (canvas.into_pixels(), Legend::named("", colours))
}

/// Yellow edges of cells over a picture.
const CELL: Rgb = Rgb::new(0.9, 0.75, 0.3);

/// The cells and records at the bottom of the scene, seen from above, with the empty cells. One can count the records of
/// each cell. The channel `records` has the number of records of the cell at each pixel.
fn octree_slice(cache: &Cache<impl Sited>, film: &Film) -> Picture {
    let [w, h] = film.size();
    let mut counts = vec![0.0; w * h];
    let mut canvas = Canvas::over([w, h], vec![Rgb::WHITE; w * h]);
    let bounds = Bounds::of(cache.records().iter().map(|r| r.site().p));
    let extent = (bounds.max - bounds.min).max(Vec3::splat(f32::MIN_POSITIVE));
    let pixels_per_unit = 0.92 * (w as f32 / extent.x).min(h as f32 / extent.z);
    let (middle, ground) = (0.5 * (bounds.min + bounds.max), bounds.min.y + 1e-3 * extent.y);
    let at = |p: Vec3| {
        let d = (p - middle) * pixels_per_unit;
        Vec2::new(0.5 * w as f32 + d.x, 0.5 * h as f32 + d.z)
    };
    let (mut cells, mut fullest) = (0, 0);
    for cell in cache.tree().cells() {
        let Bounds { min, max } = cell.cube;
        if min.y > ground || max.y <= ground {
            continue;
        }
        let corners = [(min.x, min.z), (max.x, min.z), (max.x, max.z), (min.x, max.z)];
        let corners = corners.map(|(x, z)| at(Vec3::new(x, ground, z)));
        for k in 0..4 {
            canvas.line(corners[k], corners[(k + 1) % 4], 0.6 * dot(film), Rgb::grey(0.35));
        }
        let inside = |p: &Vec3| p.cmpge(min).all() && p.cmplt(max).all();
        let records = || cache.records().iter().map(|r| r.site().p).filter(inside);
        records().for_each(|p| canvas.disc(at(p), 1.6 * dot(film), RECORD));
        let count = records().count();
        fill(&mut counts, [w, h], corners[0], corners[2], count as f32);
        cells += 1;
        fullest = fullest.max(count);
    }
    let title =
        format!("{cells} cells at the bottom of the scene, at most {fullest} records in one.");
    let legend = Some(Legend::named(&title, [(RECORD, "record")]));
    let channels = vec![("records".to_string(), counts)];
    Picture { name: "octree-slice".into(), channels, view: canvas.into_pixels(), legend }
}

/// Red records on white paper.
const RECORD: Rgb = Rgb::new(0.7, 0.05, 0.02);

/// The visible record nearest to the middle of the picture.
fn middle_record(setting: &Setting, cache: &Cache<impl Sited>, film: &Film) -> Option<usize> {
    let middle = Vec2::from_array(film.size().map(|n| 0.5 * n as f32));
    let distance = |site: &Site| {
        let at = seen_at(setting.scene, setting.camera, site.p, site.n)?;
        Some((at - middle).length())
    };
    let records = cache.records().iter().enumerate();
    let seen = records.filter_map(|(j, r)| Some((j, distance(r.site())?)));
    seen.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(j, _)| j)
}

fn weights(setting: &Setting, cache: &Cache<impl Sited>, film: &Film) -> Picture {
    let [w, h] = film.size();
    let mut weight = vec![0.0f32; w * h];
    let least = 1.0 / cache.weighing().accuracy;
    if let Some(j) = middle_record(setting, cache, film) {
        for (i, weight) in weight.iter_mut().enumerate() {
            let film_point = [(i % w) as f32 + 0.5, (i / w) as f32 + 0.5];
            let ray = setting.camera.ray(film_point, [0.5; 2]);
            if let Some((surface, _)) = setting.scene.intersect(&ray) {
                let n = surface.ns() * 1f32.copysign(-surface.ns().dot(ray.d));
                *weight = cache.lecture_weight(j, &Query { p: surface.p, n });
            }
        }
    }
    // The colours span two decades around the smallest valid weight. A white line shows where that weight is crossed.
    let good = |i: usize| weight[i] > least;
    let colour = |i: usize| {
        let edge =
            (!i.is_multiple_of(w) && good(i) != good(i - 1)) || (i >= w && good(i) != good(i - w));
        if edge { Rgb::WHITE } else { viridis(0.5 + 0.5 * (weight[i].max(1e-9) / least).log10()) }
    };
    let view = (0..w * h).map(colour).collect();
    let title = format!("Weight w of one record. White line: w = {}", number(least));
    let legend = Some(Legend::logarithmic(&title, least * 0.1, least * 10.0));
    Picture { name: "weights".into(), channels: vec![("w".to_string(), weight)], view, legend }
}
