//! Pictures of cuts, clusters and trees.

mod bounds;
mod clusters;
mod common;
mod cuts;

use std::path::Path;

use gi_core::canvas::{Legend, viridis};
use gi_core::film::Film;
use gi_core::technique::Picture;
use rayon::prelude::*;
use vpl::to_file;

use crate::light::At;
use crate::params::Params;

pub(crate) use common::{CutOfPixel, Subject};

pub use crate::params::Figure;

impl Figure {
    /// Draw the figure.
    pub(crate) fn draw(self, subject: &Subject, film: &Film) -> Vec<Picture> {
        match self {
            Figure::CutSize => vec![cut_size(subject, film)],
            Figure::Bounds => vec![bounds::picture(subject, film)],
            Figure::Clusters => clusters::clusters(subject, film),
            Figure::Tree => vec![clusters::tree(subject, film)],
            Figure::Cuts => cuts::pictures(subject),
        }
    }
}

/// The contents of a file that the parameters ask for.
pub(crate) fn file(subject: &Subject, path: &Path) -> Vec<u8> {
    let Params { bounds_out, cuts_out, tree_out, .. } = subject.view.params;
    if bounds_out.as_deref() == Some(path) {
        return bounds::bounds_csv(subject);
    }
    if cuts_out.as_deref() == Some(path) {
        return cuts::cuts_csv(subject);
    }
    if tree_out.as_deref() == Some(path) {
        return clusters::tree_csv(subject);
    }
    let origin = subject.view.setting.scene.origin();
    to_file(path, &subject.lights.prepared.set().lights, origin)
}

fn cut_size<'a>(subject: &Subject<'_, 'a>, film: &Film) -> Picture {
    let [w, h] = film.size();
    let size = |i: usize| {
        let light = |at: &At<'_, '_, 'a>| {
            subject.lights.add_up(&mut subject.cut(at), &subject.view.params.cut)
        };
        let pixel = [i % w, i / w];
        let lit = match subject.cut_of_pixel {
            Some(cut) => cut(pixel),
            None => subject.view.at_pixel(pixel, light).unwrap_or_default(),
        };
        [lit.size as f32, lit.rays as f32]
    };
    let sizes: Vec<[f32; 2]> = (0..w * h).into_par_iter().map(size).collect();
    let largest = sizes.iter().map(|s| s[0]).fold(1.0, f32::max);
    let title = match subject.cut_of_pixel {
        Some(_) => "Cut size (pairs per pixel)",
        None => "Cut size (clusters per pixel)",
    };
    let channel = |k: usize| sizes.iter().map(|s| s[k]).collect::<Vec<f32>>();
    Picture {
        name: "cut-size".into(),
        channels: vec![("Clusters".into(), channel(0)), ("Rays".into(), channel(1))],
        view: sizes.iter().map(|s| viridis(s[0] / largest)).collect(),
        legend: Some(Legend::linear(title, 0.0, largest)),
    }
}
