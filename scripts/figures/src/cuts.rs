//! Draws the cuts of a few lights in one drawing: for each cut its picture, the light tree with the cut's nodes, and its errors.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, bail};

use crate::svg::{FONT, data_uri, escaped};
use crate::table::Table;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The drawing to write (.svg)
    out: PathBuf,
    /// The cuts, as written by lightcuts --cuts-out
    #[arg(long)]
    table: PathBuf,
    /// Pictures of the cuts: PREFIX-0.png and so on
    #[arg(long)]
    prefix: String,
    /// Numbers of the cuts to draw
    #[arg(required = true)]
    cuts: Vec<usize>,
}

/// Lights of a cluster, and the one that represents them.
#[derive(Clone, Debug, PartialEq)]
struct Cluster {
    representative: u32,
    members: BTreeSet<u32>,
}

/// A cut: its clusters, and its errors relative to the exact picture.
struct Cut {
    clusters: Vec<Cluster>,
    mean_error: f64,
    error_99: f64,
}

/// Width of a column with its gap, size of a picture in it, and height of the tree.
const COLUMN: usize = 330;
const PICTURE: [usize; 2] = [310, 233];
const TREE: usize = 190;
const LEGEND: usize = 34;

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let cuts = read(&args.table)?;
    let nodes = nodes(&cuts);
    let (width, height) = (COLUMN * args.cuts.len(), 54 + PICTURE[1] + TREE + LEGEND);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-family=\"{FONT}\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (column, &k) in args.cuts.iter().enumerate() {
        let cut =
            cuts.get(k).with_context(|| format!("there is no cut {k}, only {}", cuts.len()))?;
        let picture = format!("{}-{k}.png", args.prefix);
        let bytes = std::fs::read(&picture).with_context(|| picture.clone())?;
        let (left, [w, h]) = (COLUMN * column + (COLUMN - PICTURE[0]) / 2, PICTURE);
        let text = |out: &mut String, y: usize, size: usize, text: &str| {
            let x = left + w / 2;
            let _ = writeln!(
                out,
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"middle\">{}</text>",
                escaped(text)
            );
        };
        text(&mut out, 24, 19, &heading(cut));
        let uri = data_uri("image/png", &bytes);
        writeln!(
            out,
            "<image x=\"{left}\" y=\"34\" width=\"{w}\" height=\"{h}\" href=\"{uri}\"/>"
        )?;
        text(&mut out, 34 + h + 20, 14, &errors(cut));
        tree(&mut out, &nodes, cut, [left, 34 + h + 30]);
    }
    legend(&mut out, height - 12);
    std::fs::write(&args.out, out + "</svg>\n").with_context(|| args.out.display().to_string())
}

fn heading(cut: &Cut) -> String {
    if cut.clusters.iter().all(|c| c.members.len() == 1) {
        return format!("All {} lights: exact", cut.clusters.len());
    }
    let name = |c: &Cluster| {
        let members: Vec<String> = c.members.iter().map(|m| (m + 1).to_string()).collect();
        members.join("+")
    };
    let names: Vec<String> = cut.clusters.iter().map(name).collect();
    format!("{} clusters: {}", names.len(), names.join(", "))
}

fn errors(cut: &Cut) -> String {
    let [mean, most] = [cut.mean_error, cut.error_99].map(|e| format!("{:.1} %", 100.0 * e));
    match cut.mean_error {
        0.0 => "no error".into(),
        _ => format!("mean error {mean}, 99th percentile {most}"),
    }
}

/// Read the table of cuts. A cluster is `REPRESENTATIVE:MEMBER+MEMBER`.
fn read(path: &std::path::Path) -> anyhow::Result<Vec<Cut>> {
    let table = Table::read(path)?;
    let mut cuts = Vec::new();
    for [clusters, mean, high] in table.fields(["clusters", "mean_error", "error_99"])? {
        let told = || format!("{}: {clusters}", path.display());
        let clusters: Vec<Cluster> =
            clusters.split(' ').map(cluster).collect::<Result<_, _>>().with_context(told)?;
        cuts.push(Cut { clusters, mean_error: mean.parse()?, error_99: high.parse()? });
    }
    Ok(cuts)
}

fn cluster(text: &str) -> anyhow::Result<Cluster> {
    let (representative, members) =
        text.split_once(':').context("expected REPRESENTATIVE:MEMBERS")?;
    let members = members.split('+').map(str::parse).collect::<Result<_, _>>()?;
    let cluster = Cluster { representative: representative.parse()?, members };
    if !cluster.members.contains(&cluster.representative) {
        bail!("the representative is not a member");
    }
    Ok(cluster)
}

/// All nodes of the tree: every cluster of any cut, large ones first.
fn nodes(cuts: &[Cut]) -> Vec<Cluster> {
    let mut nodes: Vec<Cluster> = Vec::new();
    for c in cuts.iter().flat_map(|c| &c.clusters) {
        if !nodes.contains(c) {
            nodes.push(c.clone());
        }
    }
    nodes.sort_by_key(|n| std::cmp::Reverse(n.members.len()));
    nodes
}

/// Lights from left to right, so that every node's members are neighbours: split from the largest node down.
fn order(nodes: &[Cluster], within: &BTreeSet<u32>, out: &mut Vec<u32>) {
    let child =
        nodes.iter().find(|n| n.members.len() < within.len() && n.members.is_subset(within));
    match child {
        None => out.extend(within),
        Some(child) => {
            order(nodes, &child.members, out);
            let rest: BTreeSet<u32> = within.difference(&child.members).copied().collect();
            order(nodes, &rest, out);
        }
    }
}

/// The tree; nodes of the cut are filled. Each node shows the number of its representative.
fn tree(out: &mut String, nodes: &[Cluster], cut: &Cut, [left, top]: [usize; 2]) {
    let mut lights = Vec::new();
    let all = nodes.iter().flat_map(|n| n.members.iter().copied()).collect();
    order(nodes, &all, &mut lights);
    let slot = PICTURE[0] as f64 / lights.len().max(1) as f64;
    let depth = |n: &Cluster| nodes.iter().filter(|o| n.members.is_subset(&o.members)).count() - 1;
    let deepest = nodes.iter().map(depth).max().unwrap_or(0).max(1);
    let at = |n: &Cluster| {
        let places = lights.iter().enumerate().filter(|(_, l)| n.members.contains(l));
        let places: Vec<f64> = places.map(|(k, _)| k as f64 + 0.5).collect();
        let x = left as f64 + slot * places.iter().sum::<f64>() / places.len() as f64;
        let level = if n.members.len() == 1 { deepest } else { depth(n) };
        (x, top as f64 + 26.0 + (TREE as f64 - 60.0) * level as f64 / deepest as f64)
    };
    for n in nodes {
        let above = nodes
            .iter()
            .rev()
            .find(|o| o.members.len() > n.members.len() && n.members.is_subset(&o.members));
        if let Some(above) = above {
            let ((x, y), (u, v)) = (at(n), at(above));
            let _ = writeln!(
                out,
                "<path d=\"M{x:.1} {y:.1}L{u:.1} {v:.1}\" stroke=\"#777\" stroke-width=\"2\"/>"
            );
        }
    }
    for n in nodes {
        let (x, y) = at(n);
        let fill = if cut.clusters.contains(n) { "#f5a84b" } else { "#fff" };
        let number = n.representative + 1;
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"16\" fill=\"{fill}\" stroke=\"#333\" stroke-width=\"1.5\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"16\" text-anchor=\"middle\">{number}</text>",
            y + 5.5
        );
    }
}

fn legend(out: &mut String, y: usize) {
    let _ = writeln!(
        out,
        "<circle cx=\"22\" cy=\"{0}\" r=\"9\" fill=\"#f5a84b\" stroke=\"#333\"/><text x=\"38\" y=\"{y}\" font-size=\"15\">node of the cut</text>\
         <circle cx=\"172\" cy=\"{0}\" r=\"9\" fill=\"#fff\" stroke=\"#333\"/><text x=\"188\" y=\"{y}\" font-size=\"15\">other node; the number is the light that represents the node</text>",
        y - 5
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_are_read_and_members_of_a_node_are_neighbours() {
        let parsed = cluster("2:0+2").expect("a cluster");
        assert_eq!((parsed.representative, parsed.members.len()), (2, 2));
        assert!(cluster("1:0+2").is_err() && cluster("1").is_err());
        let nodes: Vec<Cluster> =
            ["0:0+1+2+3", "2:0+2", "1:1+3"].map(|t| cluster(t).expect(t)).into();
        let mut lights = Vec::new();
        order(&nodes, &nodes[0].members, &mut lights);
        assert_eq!(lights, [0, 2, 1, 3]);
    }
}
