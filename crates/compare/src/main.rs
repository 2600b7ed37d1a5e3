//! `compare`: compares techniques on one scene.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU8, Ordering::SeqCst};
use std::time::Duration;

use clap::{CommandFactory, Parser};
use compare::{
    Budget, Failure, Programs, Request, Run, Series, Subjects, Truth, compare, is_picture, plan,
};

/// The end of the help.
const EXAMPLE: &str = "Example: two techniques, ten seconds each
  compare scenes/cornell-box.xml --techniques pathtrace,ppm --time 10s -o out";

/// Compare techniques on one scene with equal time or equal passes, or compare finished pictures. Measures errors
/// against a reference and writes one page to view them.
///
/// The programs run one after the other, each as if started by hand. --time counts preparation and passes; reading the
/// scene and building its tree are not included. The folder then contains index.html, which needs no other file, and
/// the output of the runs.
#[derive(Parser)]
#[command(name = "compare", version = gi_cli::VERSION, after_help = EXAMPLE)]
struct Args {
    /// A scene, or finished pictures: .exr, .pfm or .hdr; FILE.exr#LAYER takes a layer
    #[arg(required = true)]
    inputs: Vec<String>,
    /// What to run: names of programs, or PROGRAM/LABEL for several runs of one program [default: all that are built]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    techniques: Vec<String>,
    /// Flags for the run with that name, or for an additional run: "ppm/a=0.5: --alpha 0.5"; "all: FLAGS" for all runs
    #[arg(long, value_name = "NAME: FLAGS")]
    with: Vec<String>,
    /// Time of each run, including preparation: 10s, 5m [default: 10s]
    #[arg(long, value_name = "TIME", conflicts_with = "spp", value_parser = gi_cli::parse_time)]
    time: Option<Duration>,
    /// Passes of each run, instead of a time
    #[arg(long, visible_alias = "passes", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Finished picture to compare with; several with independent seeds are averaged, and their noise is estimated
    #[arg(long, value_name = "FILE", conflicts_with_all = ["reference_by", "reference_time", "reference_spp"])]
    reference: Vec<String>,
    /// Program and flags that make the reference, in two halves with separate seeds
    #[arg(long, value_name = "NAME: FLAGS", default_value = "pathtrace")]
    reference_by: String,
    /// Time of the reference, for both halves together [default: ten times that of a run]
    #[arg(long, value_name = "TIME", conflicts_with = "reference_spp", value_parser = gi_cli::parse_time)]
    reference_time: Option<Duration>,
    /// Passes of the reference, for both halves together [default: sixteen times those of a run]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    reference_spp: Option<u32>,
    /// Independent seeds of each run; with two or more, bias and variance are measured
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,
    /// Number of budgets per run: 4 runs an eighth, a quarter, a half and the whole, and plots error against time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    ladder: u32,
    /// First seed
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Width and height of all pictures in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// Threads of each run [default: one per processor]
    #[arg(short, long, value_name = "N")]
    threads: Option<u16>,
    /// Set a scene parameter, for all runs
    #[arg(short = 'D', value_name = "NAME=VALUE")]
    define: Vec<String>,
    /// Layer to compare, such as Caustic [default: radiance]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Folder for the page and the pictures [default: SCENE.compare, or compare]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Also write the numbers to a file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Folder with the techniques' programs [default: the folder of this program]
    #[arg(long, value_name = "FOLDER")]
    programs: Option<PathBuf>,
    /// Print only the table and errors
    #[arg(short, long)]
    quiet: bool,
}

impl Args {
    fn request(&self) -> Result<Request, Failure> {
        let programs = match &self.programs {
            Some(folder) => Programs { folder: folder.clone() },
            None => Programs::beside_this()?,
        };
        let is_view = |name: &&String| {
            let name = name.to_ascii_lowercase();
            [".png", ".jpg", ".jpeg"].iter().any(|e| name.ends_with(e))
        };
        if let Some(view) = self.inputs.iter().chain(&self.reference).find(is_view) {
            return Err(Failure::Input(format!(
                "error: {view} is a display image, clipped and rounded: give the .exr that it was made from"
            )));
        }
        let pictures = self.inputs.iter().all(|i| is_picture(i));
        let (subjects, truth, folder) =
            if pictures { self.pictures()? } else { self.series(&programs)? };
        let mut remarks = Vec::new();
        let (_, missing) = programs.techniques();
        if !pictures && self.techniques.is_empty() && !missing.is_empty() {
            remarks.push(format!("not built, and skipped: {}", missing.join(", ")));
        }
        let words = std::env::args_os().skip(1).map(|w| w.to_string_lossy().into_owned());
        let words: Vec<String> = words.collect();
        Ok(Request {
            subjects,
            truth,
            layer: self.layer.clone(),
            folder: self.output.clone().unwrap_or(folder),
            json: self.json.clone(),
            programs,
            command: format!("compare {}", compare::command_line(&words)),
            remarks,
            quiet: self.quiet,
        })
    }

    /// The finished pictures, their reference, and the folder for the page.
    fn pictures(&self) -> Result<(Subjects, Truth, PathBuf), Failure> {
        let for_runs = [
            ("--techniques", !self.techniques.is_empty()),
            ("--with", !self.with.is_empty()),
            ("--time", self.time.is_some()),
            ("--spp", self.spp.is_some()),
            ("--seeds", self.seeds != 1),
            ("--ladder", self.ladder != 1),
            ("--size", self.size.is_some()),
        ];
        if let Some((flag, _)) = for_runs.iter().find(|(_, given)| *given) {
            return Err(Failure::Input(format!(
                "error: {flag} is for runs of a scene, not for finished pictures"
            )));
        }
        if self.reference.is_empty() {
            let text = "error: finished pictures need --reference FILE to be compared with";
            return Err(Failure::Input(text.into()));
        }
        Ok((
            Subjects::Files(self.inputs.clone()),
            Truth::Files(self.reference.clone()),
            "compare".into(),
        ))
    }

    /// The runs of a scene, their reference, and the output folder.
    fn series(&self, programs: &Programs) -> Result<(Subjects, Truth, PathBuf), Failure> {
        let [scene] = &self.inputs[..] else {
            return Err(Failure::Input("error: give one scene, or only finished pictures".into()));
        };
        let scene = PathBuf::from(scene);
        if !scene.is_file() {
            return Err(Failure::Input(format!(
                "error: cannot read {}: there is no such file",
                scene.display()
            )));
        }
        let budget = match (self.spp, self.time) {
            (Some(n), _) => Budget::Passes(n),
            (None, time) => Budget::Time(time.unwrap_or(DEFAULT_TIME)),
        };
        let techniques = if self.techniques.is_empty() {
            programs.techniques().0
        } else {
            self.techniques.clone()
        };
        if techniques.is_empty() && self.with.is_empty() {
            return Err(Failure::Input(format!(
                "error: there is no technique's program in {}: build them (cargo build --release), or name another folder \
                 with --programs",
                programs.folder.display()
            )));
        }
        let (runs, for_all) = plan(&techniques, &self.with)?;
        let truth = if self.reference.is_empty() {
            Truth::Run(Run::parse(&self.reference_by)?, self.reference_budget(budget))
        } else {
            Truth::Files(self.reference.clone())
        };
        let mut flags: Vec<String> = Vec::new();
        let threads = self.threads.map(|t| t.to_string());
        for (flag, value) in [("--size", &self.size), ("-t", &threads)] {
            flags.extend(value.iter().flat_map(|v| [flag.to_string(), v.clone()]));
        }
        flags.extend(self.define.iter().flat_map(|d| ["-D".to_string(), d.clone()]));
        flags.extend(for_all);
        let folder =
            format!("{}.compare", scene.file_stem().unwrap_or_default().to_string_lossy()).into();
        let Args { seeds, seed, ladder, .. } = *self;
        Ok((
            Subjects::Series(Series { scene, runs, budget, seeds, seed, ladder, flags }),
            truth,
            folder,
        ))
    }

    fn reference_budget(&self, run: Budget) -> Budget {
        match (self.reference_spp, self.reference_time, run) {
            (Some(n), ..) => Budget::Passes(n),
            (None, Some(time), _) => Budget::Time(time),
            (None, None, Budget::Time(_)) => run.times(10.0),
            (None, None, Budget::Passes(_)) => run.times(16.0),
        }
    }
}

/// Default time of a run.
const DEFAULT_TIME: Duration = Duration::from_secs(10);

/// Exit status for the signal that stopped the comparison; 0 while there is none.
static STOPPED: AtomicU8 = AtomicU8::new(0);

/// Stop the current run together with the comparison. The run saves its picture first.
fn stop_with_runs() {
    gi_cli::on_signal(|signal| {
        let status = signal.exit_status();
        STOPPED.store(status, SeqCst);
        gi_cli::say(format!("stopped by {}", signal.name()));
        if !compare::stop(|run| gi_cli::send(signal, run)) {
            let _whole = gi_core::files::hold_writes();
            std::process::exit(status.into());
        }
    });
}

fn main() -> ExitCode {
    let mut words = std::env::args();
    if let (Some("--generate"), Some(what)) = (words.nth(1).as_deref(), words.next()) {
        return gi_cli::generate(Args::command(), &what);
    }
    let args = Args::parse();
    stop_with_runs();
    let done = args.request().and_then(|request| Ok((compare(&request)?, request)));
    let status = match done {
        Ok((report, request)) => {
            gi_cli::print(report.table());
            if !args.quiet {
                gi_cli::print(format!("page: {}\n", request.folder.join("index.html").display()));
            }
            ExitCode::SUCCESS
        }
        Err(Failure::Input(text)) => {
            gi_cli::say(text);
            ExitCode::from(2)
        }
        Err(Failure::Other(text)) => {
            gi_cli::say(format!("error: {text}"));
            ExitCode::from(1)
        }
    };
    match STOPPED.load(SeqCst) {
        0 => status,
        stopped => ExitCode::from(stopped),
    }
}
