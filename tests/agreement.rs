//! Compares techniques with each other.

use std::ops::Range;

use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk, GatherRay, PathLimits};
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::{Frame, Rgb};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::texture::Texture;
use gi_core::warp::cosine_hemisphere;
use gi_stats::{Running, sidak, z_test};
use gi_tests::World;
use pathtrace::{Mode, Params, PathTracer};

/// Mean and variance of the mean for blocks of the picture, per channel.
pub(crate) fn blocks(film: &Film, side: usize) -> Vec<(f64, f64)> {
    let layers = film.layers();
    let (w, h) = (layers.width, layers.height);
    let mut out = Vec::new();
    for c in ["R", "G", "B"] {
        let (value, variance) = (
            layers.channel(c).expect("a layer"),
            layers.channel(&format!("Variance.{c}")).expect("one"),
        );
        for y in (0..h).step_by(side) {
            for x in (0..w).step_by(side) {
                let inside = (y..(y + side).min(h))
                    .flat_map(|j| (x..(x + side).min(w)).map(move |i| j * w + i));
                let (mut m, mut v, mut n) = (0.0, 0.0, 0.0);
                for i in inside {
                    m += f64::from(value[i]);
                    v += f64::from(variance[i]);
                    n += 1.0;
                }
                out.push((m / n, v / (n * n)));
            }
        }
    }
    out
}

/// The means of [`blocks`] alone.
pub(crate) fn block_means(film: &Film, side: usize) -> Vec<f64> {
    blocks(film, side).into_iter().map(|(mean, _)| mean).collect()
}

/// Check that two unbiased estimates of the same picture agree in every block.
pub(crate) fn assert_agree(name: &str, a: &Film, b: &Film, side: usize) {
    let (a, b) = (blocks(a, side), blocks(b, side));
    let level = sidak(1e-3, a.len());
    for (k, ((ma, va), (mb, vb))) in a.into_iter().zip(b).enumerate() {
        let p = z_test(ma, va, mb, vb);
        assert!(
            p > level,
            "{name}, block {k}: {ma:.5} +- {:.1e} against {mb:.5} +- {:.1e}, p = {p:.1e}",
            va.sqrt(),
            vb.sqrt()
        );
    }
}

/// Means over parts of pictures that `render` makes from these seeds. Their variance follows from the differences between the pictures,
/// so pixels need not be independent.
pub(crate) fn means_of_parts(
    seeds: Range<u32>,
    render: impl Fn(u32) -> Film,
    parts: impl Fn(&Film) -> Vec<f64>,
) -> Vec<Running> {
    let mut all = Vec::new();
    for seed in seeds {
        let means = parts(&render(seed));
        all.resize(means.len(), Running::default());
        all.iter_mut().zip(means).for_each(|(sum, mean): (&mut Running, _)| sum.push(mean));
    }
    all
}

fn both_ends(world: &World, passes: [u32; 2], show: Show) -> [Film; 2] {
    let render = |mode, passes| {
        world.render::<PathTracer>(&Params { mode, ..Params::default() }, passes, 5, show)
    };
    [render(Mode::Path, passes[0]), render(Mode::Light, passes[1])]
}

#[test]
fn paths_from_the_eye_and_from_the_lights_agree_in_the_cornell_box() {
    let world = World::load("cornell-box.xml", [32, 32], &[]);
    let [eye, light] = both_ends(&world, [256, 256], Show::All);
    assert_agree("cornell-box", &eye, &light, 8);
}

#[test]
fn paths_from_both_ends_agree_with_paths_from_one_in_each_component() {
    let world = World::load("cornell-glossy.xml", [32, 32], &[]);
    for show in [Show::Direct, Show::Indirect] {
        let [eye, both] = [(Mode::Path, 256), (Mode::Bdpt, 128)].map(|(mode, passes)| {
            world.render::<PathTracer>(&Params { mode, ..Params::default() }, passes, 5, show)
        });
        assert_agree(&format!("cornell-glossy, {show:?}"), &eye, &both, 8);
    }
    let world = World::load("ring.xml", [24, 24], &[]);
    let [light, both] = [(Mode::Light, 512), (Mode::Bdpt, 256)].map(|(mode, passes)| {
        world.render::<PathTracer>(&Params { mode, ..Params::default() }, passes, 5, Show::Caustic)
    });
    assert_agree("the ring's caustic", &light, &both, 8);
}

#[test]
fn paths_from_the_eye_and_from_the_lights_agree_on_a_caustic() {
    // Rays from the eye rarely find the small lamp, so many are needed to estimate their variance.
    let world = World::load("ring.xml", [24, 24], &[]);
    let [eye, light] = both_ends(&world, [8192, 2048], Show::Caustic);
    let caustic: f64 = blocks(&light, 24)[0].0;
    assert!(caustic > 0.01, "there is a caustic: {caustic}");
    assert_agree("the ring's caustic", &eye, &light, 8);
}

/// A technique that supplies an estimate at every vertex from one nested path. If the estimates are right,
/// [`gi_core::eye`] must give the right picture.
fn estimated_by_nested_paths(world: &World, whole: bool, passes: u32) -> Film {
    let (scene, camera) = (&world.scene, &world.camera);
    let setting = world.setting(3, Show::All);
    let limits = PathLimits::default();
    let mut film = Film::new(camera.size(), Filter::Box, Show::All);
    for pass in 0..passes {
        film.add_pass(|pixel| {
            let mut walk = EyeWalk::through_pixel(&setting, limits, pixel, pass);
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = nested_estimate(scene, v, whole, &mut walk.sampler)
                {
                    walk.add_estimate(v, estimate);
                }
                walk.add_direct(v);
                if !walk.scatter(v) {
                    break;
                }
            }
            walk.sample()
        });
    }
    film
}

/// Indirect light at a vertex by one path along a gather ray.
fn nested_estimate(
    scene: &Scene,
    v: &EyeVertex,
    whole: bool,
    sampler: &mut Sampler,
) -> Option<Estimate> {
    let (u_choice, u) = (sampler.next_1d(), sampler.next_2d());
    let (covers, factor, wi) = if whole {
        let s = v.bsdf.sample(v.wo, u_choice, u).filter(|s| !s.delta);
        let (factor, wi) = s.map_or((Rgb::BLACK, v.surface.ns()), |s| (s.weight, s.wi));
        (Covers::NonDelta, factor, wi)
    } else {
        let part = v.bsdf.diffuse_part(v.wo)?;
        let wi = Frame::from_normal(part.normal).to_world(cosine_hemisphere(u));
        (Covers::Diffuse(part), part.albedo, wi)
    };
    let ray = scene.spawn(&v.surface, wi);
    let start = GatherRay { ray, segments: v.segments + 1, length: v.length };
    let mut walk = EyeWalk::along(scene, PathLimits::default(), start, sampler.clone());
    while let Some(v) = &walk.next_vertex() {
        walk.add_emitted(v);
        walk.add_direct(v);
        if !walk.scatter(v) {
            break;
        }
    }
    *sampler = walk.sampler.clone();
    let found = walk.sample().radiance;
    Some(Estimate { covers, indirect: factor * found.indirect, direct: None, caustic: None })
}

#[test]
fn paths_with_supplied_estimates_agree_with_plain_paths() {
    let roughness = |alpha| Roughness {
        distribution: Distribution::Ggx,
        alpha_u: Texture::grey(alpha),
        alpha_v: Texture::grey(alpha),
    };
    // For the diffuse part of Phong's model, the estimate is exact; for that of a coat, only nearly. So for coats, the
    // estimate covers all lobes.
    for (name, whole) in [("phong", false), ("smooth coats", true), ("rough coats", true)] {
        let world = World::load_with("cornell-spheres.xml", [24, 24], &[], |parts, _| {
            for material in &mut parts.materials {
                if let Material::Diffuse { reflectance } = material.clone() {
                    let (diffuse, eta, nonlinear) = (reflectance, 1.5, false);
                    let rough = (name == "rough coats").then(|| roughness(0.3));
                    *material = if name == "phong" {
                        let (specular, exponent) = (Texture::grey(0.2), Texture::grey(20.0));
                        Material::Phong { diffuse, specular, exponent }
                    } else {
                        let specular = Texture::grey(1.0);
                        Material::Plastic { eta, diffuse, specular, nonlinear, roughness: rough }
                    };
                }
            }
        });
        let [path, _] = both_ends(&world, [256, 1], Show::All);
        let answered = estimated_by_nested_paths(&world, whole, 256);
        assert_agree(name, &path, &answered, 8);
    }
}
