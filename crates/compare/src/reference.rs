//! The reference that pictures are compared with.

use std::path::Path;

use gi_stats::Running;
use gi_stats::metrics::{RELATIVE_FLOOR, finite_pixels};

use crate::programs::{Order, Stats};
use crate::{Budget, Failure, Picture, Request, Run, Series, show, text};

/// Seed of computed references. It is far from the seeds of runs, because a picture that shares random numbers with the
/// reference looks better than it is.
pub(crate) const SEED: u32 = 0x7e57_5eed;

/// The best known solution: one picture, or the mean of several with independent seeds.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The mean.
    pub picture: Picture,
    /// Variance of the mean, for each value, computed from its parts; needs at least two. The variance in the metadata
    /// of a file is not used, because it treats the samples as independent, which overestimates that of stratified
    /// samples.
    pub variance: Option<Vec<f32>>,
    /// Commands or files.
    pub sources: Vec<String>,
    /// Programs and seeds of its parts, if known.
    pub seeds: Vec<(String, String)>,
    /// The light paths that it can contain, in its program's words.
    pub reach: Option<String>,
    /// Other remarks.
    pub notes: Vec<String>,
    /// Its own noise, if known: the MSE and relMSE that a perfect picture would have.
    pub noise: Option<[f64; 2]>,
}

impl Reference {
    fn new(
        parts: Vec<Picture>,
        sources: Vec<String>,
        mut notes: Vec<String>,
    ) -> Result<Self, Failure> {
        for part in &parts[1..] {
            part.check_size(&parts[0])?;
        }
        let (mean, variance) = mean_and_variance(&parts);
        let first = &parts[0];
        let reach = first.text("gi.reach").map(String::from);
        if reach.is_none() {
            notes.push("it does not say which light paths it can contain".into());
        }
        notes.extend(first.note.clone());
        let known = variance.as_ref().map(|v| noise(v, &mean));
        // A picture of a single pass has no variance: its variance layer is black.
        let carried = first.variance.as_ref().filter(|_| first.text("gi.passes") != Some("1"));
        if let (None, Some(carried)) = (&known, carried) {
            let [mse, rel_mse] = noise(carried, &mean).map(text::number);
            notes.push(format!(
                "by the variance that it carries its own noise is at most about {mse} of each MSE and {rel_mse} of each relMSE: \
                 less if its samples are stratified"
            ));
        } else if known.is_none() {
            notes.push("its own noise is not known: it is part of all errors".into());
        }
        let seed =
            |p: &Picture| Some((p.text("gi.program")?.to_string(), p.text("gi.seed")?.to_string()));
        let seeds = parts.iter().filter_map(seed).collect();
        let picture = Picture { rgb: mean, ..parts.into_iter().next().unwrap_or_default() };
        Ok(Reference { picture, variance, sources, seeds, reach, notes, noise: known })
    }

    /// Read finished pictures; several are averaged.
    pub(crate) fn read(names: &[String], layer: Option<&str>) -> Result<Self, Failure> {
        let parts: Vec<Picture> =
            names.iter().map(|n| Picture::read(n, layer)).collect::<Result<_, _>>()?;
        let made = parts.iter().filter_map(|p| Some(format!("made by: {}", p.text("gi.command")?)));
        let notes = made.collect();
        Self::new(parts, names.to_vec(), notes)
    }

    /// Make the reference of a series of runs, in two halves with separate seeds; their difference estimates its noise.
    /// Halves of an earlier comparison are reused if they match: same scene, size and flags, at least the same budget,
    /// and a program that is not newer.
    pub(crate) fn make(
        request: &Request,
        series: &Series,
        (run, budget): (&Run, Budget),
        (scene_hash, [w, h]): (&str, [usize; 2]),
    ) -> Result<Self, Failure> {
        let (mut parts, mut sources, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for (half, name) in ["a", "b"].into_iter().enumerate() {
            let exr = request.folder.join(format!("reference-{scene_hash}-{w}x{h}.{name}.exr"));
            let order = order(series, run, (budget.times(0.5), SEED + half as u32), exr.clone());
            let kept = Stats::read(&exr.with_extension("json")).ok();
            let fits = |stats: &Stats| {
                exr.exists()
                    && !request.programs.is_newer_than(&run.program, &exr)
                    && enough(stats, order.budget)
                    && same_making(&order)
            };
            let kept = kept.filter(fits);
            let from = if kept.is_some() { ", kept from an earlier comparison" } else { "" };
            let stats = match kept {
                Some(stats) => stats,
                None => {
                    let flag = order.budget.flag().join(" ");
                    text::say(request.quiet, &format!("reference, {name}: {} {flag}", run.label));
                    request.programs.run(&order)?.stats
                }
            };
            parts.push(Picture::read(&show(&exr), request.layer.as_deref())?);
            sources.push(text::command_line(&order.command()));
            let (passes, seconds) = (stats.passes, stats.counted_seconds());
            notes.push(format!("half {name}: {passes} passes in {seconds:.1} s{from}"));
        }
        if run.program != "pathtrace" {
            notes.push(format!("made by {}, so it has the errors of this program", run.program));
        }
        Self::new(parts, sources, notes)
    }
}

/// The run that makes a reference.
pub(crate) fn order<'a>(
    series: &'a Series,
    run: &'a Run,
    (budget, seed): (Budget, u32),
    exr: std::path::PathBuf,
) -> Order<'a> {
    Order { run, scene: &series.scene, budget, seed, flags: &series.flags, exr }
}

/// Whether a kept reference was made with at least this budget.
fn enough(stats: &Stats, budget: Budget) -> bool {
    match budget {
        Budget::Passes(n) => stats.passes >= u64::from(n),
        // The last pass may end slightly too early when measured with another clock.
        Budget::Time(time) => stats.counted_seconds() >= 0.99 * time.as_secs_f64(),
    }
}

/// Whether a kept reference was made by the same command, except for its budget.
fn same_making(order: &Order) -> bool {
    let made = || -> Option<Vec<String>> {
        let bytes = std::fs::read(order.exr.with_extension("json")).ok()?;
        let json: serde_json::Value = serde_json::from_slice(&bytes).ok()?;
        json["command"].as_array()?.iter().map(|w| Some(w.as_str()?.to_string())).collect()
    };
    made().is_some_and(|made| without_budget(&made) == without_budget(&order.command()))
}

/// A command line without its program's folder, its budget, and flags that do not affect the picture.
fn without_budget(words: &[String]) -> Vec<String> {
    let mut rest = Vec::new();
    let mut words = words.iter();
    let program = words.next().and_then(|p| Path::new(p).file_stem()).unwrap_or_default();
    rest.push(program.to_string_lossy().into_owned());
    while let Some(word) = words.next() {
        match word.as_str() {
            "--time" | "--spp" | "-o" | "--stats" | "-t" => drop(words.next()),
            "--quiet" => {}
            _ => rest.push(word.clone()),
        }
    }
    rest
}

/// Mean of the pictures, and the variance of the mean if there are at least two.
fn mean_and_variance(parts: &[Picture]) -> (Vec<f32>, Option<Vec<f32>>) {
    let running = |i: usize| parts.iter().map(|p| f64::from(p.rgb[i])).collect::<Running>();
    let all: Vec<Running> = (0..parts[0].rgb.len()).map(running).collect();
    let mean = all.iter().map(|r| r.mean() as f32).collect();
    let variance = || all.iter().map(|r| r.variance_of_mean() as f32).collect();
    (mean, (parts.len() > 1).then(variance))
}

/// The MSE and relMSE that result from a variance of the reference.
fn noise(variance: &[f32], reference: &[f32]) -> [f64; 2] {
    let finite = finite_pixels(&[reference, variance]);
    let values = || (0..variance.len()).filter(|i| finite[i / 3]);
    let n = values().count().max(1) as f64;
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        values().map(|i| of(f64::from(variance[i]), f64::from(reference[i]))).sum::<f64>() / n
    };
    [mean(&|v, _| v), mean(&|v, r| v / (r * r + RELATIVE_FLOOR))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_halves_give_the_noise_and_one_picture_does_not() {
        let of = |rgb: [f32; 3]| Picture { size: [1, 1], rgb: rgb.to_vec(), ..Picture::default() };
        let make =
            |parts: Vec<Picture>| Reference::new(parts, Vec::new(), Vec::new()).expect("one");
        let r = make(vec![of([1.0, 2.0, 3.0]), of([2.0, 2.0, 5.0])]);
        assert_eq!(r.picture.rgb, [1.5, 2.0, 4.0]);
        // (a - b)^2 / 4.
        assert_eq!(r.variance, Some(vec![0.25, 0.0, 1.0]));
        assert!((r.noise.expect("known")[0] - 1.25 / 3.0).abs() < 1e-12);
        assert_eq!(make(vec![of([1.0; 3])]).noise, None);
    }

    #[test]
    fn a_reference_of_one_pass_does_not_claim_to_be_without_noise() {
        let notes = |passes: &str| {
            let part = Picture {
                size: [1, 1],
                rgb: vec![1.0; 3],
                variance: Some(vec![0.0; 3]),
                metadata: vec![("gi.passes".into(), passes.into())],
                ..Picture::default()
            };
            Reference::new(vec![part], Vec::new(), Vec::new()).expect("one").notes.join("\n")
        };
        assert!(notes("2").contains("at most about 0"));
        assert!(notes("1").contains("not known"), "{}", notes("1"));
    }

    #[test]
    fn another_flag_needs_another_reference_but_another_budget_or_folder_does_not() {
        let words = |text: &str| without_budget(&text::split_words(text).expect("words"));
        let made = words(
            "target/release/pathtrace a.xml --spp 16 --seed 3 -o x.exr --stats x.json --quiet",
        );
        assert_eq!(made, words("pathtrace a.xml --time 3s --seed 3 -o y.exr --stats y.json"));
        assert_ne!(
            made,
            words("pathtrace a.xml --mode light --spp 16 --seed 3 -o x.exr --stats x.json")
        );
    }
}
