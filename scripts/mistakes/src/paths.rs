//! Path tracing with Russian roulette. Each scattering after the first survives with probability one half; survivors count double.

use gi_core::bsdf::Transport;
use gi_core::math::Rgb;
use gi_core::ray::Ray;

use crate::world::{Picture, Seen, World};
use crate::{Args, Way};

/// Probability of survival.
const SURVIVAL: f32 = 0.5;

pub(crate) fn render(world: &World, args: &Args) -> Picture {
    let pixels = world.mean_of(args.spp, |film, sampler| {
        let (mut light, mut throughput) = (Rgb::BLACK, Rgb::WHITE);
        let mut ray: Ray = world.camera.ray(film, [0.5; 2]);
        for depth in 0..64 {
            let Some((surface, _)) = world.scene.intersect(&ray) else { break };
            let at = Seen { surface, wo: -ray.d };
            if depth == 0 {
                light += world.emitted(&at);
            }
            let (u_light, [u_choice, u_survive], u) =
                (sampler.next_2d(), sampler.next_2d(), sampler.next_2d());
            if let Some(sample) = world.scene.sample_light(at.surface.p, u_light) {
                let f_cos = world.f(&at, sample.wi) * at.surface.ns().dot(sample.wi).abs();
                let visible = world.scene.visibility(&at.surface, &sample);
                light += throughput * f_cos * sample.radiance * visible / sample.pdf_w;
            }
            if depth > 0 {
                if u_survive >= SURVIVAL {
                    break;
                }
                if args.way != Way::BiasedRoulette {
                    throughput = throughput / SURVIVAL;
                }
            }
            let bsdf = world.scene.bsdf(&at.surface, at.wo, Transport::Radiance);
            let Some(scatter) = bsdf.sample(at.wo, u_choice, u) else { break };
            throughput *= scatter.weight;
            ray = world.scene.spawn(&at.surface, scatter.wi);
        }
        light
    });
    Picture::new(world, pixels)
}
