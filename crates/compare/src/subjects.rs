//! Gets the pictures of a request: reads finished ones or carries out runs.

use std::path::Path;

use crate::measure::finish;
use crate::programs::Order;
use crate::reference::{self, Reference};
use crate::subject::Subject;
use crate::{Budget, Failure, Finished, Picture, Report, Request, Run, Series, Truth, show, text};

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
        // A name that two pictures share does not identify them.
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
            "error: --seed {}: seeds are 32-bit numbers, so {} of them cannot start there",
            series.seed, series.seeds
        ))
    })?;
    if last >= reference::SEED && series.seed <= reference::SEED + 1 {
        let text = format!(
            "error: --seed {}: {} is the seed of the reference",
            series.seed,
            reference::SEED
        );
        return Err(Failure::Input(text));
    }
    // Check all command lines before the first run, so that an error in the last one costs no time.
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

/// A run with the whole budget.
fn whole<'a>(request: &Request, series: &'a Series, run: &'a Run, seed: u32) -> Order<'a> {
    let name = match seed - series.seed {
        0 => format!("{}.exr", run.stem()),
        _ => format!("{}.seed-{seed}.exr", run.stem()),
    };
    let Series { scene, budget, flags, .. } = series;
    Order { run, scene, budget: *budget, seed, flags, exr: request.folder.join(name) }
}

/// Carry out all runs of one entry.
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

/// The smaller budgets, from the smallest: the whole is halved repeatedly.
fn smaller(budget: Budget, ladder: u32) -> Vec<Budget> {
    let mut all: Vec<Budget> =
        (1..ladder).rev().map(|k| budget.times(0.5f64.powi(k as i32))).collect();
    all.dedup();
    all.retain(|b| *b != budget);
    all
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
