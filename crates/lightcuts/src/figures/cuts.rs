//! All cuts of a few lights: the exact picture, the picture with each cut, and its error [slides 59, 60].

use gi_core::math::Rgb;
use gi_core::points::csv;
use gi_core::technique::Picture;
use rayon::prelude::*;

use super::common::Subject;
use crate::light::{At, Lights};
use crate::tree::NodeId;

/// Largest number of cuts that are drawn.
const MOST_CUTS: usize = 16;

/// A cut of the whole forest: nodes by tree.
type Nodes = Vec<NodeId>;

/// All cuts of the forest, the finest first, but at most [`MOST_CUTS`].
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
        let of_tree = |nodes: &Vec<u32>| {
            nodes.iter().map(|&node| NodeId { tree: t as u32, node }).collect::<Nodes>()
        };
        let choices: Vec<Nodes> = below[0].iter().map(of_tree).collect();
        cuts = cuts.iter().flat_map(|c| choices.iter().map(|n| [&c[..], n].concat())).collect();
        cuts.truncate(MOST_CUTS);
    }
    cuts.sort_by_key(|c| std::cmp::Reverse(c.len()));
    cuts
}

/// The picture with one cut, with one sample at the middle of each pixel.
fn by_cut<'a>(subject: &Subject<'_, 'a>, cut: &Nodes) -> Vec<Rgb> {
    let (view, lights) = (&subject.view, subject.lights);
    let [w, h] = view.setting.camera.size();
    let pixel = |i: usize| {
        let look = |at: &At<'_, '_, 'a>| {
            let node = |id: &NodeId| {
                let node = lights.forest.trees[id.tree as usize].node(id.node);
                lights.one_unit(at, node.representative) * node.power
            };
            cut.iter().map(node).sum::<Rgb>()
        };
        view.at_pixel([i % w, i / w], look).unwrap_or(Rgb::BLACK)
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

/// One picture per cut, the exact one first.
pub(super) fn pictures(subject: &Subject) -> Vec<Picture> {
    let cuts = all_cuts(subject.lights);
    let exact = by_cut(subject, &cuts[0]);
    let draw = |(i, cut): (usize, &Nodes)| {
        let view = by_cut(subject, cut);
        let error =
            |(p, e): (&Rgb, &Rgb)| (*p - *e).luminance() / e.luminance().max(f32::MIN_POSITIVE);
        let errors = view.iter().zip(&exact).map(error).collect();
        let mut channels: Vec<(String, Vec<f32>)> = Vec::new();
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push((name.into(), view.iter().map(|c| c.to_array()[k]).collect()));
        }
        channels.push(("Error".into(), errors));
        Picture { name: format!("cut-{i}"), channels, view, legend: None }
    };
    cuts.iter().enumerate().map(draw).collect()
}

/// The cuts with their clusters and errors, as a table.
pub(super) fn cuts_csv(subject: &Subject) -> Vec<u8> {
    let lights = subject.lights;
    let cuts = all_cuts(lights);
    let exact = by_cut(subject, &cuts[0]);
    let line = |(i, cut): (usize, &Nodes)| {
        let [mean, high] = errors(&by_cut(subject, cut), &exact);
        let cluster = |id: &NodeId| {
            let tree = &lights.forest.trees[id.tree as usize];
            let members: Vec<String> = tree.members(id.node).iter().map(u32::to_string).collect();
            format!("{}:{}", tree.node(id.node).representative, members.join("+"))
        };
        let clusters: Vec<String> = cut.iter().map(cluster).collect();
        format!("{i},{},{},{mean},{high}", cut.len(), clusters.join(" "))
    };
    csv("cut,size,clusters,mean_error,error_99", cuts.iter().enumerate().map(line))
}
