//! Photon maps against references of scenes whose light is mostly caustic, which path tracing does not find.
//!
//! The references are numbers in `references/`, made by long runs of `pathtrace --mode vcm` with `make references`.

use gi_core::film::{Film, Show};
use gi_stats::{Running, z_test};
use gi_tests::World;
use photonmap::PhotonMapping;
use ppm::Ppm;

/// Pixels across and down, and blocks across and down, of a reference.
const SIDE: usize = 64;
const BLOCKS: usize = 4;

/// Mean and standard error.
type Estimate = (f64, f64);

/// The green means of a reference's blocks.
fn reference(scene: &str) -> Vec<Estimate> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("references");
    let text = std::fs::read_to_string(path.join(format!("{scene}.csv"))).expect("a reference");
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    let blocks: Vec<Estimate> = rows
        .map(|row| {
            let cells: Vec<f64> = row.split(',').map(|c| c.parse().expect("a number")).collect();
            (cells[3], cells[6])
        })
        .collect();
    assert_eq!(blocks.len(), BLOCKS * BLOCKS);
    blocks
}

/// The green means of the blocks of pictures with several seeds.
fn rendered(seeds: u32, render: impl Fn(u32) -> Film) -> Vec<Estimate> {
    let mut blocks = vec![Running::default(); BLOCKS * BLOCKS];
    for seed in 1..=seeds {
        let means = crate::agreement::blocks(&render(seed), SIDE / BLOCKS);
        let green = &means[BLOCKS * BLOCKS..2 * BLOCKS * BLOCKS];
        blocks.iter_mut().zip(green).for_each(|(block, (mean, _))| block.push(*mean));
    }
    blocks.iter().map(|b| (b.mean(), b.variance_of_mean().sqrt())).collect()
}
