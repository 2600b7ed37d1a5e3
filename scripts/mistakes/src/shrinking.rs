//! A progressive radius: after each pass R'^2 = R^2 (N + alpha M) / (N + M), and the flux found in the larger disc must shrink by
//! the same factor.

use std::f32::consts::PI;

use gi_core::grid::Grid;
use gi_core::math::Rgb;
use rayon::prelude::*;

use crate::world::{Picture, Seen, World};
use crate::{Args, Way};

/// Share of each pass's photons that stay.
pub(crate) const ALPHA: f32 = 0.7;

/// A pixel's point with its statistics.
struct Point {
    seen: Option<Seen>,
    radius: f32,
    photons: f32,
    flux: Rgb,
}

pub(crate) fn render(world: &World, args: &Args) -> Picture {
    let [w, h] = world.camera.size();
    let radius = args.radius * world.scene.radius();
    let point = |i: usize| {
        let seen = world.seen([(i % w) as f32 + 0.5, (i / w) as f32 + 0.5]);
        Point { seen, radius, photons: 0.0, flux: Rgb::BLACK }
    };
    let mut points: Vec<Point> = (0..w * h).map(point).collect();
    for pass in 0..args.spp {
        let grid = Grid::build(&world.visits(args.light_paths, 3 + pass), radius);
        points.par_iter_mut().for_each(|point| {
            let Some(at) = &point.seen else { return };
            let side = at.surface.ng * 1f32.copysign(at.surface.ng.dot(at.wo));
            let (mut found, mut flux) = (0.0, Rgb::BLACK);
            grid.within(at.surface.p, point.radius, |_, photon, _| {
                if photon.side.dot(side) > 0.5 {
                    found += 1.0;
                    flux += world.f(at, photon.wi) * photon.power;
                }
            });
            if found > 0.0 {
                let kept = (point.photons + ALPHA * found) / (point.photons + found);
                point.photons += ALPHA * found;
                point.radius *= kept.sqrt();
                point.flux += flux;
                if args.way != Way::FluxStays {
                    point.flux *= kept;
                }
            }
        });
    }
    let paths = args.light_paths as f32 * args.spp as f32;
    let radiance = |p: &Point| match &p.seen {
        Some(at) => world.emitted(at) + p.flux / (PI * p.radius * p.radius * paths),
        None => Rgb::BLACK,
    };
    Picture::new(world, points.iter().map(radiance).collect())
}
