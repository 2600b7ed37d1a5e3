//! Programs run as their users run them: with a command line, in a folder, until an exit status and a message.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Run a program. Its crate's own tests know where it is: `env!("CARGO_BIN_EXE_name")`.
pub fn run(program: &str, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).output().expect("it runs")
}

/// What a run said beside its result: errors, warnings, progress.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Check that a run succeeded.
#[track_caller]
pub fn assert_success(output: &Output) {
    assert!(output.status.success(), "{}", said(output));
}

/// Check that a run ended with this exit status, and in its message has these words and no panic.
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

/// A folder for the files of a test, which goes away with them.
pub struct Folder(TempDir);

impl Folder {
    /// A new one, empty.
    pub fn make() -> Self {
        Folder(tempfile::tempdir().expect("a folder"))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// A file in it, there or not, as an argument.
    pub fn at(&self, name: &str) -> String {
        self.path().join(name).to_str().expect("UTF-8").to_string()
    }

    /// The names of all that is in it, sorted.
    pub fn files(&self) -> Vec<String> {
        files(self.path())
    }
}

/// The names of all that is in a folder, sorted.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
