//! Direct light: f cos L / pdf, and what happens if a factor is forgotten or counted twice.

use std::f32::consts::PI;

use gi_core::math::Rgb;

use crate::world::{Picture, World};
use crate::{Args, Way};

pub(crate) fn render(world: &World, args: &Args) -> Picture {
    let pixels = world.mean_of(args.spp, |film, sampler| {
        let Some(at) = world.seen(film) else { return Rgb::BLACK };
        let emitted = world.emitted(&at);
        let Some(light) = world.scene.sample_light(at.surface.p, sampler.next_2d()) else {
            return emitted;
        };
        let cos = at.surface.ns().dot(light.wi).abs();
        let f = world.f(&at, light.wi);
        let f_cos = match args.way {
            Way::NoPi => f * PI * cos,
            Way::PiTwice => f / PI * cos,
            Way::NoCosine => f,
            Way::CosineTwice => f * cos * cos,
            _ => f * cos,
        };
        let visibility = world.scene.visibility(&at.surface, &light);
        emitted + f_cos * light.radiance * visibility / light.pdf_w
    });
    Picture::new(world, pixels)
}
