//! Indirect light from virtual point lights: f G f power, with the geometry term G bounded or not.

use gi_core::grid::Item;
use gi_core::math::Rgb;
use gi_core::ray::Ray;

use crate::world::{Picture, Visit, World};
use crate::{Args, Way};

/// Bound of the geometry term, in 1 / squared scene radius.
const BOUND: f32 = 3.0;

pub(crate) fn render(world: &World, args: &Args) -> Picture {
    let lights: Vec<Item<Visit>> = world.visits(args.light_paths, 4).concat();
    let radius = world.scene.radius();
    let bound = if args.way == Way::Unclamped { f32::INFINITY } else { BOUND / (radius * radius) };
    let pixels = world.mean_of(args.spp, |film, _| {
        let Some(at) = world.seen(film) else { return Rgb::BLACK };
        let one = |light: &Item<Visit>| {
            let to = light.p - at.surface.p;
            let wi = to.normalize_or_zero();
            let (here, there) = (at.surface.ns().dot(wi), light.value.side.dot(-wi));
            let g = (here.abs() * there.max(0.0) / to.length_squared().max(1e-12)).min(bound);
            let ray: Ray = world.scene.tree().shadow_ray(at.surface.p, at.surface.ng, light.p);
            if g == 0.0 || world.scene.transmittance(ray).is_black() {
                return Rgb::BLACK;
            }
            world.f(&at, wi) * light.value.albedo * light.value.power * (g / std::f32::consts::PI)
        };
        lights.iter().map(one).sum::<Rgb>() / args.light_paths as f32
    });
    Picture::new(world, pixels)
}
