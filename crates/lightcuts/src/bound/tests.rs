use super::*;
use crate::light::{At, Lights};
use crate::test_scenes::{lights, point, rubble};
use crate::tree::Forest;
use gi_core::rng::Pcg;
use vpl::{Prepared, Receiver};

/// What a light brings with nothing in between.
fn unshadowed(lights: &Lights, at: &At, k: u32, direct: bool) -> Rgb {
    let power = lights.prepared.set().lights[k as usize].power;
    lights
        .prepared
        .connect_unit(k as usize, &at.receiver)
        .map_or(Rgb::BLACK, |c| c.radiance * power * at.kept(c.geometry, direct))
}

#[test]
fn no_cluster_brings_more_than_its_bound() {
    let mut rng = Pcg::new(21, 0);
    let (mut cases, mut tight, mut dark) = (0u32, 0u32, 0u32);
    for seed in 0..12 {
        let scene = rubble(seed);
        let set = lights(&scene, 400, &mut rng);
        let prepared = Prepared::new(&set, &scene);
        let forest = Forest::build(&scene, &set, false, 1);
        let lights = Lights { scene: &scene, prepared: &prepared, forest: &forest };
        for _ in 0..60 {
            let (surface, wo) = point(&scene, &mut rng);
            let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
            let most = [f32::INFINITY, 4.0, 0.1][rng.next_below(3) as usize];
            let at = At {
                receiver: Receiver::new(&surface, wo, &bsdf),
                site: Site::new(&surface, wo, &bsdf, most),
                deepest: u32::MAX,
                direct: true,
            };
            for tree in &forest.trees {
                let n = tree.nodes().len();
                let light = |k: u32| unshadowed(&lights, &at, k, tree.is_direct());
                // What every node's lights bring, from below.
                let mut brings = vec![Rgb::BLACK; n];
                for k in (0..n as u32).rev() {
                    let node = tree.node(k);
                    brings[k as usize] = match node.children() {
                        None => light(node.representative),
                        Some([a, b]) => brings[a as usize] + brings[b as usize],
                    };
                    let truth = brings[k as usize];
                    let power = prepared.set().lights[node.representative as usize].power;
                    let said = light(node.representative);
                    let unit = |t: f32, p: f32| if p > 0.0 { t / p } else { 0.0 };
                    let estimate = said.zip(power, unit) * node.power;
                    let bound = Terms::new(tree, k, &at.site)
                        .map_or(Rgb::BLACK, |t| t.bound(tree, node, &at.site));
                    for value in [truth, estimate] {
                        // Channel by channel, and nothing at all where the bound is nothing. (Not a number: infinite.)
                        let pairs = value.to_array().into_iter().zip(bound.to_array());
                        let holds = pairs.into_iter().all(|(v, b)| v <= b || b.is_nan());
                        assert!(holds, "{:?} {k}: {value:?} above {bound:?}", tree.family);
                        cases += 1;
                        dark += u32::from(bound.is_black());
                        tight += u32::from(value.luminance() > 0.3 * bound.luminance());
                    }
                    let far = (estimate.luminance() - truth.luminance()).abs();
                    let said = error(estimate, bound);
                    assert!(far <= said || bound.is_black(), "{far} apart, at most {said} said");
                    // Where something stands before the representative, and where it stands before all others.
                    assert!(truth.luminance() <= error(Rgb::BLACK, bound));
                    assert!(estimate.luminance() <= error(estimate, bound));
                }
            }
        }
    }
    assert!(cases > 500_000, "{cases} cases");
    // A bound that is never near would hold too.
    assert!(tight > cases / 20 && dark > cases / 20, "{tight} tight, {dark} dark of {cases}");
}

#[test]
fn a_glossy_light_never_sends_more_than_its_gain() {
    let mut rng = Pcg::new(22, 0);
    let mut largest = 0.0f32;
    for seed in 0..6 {
        let scene = rubble(seed);
        for _ in 0..150 {
            let (surface, wo) = point(&scene, &mut rng);
            let lit = LitSurface { surface, wo };
            let gain = gain(&scene, &lit);
            let bsdf = scene.bsdf(&surface, wo, Transport::Power);
            for _ in 0..200 {
                let drawn = bsdf.sample(wo, rng.next_f32(), rng.next_2d());
                let Some(d) = drawn.filter(|s| !s.delta).map(|s| s.wi) else { continue };
                let turned = gi_core::walk::adjoint_correction(&surface, wo, d);
                let sent = bsdf.f_cos(wo, d).max() * turned;
                let cos = d.dot(surface.ng).abs();
                assert!(
                    sent <= gain.most && sent <= gain.over_cos * cos * (1.0 + 1e-3),
                    "{sent} {gain:?}"
                );
                largest = largest.max(sent / gain.most);
            }
        }
    }
    assert!(largest > 0.8, "no gain is reached: {largest}");
}
