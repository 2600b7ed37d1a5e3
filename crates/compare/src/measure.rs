//! From pictures to errors.

use std::path::Path;

use gi_stats::flip::{PIXELS_PER_DEGREE, flip_hdr, flip_ldr};
use gi_stats::metrics::{Metrics, finite_pixels};
use gi_stats::{Split, log_log_line, split};
use rayon::prelude::*;

use crate::programs::Order;
use crate::reference::{self, Reference};
use crate::{
    Budget, Failure, Finished, Picture, Report, Request, Run, Series, Stats, Truth, show, text,
};

/// A picture and what is wrong with it.
#[derive(Clone, Debug)]
pub struct Entry {
    /// What it is called.
    pub label: String,
    /// Its picture: of the whole budget and the first seed.
    pub picture: Picture,
    /// How it was made, if that is known.
    pub command: Option<String>,
    /// What its run says of itself, if there was one.
    pub stats: Option<Stats>,
    /// Which light paths it can hold, in its program's words.
    pub reach: Option<String>,
    /// Its errors.
    pub errors: Errors,
    /// Bias and variance, of several seeds.
    pub split: Option<Split>,
    /// Errors at smaller budgets, and at the whole.
    pub rungs: Vec<Rung>,
    /// What there is to know about it besides.
    pub notes: Vec<String>,
}

/// Errors of a picture.
#[derive(Clone, Debug)]
pub struct Errors {
    /// Over linear radiance.
    pub metrics: Metrics,
    /// Mean of FLIP over radiance clipped to [0, 1].
    pub flip_ldr: f64,
    /// Mean of FLIP over all exposures.
    pub flip_hdr: f64,
    /// The latter, pixel by pixel; 0 at pixels left out.
    pub flip_map: Vec<f64>,
}

/// Errors of a run at one budget.
#[derive(Clone, Copy, Debug)]
pub struct Rung {
    /// Seconds that it took, preparing included.
    pub seconds: f64,
    /// Passes made.
    pub passes: u64,
    /// MSE and relMSE, less the reference's own noise where that is known.
    pub errors: [f64; 2],
}

impl Entry {
    /// Slope of error against time on logarithmic axes, of MSE (0) or relMSE (1), and the error at one second of the
    /// fitted line; `None` where times hardly differ.
    pub fn line(&self, which: usize) -> Option<(f64, f64)> {
        let points: Vec<(f64, f64)> =
            self.rungs.iter().map(|r| (r.seconds, r.errors[which])).filter(|p| p.1 > 0.0).collect();
        let (first, last) =
            points.iter().fold((f64::INFINITY, 0.0f64), |(lo, hi), p| (lo.min(p.0), hi.max(p.0)));
        let line = log_log_line(&points).filter(|_| last >= 2.0 * first)?;
        Some((line.0, line.1.exp()))
    }
}

/// Pictures of a run, not yet measured.
struct Subject {
    label: String,
    finished: Option<Finished>,
    picture: Picture,
    /// Of all seeds, the first among them, if there are several.
    seeds: Vec<Picture>,
    /// Of smaller budgets.
    rungs: Vec<(Stats, Picture)>,
}

/// Compare finished pictures.
pub(crate) fn files(request: &Request, files: &[String]) -> Result<Report, Failure> {
    let Truth::Files(truth) = &request.truth else {
        return Err(Failure::Input(
            "error: finished pictures need --reference FILE to be compared with".into(),
        ));
    };
    let layer = request.layer.as_deref();
    let reference = Reference::read(truth, layer)?;
    let stems: Vec<String> = files.iter().map(|f| stem(f)).collect();
    let mut subjects = Vec::new();
    for (file, stem) in files.iter().zip(&stems) {
        let picture = Picture::read(file, layer)?;
        picture.check_size(&reference.picture)?;
        // A name that two pictures share says nothing.
        let unique = stems.iter().filter(|s| *s == stem).count() == 1;
        let label = if unique { stem } else { file };
        subjects.push(Subject {
            label: label.clone(),
            finished: None,
            picture,
            seeds: Vec::new(),
            rungs: Vec::new(),
        });
    }
    finish(request, "pictures".into(), None, reference, subjects)
}

/// A file's name without folder and extension, but with its layer.
fn stem(file: &str) -> String {
    let path = Path::new(file);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let name = name.split_once(".exr").map_or(name.clone(), |(stem, rest)| format!("{stem}{rest}"));
    name.trim_end_matches(".pfm").trim_end_matches(".hdr").to_string()
}

/// Make runs and compare them.
pub(crate) fn series(request: &Request, series: &Series) -> Result<Report, Failure> {
    let given = match &request.truth {
        Truth::Files(files) => Some(Reference::read(files, request.layer.as_deref())?),
        Truth::Run(run, budget) => {
            let exr = request.folder.join("reference.exr");
            request.programs.check(&reference::order(
                series,
                run,
                (*budget, reference::SEED),
                exr,
            ))?;
            None
        }
    };
    let last = series.seed.checked_add(series.seeds - 1).ok_or_else(|| {
        Failure::Input(format!(
            "error: --seed {}: there are no {} seeds from it on",
            series.seed, series.seeds
        ))
    })?;
    if last >= reference::SEED && series.seed <= reference::SEED + 1 {
        let text = format!("error: --seed {}: {} is the reference's", series.seed, reference::SEED);
        return Err(Failure::Input(text));
    }
    // All command lines before the first run, so that a slip in the last costs no time.
    for run in &series.runs {
        request.programs.check(&whole(request, series, run, series.seed))?;
    }
    let mut subjects = Vec::new();
    for run in &series.runs {
        subjects.push(subject(request, series, run, given.as_ref())?);
    }
    let reference = match (given, &request.truth) {
        (Some(reference), _) => reference,
        (None, Truth::Run(run, budget)) => {
            let first = &subjects[0];
            let hash = first.finished.as_ref().map_or("", |f| f.stats.scene_hash.as_str());
            Reference::make(request, series, (run, *budget), (hash, first.picture.size))?
        }
        (None, Truth::Files(_)) => unreachable!("a file was read above"),
    };
    finish(request, show(&series.scene), Some(series), reference, subjects)
}

/// A run of the whole budget.
fn whole<'a>(request: &Request, series: &'a Series, run: &'a Run, seed: u32) -> Order<'a> {
    let name = match seed - series.seed {
        0 => format!("{}.exr", run.stem()),
        _ => format!("{}.seed-{seed}.exr", run.stem()),
    };
    let Series { scene, budget, flags, .. } = series;
    Order { run, scene, budget: *budget, seed, flags, exr: request.folder.join(name) }
}

/// Make all runs of one entry.
fn subject(
    request: &Request,
    series: &Series,
    run: &Run,
    given: Option<&Reference>,
) -> Result<Subject, Failure> {
    let layer = request.layer.as_deref();
    let make = |order: &Order| -> Result<(Finished, Picture), Failure> {
        let finished = request.programs.run(order)?;
        let picture = Picture::read(&show(&finished.exr), layer)?;
        given.map_or(Ok(()), |r| picture.check_size(&r.picture))?;
        let (passes, seconds) = (finished.stats.passes, finished.stats.counted_seconds());
        text::say(request.quiet, &format!("{}: {passes} passes in {seconds:.2} s", run.label));
        Ok((finished, picture))
    };
    let mut rungs = Vec::new();
    for budget in smaller(series.budget, series.ladder) {
        let mut order = whole(request, series, run, series.seed);
        order.budget = budget;
        order.exr.set_file_name(format!("{}.{}.exr", run.stem(), budget.flag()[1]));
        let (finished, picture) = make(&order)?;
        rungs.push((finished.stats, picture));
    }
    let (finished, picture) = make(&whole(request, series, run, series.seed))?;
    let mut seeds = Vec::new();
    for k in 1..series.seeds {
        seeds.push(make(&whole(request, series, run, series.seed + k))?.1);
    }
    if !seeds.is_empty() {
        seeds.insert(0, picture.clone());
    }
    Ok(Subject { label: run.label.clone(), finished: Some(finished), picture, seeds, rungs })
}

/// The budgets below the whole, from the smallest: halves of halves.
fn smaller(budget: Budget, ladder: u32) -> Vec<Budget> {
    let mut all: Vec<Budget> =
        (1..ladder).rev().map(|k| budget.times(0.5f64.powi(k as i32))).collect();
    all.dedup();
    all.retain(|b| *b != budget);
    all
}

/// Measure, and put everything together.
fn finish(
    request: &Request,
    title: String,
    series: Option<&Series>,
    reference: Reference,
    subjects: Vec<Subject>,
) -> Result<Report, Failure> {
    let mut warnings: Vec<String> = Vec::new();
    for subject in &subjects {
        subject.picture.check_size(&reference.picture)?;
        let stats = subject.finished.as_ref().map(|f| &f.stats);
        warnings.extend(stats.into_iter().flat_map(|s| s.warnings.clone()));
    }
    if let Some(hash) =
        subjects.iter().find_map(|s| s.finished.as_ref().map(|f| f.stats.scene_hash.as_str()))
        && reference.picture.text("gi.scene_hash").is_some_and(|its| its != hash)
    {
        warnings.push(
            "the reference was made of another scene, or of an earlier state of this one".into(),
        );
    }
    warnings.sort();
    warnings.dedup();
    text::say(request.quiet, "measuring");
    let entries: Result<Vec<Entry>, Failure> =
        subjects.into_par_iter().map(|subject| entry(subject, &reference, series)).collect();
    Ok(Report {
        title,
        command: request.command.clone(),
        layer: request.layer.clone(),
        budget: series.map(|s| s.budget),
        seeds: series.map_or(1, |s| s.seeds),
        reference,
        entries: entries?,
        warnings,
    })
}

fn entry(
    subject: Subject,
    reference: &Reference,
    series: Option<&Series>,
) -> Result<Entry, Failure> {
    let Subject { label, finished, picture, seeds, rungs } = subject;
    let refuse = |e: String| Failure::Input(format!("error: {label}: {e}"));
    let errors = errors(&picture.rgb, &reference.picture).map_err(refuse)?;
    let noise = reference.noise.unwrap_or_default();
    let rung = |stats: &Stats, metrics: &Metrics| Rung {
        seconds: stats.counted_seconds(),
        passes: stats.passes,
        errors: [metrics.mse - noise[0], metrics.rel_mse - noise[1]],
    };
    let mut steps = Vec::new();
    if let (false, Some(finished)) = (rungs.is_empty(), &finished) {
        for (stats, picture) in &rungs {
            let metrics =
                gi_stats::metrics::compare(&picture.rgb, &reference.picture.rgb).map_err(refuse)?;
            steps.push(rung(stats, &metrics));
        }
        steps.push(rung(&finished.stats, &errors.metrics));
    }
    let seeds: Vec<&[f32]> = seeds.iter().map(|p| p.rgb.as_slice()).collect();
    let split = match seeds[..] {
        [] => None,
        _ => Some(
            split(&seeds, &reference.picture.rgb, reference.variance.as_deref()).map_err(refuse)?,
        ),
    };
    let notes = notes(&picture, finished.as_ref(), &errors, reference, series);
    let command = match &finished {
        Some(finished) => Some(text::command_line(&finished.command)),
        None => picture.text("gi.command").map(String::from),
    };
    let reach = picture.text("gi.reach").map(String::from);
    Ok(Entry {
        label,
        command,
        stats: finished.map(|f| f.stats),
        reach,
        errors,
        split,
        rungs: steps,
        notes,
        picture,
    })
}

/// What must be known to read an entry's numbers aright.
fn notes(
    picture: &Picture,
    finished: Option<&Finished>,
    errors: &Errors,
    reference: &Reference,
    series: Option<&Series>,
) -> Vec<String> {
    let mut notes: Vec<String> = picture.note.clone().into_iter().collect();
    if errors.metrics.left_out > 0 {
        notes.push(format!(
            "{} pixels are not finite here or in the reference; no error counts them",
            errors.metrics.left_out
        ));
    }
    let shares = |(program, seed): &(String, String)| {
        picture.text("gi.program") == Some(program) && picture.text("gi.seed") == Some(seed)
    };
    if reference.seeds.iter().any(shares) {
        notes.push("made by the reference's program with its seed: they share their noise, and errors look smaller than they are".into());
    }
    if let (Some(finished), Some(Budget::Time(time))) = (finished, series.map(|s| s.budget)) {
        let (prepared, taken) = (finished.stats.seconds[2], finished.stats.counted_seconds());
        if taken > 1.1 * time.as_secs_f64() {
            notes.push(format!("took {taken:.2} s, {prepared:.2} s of it for preparing: a pass is never cut short, and there is one at least"));
        }
    }
    notes
}

/// All errors of one picture.
fn errors(picture: &[f32], reference: &Picture) -> Result<Errors, String> {
    let metrics = gi_stats::metrics::compare(picture, &reference.rgb)?;
    // FLIP looks at neighbours too: pixels left out are equal in both, and black.
    let finite = finite_pixels(&[picture, &reference.rgb]);
    let cleared = |p: &[f32]| -> Vec<f32> {
        p.iter().enumerate().map(|(i, v)| if finite[i / 3] { *v } else { 0.0 }).collect()
    };
    let (picture, truth, [w, h]) = (cleared(picture), cleared(&reference.rgb), reference.size);
    let mean = |map: &[f64]| -> f64 {
        let kept = map.iter().zip(&finite).filter(|(_, f)| **f).map(|(v, _)| v);
        kept.sum::<f64>() / (map.len() - metrics.left_out) as f64
    };
    let ldr = flip_ldr(&picture, &truth, w, h, PIXELS_PER_DEGREE);
    let hdr = flip_hdr(&picture, &truth, w, h, PIXELS_PER_DEGREE);
    Ok(Errors { metrics, flip_ldr: mean(&ldr), flip_hdr: mean(&hdr), flip_map: hdr })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_ladder_halves_and_never_repeats_a_budget() {
        let seconds = |s: f64| Budget::Time(Duration::from_secs_f64(s));
        assert_eq!(smaller(seconds(8.0), 4), [seconds(1.0), seconds(2.0), seconds(4.0)]);
        assert_eq!(smaller(Budget::Passes(4), 6), [Budget::Passes(1), Budget::Passes(2)]);
        assert_eq!(smaller(seconds(8.0), 1), []);
    }

    #[test]
    fn names_keep_their_layer_and_lose_the_rest() {
        assert_eq!(stem("a/b.exr#Direct"), "b#Direct");
        assert_eq!(stem("a/b.c.pfm"), "b.c");
    }
}
