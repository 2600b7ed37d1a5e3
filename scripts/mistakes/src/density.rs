//! Density of photons: sum of f power / (pi r^2), and mistakes about the power and about which photons count.

use std::f32::consts::PI;

use gi_core::grid::Grid;
use gi_core::math::Rgb;

use crate::world::{Picture, World};
use crate::{Args, Way};

pub(crate) fn render(world: &World, args: &Args) -> Picture {
    let visits = world.visits(args.light_paths, 2);
    let stored: usize = visits.iter().map(Vec::len).sum();
    let emitted = args.light_paths as usize;
    let photons = if args.way == Way::PerStored { stored } else { emitted };
    let radius = args.radius * world.scene.radius();
    let grid = Grid::build(&visits, radius);
    let pixels = world.mean_of(args.spp, |film, _| {
        let Some(at) = world.seen(film) else { return Rgb::BLACK };
        let side = at.surface.ng * 1f32.copysign(at.surface.ng.dot(at.wo));
        let mut sum = world.emitted(&at);
        grid.within(at.surface.p, radius, |_, photon, _| {
            if args.way != Way::FromBehind && photon.side.dot(side) < 0.5 {
                return;
            }
            let adjoint = if args.way == Way::NoAdjoint { 1.0 } else { photon.adjoint };
            // A photon from behind lights the surface as if it came from the front.
            let wi = if photon.wi.dot(side) > 0.0 { photon.wi } else { -photon.wi };
            let area = PI * radius * radius;
            sum += world.f(&at, wi) * photon.power * (adjoint / (area * photons as f32));
        });
        sum
    });
    let facts = vec![("emitted", emitted as f64), ("stored", stored as f64)];
    Picture { facts, ..Picture::new(world, pixels) }
}
