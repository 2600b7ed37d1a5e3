//! Small pictures for test scenes: normal maps and a height field, as linear floats.

use std::f32::consts::TAU;
use std::path::Path;

const SIDE: usize = 32;

/// Write `gentle.pfm` and `strong.pfm`, normal maps of waves with slopes up to 0.3 and 1.5, and `height.pfm`, waves
/// from 0 to 1.
pub fn write(folder: &Path) {
    for (name, slope) in [("gentle.pfm", 0.3), ("strong.pfm", 1.5)] {
        let normal = |u: f32, v: f32| {
            let n = [-slope * (2.0 * u).cos(), -slope * (2.0 * v).cos(), 1.0];
            let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
            n.map(|x| 0.5 * x / length + 0.5)
        };
        pfm(&folder.join(name), normal);
    }
    pfm(&folder.join("height.pfm"), |u, v| [0.5 + 0.5 * (3.0 * u).sin() * (3.0 * v).sin(); 3]);
}

/// Write a picture of a function of two angles; each angle makes a full turn along its side of the picture.
fn pfm(path: &Path, value: impl Fn(f32, f32) -> [f32; 3]) {
    let angle = |k: usize| TAU * (k as f32 + 0.5) / SIDE as f32;
    let mut bytes = format!("PF\n{SIDE} {SIDE}\n-1.0\n").into_bytes();
    for y in 0..SIDE {
        for x in 0..SIDE {
            value(angle(x), angle(y)).iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        }
    }
    std::fs::write(path, bytes).expect("written");
}
