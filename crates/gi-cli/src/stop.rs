//! Signals that end a run early: its picture is saved first.
//!
//! | when | first signal | second | third |
//! |---|---|---|---|
//! | reading, preparing | ends the process; nothing is written | | |
//! | passes | the current pass is finished, then everything is saved | the pass is abandoned, then everything is saved | ends the process |
//! | saving | everything is saved | ends the process | |
//!
//! Signals that came during the passes do not count while saving: two in a row never lose a picture.
//! No file is ever half-written: the process ends between two files.

use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Mutex, PoisonError};

use gi_core::{files, progress};

use crate::say::say;

/// A signal that asks a program to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The number that systems give it.
    number: i32,
    /// Its name.
    name: &'static str,
}

/// The signals that are caught: SIGHUP, SIGINT, SIGTERM.
const SIGNALS: [Signal; 3] = [
    Signal { number: 1, name: "SIGHUP" },
    Signal { number: 2, name: "SIGINT" },
    Signal { number: 15, name: "SIGTERM" },
];

impl Signal {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The exit status of a program that it has ended.
    pub fn exit_status(self) -> u8 {
        128 + self.number as u8
    }
}

/// What a run is doing, as far as signals are concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Preparing,
    Passes,
    Saving,
    /// Everything is written.
    Farewell,
}

static PHASE: Mutex<Phase> = Mutex::new(Phase::Preparing);
/// The first signal that came: its position in [`SIGNALS`] plus one.
static REQUESTED: AtomicUsize = AtomicUsize::new(0);

/// Say what the run does from now on. If a signal is about to end the process, this does not return.
pub(crate) fn enter(phase: Phase) {
    *PHASE.lock().unwrap_or_else(PoisonError::into_inner) = phase;
}

/// The signal that asked the run to end, if one did.
pub(crate) fn requested() -> Option<Signal> {
    REQUESTED.load(SeqCst).checked_sub(1).map(|k| SIGNALS[k])
}

/// React to signals from now on.
pub(crate) fn watch() {
    let mut last = (Phase::Preparing, 0);
    on_signal(move |signal| {
        let place = SIGNALS.iter().position(|s| *s == signal).map_or(0, |k| k + 1);
        let _ = REQUESTED.compare_exchange(0, place, SeqCst, SeqCst);
        // Held until the process ends if it does, so that no pass begins meanwhile.
        let phase = PHASE.lock().unwrap_or_else(PoisonError::into_inner);
        last = (*phase, if last.0 == *phase { last.1 + 1 } else { 1 });
        react(signal, last);
    });
}

/// React to a signal that is the `nth` in a phase.
fn react(signal: Signal, (phase, nth): (Phase, u32)) {
    let name = signal.name();
    match (phase, nth) {
        (Phase::Preparing, _) => end(signal, "before the first pass: no picture is written"),
        (Phase::Passes, 1) => say(format!(
            "{name}: finishing this pass, then saving; a second signal abandons the pass"
        )),
        (Phase::Passes, 2) => {
            progress::abandon();
            say(format!("{name}: abandoning this pass, then saving; a third signal saves nothing"));
        }
        (Phase::Saving, 1) => say(format!("{name}: saving; a second signal saves nothing more")),
        (Phase::Farewell, _) => std::process::exit(signal.exit_status().into()),
        _ => end(signal, "again: nothing more is saved"),
    }
}

/// End the process between two files.
fn end(signal: Signal, what: &str) -> ! {
    let _whole = files::hold_writes();
    say(format!("stopped by {} {what}", signal.name()));
    std::process::exit(signal.exit_status().into())
}

/// Call `react` for every signal of those that ask a program to end, in a thread of its own. Signals that whoever started
/// the program has told it to ignore (`nohup`, say) stay ignored.
#[cfg(unix)]
pub fn on_signal(mut react: impl FnMut(Signal) + Send + 'static) {
    let ignored = ignored();
    let caught = SIGNALS.iter().map(|s| s.number).filter(|n| ignored >> (n - 1) & 1 == 0);
    let Ok(mut signals) = signal_hook::iterator::Signals::new(caught) else {
        return say("warning: cannot catch signals: a signal ends the run without a picture");
    };
    // A file that grows beyond the limit of the shell is then a write that fails, like a full disk.
    let limit = signal_hook::consts::SIGXFSZ;
    let _ = signal_hook::flag::register(limit, std::sync::Arc::default());
    std::thread::spawn(move || {
        for number in signals.forever() {
            SIGNALS.iter().filter(|s| s.number == number).for_each(|s| react(*s));
        }
    });
}

/// The same, where there are no such signals.
#[cfg(not(unix))]
pub fn on_signal(_: impl FnMut(Signal) + Send + 'static) {}

/// The signals that this process ignores, as a mask; none where the system does not say.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|text| u64::from_str_radix(text.trim(), 16).ok()).unwrap_or(0)
}

/// Send a signal to another process. That it has ended meanwhile is no error.
#[cfg(unix)]
pub fn send(signal: Signal, process: u32) {
    let id = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    let signal = rustix::process::Signal::from_named_raw(signal.number);
    if let (Some(id), Some(signal)) = (id, signal) {
        let _ = rustix::process::kill_process(id, signal);
    }
}

/// The same, where there are no such signals.
#[cfg(not(unix))]
pub fn send(_: Signal, _: u32) {}
