//! A run from command line to picture.

use std::path::Path;
use std::time::{Duration, Instant};

use clap::ArgMatches;
use gi_core::camera::Camera;
use gi_core::eye::{PathLimits, SourceRays};
use gi_core::film::Film;
use gi_core::filter::Filter;
use gi_core::image_io::Layers;
use gi_core::options::Parameters;
use gi_core::scene::{Scene, SceneParts};
use gi_core::technique::{Setting, Technique};
use gi_scene::{ExportError, Loaded};
use glam::Vec3A;

use crate::checkpoint::Identity;
use crate::finish::Finished;
use crate::identity::of_run;
use crate::inspect::inspect;
use crate::merge::merge;
use crate::passes::{Making, check_checkpoints};
use crate::paths::{Files, check_export};
use crate::presets::with_presets;
use crate::preview::Preview;
use crate::progress::{Part, Progress, span};
use crate::record::{About, SoFar};
use crate::save::Output;
use crate::say::say;
use crate::serve::Stage;
use crate::stop::{self, Phase, Signal};
use crate::views::Views;
use crate::{Args, Common, Failure, Program, parse, sensors, warnings};

/// Run a program from its command line. Returns the signal that stopped it, if one did.
pub(crate) fn run<P: Program>(arguments: &[String]) -> Result<Option<Signal>, Failure> {
    let command = P::command();
    let program = command.get_name();
    // Once for the scene's name and the -D; again with the presets of the scene in front.
    let (first, matches) = parse::<P>(arguments);
    stop::watch();
    gi_core::check_instruction_set().map_err(input_error)?;
    let Args { common, params } = first.args();
    if let Some(threads) = common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| Failure::Other(format!("cannot start {threads} threads: {e}")))?;
    }
    if common.inspect {
        return inspect(common).map(|()| None);
    }
    if let Some(out) = &common.export_mitsuba {
        return export(common, out).map(|()| None);
    }
    let output = Output::new(common.output(program), common.points.as_deref())?;
    if output.sensors().is_some() {
        sensors::check_flags(&command, &matches)?;
    }
    Files::of(common, &output, (&command, &matches), &params.outputs()).check()?;
    let name = output.path().display().to_string();
    let mut views = Views::open(common, program, name)?;
    let ended = read_and_render::<P>(arguments, common, &output, &mut views);
    stop::enter(Phase::Farewell);
    views.end(&ended);
    ended
}

/// Read the scene and render it. `first` is the command line without the presets of the scene.
fn read_and_render<P: Program>(
    arguments: &[String],
    first: &Common,
    output: &Output,
    views: &mut Views,
) -> Result<Option<Signal>, Failure> {
    let command = P::command();
    let program = command.get_name();
    let date = crate::identity::date();
    let clock = Instant::now();
    let mut loaded = load(first)?;
    if let Some(sensors) = output.sensors() {
        (loaded.camera.size, loaded.filter) = (sensors.film_size(), Filter::Box);
    }
    let load_time = clock.elapsed();
    let with_presets = with_presets::<P>(arguments, program, first.has_other_budget(), &loaded)?;
    let (all, matches) = parse::<P>(&with_presets);
    let Args { common, params } = all.args();
    params.check().map_err(input_error)?;
    check_source_rays(common, params)?;
    let mut files = Files::of(common, output, (&command, &matches), &params.outputs());
    files.read_by_scene(&loaded.files);
    files.check()?;
    let about = About {
        program,
        arguments,
        common,
        size: loaded.camera.size,
        scene_hash: loaded.hash,
        warnings: Vec::new(),
        date,
        load: load_time,
        build: Duration::ZERO,
        prepare: Duration::ZERO,
    };
    render::<P>(about, (params, &matches), loaded, output, views)
}

/// Render a scene that was read.
fn render<P: Program>(
    mut about: About,
    (params, matches): (&P::Params, &ArgMatches),
    loaded: Loaded,
    output: &Output,
    views: &mut Views,
) -> Result<Option<Signal>, Failure> {
    let common = about.common;
    let Loaded { mut parts, mut camera, filter, world, .. } = loaded;
    about.warn(loaded.warnings);
    let depth = loaded.integrator_max_depth;
    about.warn(warnings::of_depth(params.max_depth(), about.arguments, depth));
    let shift = parts.recentre();
    camera.to_world.translation += Vec3A::from(shift);
    check_film(camera.size)?;
    let scene = build(&mut about, params, parts)?;
    let camera = match output.sensors() {
        Some(sensors) => Camera::of_sensors(sensors.in_scene(shift), sensors.samples()),
        None => Camera::new(&camera),
    };
    views.set_size(camera.size());
    let setting = Setting {
        scene: &scene,
        world,
        camera: &camera,
        seed: common.seed,
        show: common.component,
        surface_layers: common.surface_layers,
        source_rays: common.source_rays,
    };
    let limits = PathLimits { max_depth: params.max_depth(), ..PathLimits::default() };
    let sources = SourceRays::new(&setting, limits, params.simulates_media());
    let of_sources = if sources.is_some() { SourceRays::memory(camera.size()) } else { 0 };
    let memory = Film::memory(camera.size(), filter) + of_sources;
    warnings::say_scene(common, &scene, memory, camera.size());
    let mut film = Film::new(camera.size(), filter, common.component);
    let start = Instant::now();
    let mut identity = of_run::<P>(common, matches, (world, &camera, filter));
    check_checkpoints(common, &identity)?;
    let mut technique = prepare::<P>(&mut about, setting, params, views)?;
    if common.checkpoint.is_some() || !common.merge.is_empty() {
        identity
            .push(("set of records or photons".into(), format!("{:016x}", technique.prepared())));
    }
    let passes = make_passes(
        &about,
        (&identity, start),
        (&mut technique, sources.as_ref()),
        &mut film,
        (output, views),
    )?;
    let elapsed = start.elapsed();
    stop::enter(Phase::Saving);
    film.end_passes();
    views.enter(Stage::Saving);
    let stopped = stop::requested();
    if let (Some(signal), 0) = (stopped, film.passes()) {
        say(format!(
            "stopped by {} in the first pass, before there was a whole picture",
            signal.name()
        ));
        return Ok(stopped);
    }
    let earlier = passes.as_ref().map_or(film.passes(), Making::earlier);
    let so_far = SoFar { earlier, ..about.so_far(&technique, &film, elapsed, stopped) };
    views.finish(&film, &so_far);
    let finished = Finished { about: &about, so_far: &so_far, film: &film, output };
    finished.save(&technique, &params.outputs(), passes)?;
    // A signal that came while files were written.
    Ok(stop::requested())
}

/// Build the scene and its tree, and warn of what the technique does not find in it.
fn build(about: &mut About, params: &impl Parameters, parts: SceneParts) -> Result<Scene, Failure> {
    let (common, clock) = (about.common, Instant::now());
    let scene =
        Scene::new(parts).map_err(|e| input_error(format!("{}: {e}", common.scene.display())))?;
    about.build = clock.elapsed();
    if scene.has_varying_media() && !params.simulates_varying_media() {
        return Err(input_error(format!(
            "{}: the density of a medium varies, which only `pathtrace --mode volpath` and `pathtrace --mode light` \
             simulate: use one of them, or make the medium `homogeneous`",
            common.scene.display()
        )));
    }
    if let Some(points) = &common.points {
        sensors::check_scene(&scene, points)?;
    }
    about.warn(warnings::of_media(&scene, params.simulates_media()));
    if !params.finds_focused_light(scene.has_media()) {
        about.warn(warnings::of_focused_light(&scene, common.seed));
    }
    Ok(scene)
}

/// Refuse rays for light sources if the technique finds those in another way.
fn check_source_rays(common: &Common, params: &impl Parameters) -> Result<(), Failure> {
    if common.source_rays == 0 || params.can_leave_out_sources() {
        return Ok(());
    }
    let text = "--source-rays does not work with `pathtrace --mode light` and `--show strategies`, which find the light sources in view \
                themselves; use --source-rays 0";
    Err(input_error(text.into()))
}

/// Prepare the technique.
fn prepare<'t, P: Program>(
    about: &mut About,
    setting: Setting<'t>,
    params: &P::Params,
    views: &Views,
) -> Result<P::Technique<'t>, Failure> {
    let clock = Instant::now();
    views.enter(Stage::Preparing);
    let progress = Progress::show(Part::Preparation, about.common.quiet);
    let technique = P::Technique::prepare(setting, params).map_err(input_error)?;
    drop(progress);
    about.prepare = clock.elapsed();
    stop::enter(Phase::Passes);
    if !about.common.quiet {
        say(format!("prepared in {}", span(about.prepare)));
    }
    Ok(technique)
}

/// Make the passes, or add up those of checkpoints. Returns what writes the last checkpoint.
fn make_passes<'a, 't, T: Technique<'t>>(
    about: &About<'a>,
    (identity, start): (&'a Identity, Instant),
    (technique, sources): (&mut T, Option<&'a SourceRays<'a>>),
    film: &mut Film,
    (output, views): (&Output, &mut Views),
) -> Result<Option<Making<'a>>, Failure> {
    let common = about.common;
    if !common.merge.is_empty() {
        let mut spare = Film::new(film.size(), film.filter().filter(), common.component);
        let last = merge(technique, common, [film, &mut spare], identity)?;
        technique.recall(last, film);
        return Ok(None);
    }
    let mut passes = Making::begin((technique, sources), common, film, identity, start)?;
    let mut previews = Vec::new();
    if let Some(every) = common.preview() {
        let save = |layers, so_far: &SoFar| {
            output.save(&Layers { metadata: about.metadata(so_far), ..layers }, so_far.passes)
        };
        previews.push(Preview::new("preview", every, film.size(), save));
    }
    let page = views.page().cloned();
    previews.extend(views.previews(film.size()));
    passes.run(technique, film, (about, previews), page.as_ref());
    Ok(Some(passes))
}

/// A failure whose cause is what the user gave.
pub(crate) fn input_error(message: String) -> Failure {
    Failure::Input(format!("error: {message}"))
}

/// Read the scene.
pub(crate) fn load(common: &Common) -> Result<Loaded, Failure> {
    gi_scene::load(&common.scene, &common.scene_options())
        .map_err(|problems| Failure::Input(problems.to_string()))
}

/// Write the scene as it was understood.
fn export(common: &Common, out: &Path) -> Result<(), Failure> {
    check_export(&common.scene, out)?;
    match gi_scene::export_mitsuba(&common.scene, &common.scene_options(), out) {
        Ok(warnings) => {
            warnings::say_all(common, &warnings);
            Ok(())
        }
        Err(ExportError::Scene(problems)) => Err(Failure::Input(problems.to_string())),
        Err(ExportError::Overwrite(why)) => Err(input_error(why)),
        Err(error) => Err(Failure::Other(format!("--export-mitsuba: {error}"))),
    }
}

/// Largest picture that is made, in pixels.
const MAX_PIXELS: usize = 1 << 26;

/// Refuse a film that is too large.
pub(crate) fn check_film([w, h]: [usize; 2]) -> Result<(), Failure> {
    if w.saturating_mul(h) <= MAX_PIXELS {
        return Ok(());
    }
    let advice = format!("{MAX_PIXELS} pixels are the most; give a smaller --size");
    Err(Failure::Input(format!("error: a film of {w} x {h} pixels is too large: {advice}")))
}

impl About<'_> {
    /// Print warnings, and keep them for the statistics.
    fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        let warnings: Vec<String> = warnings.into_iter().collect();
        warnings::say_all(self.common, &warnings);
        self.warnings.extend(warnings);
    }
}
