//! What the user should know about a scene before it is rendered.

use gi_core::scene::Scene;
use gi_core::walk::{Focused, focused};
use gi_scene::AddedLight;

use crate::Common;
use crate::say::say;

/// A warning if the scene's integrator asks for another length of paths, unless the flag was typed.
pub(crate) fn of_depth(
    used: Option<u32>,
    arguments: &[String],
    scene: Option<i32>,
) -> Option<String> {
    let typed = arguments.iter().any(|a| a == "--max-depth" || a.starts_with("--max-depth="));
    let is_used = |depth: i32| u32::try_from(depth).ok() == used;
    let depth = scene.filter(|depth| *depth != -1 && !is_used(*depth) && !typed)?;
    Some(format!(
        "the integrator's `max_depth` {depth} is ignored: give `--max-depth {depth}` for it, `--max-depth -1` for all light"
    ))
}

/// Warnings about the scene's media. `known`: whether the program simulates them.
pub(crate) fn of_media(scene: &Scene, known: bool) -> Vec<String> {
    match (scene.has_media(), known) {
        (false, _) => Vec::new(),
        (true, true) => scene.media_warnings(),
        (true, false) => vec![
            "participating media are left out: their boundaries are drawn, and what is inside neither absorbs nor scatters \
             light (`pathtrace --mode volpath` simulates media)"
                .into(),
        ],
    }
}

/// Fractions of focused light below this are not worth a word.
const LITTLE: f32 = 0.01;

/// A warning about light that the program finds badly.
pub(crate) fn of_focused_light(scene: &Scene, seed: u32) -> Option<String> {
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

/// Print warnings.
pub(crate) fn say_all(common: &Common, warnings: &[String]) {
    if !common.quiet {
        warnings.iter().for_each(|w| say(format!("warning: {w}")));
    }
}

/// Print what a scene contains, and the memory of the film.
pub(crate) fn say_scene(common: &Common, scene: &Scene, film: u64, [w, h]: [usize; 2]) {
    if !common.quiet {
        let primitives: usize = scene.shapes().iter().map(|s| s.geometry.primitive_count()).sum();
        let lights = scene.lights().all().len();
        say(format!(
            "{}: {} shapes, {primitives} primitives, {lights} lights; film of {w} x {h} pixels in {} MB",
            common.scene.display(),
            scene.shapes().len(),
            film.div_ceil(1_000_000)
        ));
        if scene.lights().all().is_empty() {
            let advice = AddedLight::NAMES.map(|name| format!("--light {name}")).join(" or ");
            say(format!(
                "warning: nothing shines in this scene; the picture will be black. {advice} adds a light"
            ));
        }
    }
}
