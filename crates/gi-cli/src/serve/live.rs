//! What the run and the threads that answer clients share: how far the run is, the last picture, and when somebody last asked.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use gi_core::image_io::Layers;
use gi_core::progress::{self, State};
use serde_json::{Map, Value, json};

use super::picture::{Encoded, Snapshot};
use crate::budget::Budget;
use crate::progress::Passes;
use crate::record::SoFar;

/// Time after a request for which its client counts as watching: the page asks every second.
const WATCHED: Duration = Duration::from_secs(5);

/// What a run is doing.
pub(crate) enum Stage {
    /// The scene is read.
    Reading,
    /// The technique prepares.
    Preparing,
    /// Passes are made, since then.
    Passes(Passes, Instant),
    /// Files are written.
    Saving,
    /// It is over, with this outcome.
    Ended(String),
}

/// A run that can be watched.
pub(super) struct Live {
    /// What does not change.
    about: Map<String, Value>,
    start: Instant,
    now: Mutex<Now>,
    clients: Mutex<Clients>,
}

/// What changes during the run.
struct Now {
    stage: Stage,
    size: Option<[usize; 2]>,
    snapshot: Option<Arc<Snapshot>>,
    /// Number of snapshots so far.
    version: u32,
}

/// Who asks.
#[derive(Default)]
struct Clients {
    /// When somebody last asked for the state or for a layer.
    asked: Option<Instant>,
    /// Whether somebody was told that the run has ended.
    know_of_end: bool,
    /// Time spent on answers that is not yet counted as time of a snapshot.
    spent: Duration,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Live {
    /// A run that begins now.
    pub(super) fn new(program: &str, scene: &str) -> Self {
        let id = format!("{} {}", crate::identity::date(), std::process::id());
        let about = [
            ("run", id),
            ("program", program.to_string()),
            ("version", crate::identity::VERSION.to_string()),
            ("scene", scene.to_string()),
        ];
        let about = about.map(|(name, value)| (name.to_string(), json!(value)));
        let now = Now { stage: Stage::Reading, size: None, snapshot: None, version: 0 };
        Live {
            about: about.into_iter().collect(),
            start: Instant::now(),
            now: Mutex::new(now),
            clients: Mutex::default(),
        }
    }

    pub(super) fn enter(&self, stage: Stage) {
        lock(&self.now).stage = stage;
    }

    pub(super) fn set_size(&self, size: [usize; 2]) {
        lock(&self.now).size = Some(size);
    }

    /// Show another picture from now on.
    pub(super) fn show(&self, layers: Layers, so_far: &SoFar) {
        let version = lock(&self.now).version + 1;
        let snapshot = Arc::new(Snapshot::new(version, layers, so_far));
        let mut now = lock(&self.now);
        (now.version, now.snapshot) = (version, Some(snapshot));
    }

    /// If somebody watches: the time that answers took since this was asked last.
    pub(super) fn watched(&self) -> Option<Duration> {
        let mut clients = lock(&self.clients);
        clients.asked.filter(|asked| asked.elapsed() < WATCHED)?;
        Some(std::mem::take(&mut clients.spent))
    }

    /// Whether somebody was told that the run has ended, and nobody has asked for this long.
    pub(super) fn is_left(&self, quiet: Duration) -> bool {
        let clients = lock(&self.clients);
        clients.know_of_end && clients.asked.is_none_or(|asked| asked.elapsed() >= quiet)
    }

    /// A layer of the last picture, for a client.
    pub(super) fn layer(&self, name: &str) -> Option<Encoded> {
        let snapshot = lock(&self.now).snapshot.clone();
        let (encoded, spent) = snapshot?.layer(name)?;
        let mut clients = lock(&self.clients);
        clients.asked = Some(Instant::now());
        clients.spent += spent;
        Some(encoded)
    }

    /// How far the run is, for a client.
    pub(super) fn state(&self) -> Value {
        let now = lock(&self.now);
        let mut state = self.about.clone();
        let mut put = |name: &str, value: Value| state.insert(name.into(), value);
        put("size", json!(now.size));
        put("elapsed", json!(self.start.elapsed().as_secs_f64()));
        put("picture", json!(now.snapshot.as_ref().map(|snapshot| snapshot.describe())));
        for (name, value) in now.stage.describe(progress::state()) {
            put(name, value);
        }
        let has_ended = matches!(now.stage, Stage::Ended(_));
        drop(now);
        let mut clients = lock(&self.clients);
        clients.asked = Some(Instant::now());
        clients.know_of_end |= has_ended;
        Value::Object(state)
    }
}

impl Stage {
    /// What the page is told about it.
    fn describe(&self, state: State) -> Vec<(&'static str, Value)> {
        match self {
            Stage::Reading => vec![("phase", json!("reading"))],
            Stage::Preparing => {
                let step = json!({ "name": state.step, "done": state.done, "total": state.total });
                vec![("phase", json!("preparing")), ("step", step)]
            }
            Stage::Passes(passes, since) => {
                let estimate = passes.estimate(state, since.elapsed());
                let (number, time) = match passes.budget {
                    Budget::Passes(number) => (Some(number), None),
                    Budget::Time(time) => (None, Some(time.as_secs_f64())),
                };
                vec![
                    ("phase", json!("passes")),
                    ("pass", json!(estimate.made)),
                    ("passes", json!(number)),
                    ("time", json!(time)),
                    ("fraction", json!(estimate.fraction)),
                    ("remaining", json!(estimate.remaining)),
                    ("samples_per_second", json!(estimate.samples_per_second)),
                ]
            }
            Stage::Saving => vec![("phase", json!("saving"))],
            Stage::Ended(outcome) => vec![("phase", json!("ended")), ("outcome", json!(outcome))],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_watches_until_somebody_asks_and_answers_cost_time_once() {
        let live = Live::new("pathtrace", "scene.xml");
        assert_eq!(live.watched(), None);
        assert!(live.layer("Picture").is_none());
        assert_eq!(live.watched(), None);
        assert_eq!(live.state()["picture"], Value::Null);
        assert_eq!(live.watched(), Some(Duration::ZERO));
        lock(&live.clients).spent = Duration::from_secs(2);
        assert_eq!(live.watched(), Some(Duration::from_secs(2)));
        assert_eq!(live.watched(), Some(Duration::ZERO));
        lock(&live.clients).asked = Instant::now().checked_sub(2 * WATCHED);
        assert_eq!(live.watched(), None);
    }

    #[test]
    fn a_run_is_left_once_a_client_knows_of_its_end() {
        let live = Live::new("pathtrace", "scene.xml");
        live.state();
        assert!(!live.is_left(Duration::ZERO));
        live.enter(Stage::Ended("finished".into()));
        assert!(!live.is_left(Duration::ZERO));
        assert_eq!(live.state()["outcome"], "finished");
        assert!(live.is_left(Duration::ZERO) && !live.is_left(Duration::from_secs(60)));
    }
}
