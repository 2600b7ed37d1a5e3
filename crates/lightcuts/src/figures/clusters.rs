//! Trees and their clusters.

use std::collections::HashSet;

use gi_core::canvas::{Canvas, Legend, seen_at};
use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::points::{csv, row};
use gi_core::technique::Picture;
use glam::Vec2;
use vpl::{Kind, Vpl};

use super::common::{Subject, background, colour};
use crate::light::At;
use crate::tree::Tree;

/// Number of clusters per tree at each level that is shown.
const LEVELS: [usize; 4] = [2, 8, 32, 128];

/// The lights over the picture at four levels.
pub(super) fn clusters(subject: &Subject, film: &Film) -> Vec<Picture> {
    LEVELS.map(|count| level(subject, film, count)).into()
}

fn level(subject: &Subject, film: &Film, count: usize) -> Picture {
    let lights = subject.lights;
    let mut canvas = background(film);
    let radius = (film.size()[0] as f32 / 250.0).max(1.0);
    let set = lights.prepared.set();
    let mut first = 0;
    for tree in &lights.forest.trees {
        let clusters = largest(tree, count);
        for (k, node) in clusters.iter().enumerate() {
            for member in tree.members(*node) {
                if let Some(at) = seen(subject, &set.lights[member as usize]) {
                    canvas.disc(at, radius, colour(first + k));
                }
            }
        }
        first += clusters.len();
    }
    let title = format!(
        "{count} clusters per tree, {first} in all. Neighbours of one colour are one cluster"
    );
    Picture {
        name: format!("clusters-{count}"),
        channels: Vec::new(),
        view: canvas.into_pixels(),
        legend: Some(Legend::named(&title, [])),
    }
}

/// The position of a light in the picture; `None` if it is not visible.
fn seen(subject: &Subject, light: &Vpl) -> Option<Vec2> {
    let (scene, camera) = (subject.view.setting.scene, subject.view.setting.camera);
    match light.kind {
        Kind::Directional => None,
        // Lights without a surface have no side.
        Kind::Omni | Kind::Spot(_) => {
            let c = camera.connect(light.p, [0.5; 2], 0.0)?;
            seen_at(scene, camera, light.p, c.wi)
        }
        _ => seen_at(scene, camera, light.p, light.n),
    }
}

/// A cut of at most `count` nodes: the node with the largest power is split repeatedly.
fn largest(tree: &Tree, count: usize) -> Vec<u32> {
    let mut nodes = vec![0];
    while nodes.len() < count {
        let strength = |k: &u32| match tree.node(*k).children() {
            Some(_) => tree.node(*k).power.luminance(),
            None => -1.0,
        };
        let strongest = (0..nodes.len())
            .max_by(|&a, &b| strength(&nodes[a]).total_cmp(&strength(&nodes[b])).then(b.cmp(&a)));
        let Some(k) = strongest else { break };
        let Some([a, b]) = tree.node(nodes[k]).children() else { break };
        nodes[k] = a;
        nodes.push(b);
    }
    nodes
}

/// Orange nodes of the cut, and dark other nodes.
const ON_CUT: Rgb = Rgb::new(1.0, 0.3, 0.0);
const OTHER: Rgb = Rgb::grey(0.05);

/// Largest number of leaves that are drawn; larger trees are cut off below.
const MOST_LEAVES: usize = 64;

/// The pixel whose cut is shown, and the nodes of its cut as (tree, node); none if nothing is visible there.
fn marked_cut<'a>(subject: &Subject<'_, 'a>) -> ([usize; 2], Vec<(u32, u32)>) {
    let middle = subject.view.setting.camera.size().map(|n| n / 2);
    let pixel = subject.view.params.pixel.unwrap_or(middle);
    let nodes = subject.view.at_pixel(pixel, |at: &At<'_, '_, 'a>| {
        subject.cut(at).clusters().iter().map(|c| (c.tree, c.node)).collect()
    });
    (pixel, nodes.unwrap_or_default())
}

/// The nodes of all trees, as a table. A root has no parent. `extent` is the diagonal of the box around the lights. `in_cut` is the
/// number of lights that a node of the marked cut stands for, and 0 for other nodes.
pub(super) fn tree_csv(subject: &Subject) -> Vec<u8> {
    let cut: HashSet<(u32, u32)> = marked_cut(subject).1.into_iter().collect();
    let mut lines = Vec::new();
    for (t, tree) in subject.lights.forest.trees.iter().enumerate() {
        let nodes = tree.nodes();
        let (mut lights, mut parents) = (vec![1usize; nodes.len()], vec![None; nodes.len()]);
        // Parents come before their children.
        for (k, node) in nodes.iter().enumerate().rev() {
            if let Some([a, b]) = node.children().map(|c| c.map(|k| k as usize)) {
                lights[k] = lights[a] + lights[b];
                parents[a] = Some(k);
                parents[b] = Some(k);
            }
        }
        for (k, node) in nodes.iter().enumerate() {
            let in_cut = if cut.contains(&(t as u32, k as u32)) { lights[k] } else { 0 };
            let numbers = row([node.bounds.extent().length(), node.power.luminance()]);
            let parent = parents[k].map_or(String::new(), |p| p.to_string());
            lines.push(format!("{t},{k},{parent},{},{numbers},{in_cut}", lights[k]));
        }
    }
    csv("tree,node,parent,lights,extent,power,in_cut", lines)
}

/// The first tree with its leaves in a row at the bottom. The cut of a pixel is marked.
pub(super) fn tree(subject: &Subject, film: &Film) -> Picture {
    let [w, h] = film.size();
    let mut canvas = Canvas::over([w, h], vec![Rgb::WHITE; w * h]);
    let (pixel, cut) = marked_cut(subject);
    let on_cut: Vec<u32> = cut.iter().filter(|c| c.0 == 0).map(|c| c.1).collect();
    if let Some(tree) = subject.lights.forest.trees.first() {
        let ends = largest(tree, MOST_LEAVES);
        let tallest = height(tree, &ends, 0);
        let (unit, canvas) = ((w as f32 / 500.0).max(1.0), &mut canvas);
        let mut drawing =
            Drawing { tree, ends: &ends, tallest, on_cut: &on_cut, placed: 0, unit, canvas };
        drawing.branch(0);
    }
    let colours = [(ON_CUT, "node of the cut"), (OTHER, "other node (lights are at the bottom)")];
    Picture {
        name: "tree".into(),
        channels: Vec::new(),
        view: canvas.into_pixels(),
        legend: Some(Legend::named(
            &format!("The cut of pixel {}, {}:", pixel[0], pixel[1]),
            colours,
        )),
    }
}

/// The children of a node, unless nothing is drawn below it.
fn drawn_children(tree: &Tree, ends: &[u32], k: u32) -> Option<[u32; 2]> {
    if ends.contains(&k) { None } else { tree.node(k).children() }
}

/// The height of a node over the leaves.
fn height(tree: &Tree, ends: &[u32], k: u32) -> u32 {
    drawn_children(tree, ends, k)
        .map_or(0, |[a, b]| 1 + height(tree, ends, a).max(height(tree, ends, b)))
}

struct Drawing<'d> {
    tree: &'d Tree,
    /// Nodes below which nothing is drawn.
    ends: &'d [u32],
    /// The height of the root.
    tallest: u32,
    on_cut: &'d [u32],
    placed: usize,
    /// Width of a line, pixels.
    unit: f32,
    canvas: &'d mut Canvas,
}

impl Drawing<'_> {
    /// Draw a node and its branches. Returns its horizontal position and its height over the leaves.
    fn branch(&mut self, k: u32) -> (f32, u32) {
        let (x, height) = match drawn_children(self.tree, self.ends, k) {
            None => {
                self.placed += 1;
                (self.placed as f32 - 0.5, 0)
            }
            Some(children) => {
                let below = children.map(|c| self.branch(c));
                let height = 1 + below[0].1.max(below[1].1);
                let x = 0.5 * (below[0].0 + below[1].0);
                for (cx, ch) in below {
                    let (from, to) = (self.place(x, height), self.place(cx, ch));
                    self.canvas.line(from, to, self.unit, Rgb::grey(0.3));
                }
                (x, height)
            }
        };
        let at = self.place(x, height);
        if self.on_cut.contains(&k) {
            self.canvas.disc(at, 5.0 * self.unit, ON_CUT);
        }
        self.canvas.disc(at, 2.5 * self.unit, OTHER);
        (x, height)
    }

    fn place(&self, x: f32, height: u32) -> Vec2 {
        let [w, h] = self.canvas.size().map(|n| n as f32);
        let across = x / self.ends.len() as f32;
        // The spacing of levels shrinks with height, because trees are deep and thin in places.
        let up = |height: u32| 1.0 - 1.0 / (1.0 + 0.18 * height as f32);
        let up = up(height) / up(self.tallest.max(1));
        Vec2::new(across * w, h * (0.95 - 0.9 * up))
    }
}
