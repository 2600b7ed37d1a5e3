//! How far a run is: a bar for preparation and one for passes on a terminal, a line every [`LINE_EVERY`] elsewhere.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gi_core::progress::{self, PIXELS, State};
use indicatif::{ProgressBar, ProgressStyle};

use crate::budget::Budget;
use crate::say::{say, set_around};

/// Time between two lines where standard error is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(30);
/// Time between two pictures of the bar.
const BAR_EVERY: Duration = Duration::from_millis(100);
/// Steps of the bar: more than it has characters.
const STEPS: f64 = 1000.0;

/// A part of a run whose progress is shown.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    /// Preparation.
    Preparation,
    /// Passes.
    Passes(Passes),
}

/// Passes whose progress is shown.
#[derive(Clone, Debug)]
pub(crate) struct Passes {
    /// When they end.
    pub(crate) budget: Budget,
    /// How many an earlier run has made.
    pub(crate) before: u32,
    /// How many there are by now.
    pub(crate) made: Arc<AtomicU32>,
    /// Samples of a pass.
    pub(crate) samples: f64,
    /// Time that the budget had spent when the passes began.
    pub(crate) spent: Duration,
}

/// Shows progress until it is dropped.
pub(crate) struct Progress {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Progress {
    /// Show the progress of a part that begins now.
    pub(crate) fn show(part: Part, quiet: bool) -> Self {
        if quiet {
            return Progress { end: None, thread: None };
        }
        let (end, ended) = channel();
        let thread = std::thread::spawn(move || {
            if std::io::stderr().is_terminal() { bar(&part, &ended) } else { lines(&part, &ended) }
        });
        Progress { end: Some(end), thread: Some(thread) }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Draw a bar until the part has ended.
fn bar(part: &Part, ended: &Receiver<()>) {
    let (start, bar) = (Instant::now(), ProgressBar::new(STEPS as u64));
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
        bar.set_style(style);
    }
    let message_bar = bar.clone();
    set_around(Some(Box::new(move |write| message_bar.suspend(write))));
    let mut most = 0f64;
    while ended.recv_timeout(BAR_EVERY) == Err(RecvTimeoutError::Timeout) {
        let (fraction, text) = describe(part, progress::state(), start.elapsed());
        // Within a pass or a step it only grows; a new step of the preparation begins anew.
        most = if matches!(part, Part::Passes(_)) { most.max(fraction) } else { fraction };
        bar.set_position((most.clamp(0.0, 1.0) * STEPS) as u64);
        bar.set_message(text);
    }
    set_around(None);
    bar.finish_and_clear();
}

/// Write lines until the part has ended.
fn lines(part: &Part, ended: &Receiver<()>) {
    let start = Instant::now();
    while ended.recv_timeout(LINE_EVERY) == Err(RecvTimeoutError::Timeout) {
        let (fraction, text) = describe(part, progress::state(), start.elapsed());
        say(format!("{:.0} %: {text}", 100.0 * fraction));
    }
}

/// Which fraction of a part is done, and a line about it.
fn describe(part: &Part, state: State, elapsed: Duration) -> (f64, String) {
    match part {
        Part::Preparation => (within(state), preparation(state, elapsed)),
        Part::Passes(passes) => passes.describe(&passes.estimate(state, elapsed), elapsed),
    }
}

/// A line about the preparation, which began `elapsed` ago. The rate and the remaining time are those of the current step.
fn preparation(State { step, done, total, elapsed: since }: State, elapsed: Duration) -> String {
    let counted = match (step, done, total) {
        ("", ..) => String::new(),
        (_, 0, 0) => format!(": {step}"),
        (_, _, 0) => format!(": {done} {step}"),
        _ => format!(": {} of {total} {step}", done.min(total)),
    };
    let mut text = format!("preparing{counted}");
    let seconds = since.as_secs_f64();
    if done > 0 && seconds > 0.0 {
        text += &format!(", {:.0} per second", done as f64 / seconds);
    }
    text += &format!(", {} elapsed", span(elapsed));
    if done > 0 && total > 0 {
        let left = total.saturating_sub(done) as f64 * seconds / done as f64;
        text += &format!(", {} remaining in this step", span(Duration::from_secs_f64(left)));
    }
    text
}

/// Which fraction of a step is done; zero if that is unknown.
fn within(state: State) -> f64 {
    let fraction = if state.total > 0 { state.done as f64 / state.total as f64 } else { 0.0 };
    fraction.min(1.0)
}

/// How far passes are.
pub(crate) struct Estimate {
    /// Number of passes that are finished.
    pub(crate) made: u32,
    /// Which fraction of the budget is spent.
    pub(crate) fraction: f64,
    /// Rate of this run.
    pub(crate) samples_per_second: f64,
    /// Seconds until the last pass ends, if that is known.
    pub(crate) remaining: Option<f64>,
}

impl Passes {
    /// How far they are, `elapsed` after they began. Within a pass only the step over the pixels counts.
    pub(crate) fn estimate(&self, state: State, elapsed: Duration) -> Estimate {
        let made = self.made.load(Relaxed);
        let part = if state.step == PIXELS { within(state) } else { 0.0 };
        let new = f64::from(made - self.before) + part;
        let seconds = elapsed.as_secs_f64().max(1e-9);
        let (fraction, remaining) = match self.budget {
            Budget::Passes(all) => {
                let left = f64::from(all) - f64::from(self.before) - new;
                let fraction = 1.0 - left / f64::from(all);
                (fraction, (new > 0.0).then(|| left.max(0.0) * seconds / new))
            }
            Budget::Time(time) => {
                let spent = (self.spent + elapsed).as_secs_f64();
                let left = (time.as_secs_f64() - spent).max(0.0);
                ((spent / time.as_secs_f64()).min(1.0), Some(left))
            }
        };
        Estimate { made, fraction, samples_per_second: new * self.samples / seconds, remaining }
    }

    /// The same as a fraction and a line.
    fn describe(&self, estimate: &Estimate, elapsed: Duration) -> (f64, String) {
        let of = match self.budget {
            Budget::Passes(all) => format!(" of {all}"),
            Budget::Time(_) => String::new(),
        };
        let rate = estimate.samples_per_second * 1e-6;
        let remaining =
            estimate.remaining.map_or("unknown time".into(), |s| span(Duration::from_secs_f64(s)));
        let text = format!(
            "pass {}{of}, {rate:.3} M samples/s, {} elapsed, {remaining} remaining",
            estimate.made + 1,
            span(elapsed)
        );
        (estimate.fraction, text)
    }
}

/// A time span in the two units that matter.
pub(crate) fn span(time: Duration) -> String {
    match time.as_secs() {
        0..10 => format!("{:.1} s", time.as_secs_f64()),
        s @ 10..60 => format!("{s} s"),
        s @ 60..3600 => format!("{} min {} s", s / 60, s % 60),
        s => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(budget: Budget, before: u32, made: u32) -> Part {
        let made = Arc::new(AtomicU32::new(made));
        Part::Passes(Passes { budget, before, made, samples: 1e6, spent: Duration::from_secs(2) })
    }

    #[test]
    fn a_bar_moves_within_a_pass_and_tells_rate_and_remaining_time() {
        let half = State { step: PIXELS, done: 5, total: 10, elapsed: Duration::ZERO };
        let part = passes(Budget::Passes(8), 0, 1);
        let (fraction, text) = describe(&part, half, Duration::from_secs(3));
        assert_eq!(fraction, 1.5 / 8.0);
        assert_eq!(text, "pass 2 of 8, 0.500 M samples/s, 3.0 s elapsed, 13 s remaining");
        // Other steps of a pass take no part in it.
        let photons = State { step: "light paths", ..half };
        assert_eq!(describe(&part, photons, Duration::from_secs(3)).0, 1.0 / 8.0);
    }

    #[test]
    fn passes_of_an_earlier_run_count_for_the_bar_but_not_for_the_rate() {
        let none = State { step: PIXELS, done: 0, total: 10, elapsed: Duration::ZERO };
        let (fraction, text) =
            describe(&passes(Budget::Passes(8), 4, 6), none, Duration::from_secs(100));
        assert_eq!(fraction, 6.0 / 8.0);
        assert_eq!(
            text,
            "pass 7 of 8, 0.020 M samples/s, 1 min 40 s elapsed, 1 min 40 s remaining"
        );
    }

    #[test]
    fn a_time_budget_counts_preparation() {
        let none = State { step: PIXELS, done: 0, total: 10, elapsed: Duration::ZERO };
        let part = passes(Budget::Time(Duration::from_secs(10)), 0, 3);
        let (fraction, text) = describe(&part, none, Duration::from_secs(3));
        assert_eq!(fraction, 0.5);
        assert_eq!(text, "pass 4, 1.000 M samples/s, 3.0 s elapsed, 5.0 s remaining");
    }

    #[test]
    fn preparation_names_its_step() {
        let at = |step, done, total| {
            let state = State { step, done, total, elapsed: Duration::from_secs(20) };
            describe(&Part::Preparation, state, Duration::from_secs(4000)).1
        };
        assert_eq!(at("", 0, 0), "preparing, 1 h 6 min elapsed");
        assert_eq!(at("trees", 0, 0), "preparing: trees, 1 h 6 min elapsed");
        assert_eq!(at("records", 60, 0), "preparing: 60 records, 3 per second, 1 h 6 min elapsed");
        let photons = "preparing: 500 of 800 photons, 25 per second, 1 h 6 min elapsed, 12 s remaining in this step";
        assert_eq!(at("photons", 500, 800), photons);
        // Threads may count more than was asked for.
        assert!(at("photons", 900, 800).starts_with("preparing: 800 of 800 photons"));
    }
}
