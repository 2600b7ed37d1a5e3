//! Lightcuts in participating media, against path tracing.

use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::options::Caustics;
use gi_core::technique::Technique;
use gi_stats::Running;
use gi_tests::World;
use lightcuts::cut::{Limits, Rule};
use lightcuts::{Lightcuts, Method, Params};
use pathtrace::{Mode, PathTracer};

use crate::agreement::blocks;
use crate::media_light::{assert_agree, mode, murky_camera, murky_parts};

/// Means of blocks of the picture, one value per run of a few passes with a seed of its own: all pixels of a pass share its
/// lights.
fn block_means<'a, T: Technique<'a>>(
    world: &'a World,
    params: &T::Params,
    (runs, passes): (u32, u32),
    show: Show,
) -> Vec<Running> {
    let mut means = Vec::new();
    for seed in 0..runs {
        let mut film = Film::new(world.camera.size(), Filter::Box, show);
        let mut technique =
            T::prepare(world.setting(seed, show), params).expect("valid parameters");
        (0..passes).for_each(|pass| technique.pass(pass, &mut film));
        let blocks = blocks(&film, 8);
        means.resize(blocks.len(), Running::default());
        means.iter_mut().zip(blocks).for_each(|(m, (value, _))| m.push(value));
    }
    means
}

/// Few lights, all of them used if the method is a cut.
fn exact(method: Method, max_depth: Option<u32>) -> Params {
    let mut params = Params { method, vpls: 64, ..Params::default() };
    params.limits = PathLimits { max_depth, ..PathLimits::default() };
    params.lights.total = 16;
    params.cut = Limits { error: 0.0, rule: Rule::Cluster, max_cut: None };
    params.gather = 4;
    params.caustics.caustics = Caustics::Path;
    params
}

/// Number of runs.
const RUNS: u32 = 16;

const METHODS: [Method; 5] =
    [Method::Cuts, Method::All, Method::Stochastic, Method::One, Method::Multidimensional];

/// Check that methods agree with path tracing, and that both are accurate enough to tell.
fn check(
    name: &str,
    world: &World,
    methods: &[Method],
    (show, max_depth, passes): (Show, Option<u32>, [u32; 2]),
) {
    let path = mode(Mode::VolPath, max_depth);
    let expected = block_means::<PathTracer>(world, &path, (RUNS, passes[0]), show);
    for &method in methods {
        let params = exact(method, max_depth);
        let found = block_means::<Lightcuts>(world, &params, (RUNS, passes[1]), show);
        let name = format!("{name}, {method:?}, {show:?}, {max_depth:?}");
        assert_agree(&name, &found, &expected);
        for all in [&found, &expected] {
            let mean = all.iter().map(Running::mean).sum::<f64>();
            let variance = all.iter().map(Running::variance_of_mean).sum::<f64>();
            assert!(variance.sqrt() < 0.03 * mean, "{name}: {mean} +- {}", variance.sqrt());
        }
    }
}

#[test]
fn every_method_agrees_with_path_tracing_in_media() {
    let world = World::new(murky_parts(), &murky_camera());
    check("murky", &world, &METHODS, (Show::All, None, [16, 4]));
    for (show, max_depth) in [(Show::All, Some(3)), (Show::Direct, None), (Show::Indirect, None)] {
        check("murky", &world, &[METHODS[0], METHODS[4]], (show, max_depth, [16, 8]));
    }
}

#[test]
fn multidimensional_lightcuts_agree_with_path_tracing_in_fog_and_behind_glass() {
    // A larger lamp, because paths rarely find a small one through the glass ball.
    for (scene, defines) in [("fog.xml", &[("lamp", "0.5")][..]), ("milk.xml", &[])] {
        let world = World::load(scene, [16, 16], defines);
        check(scene, &world, &[Method::Multidimensional], (Show::All, None, [64, 12]));
    }
}
