//! `--inspect`: what was read, what was approximated, what looks wrong, and which program suits the scene. Nothing is
//! rendered.

mod advice;
mod counts;
mod solid;
mod suspicious;

use gi_core::camera::{CameraSpec, Projection};
use gi_core::film::Film;
use gi_core::math::Bounds;
use gi_core::scene::Scene;
use gi_core::walk::focused;
use gi_scene::Loaded;
use glam::{Vec3, Vec3A};

use crate::run::{check_film, input_error, load};
use crate::say::print;
use crate::{Common, Failure};
use advice::Facts;
use counts::Counts;

/// Read the scene and print what is known about it.
pub(crate) fn inspect(common: &Common) -> Result<(), Failure> {
    let loaded = load(common)?;
    let Loaded { mut parts, mut camera, filter, warnings, files, memory, .. } = loaded;
    camera.to_world.translation += Vec3A::from(parts.recentre());
    check_film(camera.size)?;
    let (counts, build) = (Counts::of(&parts), parts.build_bytes());
    let suspicious = suspicious::find(&parts, camera.to_world.translation.into());
    let scene =
        Scene::new(parts).map_err(|e| input_error(format!("{}: {e}", common.scene.display())))?;
    let facts = Facts {
        lights: scene.lights().all().len(),
        media: if scene.has_media() { scene.media().len() } else { 0 },
        focused: focused(&scene, common.seed),
        view: advice::survey(&scene, &camera, common.seed),
    };
    let megabytes = |bytes: u64| format!("{} MB", bytes.div_ceil(1_000_000));
    let mut report = Report::default();
    report.title(format!("{}: {} files", common.scene.display(), files.len()));
    report.line("shapes", counts.shapes());
    report.line("materials", counts.materials());
    report.line("lights", counts.lights(facts.lights));
    report.line("media", scene.media().len().to_string());
    report.line("extent", extent(scene.bounds(), scene.origin()));
    report.line("camera", described(&camera));
    report.line(
        "memory",
        format!(
            "{} for meshes, pictures and text, {} for the tree (about {} while it is built), {} for the film",
            megabytes(memory),
            megabytes(scene.tree().memory_bytes() as u64),
            megabytes(build),
            megabytes(Film::memory(camera.size, filter))
        ),
    );
    report.list("Approximated or ignored", &warnings);
    report.list("Suspicious", &suspicious);
    let advice = advice::choose(&facts);
    report.title("Suggestion");
    report.text += &format!("  {}: {}\n", advice.program, advice.reason);
    print(report.text);
    Ok(())
}

/// The text that is printed.
#[derive(Default)]
struct Report {
    text: String,
}

impl Report {
    fn title(&mut self, title: impl AsRef<str>) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.text += &format!("{}\n", title.as_ref());
    }

    fn line(&mut self, name: &str, value: String) {
        self.text += &format!("  {name:<10} {value}\n");
    }

    fn list(&mut self, title: &str, entries: &[String]) {
        self.title(title);
        if entries.is_empty() {
            self.text += "  nothing\n";
        }
        entries.iter().for_each(|entry| self.text += &format!("  - {entry}\n"));
    }
}

/// A point as text, with four significant digits.
fn point(p: Vec3) -> String {
    format!("({}, {}, {})", short(p.x), short(p.y), short(p.z))
}

/// A number with four significant digits.
fn short(x: f32) -> String {
    let digits = if x == 0.0 { 0 } else { 3 - x.abs().log10().floor() as i32 };
    let text = format!("{x:.*}", digits.clamp(0, 9) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn extent(bounds: Bounds, origin: Vec3) -> String {
    if bounds.is_empty() {
        return "empty".into();
    }
    let size = bounds.extent();
    let (from, to) = (point(bounds.min + origin), point(bounds.max + origin));
    format!("{} x {} x {}, from {from} to {to}", short(size.x), short(size.y), short(size.z))
}

fn described(camera: &CameraSpec) -> String {
    let [w, h] = camera.size;
    match camera.projection {
        Projection::Orthographic => format!("orthographic, {w} x {h} pixels"),
        Projection::Perspective { fov_x, aperture_radius, .. } => {
            let lens = if aperture_radius > 0.0 { ", with a lens" } else { "" };
            format!(
                "perspective, {} degrees wide, {w} x {h} pixels{lens}",
                short(fov_x.to_degrees())
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_significant_digits() {
        let all = [0.0, 1.0, -12.3456, 0.001_234_56, 98_765.4].map(short);
        assert_eq!(all, ["0", "1", "-12.35", "0.001235", "98765"]);
    }
}
