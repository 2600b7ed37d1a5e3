//! Turns a panic of another library, whose decoder met a damaged file, into an error.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread runs a guarded function.
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Run a decoder. If it panics, nothing is printed, and the error says so.
///
/// # Errors
/// Those of the decoder, or a message of one line without the name of the file.
pub fn guarded<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    hide_guarded_panics();
    let outer = GUARDED.replace(true);
    // The state of a decoder that panicked is dropped here: nobody sees it half changed.
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    GUARDED.set(outer);
    result.unwrap_or_else(|_| Err("its decoder failed: the file is damaged".into()))
}

/// Let the panic hook print nothing while a guarded function runs.
fn hide_guarded_panics() {
    static HIDE: Once = Once::new();
    HIDE.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !GUARDED.get() {
                usual(info);
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decoder_that_panics_gives_an_error() {
        let numbers: Vec<u8> = Vec::new();
        let shown = guarded(|| Ok(numbers[0])).unwrap_err();
        assert!(shown.contains("the file is damaged"), "{shown}");
        assert_eq!(guarded(|| Ok(1)), Ok(1));
        assert_eq!(guarded(|| Err::<(), _>("why".into())), Err("why".into()));
        assert!(!GUARDED.get());
    }
}
