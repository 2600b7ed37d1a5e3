use super::*;
use crate::gain::gain;
use crate::light::{At, Lights};
use crate::test_scenes::{Checked, is_bent, lights, materials, point, rubble, unshadowed};
use crate::tree::{Forest, Tree};
use gi_core::bsdf::{Toward, Transport};
use gi_core::math::Bounds;
use gi_core::rng::Pcg;
use vpl::{LitSurface, Prepared, Receiver};

/// Check every node of a tree at a point: the light from its lights, and the error bound given its representative.
fn check_tree(lights: &Lights, at: &At, tree: &Tree, checked: &mut Checked) {
    let n = tree.nodes().len();
    let light = |k: u32| unshadowed(lights, at, k, tree.is_direct());
    // The light from each node, computed bottom-up.
    let mut brings = vec![Rgb::BLACK; n];
    for k in (0..n as u32).rev() {
        let node = tree.node(k);
        brings[k as usize] = match node.children() {
            None => light(node.representative),
            Some([a, b]) => brings[a as usize] + brings[b as usize],
        };
        let truth = brings[k as usize];
        let power = lights.prepared.set().lights[node.representative as usize].power;
        let unit = |t: f32, p: f32| if p > 0.0 { t / p } else { 0.0 };
        let estimate = light(node.representative).zip(power, unit) * node.power;
        let bound =
            Terms::new(tree, k, &at.site).map_or(Rgb::BLACK, |t| t.bound(tree, node, &at.site));
        checked.check(truth, bound, &(tree.family, k));
        // The gain of glossy lights is a mean over the cluster, which its representative may exceed.
        if tree.family != Family::Glossy {
            checked.check(estimate, bound, &(tree.family, k));
        }
        let far = (estimate.luminance() - truth.luminance()).abs();
        let said = error(estimate, bound);
        assert!(far <= said || bound.is_black(), "the error is {far}, but its bound is {said}");
        // The error if only the representative is occluded, and if all other lights are occluded.
        assert!(truth.luminance() <= error(Rgb::BLACK, bound));
        assert!(estimate.luminance() <= error(estimate, bound));
    }
}

/// Check all nodes at points of many scenes, grouped by material and by whether shading normals differ.
fn check_scenes(seeds: std::ops::Range<u64>) -> Vec<[Checked; 2]> {
    let mut rng = Pcg::new(21, seeds.start);
    let mut of = vec![[Checked::default(); 2]; materials().len()];
    for seed in seeds {
        let scene = rubble(seed);
        let set = lights(&scene, 400, &mut rng);
        let prepared = Prepared::new(&set, &scene);
        let forest = Forest::build(&scene, &set, false, 1);
        let lights = Lights { scene: &scene, prepared: &prepared, forest: &forest };
        for _ in 0..80 {
            let (surface, wo) = point(&scene, &mut rng);
            let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
            let most = [f32::INFINITY, 4.0, 0.1][rng.next_below(3) as usize];
            let at = At {
                receiver: Receiver::new(&surface, wo, &bsdf),
                site: Site::new(&surface, wo, &bsdf, most),
                deepest: u32::MAX,
                direct: true,
            };
            let shard = surface.shape as usize;
            let checked = &mut of[shard % materials().len()][usize::from(is_bent(shard))];
            forest.trees.iter().for_each(|tree| check_tree(&lights, &at, tree, checked));
        }
    }
    of
}

#[test]
fn no_cluster_exceeds_its_bound() {
    let of = check_scenes(0..16);
    let sum = |f: fn(&Checked) -> u32| of.iter().flatten().map(f).sum::<u32>();
    let (cases, tight, dark) = (sum(|c| c.cases), sum(|c| c.tight), sum(|c| c.dark));
    assert!(cases > 1_000_000, "{cases} cases");
    // A bound that is far too large would pass too, so require cases near the bound.
    assert!(tight > cases / 20 && dark > cases / 20, "{tight} tight, {dark} dark of {cases}");
    for (k, of) in of.iter().enumerate() {
        for (bent, c) in of.iter().enumerate() {
            assert!(c.lit > 1000 && c.tight > 100, "material {k}, bent {bent}: {} lit", c.lit);
        }
    }
}

#[test]
#[ignore = "a minute: a hundred million cases"]
fn no_cluster_of_very_many_exceeds_its_bound() {
    let of = check_scenes(100..1000);
    assert!(of.iter().flatten().all(|c| c.lit > 50_000));
    assert!(of.iter().flatten().map(|c| c.cases).sum::<u32>() > 100_000_000);
}

#[test]
fn a_glossy_light_never_scatters_more_than_its_gain() {
    let mut rng = Pcg::new(22, 0);
    let mut largest = 0.0f32;
    for seed in 0..6 {
        let scene = rubble(seed);
        for _ in 0..150 {
            let (surface, wo) = point(&scene, &mut rng);
            let lit = LitSurface { surface, wo };
            let gain = gain(&scene, &lit);
            let Some(bsdf) = lit.bsdf(&scene) else { continue };
            for _ in 0..200 {
                let drawn = bsdf.sample(wo, rng.next_f32(), rng.next_2d());
                let Some(d) = drawn.filter(|s| !s.delta).map(|s| s.wi) else { continue };
                let sent = bsdf.f_cos(wo, d).max();
                let cos = d.dot(surface.ng).abs();
                // The point lies in direction `d` from the light.
                let gain_toward =
                    gain.toward(&Toward::new(d, &Bounds { min: Vec3::ZERO, max: Vec3::ZERO }));
                assert!(
                    sent <= gain_toward.most && sent <= gain_toward.over_cos * cos * (1.0 + 1e-3),
                    "{sent} {gain_toward:?}"
                );
                largest = largest.max(sent / gain_toward.most);
            }
        }
    }
    assert!(largest > 0.8, "no gain is reached: {largest}");
}
