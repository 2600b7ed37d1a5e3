//! Renders the references of the scenes whose light is mostly caustic, and keeps them as numbers.
//!
//! `make-references PATHTRACE FOLDER [SCENE...]` renders each scene with `PATHTRACE --mode vcm` in several seeds, and writes
//! `tests/references/SCENE.csv`: the mean radiance of each block of the picture, with its standard error. Pictures and checkpoints
//! are kept in FOLDER. After an interruption, the same command continues.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, bail};
use gi_core::image_io::read_exr;
use gi_stats::Running;

/// Scenes that path tracing does not find the light of.
const SCENES: [&str; 4] = ["bulb", "cognac", "pool", "torus-in-glass"];
/// Pixels across and down, and blocks across and down.
const SIDE: usize = 64;
const BLOCKS: usize = 4;
/// Number of seeds, and of passes per seed.
const SEEDS: u32 = 16;
const PASSES: u32 = 2048;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [pathtrace, folder, scenes @ ..] = arguments.as_slice() else {
        bail!("usage: make-references PATHTRACE FOLDER [SCENE...]");
    };
    let folder = Path::new(folder);
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let scenes: Vec<&str> = match scenes {
        [] => SCENES.to_vec(),
        some => some.iter().map(String::as_str).collect(),
    };
    for scene in scenes {
        let mut blocks = vec![[Running::default(); 3]; BLOCKS * BLOCKS + 1];
        for seed in 1..=SEEDS {
            let picture = folder.join(format!("{scene}-{seed}.exr"));
            if !picture.exists() {
                render(pathtrace, scene, seed, &picture)?;
            }
            add(&picture, &mut blocks)?;
        }
        let path = format!("tests/references/{scene}.csv");
        std::fs::write(&path, table(scene, &blocks))
            .with_context(|| format!("cannot write {path}"))?;
        println!("{path}");
    }
    Ok(())
}

/// Render one seed, from its checkpoint if there is one.
fn render(pathtrace: &str, scene: &str, seed: u32, picture: &Path) -> anyhow::Result<()> {
    let checkpoint = picture.with_extension("checkpoint");
    let mut command = Command::new(pathtrace);
    command.arg(format!("scenes/{scene}.xml")).args(options(seed).split(' '));
    command.arg("-o").arg(picture).arg("--checkpoint").arg(&checkpoint);
    if checkpoint.exists() {
        command.arg("--resume");
    }
    let status = command.status().with_context(|| format!("cannot run {pathtrace}"))?;
    if !status.success() {
        bail!("{pathtrace} ended with {status}");
    }
    Ok(())
}

/// The options that the numbers depend on.
fn options(seed: u32) -> String {
    format!("--mode vcm --radius 0.003 --size {SIDE}x{SIDE} --spp {PASSES} --seed {seed}")
}

/// Add the block means of a picture, and last its mean.
fn add(picture: &Path, blocks: &mut [[Running; 3]]) -> anyhow::Result<()> {
    let layers = read_exr(picture).map_err(anyhow::Error::msg)?;
    if [layers.width, layers.height] != [SIDE; 2] {
        bail!("{} is of another size; remove it", picture.display());
    }
    let rgb = layers.interleaved(["R", "G", "B"]).context("a picture without colours")?;
    let side = SIDE / BLOCKS;
    for c in 0..3 {
        let mut all = 0.0;
        for (k, block) in blocks[..BLOCKS * BLOCKS].iter_mut().enumerate() {
            let [x, y] = [k % BLOCKS * side, k / BLOCKS * side];
            let pixels = (0..side * side).map(|i| (y + i / side) * SIDE + x + i % side);
            let sum: f64 = pixels.map(|i| f64::from(rgb[3 * i + c])).sum();
            block[c].push(sum / (side * side) as f64);
            all += sum;
        }
        blocks[BLOCKS * BLOCKS][c].push(all / (SIDE * SIDE) as f64);
    }
    Ok(())
}

/// The file of a scene.
fn table(scene: &str, blocks: &[[Running; 3]]) -> String {
    let mut text = format!(
        "# Mean radiance of blocks of {0} x {0} pixels and of the picture, and its standard error.\n# pathtrace scenes/{scene}.xml {1}, for seeds 1 to {SEEDS}; \
         made by `make references`.\nrow,column,r,g,b,error_r,error_g,error_b\n",
        SIDE / BLOCKS,
        options(1)
    );
    for (k, block) in blocks.iter().enumerate() {
        let [r, g, b] = block.map(|c| c.mean());
        let [er, eg, eb] = block.map(|c| c.variance_of_mean().sqrt());
        let place = match k / BLOCKS {
            BLOCKS => "all,all".to_string(),
            row => format!("{row},{}", k % BLOCKS),
        };
        writeln!(text, "{place},{r:.6},{g:.6},{b:.6},{er:.6},{eg:.6},{eb:.6}").expect("text grows");
    }
    text
}
