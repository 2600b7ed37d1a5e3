use super::*;
use crate::test_scenes::{lights, rubble};
use gi_core::rng::Pcg;

fn forest(count: u32, by_depth: bool, seed: u32) -> (Vpls, Forest) {
    let scene = rubble(1);
    let set = lights(&scene, count, &mut Pcg::new(5, u64::from(count)));
    let forest = Forest::build(&scene, &set, by_depth, seed);
    (set, forest)
}

#[test]
fn a_node_is_small() {
    assert!(size_of::<Node>() <= 64, "{} bytes", size_of::<Node>());
}

#[test]
fn every_node_contains_its_lights_and_every_light_occurs_once() {
    for by_depth in [false, true] {
        let (set, forest) = forest(3000, by_depth, 1);
        let mut seen = vec![0; set.lights.len()];
        for tree in &forest.trees {
            tree.members(0).iter().for_each(|&k| seen[k as usize] += 1);
            for k in 0..tree.nodes().len() as u32 {
                let node = tree.node(k);
                let members = tree.members(k);
                let power: Rgb = members.iter().map(|&k| set.lights[k as usize].power).sum();
                assert!((power.g - node.power.g).abs() <= 1e-5 * power.g);
                if let Some(children) = node.children() {
                    let from_child = |c: u32| tree.node(c).representative == node.representative;
                    assert!(children.into_iter().any(from_child));
                }
                for light in members.iter().map(|&k| &set.lights[k as usize]) {
                    let p = place(light);
                    assert!(node.bounds.with(p) == node.bounds);
                    let turned = tree.family == Family::Oriented || tree.family == Family::Glossy;
                    assert!(!turned || node.cone.axis.dot(light.n) >= node.cone.cos - 1e-5);
                    assert!(
                        (tree.depth[1]..=tree.depth[0]).contains(&light.depth)
                            || tree.depth[0] >= light.depth
                    );
                    assert_eq!(light.depth == 0, tree.is_direct());
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1), "{by_depth}");
    }
}

#[test]
fn a_light_is_the_representative_in_proportion_to_its_power() {
    let trials = 4000u32;
    let (set, first) = forest(24, false, 0);
    let mut counts = vec![vec![0u32; set.lights.len()]; first.trees.len()];
    let scene = rubble(1);
    for seed in 0..trials {
        for (t, tree) in Forest::build(&scene, &set, false, seed).trees.iter().enumerate() {
            counts[t][tree.node(0).representative as usize] += 1;
        }
    }
    let n = f64::from(trials);
    let cases = first.trees.iter().map(|t| t.members(0).len()).sum::<usize>();
    for (tree, counts) in first.trees.iter().zip(counts) {
        for k in tree.members(0) {
            let light = set.lights[k as usize].power.luminance();
            let share = f64::from(light / tree.node(0).power.luminance());
            let z = (f64::from(counts[k as usize]) - n * share)
                / (n * share * (1.0 - share)).max(1.0).sqrt();
            // One of this many cases is beyond 4.5 standard deviations by chance in fewer than one of five thousand
            // runs.
            assert!(z.abs() < 4.5, "light {k} of {cases}: {z} standard deviations off {share}");
        }
    }
}

#[test]
fn the_trees_are_the_same_for_any_number_of_threads() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let (_, forest) = pool.install(|| forest(5000, false, 3));
        format!("{forest:?}")
    };
    let one = with(1);
    assert!(one == with(2) && one == with(4));
}
