//! Draws a light tree with the cut of one pixel.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, ensure};

use crate::svg::FONT;
use crate::table::Table;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The drawing to write (.svg)
    out: PathBuf,
    /// The nodes, as written by lightcuts --tree-out
    #[arg(long)]
    table: PathBuf,
    /// The tree to draw
    #[arg(long, default_value_t = 0)]
    tree: usize,
}

/// A node of the tree.
struct Node {
    children: Vec<usize>,
    lights: usize,
    is_in_cut: bool,
}

const SIZE: [f64; 2] = [720.0, 420.0];
/// Height of the legend, and free space at the other borders.
const LEGEND: f64 = 34.0;
const MARGIN: f64 = 20.0;
/// Largest number of lights that fit beside each other.
const MOST_LIGHTS: usize = 128;

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let nodes = read(&args.table, args.tree)?;
    let lights = nodes[0].lights;
    ensure!(lights <= MOST_LIGHTS, "the tree has {lights} lights; at most {MOST_LIGHTS} fit");
    std::fs::write(&args.out, drawing(&nodes)).with_context(|| args.out.display().to_string())
}

/// The nodes of one tree, the root first. Parents come before their children.
fn read(path: &std::path::Path, tree: usize) -> anyhow::Result<Vec<Node>> {
    let table = Table::read(path)?;
    let mut nodes: Vec<Node> = Vec::new();
    for [of, node, parent, lights, in_cut] in
        table.fields(["tree", "node", "parent", "lights", "in_cut"])?
    {
        if of.parse() != Ok(tree) {
            continue;
        }
        let told = || format!("{}: node {node} of tree {tree}", path.display());
        let k = nodes.len();
        ensure!(node.parse() == Ok(k), "{}: expected node {k}", told());
        if k > 0 {
            let parent: usize = parent.parse().with_context(told)?;
            nodes.get_mut(parent).with_context(told)?.children.push(k);
        }
        let lights = lights.parse().with_context(told)?;
        nodes.push(Node { children: Vec::new(), lights, is_in_cut: in_cut != "0" });
    }
    ensure!(!nodes.is_empty(), "{} has no tree {tree}", path.display());
    Ok(nodes)
}

fn drawing(nodes: &[Node]) -> String {
    let ([width, height], mut places) = (SIZE, vec![[0.0; 2]; nodes.len()]);
    let slot = (width - 2.0 * MARGIN) / nodes[0].lights as f64;
    let radius = (0.4 * slot).min(13.0);
    place(nodes, 0, &mut 0, &mut places);
    let tallest = places[0][1];
    for [x, y] in &mut places {
        *x = MARGIN + slot * *x;
        *y = height - LEGEND - MARGIN - (height - LEGEND - 2.0 * MARGIN) * *y / tallest.max(1.0);
    }
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-family=\"{FONT}\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (node, [x, y]) in nodes.iter().zip(&places) {
        for [u, v] in node.children.iter().map(|&k| places[k]) {
            let _ = writeln!(
                out,
                "<path d=\"M{x:.1} {y:.1}L{u:.1} {v:.1}\" stroke=\"#777\" stroke-width=\"1.5\"/>"
            );
        }
    }
    for (node, [x, y]) in nodes.iter().zip(&places) {
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{}\" stroke=\"#333\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            if node.is_in_cut { "#f5a84b" } else { "#fff" },
            y + 0.4 * radius,
            1.15 * radius,
            node.lights
        );
    }
    let y = height - 12.0;
    let _ = writeln!(
        out,
        "<circle cx=\"22\" cy=\"{0}\" r=\"9\" fill=\"#f5a84b\" stroke=\"#333\"/><text x=\"38\" y=\"{y}\" font-size=\"15\">node of the cut</text>\
         <circle cx=\"172\" cy=\"{0}\" r=\"9\" fill=\"#fff\" stroke=\"#333\"/><text x=\"188\" y=\"{y}\" font-size=\"15\">other node; numbers count the lights</text>",
        y - 5.0
    );
    out + "</svg>\n"
}

/// Place a node and those below it: x in lights from the left, y as its height over the lights.
fn place(nodes: &[Node], k: usize, placed: &mut usize, places: &mut [[f64; 2]]) {
    if nodes[k].children.is_empty() {
        places[k] = [*placed as f64 + 0.5, 0.0];
        *placed += 1;
        return;
    }
    let (mut x, mut y) = (0.0, 0.0f64);
    for &child in &nodes[k].children {
        place(nodes, child, placed, places);
        x += places[child][0] / nodes[k].children.len() as f64;
        y = y.max(places[child][1] + 1.0);
    }
    places[k] = [x, y];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parents_stand_over_the_middle_of_their_children() {
        let node = |children: &[usize], lights| Node {
            children: children.into(),
            lights,
            is_in_cut: false,
        };
        let nodes = [node(&[1, 2], 3), node(&[3, 4], 2), node(&[], 1), node(&[], 1), node(&[], 1)];
        let mut places = vec![[0.0; 2]; 5];
        place(&nodes, 0, &mut 0, &mut places);
        assert_eq!(places, [[1.75, 2.0], [1.0, 1.0], [2.5, 0.0], [0.5, 0.0], [1.5, 0.0]]);
        assert_eq!(drawing(&nodes).matches("<circle").count(), 5 + 2);
    }
}
