//! Runs programs as a user would: with a command line, in a folder, checking exit status and messages.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Run a program. The tests of its crate know its path: `env!("CARGO_BIN_EXE_name")`.
pub fn run(program: &str, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).output().expect("it runs")
}

/// Everything that a run printed to standard error: errors, warnings, progress.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Check that a run succeeded.
#[track_caller]
pub fn assert_success(output: &Output) {
    assert!(output.status.success(), "{}", said(output));
}

/// Check that a run ended with this exit status, and that its message contains these words and no panic.
#[track_caller]
pub fn assert_refused(output: &Output, status: i32, says: &[&str]) {
    let text = said(output);
    assert_eq!(output.status.code(), Some(status), "{says:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
    for word in says {
        assert!(text.contains(word), "the message does not say \"{word}\":\n{text}");
    }
}

/// A scene of the project, as an argument.
pub fn scene(name: &str) -> String {
    format!("{}/../scenes/{name}.xml", env!("CARGO_MANIFEST_DIR"))
}

/// A folder for the files of a test; it is deleted with this value.
pub struct Folder(TempDir);

impl Folder {
    /// Create a new, empty folder.
    pub fn make() -> Self {
        Folder(tempfile::tempdir().expect("a folder"))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The path of a file in it, which need not exist, as an argument.
    pub fn at(&self, name: &str) -> String {
        self.path().join(name).to_str().expect("UTF-8").to_string()
    }

    /// The names of all its entries, sorted.
    pub fn files(&self) -> Vec<String> {
        files(self.path())
    }
}

/// The names of all entries of a folder, sorted.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
