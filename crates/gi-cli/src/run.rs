//! A run from command line to picture.

use std::path::Path;
use std::time::{Duration, Instant};

use gi_core::camera::Camera;
use gi_core::film::Film;
use gi_core::scene::Scene;
use gi_core::technique::{Setting, Technique};
use gi_scene::{ExportError, Loaded};
use serde_json::{Map, Value, json};

use crate::progress::Progress;
use crate::save::{Output, check_writable, save_json};
use crate::{Common, Failure, Program, parse};

/// What a run knows about itself when it is done.
struct Record<'a> {
    program: &'a str,
    arguments: &'a [String],
    common: &'a Common,
    size: [usize; 2],
    passes: u32,
    /// Seconds for reading the scene, building its tree, preparing, and all passes.
    seconds: [f64; 4],
    scene_hash: u64,
    reach: String,
    technique: Vec<(String, f64)>,
    warnings: &'a [String],
}

/// Run a program from its command line.
pub(crate) fn run<P: Program>(arguments: &[String]) -> Result<(), Failure> {
    let command = P::command();
    let program = command.get_name();
    // Once for the scene's name and the -D; again with the presets of the scene in front.
    let first: P = parse(arguments);
    first.common().check()?;
    if let Some(threads) = first.common().threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| Failure::Other(format!("cannot start {threads} threads: {e}")))?;
    }
    if let Some(out) = &first.common().export_mitsuba {
        return export(first.common(), out);
    }
    let clock = Instant::now();
    let loaded = load(first.common())?;
    let load_time = clock.elapsed();
    let args: P =
        parse(&with_presets::<P>(arguments, program, first.common().time.is_some(), &loaded)?);
    let common = args.common();
    common.check()?;
    let output = Output::new(common.output(program))?;
    if let Some(path) = &common.stats {
        output.check_apart(path)?;
        check_writable(path)?;
    }
    say_warnings(common, &loaded.warnings);

    let Loaded { parts, camera, filter, warnings, hash, .. } = loaded;
    check_film(camera.size)?;
    let clock = Instant::now();
    let scene = Scene::new(parts)
        .map_err(|e| Failure::Input(format!("error: {}: {e}", common.scene.display())))?;
    let build_time = clock.elapsed();
    let camera = Camera::new(&camera);
    say_scene(common, &scene, camera.size());
    let setting = Setting { scene: &scene, camera: &camera, seed: common.seed };
    let mut film = Film::new(camera.size(), filter, common.show());

    let clock = Instant::now();
    let mut technique = P::Technique::prepare(setting, &args.params());
    let prepare_time = clock.elapsed();
    passes(&mut technique, common, &mut film, clock);
    let render_time = clock.elapsed() - prepare_time;

    let record = Record {
        program,
        arguments,
        common,
        size: camera.size(),
        passes: film.passes(),
        seconds: [load_time, build_time, prepare_time, render_time].map(|t| t.as_secs_f64()),
        scene_hash: hash,
        reach: technique.reach(),
        technique: technique.statistics(),
        warnings: &warnings,
    };
    save(&record, &film, &output)
}

/// Read the scene.
fn load(common: &Common) -> Result<Loaded, Failure> {
    gi_scene::load(&common.scene, &common.scene_options())
        .map_err(|problems| Failure::Input(problems.to_string()))
}

/// Write the scene as it was understood.
fn export(common: &Common, out: &Path) -> Result<(), Failure> {
    match gi_scene::export_mitsuba(&common.scene, &common.scene_options(), out) {
        Ok(warnings) => {
            say_warnings(common, &warnings);
            Ok(())
        }
        Err(ExportError::Scene(problems)) => Err(Failure::Input(problems.to_string())),
        Err(error) => Err(Failure::Other(format!("cannot write {}: {error}", out.display()))),
    }
}

/// Largest picture that is made, in pixels: the film of one takes about twelve gigabytes.
const MAX_PIXELS: usize = 1 << 26;

fn check_film([w, h]: [usize; 2]) -> Result<(), Failure> {
    if w.saturating_mul(h) <= MAX_PIXELS {
        return Ok(());
    }
    let advice = format!("{MAX_PIXELS} pixels are the most; give a smaller --size");
    Err(Failure::Input(format!("error: a film of {w} x {h} pixels is too large: {advice}")))
}

/// Passes until the budget is spent.
fn passes<'a>(
    technique: &mut impl Technique<'a>,
    common: &Common,
    film: &mut Film,
    start: Instant,
) {
    let budget = common.budget();
    let progress = Progress::new(budget, film.size(), common.quiet);
    let mut done = 0;
    while budget.goes_on(done, start.elapsed()) {
        technique.pass(done, film);
        done += 1;
        progress.update(done, start.elapsed());
    }
    progress.finish();
}

/// Flags that a scene cannot set: they are needed before it is read, or say where files go.
const NOT_PRESETS: [&str; 13] = [
    "size",
    "threads",
    "define",
    "origin",
    "target",
    "up",
    "fov",
    "output",
    "stats",
    "quiet",
    "time",
    "export-mitsuba",
    "help",
];

/// The command line with the scene's presets `gi.PROGRAM.FLAG` in front, so that what was typed wins.
fn with_presets<P: Program>(
    arguments: &[String],
    program: &str,
    timed: bool,
    loaded: &Loaded,
) -> Result<Vec<String>, Failure> {
    let prefix = format!("gi.{program}.");
    let presets = loaded
        .presets
        .iter()
        .filter_map(|(name, value)| Some((name, name.strip_prefix(&prefix)?, value)));
    let mut all = arguments[..1].to_vec();
    for (name, flag, value) in presets {
        let flag = flag.replace('_', "-");
        if NOT_PRESETS.contains(&flag.as_str()) {
            return Err(Failure::Input(format!(
                "error: the scene's preset {name}: a scene cannot set --{flag}"
            )));
        }
        let argument = format!("--{flag}={value}");
        // Alone it must be understood, so that the message can name the preset.
        let alone = [arguments[0].clone(), argument.clone(), "scene.xml".to_string()];
        if let Err(problem) = P::command().try_get_matches_from(alone) {
            let cause = problem.to_string();
            let cause =
                cause.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string();
            return Err(Failure::Input(format!(
                "error: the scene's preset {name}={value}: {cause}"
            )));
        }
        // A typed --time is another budget than the scene's number of passes.
        if !(timed && matches!(flag.as_str(), "spp" | "passes")) {
            all.push(argument);
        }
    }
    all.extend_from_slice(&arguments[1..]);
    Ok(all)
}

fn say_warnings(common: &Common, warnings: &[String]) {
    if !common.quiet {
        warnings.iter().for_each(|w| eprintln!("warning: {w}"));
    }
}

fn say_scene(common: &Common, scene: &Scene, [w, h]: [usize; 2]) {
    if !common.quiet {
        let primitives: usize = scene.shapes().iter().map(|s| s.geometry.primitive_count()).sum();
        let lights = scene.lights().all().len();
        eprintln!(
            "{}: {} shapes, {primitives} primitives, {lights} lights; {w} x {h} pixels",
            common.scene.display(),
            scene.shapes().len()
        );
        if scene.lights().all().is_empty() {
            eprintln!("warning: nothing shines in this scene; the picture will be black");
        }
    }
}

/// Write the picture and the statistics.
fn save(record: &Record, film: &Film, output: &Output) -> Result<(), Failure> {
    let mut layers = film.layers();
    layers.metadata = metadata(record);
    output.save(&layers)?;
    let radiance = film.radiance();
    let mean = radiance.iter().fold([0f64; 3], |sum, c| {
        let c = c.to_array();
        std::array::from_fn(|k| sum[k] + f64::from(c[k]) / radiance.len() as f64)
    });
    if let Some(path) = &record.common.stats {
        save_json(path, &statistics(record, mean))?;
    }
    if !record.common.quiet {
        let [load, build, prepare, render] =
            record.seconds.map(|s| format!("{:.2?}", Duration::from_secs_f64(s)));
        eprintln!(
            "{}: {} passes; scene read in {load}, tree built in {build}, prepared in {prepare}, rendered in {render}",
            output.path().display(),
            record.passes
        );
    }
    Ok(())
}

/// What an EXR says about how it came to be.
fn metadata(record: &Record) -> Vec<(String, String)> {
    let command = record.arguments.join(" ");
    [
        ("gi.program", record.program.to_string()),
        ("gi.command", command),
        ("gi.passes", record.passes.to_string()),
        ("gi.seed", record.common.seed.to_string()),
        ("gi.seconds", format!("{:.3}", record.seconds[2] + record.seconds[3])),
        ("gi.scene", record.common.scene.display().to_string()),
        ("gi.scene_hash", format!("{:016x}", record.scene_hash)),
        ("gi.reach", record.reach.clone()),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec()
}

/// The statistics file.
fn statistics(record: &Record, mean: [f64; 3]) -> Value {
    let [load, build, prepare, render] = record.seconds;
    let samples = record.size[0] as f64 * record.size[1] as f64 * f64::from(record.passes);
    let technique: Map<String, Value> =
        record.technique.iter().map(|(k, v)| (k.clone(), json!(v))).collect();
    json!({
        "program": record.program,
        "command": record.arguments,
        "scene": record.common.scene.display().to_string(),
        "scene_hash": format!("{:016x}", record.scene_hash),
        "size": record.size,
        "passes": record.passes,
        "seed": record.common.seed,
        "threads": rayon::current_num_threads(),
        "seconds": { "load": load, "build": build, "prepare": prepare, "render": render },
        "samples_per_second": samples / (prepare + render),
        "mean_radiance": mean,
        "reach": record.reach,
        "technique": technique,
        "warnings": record.warnings,
    })
}
