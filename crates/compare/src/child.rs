//! The child process that is currently running. Whoever stops the comparison can stop it too.

use std::process::{Command, ExitStatus};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::Failure;

/// The current run.
#[derive(Clone, Copy)]
struct Running {
    /// The process of the current run.
    child: Option<u32>,
    /// Whether further runs are forbidden.
    stopped: bool,
}

static RUNNING: Mutex<Running> = Mutex::new(Running { child: None, stopped: false });

fn running() -> MutexGuard<'static, Running> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Forbid further runs, and call `send` with the process of the current run, if there is one. Returns whether there is
/// one: [`crate::compare`] then fails as soon as that process has ended.
pub fn stop(send: impl FnOnce(u32)) -> bool {
    let mut running = running();
    running.stopped = true;
    running.child.map(send).is_some()
}

/// Run a program to its end.
pub(crate) fn run(command: &mut Command) -> Result<std::io::Result<ExitStatus>, Failure> {
    let stopped = || Failure::Other("stopped before all runs were made".into());
    // In its own process group, the child gets signals of the terminal only through us; otherwise it would get each one
    // twice.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let child = {
        let mut running = running();
        if running.stopped {
            return Err(stopped());
        }
        let child = command.spawn();
        running.child = child.as_ref().ok().map(std::process::Child::id);
        child
    };
    let status = child.and_then(|mut child| child.wait());
    let mut running = running();
    running.child = None;
    if running.stopped { Err(stopped()) } else { Ok(status) }
}
