//! What the user should know about a scene before it is rendered.

use gi_core::scene::Scene;
use gi_core::walk::{Focused, focused};

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
            "participating media are left out: their boundaries are drawn, what is inside neither absorbs nor scatters \
             (`pathtrace --mode volpath` knows media)"
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
