//! The programs, and helpers for running programs.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

use gi_core::image_io::{Layers, read_exr};
use gi_tests::program::{Folder, run};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// A program, with flags for a short preparation and short passes.
pub(crate) struct Program {
    pub(crate) name: &'static str,
    pub(crate) flags: &'static [&'static str],
    /// Flags that make the preparation last for minutes; empty if nothing makes it long.
    pub(crate) long_preparation: &'static [&'static str],
}

/// The programs of all techniques.
pub(crate) const PROGRAMS: [Program; 7] = [
    Program { name: "pathtrace", flags: &[], long_preparation: &[] },
    Program {
        name: "irrcache",
        flags: &["--rays", "16"],
        long_preparation: &["--rays", "1000000"],
    },
    Program {
        name: "radcache",
        flags: &["--rays", "16", "--glossy-rays", "16"],
        long_preparation: &["--rays", "1000000"],
    },
    Program {
        name: "photonmap",
        flags: &["--photons", "500", "--caustic-photons", "500"],
        long_preparation: &["--photons", "50000000"],
    },
    Program {
        name: "ppm",
        flags: &["--photons", "500"],
        long_preparation: &["--photons", "50000000"],
    },
    Program { name: "instant-radiosity", flags: &[], long_preparation: &[] },
    Program {
        name: "lightcuts",
        flags: &["--lights", "16", "--vpls", "64", "--rule", "cluster"],
        long_preparation: &["--vpls", "50000000"],
    },
];

/// Run a program on `scene.xml` of a folder. In `flags`, `@` marks names of files in the folder.
pub(crate) fn start(folder: &Folder, program: &str, flags: &str) -> Output {
    let replace = |word: &str| match word.strip_prefix('@') {
        Some(name) => folder.at(name),
        None => word.to_string(),
    };
    let words = [folder.at("scene.xml")].into_iter().chain(flags.split_whitespace().map(replace));
    let words: Vec<String> = words.collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    run(path_of(program).to_str().expect("UTF-8"), &words)
}

/// Where a program is: in the target folder of this test. A test of the whole workspace has built it. A program that is missing
/// is built here, but one that is older than its code is not: `cargo build --workspace --bins` does that.
pub(crate) fn path_of(program: &str) -> PathBuf {
    let test = std::env::current_exe().expect("this test has a file");
    let folder = test.parent().and_then(Path::parent).expect("target/PROFILE/deps");
    let path = folder.join(program);
    if !path.exists() {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--quiet", "-p", program]);
        if folder.ends_with("release") {
            cargo.arg("--release");
        }
        cargo.arg("--target-dir").arg(folder.parent().expect("a target folder"));
        assert!(cargo.status().expect("cargo runs").success(), "{program} does not build");
    }
    path
}

/// Run a command in a shell, which can ignore signals or set limits for it.
pub(crate) fn shell(script: &str, program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("{script}; exec \"$0\" \"$@\"")]);
    command.arg(path_of(program)).args(arguments);
    command
}

/// A program that is running.
pub(crate) struct Running {
    child: Child,
    lines: Receiver<String>,
    said: String,
}

/// Longer than any step takes on a busy machine.
const TOO_LONG: Duration = Duration::from_secs(120);

/// Make sure that child processes start with the default action of signals. A shell that runs tests in the background,
/// or `nohup`, makes them ignore signals, and children inherit that. Signals with a handler are reset in children.
fn take_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for signal in [SIGINT, SIGHUP, SIGTERM] {
            let ends_at_once = Arc::new(AtomicBool::new(true));
            let status = 128 + signal;
            signal_hook::flag::register_conditional_shutdown(signal, status, ends_at_once)
                .expect("a handler");
        }
    });
}

impl Running {
    /// Start a program.
    pub(crate) fn start(program: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(path_of(program));
        command.args(arguments);
        Self::start_command(command)
    }

    /// Start a command.
    pub(crate) fn start_command(mut command: Command) -> Self {
        take_signals();
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let stderr = BufReader::new(child.stderr.take().expect("a pipe"));
        let (send, lines) = channel();
        std::thread::spawn(move || {
            stderr.lines().map_while(Result::ok).try_for_each(|line| send.send(line))
        });
        Running { child, lines, said: String::new() }
    }

    /// Wait until the program prints a line that contains these words.
    #[track_caller]
    pub(crate) fn wait_for(&mut self, words: &str) {
        loop {
            match self.lines.recv_timeout(TOO_LONG) {
                Ok(line) => {
                    self.said += &format!("{line}\n");
                    if line.contains(words) {
                        return;
                    }
                }
                Err(e) => panic!("it never printed {words:?} ({e}):\n{}", self.said),
            }
        }
    }

    /// All that it has said so far, as far as somebody has waited for it.
    pub(crate) fn said(&self) -> &str {
        &self.said
    }

    /// Send a signal, such as INT.
    pub(crate) fn signal(&self, name: &str) {
        let kill = format!("kill -{name} {}", self.child.id());
        let sent = Command::new("sh").args(["-c", &kill]).status().expect("a shell");
        assert!(sent.success(), "{kill}");
    }

    /// Wait for its end. Returns the exit status (`None` if a signal killed it) and everything that it printed.
    #[track_caller]
    pub(crate) fn end(mut self) -> (Option<i32>, String) {
        let start = Instant::now();
        let status = loop {
            match self.child.try_wait().expect("it can be waited for") {
                Some(status) => break status,
                None if start.elapsed() > TOO_LONG => {
                    let _ = self.child.kill();
                    panic!("it did not end:\n{}", self.said);
                }
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        self.lines.iter().for_each(|line| self.said += &format!("{line}\n"));
        assert!(!self.said.contains("panicked"), "{}", self.said);
        (status.code(), self.said)
    }
}

/// Wait until a condition is true.
#[track_caller]
pub(crate) fn wait_until(what: &str, is_so: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < TOO_LONG, "waited in vain until {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The picture that a run has written.
pub(crate) fn picture(folder: &Folder, name: &str) -> Layers {
    read_exr(Path::new(&folder.at(name))).expect("a whole EXR")
}

/// The metadata of a picture with this key.
pub(crate) fn says<'a>(layers: &'a Layers, name: &str) -> Option<&'a str> {
    layers.metadata.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
}
