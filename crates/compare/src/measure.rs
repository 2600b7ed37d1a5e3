//! Computes the errors of pictures.

use gi_stats::flip::{PIXELS_PER_DEGREE, flip_hdr, flip_ldr};
use gi_stats::metrics::{Metrics, finite_pixels};
use gi_stats::{Split, log_log_line, split};
use rayon::prelude::*;

use crate::reference::Reference;
use crate::subject::Subject;
use crate::{Budget, Failure, Finished, Picture, Report, Request, Series, Stats, text};

/// A picture with its errors.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its name.
    pub label: String,
    /// Its picture, with the whole budget and the first seed.
    pub picture: Picture,
    /// The command that made it, if known.
    pub command: Option<String>,
    /// The statistics of its run, if there was one.
    pub stats: Option<Stats>,
    /// The light paths that it can contain, in its program's words.
    pub reach: Option<String>,
    /// Its errors.
    pub errors: Errors,
    /// Bias and variance, if there are several seeds.
    pub split: Option<Split>,
    /// Errors at smaller budgets and at the whole budget.
    pub rungs: Vec<Rung>,
    /// Other remarks.
    pub notes: Vec<String>,
}

/// Errors of a picture.
#[derive(Clone, Debug)]
pub struct Errors {
    /// Over linear radiance.
    pub metrics: Metrics,
    /// Mean of FLIP over radiance clipped to [0, 1].
    pub flip_ldr: f64,
    /// Mean of FLIP over all exposures (HDR-FLIP).
    pub flip_hdr: f64,
    /// HDR-FLIP per pixel; 0 at excluded pixels.
    pub flip_map: Vec<f64>,
}

/// Errors of a run at one budget.
#[derive(Clone, Copy, Debug)]
pub struct Rung {
    /// Its time in seconds, including preparation.
    pub seconds: f64,
    /// Number of passes.
    pub passes: u64,
    /// MSE and relMSE, minus the reference's own noise if that is known.
    pub errors: [f64; 2],
}

impl Entry {
    /// Number of passes, from the run's statistics or from the picture's metadata.
    pub fn passes(&self) -> Option<u64> {
        let run = self.stats.as_ref().map(|s| s.passes);
        run.or_else(|| self.picture.text("gi.passes")?.parse().ok())
    }

    /// Seconds for preparation and passes, from the run's statistics or from the picture's metadata.
    pub fn seconds(&self) -> Option<f64> {
        let run = self.stats.as_ref().map(Stats::counted_seconds);
        run.or_else(|| self.picture.text("gi.seconds")?.parse().ok())
    }

    /// Line fitted to the error against time on logarithmic axes, of MSE (0) or relMSE (1): its slope, and its error at
    /// one second. `None` if the times hardly differ.
    pub fn line(&self, which: usize) -> Option<(f64, f64)> {
        let points: Vec<(f64, f64)> =
            self.rungs.iter().map(|r| (r.seconds, r.errors[which])).filter(|p| p.1 > 0.0).collect();
        let (first, last) =
            points.iter().fold((f64::INFINITY, 0.0f64), |(lo, hi), p| (lo.min(p.0), hi.max(p.0)));
        let line = log_log_line(&points).filter(|_| last >= 2.0 * first)?;
        Some((line.0, line.1.exp()))
    }
}

/// Compute all errors and assemble the report.
pub(crate) fn finish(
    request: &Request,
    title: String,
    series: Option<&Series>,
    reference: Reference,
    subjects: Vec<Subject>,
) -> Result<Report, Failure> {
    let mut warnings = request.remarks.clone();
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
            "the reference was made from another scene, or from an earlier version of this one"
                .into(),
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

/// Remarks that a reader needs to interpret an entry's numbers.
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
            "pixels that are not finite here or in the reference, and that no error counts: {}",
            errors.metrics.left_out
        ));
    }
    let shares = |(program, seed): &(String, String)| {
        picture.text("gi.program") == Some(program) && picture.text("gi.seed") == Some(seed)
    };
    if reference.seeds.iter().any(shares) {
        notes.push("made by the reference's program with the same seed: they share their noise, so errors look smaller than they are".into());
    }
    if let (Some(finished), Some(Budget::Time(time))) = (finished, series.map(|s| s.budget)) {
        let (prepared, taken) = (finished.stats.seconds[2], finished.stats.counted_seconds());
        if taken > 1.1 * time.as_secs_f64() {
            notes.push(format!("took {taken:.2} s, {prepared:.2} s of it for preparation: a pass always runs to its end, and there is at least one"));
        }
    }
    notes
}

/// All errors of one picture.
fn errors(picture: &[f32], reference: &Picture) -> Result<Errors, String> {
    let metrics = gi_stats::metrics::compare(picture, &reference.rgb)?;
    // FLIP also reads neighbours, so excluded pixels are black in both pictures.
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
