//! Previews: the picture so far, written over and over during a run, or sent to a viewer.

use std::time::{Duration, Instant};

use gi_core::image_io::Layers;

use crate::Failure;
use crate::record::SoFar;
use crate::say::say;

/// Largest part of the run's time that previews may take.
const SHARE: f64 = 0.01;
/// Guess of the time to write a pixel, before a preview has been written.
const SECONDS_PER_PIXEL: f64 = 5e-7;

/// What is done with the picture so far.
type Write<'a> = Box<dyn FnMut(Layers, &SoFar) -> Result<(), Failure> + 'a>;

/// Says whether somebody watches: the time that this has taken since it was asked last, besides the previews themselves.
type Watched<'a> = Box<dyn Fn() -> Option<Duration> + 'a>;

/// Writes previews, or sends them to a viewer.
pub(crate) struct Preview<'a> {
    /// What a preview is called in messages.
    what: &'static str,
    schedule: Schedule,
    watched: Watched<'a>,
    write: Write<'a>,
    /// Whether a failure was reported already.
    failed: bool,
}

impl<'a> Preview<'a> {
    /// Call `write` about `every` so often for a picture of `size` pixels.
    pub(crate) fn new(
        what: &'static str,
        every: Duration,
        [w, h]: [usize; 2],
        write: impl FnMut(Layers, &SoFar) -> Result<(), Failure> + 'a,
    ) -> Self {
        let cost = Duration::from_secs_f64((w * h) as f64 * SECONDS_PER_PIXEL);
        let schedule = Schedule { every, cost, last: Duration::ZERO };
        let watched = Box::new(|| Some(Duration::ZERO));
        Preview { what, schedule, watched, write: Box::new(write), failed: false }
    }

    /// Only while somebody watches. The first one comes as soon as it can, whatever it costs: a viewer should not wait for it.
    pub(crate) fn while_watched(mut self, watched: impl Fn() -> Option<Duration> + 'a) -> Self {
        self.schedule.cost = Duration::ZERO;
        self.watched = Box::new(watched);
        self
    }

    /// Write the picture if it is time and there is one. `elapsed` is the time since the run began.
    pub(crate) fn show(
        &mut self,
        elapsed: Duration,
        picture: impl FnOnce() -> Option<(Layers, SoFar)>,
    ) {
        let Some(besides) = (self.watched)() else { return };
        self.schedule.cost += besides;
        if !self.schedule.is_due(elapsed) {
            return;
        }
        let clock = Instant::now();
        let Some((layers, so_far)) = picture() else { return };
        let written = (self.write)(layers, &so_far);
        self.schedule.done(elapsed, clock.elapsed());
        if let (Err(failure), false) = (&written, self.failed) {
            say(format!("warning: no {}: {}; the run goes on", self.what, failure.text()));
        }
        self.failed = written.is_err();
    }
}

/// When the next preview is written.
#[derive(Clone, Copy, Debug)]
struct Schedule {
    every: Duration,
    /// Time that a preview takes.
    cost: Duration,
    /// When the last one was done; zero is the beginning of the run.
    last: Duration,
}

impl Schedule {
    fn is_due(&self, elapsed: Duration) -> bool {
        elapsed.saturating_sub(self.last) >= self.every.max(self.cost.div_f64(SHARE))
    }

    fn done(&mut self, elapsed: Duration, cost: Duration) {
        (self.cost, self.last) = (cost, elapsed + cost);
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// The share of a run of an hour that previews take which cost `cost` seconds each.
    fn share(every: f64, cost: f64) -> f64 {
        let seconds = Duration::from_secs_f64;
        let mut schedule =
            Schedule { every: seconds(every), cost: seconds(cost), last: seconds(0.0) };
        let (mut now, mut spent) = (0.0, 0.0);
        while now < 3600.0 {
            now += 0.25;
            if schedule.is_due(seconds(now)) {
                schedule.done(seconds(now), seconds(cost));
                (now, spent) = (now + cost, spent + cost);
            }
        }
        spent / now
    }

    #[test]
    fn previews_take_less_than_a_hundredth_of_the_run_or_wait() {
        for (every, cost) in [(1.0, 0.001), (10.0, 0.5), (0.1, 3.0), (10.0, 30.0)] {
            let share = share(every, cost);
            assert!(share > 0.0 && share <= SHARE, "{every} {cost}: {share}");
        }
        // One that would take longer than a hundredth of the whole run is never written.
        assert_eq!(share(10.0, 60.0), 0.0);
    }

    #[test]
    fn cheap_previews_come_at_their_interval() {
        let cost = 0.01;
        assert!((share(10.0, cost) - cost / 10.0).abs() < 0.1 * cost / 10.0);
    }

    #[test]
    fn a_preview_for_a_page_waits_until_somebody_watches_and_pays_for_its_answers() {
        let seconds = Duration::from_secs;
        let (watched, shown) = (Cell::new(None), Cell::new(0));
        let show = |_, _: &_| {
            shown.set(shown.get() + 1);
            Ok(())
        };
        let mut preview =
            Preview::new("page", seconds(1), [1, 1], show).while_watched(|| watched.take());
        // After so many seconds, with so many seconds of answers since the last time.
        let mut at = |time, answers: Option<u64>| {
            watched.set(answers.map(seconds));
            preview.show(seconds(time), || Some((Layers::default(), SoFar::default())));
            shown.get()
        };
        assert_eq!(at(10, None), 0);
        assert_eq!(at(20, Some(0)), 1);
        // Three seconds of answers are a hundredth of 300.
        assert_eq!([at(30, Some(1)), at(310, Some(2)), at(330, Some(0))], [1, 1, 2]);
        assert_eq!([at(332, Some(0)), at(340, None)], [3, 3]);
    }
}
