//! Chooses the runs: techniques by name, with labels and flags.

use crate::{Failure, text};

/// A run of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Its name: the program's name, or `PROGRAM/LABEL`.
    pub label: String,
    /// The program's name.
    pub program: String,
    /// The program's own flags.
    pub knobs: Vec<String>,
}

/// Flags that `compare` sets itself.
const NOT_KNOBS: [&str; 10] = [
    "-o",
    "--output",
    "--stats",
    "--time",
    "--spp",
    "--passes",
    "--seed",
    "-q",
    "--quiet",
    "--export-mitsuba",
];

impl Run {
    /// A run from its name, `PROGRAM` or `PROGRAM/LABEL`.
    fn named(label: &str) -> Self {
        let program = label.split('/').next().unwrap_or_default();
        Run { label: label.to_string(), program: program.to_string(), knobs: Vec::new() }
    }

    /// A run from `NAME` or `NAME: FLAGS`.
    ///
    /// # Errors
    /// The name is missing, or a flag is one that `compare` sets.
    pub fn parse(spec: &str) -> Result<Self, Failure> {
        let (name, flags) = spec.split_once(':').unwrap_or((spec, ""));
        let run = Run { knobs: text::split_words(flags)?, ..Run::named(name.trim()) };
        if run.program.is_empty() {
            let text = format!(
                "error: --with \"{spec}\": expected \"PROGRAM: FLAGS\" or \"PROGRAM/LABEL: FLAGS\""
            );
            return Err(Failure::Input(text));
        }
        let is_ours =
            |knob: &&String| NOT_KNOBS.contains(&knob.split('=').next().unwrap_or_default());
        match run.knobs.iter().find(is_ours) {
            Some(knob) => Err(Failure::Input(format!(
                "error: {}: {knob} is set by compare itself; see --time, --spp, --seed, --seeds and --output",
                run.label
            ))),
            None => Ok(run),
        }
    }

    /// The base name of its files, without extension.
    pub fn stem(&self) -> String {
        let keep = |c: char| if c.is_alphanumeric() || "._=-+,".contains(c) { c } else { '-' };
        self.label.chars().map(keep).collect()
    }
}

/// List the runs. Each name in `techniques` is a run. An item of `with` adds flags to the run with its name; if there
/// is no such run, it adds one. The flags of `"all: FLAGS"` apply to all runs and are returned separately.
///
/// # Errors
/// Names that occur twice or that would give the same file names, and the errors of [`Run::parse`].
pub fn plan(techniques: &[String], with: &[String]) -> Result<(Vec<Run>, Vec<String>), Failure> {
    let mut runs: Vec<Run> = techniques.iter().map(|name| Run::named(name.trim())).collect();
    let mut for_all = Vec::new();
    for spec in with {
        let run = Run::parse(spec)?;
        if run.label == "all" {
            for_all.extend(run.knobs);
        } else if let Some(known) = runs.iter_mut().find(|r| r.label == run.label) {
            known.knobs.extend(run.knobs);
        } else {
            runs.push(run);
        }
    }
    for (k, run) in runs.iter().enumerate() {
        if let Some(other) = runs[..k].iter().find(|r| r.stem() == run.stem()) {
            let text = format!(
                "error: the runs {} and {} would have the same files; name them PROGRAM/LABEL",
                other.label, run.label
            );
            return Err(Failure::Input(text));
        }
        if run.program.is_empty() {
            return Err(Failure::Input("error: --techniques: a name is missing".into()));
        }
    }
    if runs.is_empty() {
        return Err(Failure::Input(
            "error: nothing to compare: give --techniques or --with".into(),
        ));
    }
    Ok((runs, for_all))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(techniques: &[&str], with: &[&str]) -> Result<(Vec<Run>, Vec<String>), Failure> {
        let owned = |texts: &[&str]| texts.iter().map(|t| t.to_string()).collect::<Vec<_>>();
        plan(&owned(techniques), &owned(with))
    }

    #[test]
    fn flags_go_to_the_run_they_name_and_other_names_add_runs() {
        let with = ["ppm: --alpha 0.5", "ppm/a=0.9: --alpha 0.9", "all: --max-depth 3"];
        let (runs, for_all) = of(&["pathtrace", "ppm"], &with).expect("a plan");
        let labels: Vec<&str> = runs.iter().map(|r| r.label.as_str()).collect();
        assert_eq!(labels, ["pathtrace", "ppm", "ppm/a=0.9"]);
        assert_eq!(runs[1].knobs, ["--alpha", "0.5"]);
        assert_eq!((runs[2].program.as_str(), runs[2].stem().as_str()), ("ppm", "ppm-a=0.9"));
        assert_eq!(for_all, ["--max-depth", "3"]);
    }

    #[test]
    fn invalid_plans_are_refused() {
        for (techniques, with, says) in [
            (&[][..], &[][..], "nothing to compare"),
            (&["ppm", "ppm"], &[], "same files"),
            (&["ppm/a b"], &["ppm/a-b: --alpha 1"], "same files"),
            (&["ppm", ""], &[], "name is missing"),
            (&["ppm"], &[": --alpha 1"], "expected"),
            (&["ppm"], &["ppm: --time=3s"], "--time=3s is set by compare"),
            (&["ppm"], &["ppm: \"open"], "quote"),
        ] {
            match of(techniques, with) {
                Err(Failure::Input(text)) => assert!(text.contains(says), "{text}"),
                other => panic!("{techniques:?} {with:?}: {other:?}"),
            }
        }
    }
}
