//! Lightcuts in participating media, against path tracing.

use gi_core::eye::PathLimits;
use gi_core::film::Show;
use gi_core::options::Caustics;
use gi_tests::World;
use lightcuts::cut::{Limits, Rule};
use lightcuts::{Lightcuts, Method, Params};
use pathtrace::{Mode, PathTracer};

use crate::media_light::{
    assert_accurate, assert_agree, block_means, mode, murky_camera, murky_parts,
};

/// Parameters with few lights. A cut consists of all of them.
fn exact(method: Method, max_depth: Option<u32>) -> Params {
    let mut params = Params { method, vpls: 64, ..Params::default() };
    params.limits = PathLimits { max_depth, ..PathLimits::default() };
    params.lights.total = 16;
    params.cut = Limits { error: 0.0, rule: Rule::Cluster, max_cut: None };
    params.gather = 4;
    params.caustics.caustics = Caustics::Path;
    params
}

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
    let expected = block_means::<PathTracer>(world, &path, passes[0], show, 8);
    for &method in methods {
        let params = exact(method, max_depth);
        let found = block_means::<Lightcuts>(world, &params, passes[1], show, 8);
        let name = format!("{name}, {method:?}, {show:?}, {max_depth:?}");
        assert_agree(&name, &found, &expected);
        [&found, &expected].into_iter().for_each(|all| assert_accurate(&name, all, 0.03));
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
