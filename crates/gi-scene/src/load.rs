//! The entry point of this crate: loads a scene from a path and options.

use std::path::Path;

use gi_core::filter::Filter;
use gi_core::scene::SceneParts;

use crate::assets::Assets;
use crate::builder::Builder;
use crate::diagnostics::{Diagnostics, Report};
use crate::document::{self, Document};
use crate::options::{Loaded, Options};
use crate::{added_light, framing, integrator, obj_scene, pbrt, precision, sensor};

/// Load a scene: Mitsuba XML, pbrt, or a bare OBJ file with its materials.
///
/// # Errors
/// All errors of the scene.
pub fn load(path: &Path, options: &Options) -> Result<Loaded, Diagnostics> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").filter(|n| n.ends_with(".pbrt")).unwrap_or(&name);
    let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
    let report = Report::new(options.max_memory);
    let loaded = match extension {
        "obj" => obj_scene::load(path, options, &report),
        "xml" => document::parse(path, &options.defines, &report)
            .and_then(|doc| load_document(path, doc, options, &report)),
        "pbrt" => pbrt::parse(path, &options.defines, &report)
            .and_then(|doc| load_document(path, doc, options, &report)),
        _ => {
            let message = format!("`{}` is none of .xml, .pbrt and .obj", path.display());
            report.error_nowhere(message);
            None
        }
    };
    if loaded.is_none() && !report.has_errors() {
        report.error_nowhere(format!("`{}` contains no scene", path.display()));
    }
    let mut loaded = loaded;
    if let (Some(loaded), Some(light)) = (&mut loaded, options.light) {
        added_light::add(loaded, light, &report);
    }
    for warning in loaded.iter_mut().flat_map(|l| l.parts.enclose_media()) {
        report.warn_nowhere(warning);
    }
    if let Some(loaded) = &loaded {
        check_tree(&loaded.parts, &report);
    }
    report.reads(path);
    let files = report.files();
    let memory = report.budget.total();
    let warnings = report.finish()?;
    let loaded = loaded.expect("a scene without errors was built");
    Ok(Loaded { warnings, files, memory, ..loaded })
}

/// Refuse a scene if building its bounding volume hierarchy would take more memory than is left. The program builds it later.
fn check_tree(parts: &SceneParts, report: &Report) {
    let mut claim = report.budget.claim("the bounding volume hierarchy");
    if let Err(why) = claim.set(parts.build_bytes()) {
        let primitives = parts.primitive_count();
        report.error_nowhere(format!("no tree over {primitives} primitives can be built: {why}"));
    }
}

/// Refuse a scene in another XML format: its picture would be black, which misleads.
fn refuse_other_dialects(path: &Path, doc: &Document, parts: &SceneParts, report: &Report) {
    let no_shapes = parts.shapes.is_empty() && parts.groups.is_empty();
    let nothing = no_shapes && (parts.lights.is_empty() || doc.unknown_things);
    if !nothing || doc.unknown_tags.is_empty() || report.has_errors() {
        return;
    }
    let tags: Vec<String> = doc.unknown_tags.iter().map(|tag| format!("<{tag}>")).collect();
    report.error_nowhere(format!(
        "`{}` is not in Mitsuba's format: none of its shapes is understood, and Mitsuba has no {}",
        path.display(),
        tags.join(", ")
    ));
}

/// Build the scene that a document describes.
fn load_document(path: &Path, doc: Document, options: &Options, report: &Report) -> Option<Loaded> {
    let assets = Assets::load(&doc, report);
    let mut hash = doc.hash;
    hash.word(assets.hash.value());
    let mut world = doc.world_hash();
    world.word(assets.hash.value());
    let mut builder = Builder::new(report, assets);
    builder.scene(&doc);
    let has_media = !builder.parts.media.is_empty();
    builder.parts.hides_emitters = integrator::hides_emitters(&doc, report, has_media);
    if builder.parts.hides_emitters {
        world.bytes(b"hides emitters");
    }
    builder.parts.origin = doc.local.borrow().origin.as_vec3();
    precision::check(&builder.parts, builder.assets.rounding, report);
    refuse_other_dialects(path, &doc, &builder.parts, report);
    let integrator_max_depth = integrator::read(&doc, report);
    let seen = sensor::read(&doc, report, options, &builder.parts);
    let (camera, filter) = match seen {
        Some((camera, filter)) => {
            (framing::moved(camera, &options.camera, builder.parts.origin, report)?, filter)
        }
        None => {
            if !report.has_errors() {
                report.warn_nowhere(format!(
                    "{}: no sensor: a camera is chosen automatically",
                    path.display()
                ));
            }
            let size = options.size.unwrap_or([768, 576]);
            let camera = framing::frame(&builder.parts, &options.camera, size, report)?;
            (camera, Filter::Gaussian { stddev: 0.5 })
        }
    };
    doc.report_unused(report);
    let (parts, origins) = (builder.parts, builder.origins);
    let (presets, hash, world) = (doc.presets, hash.value(), world.value());
    let warnings = Vec::new();
    Some(Loaded {
        parts,
        camera,
        filter,
        presets,
        integrator_max_depth,
        warnings,
        hash,
        world,
        files: Vec::new(),
        memory: 0,
        origins,
    })
}
