//! The techniques' programs, run as a user runs them.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::{Budget, Failure, Run, child, show, text};

/// The programs that can be compared, in the lecture's order after the reference.
pub(crate) const TECHNIQUES: [&str; 7] =
    ["pathtrace", "irrcache", "radcache", "photonmap", "ppm", "instant-radiosity", "lightcuts"];

/// Where the programs are.
#[derive(Clone, Debug)]
pub struct Programs {
    /// Their folder.
    pub folder: PathBuf,
}

/// What a run says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats {
    /// Passes made.
    pub passes: u64,
    /// Seconds for reading the scene, building its tree, preparing, and all passes.
    pub seconds: [f64; 4],
    /// Threads.
    pub threads: u64,
    /// Seed of every random number.
    pub seed: u64,
    /// Hash of all that the scene was read from.
    pub scene_hash: String,
    /// Which light paths the estimator can reach.
    pub reach: String,
    /// The technique's own numbers.
    pub technique: Vec<(String, f64)>,
    /// What was odd about the scene.
    pub warnings: Vec<String>,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its command line, the program by name alone.
    pub command: Vec<String>,
    /// Its picture.
    pub exr: PathBuf,
    /// What it says of itself.
    pub stats: Stats,
}

/// A run in all its particulars.
pub(crate) struct Order<'a> {
    pub(crate) run: &'a Run,
    pub(crate) scene: &'a Path,
    pub(crate) budget: Budget,
    pub(crate) seed: u32,
    pub(crate) flags: &'a [String],
    /// The picture; statistics go beside it.
    pub(crate) exr: PathBuf,
}

impl Order<'_> {
    /// What the program is given, but for where its results go.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let seed = ["--seed".to_string(), self.seed.to_string()];
        let scene = [show(self.scene)];
        [&scene[..], self.flags, &self.run.knobs, &self.budget.flag(), &seed].concat()
    }

    fn outputs(&self) -> Vec<String> {
        ["-o".into(), show(&self.exr), "--stats".into(), show(&self.exr.with_extension("json"))]
            .to_vec()
    }

    /// The command line, the program by name alone.
    pub(crate) fn command(&self) -> Vec<String> {
        [&[self.run.program.clone()][..], &self.arguments(), &self.outputs()].concat()
    }
}

impl Programs {
    /// The programs beside this one.
    ///
    /// # Errors
    /// This program's own file cannot be found.
    pub fn beside_this() -> Result<Self, Failure> {
        let this = std::env::current_exe().map_err(|e| {
            Failure::Other(format!("cannot find this program's own folder: {e}; give --programs"))
        })?;
        Ok(Programs { folder: this.parent().unwrap_or(Path::new(".")).to_path_buf() })
    }

    /// The techniques whose programs are there, and those that are not.
    pub fn techniques(&self) -> (Vec<String>, Vec<String>) {
        TECHNIQUES.iter().map(|t| t.to_string()).partition(|t| self.file(t).is_file())
    }

    fn file(&self, program: &str) -> PathBuf {
        self.folder.join(format!("{program}{}", std::env::consts::EXE_SUFFIX))
    }

    /// Whether a program was built after a file was made.
    pub(crate) fn is_newer_than(&self, program: &str, file: &Path) -> bool {
        let time = |path: &Path| std::fs::metadata(path).and_then(|m| m.modified()).ok();
        time(&self.file(program)) > time(file)
    }

    /// Check that a program is there and takes its flags: with --help behind them it reads them and ends.
    pub(crate) fn check(&self, order: &Order) -> Result<(), Failure> {
        let program = &order.run.program;
        if !self.file(program).is_file() {
            let (there, _) = self.techniques();
            return Err(Failure::Input(format!(
                "error: there is no program {program} in {}: build it (cargo build --release), or name another folder \
                 with --programs; the techniques there are: {}",
                show(&self.folder),
                if there.is_empty() { "none".into() } else { there.join(", ") }
            )));
        }
        let tried = Command::new(self.file(program)).args(order.arguments()).arg("--help").output();
        let tried = tried.map_err(|e| {
            Failure::Other(format!("cannot run {}: {e}", show(&self.file(program))))
        })?;
        if tried.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&tried.stderr);
        Err(Failure::Input(format!("{}: {}", order.run.label, said.trim_end())))
    }

    /// Make a run.
    pub(crate) fn run(&self, order: &Order) -> Result<Finished, Failure> {
        let command = order.command();
        let failed = |what: String, input: bool| {
            let text = format!("{what}\n  {}", text::command_line(&command));
            if input { Failure::Input(format!("error: {text}")) } else { Failure::Other(text) }
        };
        // Its messages go where ours go.
        let mut program = Command::new(self.file(&order.run.program));
        program.args(&command[1..]).arg("--quiet").stdin(Stdio::null()).stdout(Stdio::null());
        let status = child::run(&mut program)?
            .map_err(|e| failed(format!("cannot run {}: {e}", order.run.program), false))?;
        if !status.success() {
            return Err(failed(
                format!("{} failed ({status})", order.run.label),
                status.code() == Some(2),
            ));
        }
        let stats = Stats::read(&order.exr.with_extension("json")).map_err(|e| failed(e, false))?;
        Ok(Finished { command, exr: order.exr.clone(), stats })
    }
}

impl Stats {
    /// Read what a program has written.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|e| format!("cannot read {}: {e}", show(path)))?;
        let json = serde_json::from_slice(&bytes)
            .map_err(|e| format!("{} is damaged: {e}", show(path)))?;
        Self::from_json(&json)
            .ok_or_else(|| format!("{} is not what a program writes as its statistics", show(path)))
    }

    fn from_json(json: &Value) -> Option<Self> {
        let seconds = |name: &str| json["seconds"][name].as_f64();
        let technique = json["technique"].as_object()?.iter();
        Some(Stats {
            passes: json["passes"].as_u64()?,
            seconds: [seconds("load")?, seconds("build")?, seconds("prepare")?, seconds("render")?],
            threads: json["threads"].as_u64()?,
            seed: json["seed"].as_u64()?,
            scene_hash: json["scene_hash"].as_str()?.to_string(),
            reach: json["reach"].as_str()?.to_string(),
            // A number that is not finite is written as null.
            technique: technique
                .map(|(k, v)| (k.clone(), v.as_f64().unwrap_or(f64::NAN)))
                .collect(),
            warnings: json["warnings"]
                .as_array()?
                .iter()
                .filter_map(|w| w.as_str().map(String::from))
                .collect(),
        })
    }

    /// What --time counts: preparing and passes.
    pub fn counted_seconds(&self) -> f64 {
        self.seconds[2] + self.seconds[3]
    }
}
