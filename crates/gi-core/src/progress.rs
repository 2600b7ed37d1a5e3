//! The progress of a run, and requests to end it early. There is one run per process, so the numbers are global: a loop
//! deep in a technique can count without being given a counter. They never influence the computation, with one
//! exception: after [`abandon`], the current pass stops early and does not count. With the box filter, pixels keep the
//! samples that they already took; each pixel has its own weight, so the picture stays valid.

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

/// The progress of the current step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// The items that are counted, such as light paths. Empty before the first step.
    pub step: &'static str,
    /// Number of finished items.
    pub done: u64,
    /// Number of items in this step; 0 if unknown.
    pub total: u64,
    /// Time since the step began.
    pub elapsed: Duration,
}

/// Begin a step of `total` items (0 if unknown).
pub fn begin(step: &'static str, total: u64) {
    let mut current = STEP.lock().unwrap_or_else(PoisonError::into_inner);
    *current = (step, Some(Instant::now()));
    DONE.store(0, Relaxed);
    TOTAL.store(total, Relaxed);
}

/// Count finished items.
pub fn advance(pieces: u64) {
    DONE.fetch_add(pieces, Relaxed);
}

/// The current progress.
pub fn state() -> State {
    let (step, start) = *STEP.lock().unwrap_or_else(PoisonError::into_inner);
    let elapsed = start.map_or(Duration::ZERO, |start| start.elapsed());
    State { step, done: DONE.load(Relaxed), total: TOTAL.load(Relaxed), elapsed }
}

/// Ask the current pass to end at once. Its loops skip their remaining work, and the film keeps only whole samples.
pub fn abandon() {
    ABANDONED.store(true, Relaxed);
}

/// Whether the current pass should end at once.
pub fn is_abandoned() -> bool {
    ABANDONED.load(Relaxed)
}
