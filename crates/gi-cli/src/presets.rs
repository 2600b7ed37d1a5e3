//! What a scene says about a program's flags.

use gi_scene::Loaded;

use crate::{Failure, Program, command};

/// Flags that a scene cannot set: they are needed before it is read, or say where files go.
const NOT_PRESETS: [&str; 24] = [
    "size",
    "threads",
    "define",
    "origin",
    "target",
    "up",
    "fov",
    "max-memory",
    "output",
    "stats",
    "quiet",
    "time",
    "export-mitsuba",
    "help",
    "checkpoint",
    "resume",
    "first-pass",
    "merge",
    "checkpoint-interval",
    "preview",
    "display-server",
    "serve",
    "light",
    "sensor",
];

/// Whether a flag is one that a scene cannot set: files of techniques are named `--x-out` and `--x-in`.
fn is_no_preset(flag: &str) -> bool {
    NOT_PRESETS.contains(&flag) || flag.ends_with("-out") || flag.ends_with("-in")
}

/// The command line with the scene's presets `gi.PROGRAM.FLAG` in front, so that what was typed wins.
pub(crate) fn with_presets<P: Program>(
    arguments: &[String],
    program: &str,
    has_other_budget: bool,
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
        if is_no_preset(&flag) {
            return Err(Failure::Input(format!(
                "error: the scene's preset {name}: a scene cannot set --{flag}"
            )));
        }
        let argument = format!("--{flag}={value}");
        // Alone it must be understood, so that the message can name the preset.
        let alone = [arguments[0].clone(), argument.clone(), "scene.xml".to_string()];
        if let Err(problem) = command::<P>().try_get_matches_from(alone) {
            let cause = problem.to_string();
            let cause =
                cause.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string();
            return Err(Failure::Input(format!(
                "error: the scene's preset {name}={value}: {cause}"
            )));
        }
        // A typed --time or --merge is another budget than the scene's number of passes.
        if !(has_other_budget && matches!(flag.as_str(), "spp" | "passes")) {
            all.push(argument);
        }
    }
    all.extend_from_slice(&arguments[1..]);
    Ok(all)
}
