use super::*;
use crate::cut::{Limits, Rule};
use crate::test_scenes::{lights, point, rubble};
use crate::{choose, light_by_cut};
use gi_core::bsdf::Transport;
use gi_core::rng::Pcg;

/// Call `test` with random points of test scenes, lights and a bound of the geometry term.
pub(crate) fn at_points(count: u32, each: u32, mut test: impl FnMut(&Lights, &At)) {
    let mut rng = Pcg::new(31, 0);
    for seed in 0..4 {
        let scene = rubble(seed);
        let set = lights(&scene, count, &mut rng);
        let prepared = Prepared::new(&set, &scene);
        let forest = Forest::build(&scene, &set, false, 1);
        let lights = Lights { scene: &scene, prepared: &prepared, forest: &forest };
        for k in 0..each {
            let (surface, wo) = point(&scene, &mut rng);
            let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
            let most = if k % 2 == 0 { f32::INFINITY } else { 2.0 };
            test(
                &lights,
                &At {
                    receiver: Receiver::new(&surface, wo, &bsdf),
                    site: Site::new(&surface, wo, &bsdf, most),
                    deepest: u32::MAX,
                    direct: true,
                },
            );
        }
    }
}

fn close(a: Rgb, b: Rgb) -> bool {
    // Equal except for the rounding of sums of some hundred terms in a different order.
    let near = |(a, b): (f32, f32)| (a - b).abs() <= 1e-4 * (a.abs() + b.abs()) + 1e-9;
    a.to_array().into_iter().zip(b.to_array()).all(near)
}

#[test]
fn with_error_zero_the_result_is_that_of_all_lights() {
    let mut some = 0;
    at_points(300, 150, |lights, at| {
        let exact = lights.light_by_all(at);
        let lit = light_by_cut(
            lights,
            at,
            &Limits { error: 0.0, rule: Rule::Whole, max_cut: Some(u32::MAX) },
        );
        assert!(close(lit.direct, exact.direct), "{lit:?} is not {exact:?}");
        assert!(close(lit.indirect, exact.indirect), "{lit:?} is not {exact:?}");
        assert!(!lit.at_most);
        let cut_off = (lit.cut_off - exact.cut_off).abs();
        assert!(cut_off <= 1e-3 * exact.cut_off + 1e-6, "{lit:?} {exact:?}");
        some += u32::from(!exact.all().is_black());
    });
    assert!(some > 300, "{some} points are lit");
}

#[test]
fn every_cut_partitions_the_lights_that_can_contribute() {
    at_points(300, 20, |lights, at| {
        for max_cut in [1, 7, 40, u32::MAX] {
            let mut cut = Cut::default();
            let limits = Limits { error: 0.02, rule: Rule::Whole, max_cut: Some(max_cut) };
            choose(lights, at, &limits, &mut cut, &mut None);
            let mut seen = vec![0; lights.prepared.set().lights.len()];
            for cluster in cut.clusters() {
                let tree = &lights.forest.trees[cluster.tree as usize];
                tree.members(cluster.node).iter().for_each(|&k| seen[k as usize] += 1);
            }
            for (k, n) in seen.into_iter().enumerate() {
                let brings = !lights.one(at, k as u32).is_black();
                assert!(n == 1 || n == 0 && !brings, "light {k} is in {n} clusters");
            }
            let roots = lights.forest.trees.len();
            // Roots that are pairs of lights count as two clusters.
            assert!(cut.clusters().len() <= (max_cut as usize).max(2 * roots));
        }
    });
}

#[test]
fn no_cluster_of_a_finished_cut_exceeds_the_allowed_error_and_larger_errors_give_smaller_cuts() {
    let (mut sizes, mut clusters, mut far) = ([0u32; 3], 0u32, 0u32);
    at_points(500, 60, |lights, at| {
        for (k, error) in [0.005, 0.02, 0.1].into_iter().enumerate() {
            let mut cut = Cut::default();
            let limits = Limits { error, rule: Rule::Whole, max_cut: Some(u32::MAX) };
            choose(lights, at, &limits, &mut cut, &mut None);
            let lit = lights.add_up(&mut cut, &limits);
            sizes[k] += lit.size;
            let allowed = error * lit.all().luminance() * (1.0 + 1e-4) + 1e-9;
            for cluster in cut.clusters().iter().filter(|c| c.error > 0.0) {
                let tree = &lights.forest.trees[cluster.tree as usize];
                let members = tree.members(cluster.node);
                let truth: Rgb = members.iter().map(|&k| lights.one(at, k)).sum();
                let estimate = cluster.unit * tree.node(cluster.node).power;
                let off = (truth - estimate).luminance().abs();
                assert!(off <= allowed, "{off} off, {allowed} allowed");
                clusters += 1;
                far += u32::from(off > 0.1 * allowed);
            }
        }
    });
    assert!(sizes[0] > sizes[1] && sizes[1] > sizes[2], "{sizes:?}");
    assert!(clusters > 1000 && far > 10, "only {far} of {clusters} clusters have an error");
}

#[test]
fn the_maximum_number_of_clusters_is_kept_and_reported() {
    let mut at_most = 0;
    at_points(300, 30, |lights, at| {
        let lit = light_by_cut(
            lights,
            at,
            &Limits { error: 0.001, rule: Rule::Whole, max_cut: Some(12) },
        );
        assert!(lit.size <= 12);
        at_most += u32::from(lit.at_most);
        assert!(
            !light_by_cut(
                lights,
                at,
                &Limits { error: 0.001, rule: Rule::Whole, max_cut: Some(u32::MAX) }
            )
            .at_most
        );
    });
    assert!(at_most > 30, "{at_most}");
}
