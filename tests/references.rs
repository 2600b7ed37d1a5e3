//! Photon maps against references of scenes whose light is mostly caustic, which path tracing does not find.
//!
//! The references are numbers in `references/`, made by long runs of `pathtrace --mode vcm` with `make references`.

use gi_core::film::{Film, Show};
use gi_stats::{Running, sidak, student_two_sided};
use gi_tests::World;
use photonmap::PhotonMapping;
use ppm::Ppm;

/// Scenes with references.
const SCENES: [&str; 4] = ["bulb", "cognac", "pool", "torus-in-glass"];
/// Pixels across and down, and blocks across and down, of a reference.
const SIDE: usize = 64;
const BLOCKS: usize = 4;
/// Number of pictures, each with its own seed: pixels of one picture share their photons.
const SEEDS: u32 = 8;
/// Chance that a right result is refused, over all comparisons of a technique.
const ALPHA: f64 = 1e-3;

/// The green means of a reference's blocks and, last, of the picture, with their standard errors.
fn reference(scene: &str) -> Vec<(f64, f64)> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("references");
    let text = std::fs::read_to_string(path.join(format!("{scene}.csv"))).expect("a reference");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let means: Vec<(f64, f64)> = rows
        .map(|row| {
            let cells: Vec<&str> = row.split(',').collect();
            let number = |k: usize| cells[k].parse().expect("a number");
            (number(3), number(6))
        })
        .collect();
    assert_eq!(means.len(), BLOCKS * BLOCKS + 1);
    means
}

/// The green means of the blocks of a picture and, last, of the picture.
fn means(film: &Film) -> Vec<f64> {
    let layers = film.layers();
    let green = layers.channel("G").expect("a channel");
    let side = SIDE / BLOCKS;
    let mut means = vec![0.0; BLOCKS * BLOCKS + 1];
    for (i, value) in green.iter().enumerate() {
        let block = i / SIDE / side * BLOCKS + i % SIDE / side;
        means[block] += f64::from(*value) / (side * side) as f64;
        means[BLOCKS * BLOCKS] += f64::from(*value) / (SIDE * SIDE) as f64;
    }
    means
}

/// Check that the pictures that `render` makes of a scene with a seed are those of the references, block by block and on the whole.
/// Blur moves light between blocks: it may change a block by the share `of_block`, and the picture by `of_all`.
fn assert_near_references([of_block, of_all]: [f64; 2], render: impl Fn(&World, u32) -> Film) {
    let level = sidak(ALPHA, SCENES.len() * (BLOCKS * BLOCKS + 1));
    for scene in SCENES {
        let world = World::load(&format!("{scene}.xml"), [SIDE, SIDE], &[]);
        let mut rendered = vec![Running::default(); BLOCKS * BLOCKS + 1];
        for seed in 1..=SEEDS {
            let means = means(&render(&world, seed));
            rendered.iter_mut().zip(means).for_each(|(all, mean)| all.push(mean));
        }
        let mut worst = 0.0f64;
        for (k, (ours, (truth, error))) in rendered.iter().zip(reference(scene)).enumerate() {
            let may_differ = if k < BLOCKS * BLOCKS { of_block } else { of_all };
            let far = ((ours.mean() - truth).abs() - may_differ * truth).max(0.0);
            let sigma = ours.variance_of_mean().sqrt().hypot(error);
            let p = student_two_sided(far / sigma.max(1e-12), f64::from(SEEDS - 1));
            assert!(
                p > level,
                "{scene}, block {k}: {:.5} +- {sigma:.5}, not {truth:.5}, p = {p:.1e}",
                ours.mean()
            );
            worst = worst.max((ours.mean() / truth - 1.0).abs());
        }
        let all = &rendered[BLOCKS * BLOCKS];
        let truth = reference(scene)[BLOCKS * BLOCKS].0;
        println!(
            "{scene}: ratio of means {:.4} +- {:.4}, worst block {worst:.3}",
            all.mean() / truth,
            all.variance_of_mean().sqrt() / truth
        );
    }
}

#[test]
fn progressive_photon_mapping_agrees_with_vcm_where_paths_find_nothing() {
    // Measured over 64 passes: the means differ by 0.07 % to 0.3 %, within two to three standard errors.
    assert_near_references([0.01, 0.003], |world, seed| {
        world.render::<Ppm>(&ppm::Params::default(), 24, seed, Show::All)
    });
}

#[test]
fn photon_mapping_agrees_with_vcm_where_paths_find_nothing() {
    // Its radii do not shrink. Measured over 4 and 16 passes: the means differ by at most 0.9 %, within three and a half standard errors.
    assert_near_references([0.03, 0.006], |world, seed| {
        world.render::<PhotonMapping>(&photonmap::Params::default(), 4, seed, Show::All)
    });
}
