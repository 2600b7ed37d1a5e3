//! Runs the techniques' programs as a user would.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::{Budget, Failure, Run, child, show, text};

/// The programs that can be compared: the reference, then the others in the lecture's order.
pub(crate) const TECHNIQUES: [&str; 7] =
    ["pathtrace", "irrcache", "radcache", "photonmap", "ppm", "instant-radiosity", "lightcuts"];

/// The folder with the programs.
#[derive(Clone, Debug)]
pub struct Programs {
    /// Their folder.
    pub folder: PathBuf,
}

/// Statistics that a program writes about its run.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats {
    /// Number of passes.
    pub passes: u64,
    /// Seconds for reading the scene, building its tree, preparation, and all passes.
    pub seconds: [f64; 4],
    /// Number of threads.
    pub threads: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Hash of all files that the scene was read from.
    pub scene_hash: String,
    /// Which light paths the estimator can reach.
    pub reach: String,
    /// The technique's own statistics.
    pub technique: Vec<(String, f64)>,
    /// Warnings about the scene.
    pub warnings: Vec<String>,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its command line; the program without its folder.
    pub command: Vec<String>,
    /// Its picture.
    pub exr: PathBuf,
    /// Its statistics.
    pub stats: Stats,
}

/// Everything that defines a run.
pub(crate) struct Order<'a> {
    pub(crate) run: &'a Run,
    pub(crate) scene: &'a Path,
    pub(crate) budget: Budget,
    pub(crate) seed: u32,
    pub(crate) flags: &'a [String],
    /// File of the picture; the statistics are written beside it.
    pub(crate) exr: PathBuf,
}

impl Order<'_> {
    /// The program's arguments, except those that name its output files.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let seed = ["--seed".to_string(), self.seed.to_string()];
        let scene = [show(self.scene)];
        [&scene[..], self.flags, &self.run.knobs, &self.budget.flag(), &seed].concat()
    }

    fn outputs(&self) -> Vec<String> {
        ["-o".into(), show(&self.exr), "--stats".into(), show(&self.exr.with_extension("json"))]
            .to_vec()
    }

    /// The command line; the program without its folder.
    pub(crate) fn command(&self) -> Vec<String> {
        [&[self.run.program.clone()][..], &self.arguments(), &self.outputs()].concat()
    }
}

impl Programs {
    /// The programs in the folder of this program.
    ///
    /// # Errors
    /// The path of this program's own file cannot be found.
    pub fn beside_this() -> Result<Self, Failure> {
        let this = std::env::current_exe().map_err(|e| {
            Failure::Other(format!("cannot find this program's own folder: {e}; give --programs"))
        })?;
        Ok(Programs { folder: this.parent().unwrap_or(Path::new(".")).to_path_buf() })
    }

    /// The techniques whose programs exist, and those whose programs do not.
    pub fn techniques(&self) -> (Vec<String>, Vec<String>) {
        TECHNIQUES.iter().map(|t| t.to_string()).partition(|t| self.file(t).is_file())
    }

    fn file(&self, program: &str) -> PathBuf {
        self.folder.join(format!("{program}{}", std::env::consts::EXE_SUFFIX))
    }

    /// Whether a program was built after a file was written.
    pub(crate) fn is_newer_than(&self, program: &str, file: &Path) -> bool {
        let time = |path: &Path| std::fs::metadata(path).and_then(|m| m.modified()).ok();
        time(&self.file(program)) > time(file)
    }

    /// Check that a program exists and accepts its flags. It is run with --help appended: it then parses the flags and
    /// exits.
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

    /// Carry out a run.
    pub(crate) fn run(&self, order: &Order) -> Result<Finished, Failure> {
        let command = order.command();
        let failed = |what: String, input: bool| {
            let text = format!("{what}\n  {}", text::command_line(&command));
            if input { Failure::Input(format!("error: {text}")) } else { Failure::Other(text) }
        };
        // Its messages go to our own standard error.
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
    /// Read a program's statistics file.
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
            // A number that is not finite is written as null in JSON.
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

    /// The time that --time limits: preparation and passes.
    pub fn counted_seconds(&self) -> f64 {
        self.seconds[2] + self.seconds[3]
    }
}
