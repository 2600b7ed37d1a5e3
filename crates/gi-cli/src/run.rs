//! A run from command line to picture.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gi_core::camera::Camera;
use gi_core::film::Film;
use gi_core::image_io::Layers;
use gi_core::options::Parameters;
use gi_core::scene::Scene;
use gi_core::technique::{Picture, Setting, Technique};
use gi_core::walk::{Focused, focused};
use gi_scene::{ExportError, Loaded};
use glam::Vec3A;
use serde_json::{Map, Value, json};

use crate::passes::{identity, merge, passes};
use crate::presets::with_presets;
use crate::save::{Output, save_bytes};
use crate::{Args, Common, Failure, Program, parse};

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
    let common = &first.args().common;
    if let Some(threads) = common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| Failure::Other(format!("cannot start {threads} threads: {e}")))?;
    }
    if let Some(out) = &common.export_mitsuba {
        return export(common, out);
    }
    let clock = Instant::now();
    let loaded = load(common)?;
    let load_time = clock.elapsed();
    let all: P = parse(&with_presets::<P>(arguments, program, common.time.is_some(), &loaded)?);
    let Args { common, params } = all.args();
    params.check().map_err(input_error)?;
    let output = Output::new(common.output(program))?;
    let kept = common.stats.iter().chain(&common.checkpoint).cloned();
    let others: Vec<PathBuf> = kept.chain(params.outputs()).collect();
    output.check_apart(&others)?;
    let Loaded {
        mut parts,
        mut camera,
        filter,
        mut warnings,
        hash,
        world,
        integrator_max_depth,
        ..
    } = loaded;
    warnings.extend(depth_warning(params.max_depth(), arguments, integrator_max_depth));
    say_warnings(common, &warnings);
    camera.to_world.translation += Vec3A::from(parts.recentre());
    check_film(camera.size)?;
    let clock = Instant::now();
    let scene =
        Scene::new(parts).map_err(|e| input_error(format!("{}: {e}", common.scene.display())))?;
    let build_time = clock.elapsed();
    let mut about_light = media_warnings(&scene, params.simulates_media());
    if !params.finds_focused_light() {
        about_light.extend(focus_warning(&scene, common.seed));
    }
    say_warnings(common, &about_light);
    warnings.extend(about_light);
    let camera = Camera::new(&camera);
    say_scene(common, &scene, camera.size());
    let setting = Setting {
        scene: &scene,
        world,
        camera: &camera,
        seed: common.seed,
        show: common.component,
    };
    let mut film = Film::new(camera.size(), filter, common.component);

    let clock = Instant::now();
    let mut technique = P::Technique::prepare(setting, params).map_err(input_error)?;
    let prepare_time = clock.elapsed();
    let identity = identity::<P>(common, world, &camera, filter);
    if common.merge.is_empty() {
        passes(&mut technique, common, &mut film, &identity, clock)?;
    } else {
        let spare = Film::new(camera.size(), filter, common.component);
        merge(&mut technique, common, [&mut film, &mut { spare }], &identity)?;
    }
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
    save(&record, &film, &technique.pictures(&film), &output)?;
    for path in params.outputs() {
        save_bytes(&path, &technique.export(&path))?;
    }
    Ok(())
}

/// A failure whose cause is what the user gave.
fn input_error(message: String) -> Failure {
    Failure::Input(format!("error: {message}"))
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
        Err(error) => Err(Failure::Other(format!("--export-mitsuba: {error}"))),
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

fn say_warnings(common: &Common, warnings: &[String]) {
    if !common.quiet {
        warnings.iter().for_each(|w| eprintln!("warning: {w}"));
    }
}

/// A warning if the scene's integrator asks for another length of paths, unless the flag was typed.
fn depth_warning(used: Option<u32>, arguments: &[String], scene: Option<i32>) -> Option<String> {
    let typed = arguments.iter().any(|a| a == "--max-depth" || a.starts_with("--max-depth="));
    let is_used = |depth: i32| u32::try_from(depth).ok() == used;
    let depth = scene.filter(|depth| *depth != -1 && !is_used(*depth) && !typed)?;
    Some(format!(
        "the integrator's `max_depth` {depth} is ignored: give `--max-depth {depth}` for it, `--max-depth -1` for all light"
    ))
}

/// What the user should know about the scene's media.
fn media_warnings(scene: &Scene, known: bool) -> Vec<String> {
    match (scene.has_media(), known) {
        (false, _) => Vec::new(),
        (true, true) => scene.media_warnings(),
        (true, false) => vec![
            "participating media are left out: their boundaries are drawn, what is inside neither absorbs nor scatters \
             (`pathtrace --mode volpath` knows media)"
                .into(),
        ],
    }
}

/// Shares of focused light below this are not worth a word.
const LITTLE: f32 = 0.01;

/// What the user should know about light that the program finds badly.
fn focus_warning(scene: &Scene, seed: u32) -> Option<String> {
    let Focused { unreachable, rare } = focused(scene, seed);
    let (share, what) = match (unreachable, rare) {
        (u, _) if u >= LITTLE => (u, "from lights without extent: this program cannot find it"),
        (_, r) if r >= LITTLE => {
            (r, "from small lamps: this program finds it rarely, as bright specks")
        }
        _ => return None,
    };
    Some(format!(
        "{:.0} % of the light reaches surfaces over mirrors or glass {what} (`ppm` and `photonmap` find it)",
        100.0 * share
    ))
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
fn save(
    record: &Record,
    film: &Film,
    pictures: &[Picture],
    output: &Output,
) -> Result<(), Failure> {
    let mut layers = film.layers();
    pictures.iter().for_each(|p| add_layers(&mut layers, p));
    layers.metadata = metadata(record);
    output.save(&layers)?;
    for picture in pictures {
        output.save_view(picture, film.size())?;
    }
    let radiance = film.radiance();
    let mean = radiance.iter().fold([0f64; 3], |sum, c| {
        let c = c.to_array();
        std::array::from_fn(|k| sum[k] + f64::from(c[k]) / radiance.len() as f64)
    });
    if let Some(path) = &record.common.stats {
        save_bytes(path, format!("{:#}\n", statistics(record, mean)).as_bytes())?;
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

/// A technique's picture as layers: `Name.channel`.
fn add_layers(layers: &mut Layers, picture: &Picture) {
    let mut name: Vec<char> = picture.name.chars().collect();
    name[0] = name[0].to_ascii_uppercase();
    let name: String = name.into_iter().collect();
    let mut push = |channel: &str, values: Vec<f32>| {
        layers.channels.push((format!("{name}.{channel}"), values));
    };
    if picture.channels.is_empty() {
        for (k, channel) in ["R", "G", "B"].into_iter().enumerate() {
            push(channel, picture.view.iter().map(|c| c.to_array()[k]).collect());
        }
    }
    picture.channels.iter().for_each(|(channel, values)| push(channel, values.clone()));
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
