//! Which program suits a scene, from facts that were counted.

use gi_core::bsdf::Transport;
use gi_core::camera::{Camera, CameraSpec};
use gi_core::math::Frame;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::Focused;
use gi_core::warp;

/// What is known about a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// Lights to choose from.
    pub(super) lights: usize,
    /// Participating media on boundaries of shapes.
    pub(super) media: usize,
    /// Light over mirrors and glass.
    pub(super) focused: Focused,
    /// What the camera sees.
    pub(super) view: View,
}

/// Fractions of what the camera sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct View {
    /// Pixels that show a surface.
    pub(super) surfaces: f32,
    /// Of these surfaces: Lambertian ones.
    pub(super) diffuse: f32,
    /// Of these surfaces: glossy ones that are not nearly mirrors.
    pub(super) glossy: f32,
    /// Of rays that leave these surfaces: those that hit another one.
    pub(super) enclosed: f32,
}

/// A program, with its mode, and one reason.
#[derive(Debug)]
pub(super) struct Advice {
    pub(super) program: &'static str,
    pub(super) reason: String,
}

/// Smaller fractions of focused light do not matter.
const LITTLE: f32 = 0.01;
/// From this number of lights on, choosing one of them by chance is noisy.
const MANY_LIGHTS: usize = 500;
/// From this fraction on, most of something has a property.
const MOST: f32 = 0.7;
/// Glossy surfaces matter from this fraction on.
const SOME: f32 = 0.2;

/// Choose a program.
pub(super) fn choose(facts: &Facts) -> Advice {
    let percent = |share: f32| format!("{:.0} %", 100.0 * share);
    let Facts { lights, media, focused, view } = facts;
    let (program, reason) = if *lights == 0 {
        ("pathtrace", "nothing shines; add a light first, for example with `--light sky`".into())
    } else if *media > 0 {
        ("pathtrace --mode volpath", format!("participating media on boundaries: {media}"))
    } else if focused.unreachable >= LITTLE {
        let share = percent(focused.unreachable);
        let reason = "of the light comes over mirrors or glass from lights without extent, where no path from the eye ends";
        ("ppm", format!("{share} {reason}"))
    } else if focused.rare >= LITTLE {
        let share = percent(focused.rare);
        let reason = "of the light comes over mirrors or glass from small lamps, which paths from the eye hit rarely";
        ("pathtrace --mode vcm", format!("{share} {reason}"))
    } else if *lights >= MANY_LIGHTS {
        ("lightcuts", format!("there are {lights} lights to choose from"))
    } else if view.glossy >= SOME && view.enclosed >= MOST {
        let reason = format!(
            "{} of the visible surfaces are glossy but no mirrors, in a closed scene",
            percent(view.glossy)
        );
        ("radcache", reason)
    } else if view.diffuse >= MOST && view.enclosed >= MOST {
        let (diffuse, enclosed) = (percent(view.diffuse), percent(view.enclosed));
        let reason = format!(
            "{diffuse} of the visible surfaces are diffuse and {enclosed} of the rays that leave them hit another: \
             indirect light is strong and smooth"
        );
        ("irrcache", reason)
    } else {
        let reason = format!(
            "{} of the rays that leave visible surfaces hit no other: light is mostly direct",
            percent(1.0 - view.enclosed)
        );
        let mixed = "no technique fits all visible surfaces better".to_owned();
        ("pathtrace", if view.enclosed < MOST { reason } else { mixed })
    };
    Advice { program, reason }
}

/// Rays in each direction of the picture.
const SIDE: usize = 48;
/// Separates the random numbers from all others.
const SALT: u32 = 0x696e_7370;
/// Roughness below which a surface is nearly a mirror.
const SHARP: f32 = 0.05;

/// Count what rays from the camera meet, and whether rays from there meet something.
pub(super) fn survey(scene: &Scene, camera: &CameraSpec, seed: u32) -> View {
    let camera = Camera::new(camera);
    let [w, h] = camera.size().map(|n| n as f32 / SIDE as f32);
    let mut counts = [0u32; 4];
    for k in 0..SIDE * SIDE {
        let mut sampler = Sampler::new(seed ^ SALT, 0, k as u32);
        let [u, v] = sampler.next_2d();
        let film = [((k % SIDE) as f32 + u) * w, ((k / SIDE) as f32 + v) * h];
        let ray = camera.ray(film, sampler.next_2d());
        let Some((surface, _)) = scene.intersect(&ray) else { continue };
        let wo = -ray.d;
        let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
        let normal = if wo.dot(surface.ng) < 0.0 { -surface.ng } else { surface.ng };
        let d = Frame::from_normal(normal).to_world(warp::cosine_hemisphere(sampler.next_2d()));
        let glossy =
            !bsdf.is_diffuse() && !bsdf.is_delta() && (SHARP..1.0).contains(&bsdf.roughness());
        let met = scene.closest(&scene.spawn(&surface, d)).is_some();
        let seen = [true, bsdf.is_diffuse(), glossy, met];
        counts.iter_mut().zip(seen).for_each(|(n, is)| *n += u32::from(is));
    }
    let [surfaces, diffuse, glossy, met] = counts.map(|n| n as f32);
    let share = |n: f32| if surfaces > 0.0 { n / surfaces } else { 0.0 };
    View {
        surfaces: surfaces / (SIDE * SIDE) as f32,
        diffuse: share(diffuse),
        glossy: share(glossy),
        enclosed: share(met),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_program_is_suggested_for_its_kind_of_scene() {
        let room = View { surfaces: 1.0, diffuse: 0.9, glossy: 0.0, enclosed: 0.99 };
        let plain = Facts { lights: 2, media: 0, focused: Focused::default(), view: room };
        let unreachable = Focused { unreachable: 0.3, rare: 0.3 };
        let rare = Focused { unreachable: 0.0, rare: 0.3 };
        let glossy = View { diffuse: 0.1, glossy: 0.8, ..room };
        let open = View { enclosed: 0.2, ..room };
        let mirrors = View { diffuse: 0.1, ..room };
        let cases = [
            (Facts { lights: 0, ..plain }, "pathtrace", "nothing shines"),
            (
                Facts { media: 2, ..plain },
                "pathtrace --mode volpath",
                "participating media on boundaries: 2",
            ),
            (Facts { focused: unreachable, ..plain }, "ppm", "30 %"),
            (Facts { focused: rare, ..plain }, "pathtrace --mode vcm", "30 %"),
            (Facts { lights: 3000, ..plain }, "lightcuts", "3000 lights"),
            (plain, "irrcache", "90 % of the visible surfaces are diffuse and 99 %"),
            (Facts { view: glossy, ..plain }, "radcache", "80 %"),
            (Facts { view: open, ..plain }, "pathtrace", "80 % of the rays"),
            (Facts { view: mirrors, ..plain }, "pathtrace", "no technique fits"),
        ];
        for (facts, program, reason) in cases {
            let advice = choose(&facts);
            assert_eq!(advice.program, program, "{advice:?}");
            assert!(advice.reason.contains(reason), "{advice:?}");
        }
    }
}
