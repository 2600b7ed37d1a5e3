//! Messages. A reader that has gone away, or a full disk behind it, is no reason to end a run: messages are then lost.

use std::fmt::Display;
use std::io::Write;
use std::sync::{Mutex, PoisonError};

/// What keeps a message and the progress bar from mixing.
type Around = Box<dyn Fn(&dyn Fn()) + Send>;

static AROUND: Mutex<Option<Around>> = Mutex::new(None);

/// Write a line to standard error.
pub fn say(text: impl Display) {
    let line = format!("{text}\n");
    let write = || {
        let _ = std::io::stderr().lock().write_all(line.as_bytes());
    };
    match &*AROUND.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(around) => around(&write),
        None => write(),
    }
}

/// Write text to standard output.
pub fn print(text: impl Display) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.to_string().as_bytes()).and_then(|()| out.flush());
}

/// From now on call `around` with what writes a message, so that it can clear the progress bar first.
pub(crate) fn set_around(around: Option<Around>) {
    *AROUND.lock().unwrap_or_else(PoisonError::into_inner) = around;
}
