//! How far a run is, and whether somebody wants it to end early. One run per process: the numbers are global, so that a loop
//! deep in a technique can count without being handed a counter. They never influence what is computed, with one exception:
//! after [`abandon`], the current pass stops early and does not count. With the box filter, pixels keep the samples that they
//! already took; each pixel has its own weight, so the picture stays valid.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The name of the step over all pixels of a pass.
pub const PIXELS: &str = "pixels";
/// The name of the step that looks at the pixels for points without a cached record.
pub const SEARCHED: &str = "pixels searched for missing records";

/// The step, and when it began.
static STEP: Mutex<(&str, Option<Instant>)> = Mutex::new(("", None));
static DONE: AtomicU64 = AtomicU64::new(0);
static TOTAL: AtomicU64 = AtomicU64::new(0);
static ABANDONED: AtomicBool = AtomicBool::new(false);

/// What a run is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// What is counted: light paths, say. Empty before the first step.
    pub step: &'static str,
    /// How many are done.
    pub done: u64,
    /// How many there are in this step; 0 if that is unknown.
    pub total: u64,
    /// Time since the step began.
    pub elapsed: Duration,
}

/// Begin a step of `total` pieces of work (0 if the number is unknown).
pub fn begin(step: &'static str, total: u64) {
    let mut current = STEP.lock().unwrap_or_else(PoisonError::into_inner);
    *current = (step, Some(Instant::now()));
    DONE.store(0, Relaxed);
    TOTAL.store(total, Relaxed);
}

/// Count finished pieces of work.
pub fn advance(pieces: u64) {
    DONE.fetch_add(pieces, Relaxed);
}

/// What the run is doing.
pub fn state() -> State {
    let (step, start) = *STEP.lock().unwrap_or_else(PoisonError::into_inner);
    let elapsed = start.map_or(Duration::ZERO, |start| start.elapsed());
    State { step, done: DONE.load(Relaxed), total: TOTAL.load(Relaxed), elapsed }
}

/// Ask the current pass to end at once. Its loops skip what is left, and the film keeps only whole samples.
pub fn abandon() {
    ABANDONED.store(true, Relaxed);
}

/// Whether the current pass is to end at once.
pub fn is_abandoned() -> bool {
    ABANDONED.load(Relaxed)
}
