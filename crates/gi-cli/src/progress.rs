//! A progress bar with rate and time to go, on a terminal; silence elsewhere.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::budget::Budget;

/// What the terminal shows of a run.
pub(crate) struct Progress {
    bar: ProgressBar,
    budget: Budget,
    samples_per_pass: f64,
}

impl Progress {
    pub(crate) fn new(budget: Budget, size: [usize; 2], quiet: bool) -> Self {
        let length = match budget {
            Budget::Passes(n) => u64::from(n),
            Budget::Time(time) => time.as_millis() as u64,
        };
        // indicatif hides the bar where standard error is no terminal.
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(length) };
        let style = ProgressStyle::with_template(
            "{bar:32} {percent:>3} %  {msg}  {elapsed} elapsed, {eta} to go",
        );
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Progress { bar, budget, samples_per_pass: (size[0] * size[1]) as f64 }
    }

    /// Show how far the run is.
    pub(crate) fn update(&self, passes: u32, elapsed: Duration) {
        let rate = f64::from(passes) * self.samples_per_pass / elapsed.as_secs_f64().max(1e-9);
        self.bar.set_message(format!("pass {passes}, {:.2} M samples/s", rate * 1e-6));
        self.bar.set_position(match self.budget {
            Budget::Passes(_) => u64::from(passes),
            Budget::Time(_) => elapsed.as_millis() as u64,
        });
    }

    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
