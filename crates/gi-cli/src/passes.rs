//! The passes of a run: made until the budget is spent or a signal comes, or continued from a checkpoint.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError::Timeout, channel};
use std::time::{Duration, Instant};

use gi_core::eye::SourceRays;
use gi_core::film::Film;
use gi_core::technique::Technique;

use crate::budget::Budget;
use crate::checkpoint::{Checkpoint, Identity, Keeper};
use crate::preview::Preview;
use crate::progress::{Part, Passes, Progress};
use crate::record::{About, SoFar};
use crate::say::say;
use crate::serve::{Page, Stage};
use crate::stop;
use crate::{Common, Failure};

/// Largest index of a pass, plus one: sample numbers are 32-bit integers.
const MOST_PASSES: u32 = u32::MAX - 1;
/// Time between two looks at the tiles of the first pass.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// The passes of a run, and what is done between them.
pub(crate) struct Making<'a> {
    common: &'a Common,
    /// Numbers of the passes that are in the film.
    made: Range<u32>,
    /// Number of passes that were resumed.
    earlier: u32,
    /// When preparation began.
    start: Instant,
    keeper: Option<Keeper<'a>>,
    /// Rays that look for light sources in view.
    sources: Option<&'a SourceRays<'a>>,
    /// Whether the last pass was abandoned. The technique's state must then not be saved.
    abandoned: bool,
}

impl<'a> Making<'a> {
    /// Check that the technique supports the requested options, and resume if asked to.
    pub(crate) fn begin<'t>(
        (technique, sources): (&mut impl Technique<'t>, Option<&'a SourceRays<'a>>),
        common: &'a Common,
        film: &mut Film,
        identity: &'a Identity,
        start: Instant,
    ) -> Result<Self, Failure> {
        let first = common.first_pass;
        if first > 0 && !technique.passes_are_independent() {
            return Err(Failure::Input(
                "error: --first-pass: the passes of this method build on each other".into(),
            ));
        }
        let wanted = match common.budget() {
            Budget::Passes(passes) => passes,
            Budget::Time(_) => 1,
        };
        if first.checked_add(wanted).is_none_or(|end| end > MOST_PASSES) {
            let text = format!(
                "error: --first-pass {first}: the largest number of a pass is {}, and this run would go beyond; give a smaller number",
                MOST_PASSES - 1
            );
            return Err(Failure::Input(text));
        }
        let mut made = first..first;
        if let (true, Some(path)) = (common.resume, &common.checkpoint) {
            let restore = |state: &[u8]| technique.restore(state);
            made = Checkpoint::read(path)?.resume(identity, &[], film, restore)?;
            if made.start != first {
                let text = format!(
                    "error: {0} begins with pass {1}; continue it with --first-pass {1}",
                    path.display(),
                    made.start
                );
                return Err(Failure::Input(text));
            }
        }
        let every = common.checkpoint_interval;
        let keeper = common.checkpoint.as_deref().map(|path| Keeper::new(path, identity, every));
        let earlier = made.len() as u32;
        Ok(Making { common, made, earlier, start, keeper, sources, abandoned: false })
    }

    /// Number of passes that were resumed.
    pub(crate) fn earlier(&self) -> u32 {
        self.earlier
    }

    /// Make passes until the budget is spent, the technique says that it is enough, or a signal comes. `page` tells how far they
    /// are.
    pub(crate) fn run<'t, T: Technique<'t>>(
        &mut self,
        technique: &mut T,
        film: &mut Film,
        (about, mut previews): (&About, Vec<Preview>),
        page: Option<&Page>,
    ) {
        let budget = self.common.budget();
        let before = self.made.len() as u32;
        let counter = Arc::new(AtomicU32::new(before));
        let shown = Passes {
            budget,
            before,
            made: counter.clone(),
            samples: film.size().iter().product::<usize>() as f64,
            spent: self.start.elapsed(),
        };
        if let Some(page) = page {
            page.enter(Stage::Passes(shown.clone(), Instant::now()));
        }
        let _progress = Progress::show(Part::Passes(shown), self.common.quiet);
        while budget.goes_on(self.made.len() as u32, self.start.elapsed())
            && self.made.end < MOST_PASSES
            && !technique.is_done()
            && (stop::requested().is_none() || self.is_first_pass(film))
        {
            let in_film = film.passes();
            if in_film == 0 && !previews.is_empty() {
                self.first_pass(technique, film, (about, &mut previews));
            } else {
                self.pass(technique, film);
            }
            // An abandoned pass does not count.
            self.abandoned = film.passes() == in_film;
            if self.abandoned {
                break;
            }
            self.made.end += 1;
            counter.store(self.made.len() as u32, Relaxed);
            if stop::requested().is_none() {
                self.between(technique, film);
                for preview in &mut previews {
                    let elapsed = self.start.elapsed();
                    let so_far = || about.so_far(technique, film, elapsed, None);
                    preview.show(elapsed, || Some((film.layers(), so_far())));
                }
            }
        }
        if self.made.len() as u32 == before && before > 0 {
            technique.recall(self.made.end - 1, film);
        }
    }

    /// Make the next pass.
    fn pass<'t>(&self, technique: &mut impl Technique<'t>, film: &mut Film) {
        let index = self.made.end;
        if let Some(rays) = self.sources {
            rays.add_to_pass(index, film);
        }
        technique.pass(index, film);
    }

    /// Make the first pass. It can take long, so previews show the tiles that are finished.
    fn first_pass<'t, T: Technique<'t>>(
        &self,
        technique: &mut T,
        film: &mut Film,
        (about, previews): (&About, &mut [Preview]),
    ) {
        let before = about.so_far(technique, film, Duration::ZERO, None);
        let watched = film.watch();
        std::thread::scope(|threads| {
            let (running, ended) = channel::<()>();
            threads.spawn(move || {
                let _running = running;
                self.pass(technique, film);
            });
            while ended.recv_timeout(LOOK_EVERY) == Err(Timeout) {
                let elapsed = self.start.elapsed();
                let render = elapsed.saturating_sub(about.prepare);
                let so_far = || SoFar { render, ..before.clone() };
                for preview in &mut *previews {
                    preview.show(elapsed, || Some((watched.layers()?, so_far())));
                }
            }
        });
    }

    /// Whether no pass is made yet, and none was abandoned. A signal that comes between preparation and the first pass then leaves a
    /// picture of one pass.
    fn is_first_pass(&self, film: &Film) -> bool {
        film.passes() == 0 && !gi_core::progress::is_abandoned()
    }

    /// Write a checkpoint if one is due. On failure, warn and retry after the same interval.
    fn between<'t>(&mut self, technique: &impl Technique<'t>, film: &Film) {
        if let Some(keeper) = self.keeper.as_mut().filter(|keeper| keeper.is_due())
            && let Err(failure) = keeper.keep(technique, film, &self.made)
        {
            let every = crate::progress::span(self.common.checkpoint_interval);
            let text = failure.text();
            say(format!("warning: {text}; the run goes on, and tries again in {every}"));
        }
    }

    /// Write the last checkpoint.
    pub(crate) fn end<'t>(
        &mut self,
        technique: &impl Technique<'t>,
        film: &Film,
    ) -> Result<(), Failure> {
        let Some(keeper) = &mut self.keeper else { return Ok(()) };
        if !self.abandoned {
            return keeper.keep(technique, film, &self.made);
        }
        let kept = keeper.kept().map_or("is as it was before".into(), |n| format!("holds {n}"));
        let made = self.made.len();
        say(format!(
            "warning: a checkpoint cannot be made in the middle of a pass: the picture holds {made} passes, the checkpoint {kept}"
        ));
        Ok(())
    }
}

/// Check that the checkpoints that the run needs are of this scene, camera and so on, before the technique prepares.
pub(crate) fn check_checkpoints(common: &Common, identity: &Identity) -> Result<(), Failure> {
    let resumed = common.checkpoint.iter().filter(|_| common.resume);
    let check = |path, may_differ| Checkpoint::look(path, identity, may_differ).map(|_| ());
    resumed.into_iter().try_for_each(|path| check(path, &[]))?;
    // Runs whose passes build on each other differ in the seed.
    common.merge.iter().try_for_each(|path| check(path, &["seed"]))
}

/// A number of passes, in words.
pub(crate) fn passes(number: u32) -> String {
    format!("{number} {}", if number == 1 { "pass" } else { "passes" })
}
