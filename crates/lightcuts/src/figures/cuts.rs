//! Of a few lights all cuts: the exact picture, the picture by each cut, and its error [slides 59, 60].

use std::fmt::Write;

use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::technique::Picture;
use rayon::prelude::*;
use vpl::Prepared;

use crate::Lightcuts;
use crate::light::{At, Lights};

/// Most cuts that are drawn.
const MOST_CUTS: usize = 16;

/// A cut of the whole forest: nodes by tree.
type Nodes = Vec<(u32, u32)>;

/// All cuts of the forest, the finest first; no more than [`MOST_CUTS`].
fn all_cuts(lights: &Lights) -> Vec<Nodes> {
    let mut cuts: Vec<Nodes> = vec![Vec::new()];
    for (t, tree) in lights.forest.trees.iter().enumerate() {
        // Cuts below each node, children first.
        let mut below: Vec<Vec<Vec<u32>>> = vec![Vec::new(); tree.nodes().len()];
        for k in (0..tree.nodes().len()).rev() {
            let mut here = Vec::new();
            if let Some([a, b]) = tree.node(k as u32).children() {
                for x in &below[a as usize] {
                    for y in below[b as usize].iter().take(MOST_CUTS) {
                        here.push([&x[..], y].concat());
                    }
                }
                here.truncate(MOST_CUTS);
            }
            here.push(vec![k as u32]);
            below[k] = here;
        }
        let of_tree = |nodes: &Vec<u32>| nodes.iter().map(|&k| (t as u32, k)).collect::<Nodes>();
        let choices: Vec<Nodes> = below[0].iter().map(of_tree).collect();
        cuts = cuts.iter().flat_map(|c| choices.iter().map(|n| [&c[..], n].concat())).collect();
        cuts.truncate(MOST_CUTS);
    }
    cuts.sort_by_key(|c| std::cmp::Reverse(c.len()));
    cuts
}

/// The picture by one cut, middles of pixels only.
fn by_cut<'a>(technique: &Lightcuts<'a>, lights: &Lights<'_, 'a>, cut: &Nodes) -> Vec<Rgb> {
    let [w, h] = technique.setting.camera.size();
    let pixel = |i: usize| {
        let look = |at: &At<'_, '_, 'a>| {
            let node = |&(t, k): &(u32, u32)| {
                let node = lights.forest.trees[t as usize].node(k);
                lights.one_unit(at, node.representative) * node.power
            };
            cut.iter().map(node).sum::<Rgb>()
        };
        technique.looking_at([i % w, i / w], look).unwrap_or(Rgb::BLACK)
    };
    (0..w * h).into_par_iter().map(pixel).collect()
}

/// Mean and 99th percentile of the relative errors of pixels, as luminance.
fn errors(picture: &[Rgb], exact: &[Rgb]) -> [f32; 2] {
    let pairs = picture.iter().zip(exact).filter(|(_, e)| e.luminance() > 0.0);
    let mut errors: Vec<f32> =
        pairs.map(|(p, e)| ((*p - *e).luminance() / e.luminance()).abs()).collect();
    errors.sort_unstable_by(f32::total_cmp);
    let mean = errors.iter().sum::<f32>() / errors.len().max(1) as f32;
    let high = errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0);
    [mean, high]
}

/// A picture a cut, the exact one first.
pub(super) fn pictures<'a>(
    technique: &Lightcuts<'a>,
    lights: &Lights<'_, 'a>,
    _film: &Film,
) -> Vec<Picture> {
    let cuts = all_cuts(lights);
    let exact = by_cut(technique, lights, &cuts[0]);
    let draw = |(i, cut): (usize, &Nodes)| {
        let view = by_cut(technique, lights, cut);
        let error =
            |(p, e): (&Rgb, &Rgb)| (*p - *e).luminance() / e.luminance().max(f32::MIN_POSITIVE);
        let errors = view.iter().zip(&exact).map(error).collect();
        let mut channels: Vec<(String, Vec<f32>)> = Vec::new();
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push((name.into(), view.iter().map(|c| c.to_array()[k]).collect()));
        }
        channels.push(("Error".into(), errors));
        Picture { name: format!("cut-{i}"), channels, view }
    };
    cuts.iter().enumerate().map(draw).collect()
}

/// The cuts with their clusters and errors, as a table.
pub fn cuts_csv(technique: &Lightcuts) -> String {
    let prepared = Prepared::new(&technique.vpls, technique.setting.scene);
    let lights = technique.lights(&prepared);
    let cuts = all_cuts(&lights);
    let exact = by_cut(technique, &lights, &cuts[0]);
    let mut out = String::from("cut,size,clusters,mean_error,error_99\n");
    for (i, cut) in cuts.iter().enumerate() {
        let [mean, high] = errors(&by_cut(technique, &lights, cut), &exact);
        let cluster = |&(t, k): &(u32, u32)| {
            let tree = &lights.forest.trees[t as usize];
            let members: Vec<String> = tree.members(k).iter().map(u32::to_string).collect();
            format!("{}:{}", tree.node(k).representative, members.join("+"))
        };
        let clusters: Vec<String> = cut.iter().map(cluster).collect();
        // A string takes everything.
        _ = writeln!(out, "{i},{},{},{mean},{high}", cut.len(), clusters.join(" "));
    }
    out
}
