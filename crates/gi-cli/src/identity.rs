//! Which program on which machine: what a picture says about where it comes from, and what runs must have in common to be
//! continued and added up.

use std::time::SystemTime;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, ValueEnum};
use gi_core::bytes::checksum;
use gi_core::camera::Camera;
use gi_core::filter::Filter;

use crate::checkpoint::Identity;
use crate::{Common, Program, help};

/// The version of all programs.
pub(crate) const NUMBER: &str = env!("CARGO_PKG_VERSION");

/// The commit that the program was built from; empty if that is unknown.
pub(crate) const COMMIT: &str = env!("GILAB_COMMIT");

/// What `--version` prints after the program's name.
pub const VERSION: &str = env!("GILAB_VERSION");

/// The time now, as in 2026-01-31T12:00:00Z.
pub(crate) fn date() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}

/// The processor's name, or its architecture where the system does not say.
pub(crate) fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_string(), |(_, name)| name.trim().to_string())
}

/// What a checkpoint must have in common with a run: the program, the scene, the picture, and the options of the technique that passes
/// may depend on. Some matter only in one mode; they are compared in all.
pub(crate) fn of_run<P: Program>(
    common: &Common,
    matches: &ArgMatches,
    (world, camera, filter): (u64, &Camera, Filter),
) -> Identity {
    let name = |value: Option<clap::builder::PossibleValue>| {
        value.map_or_else(String::new, |v| v.get_name().to_string())
    };
    let [w, h] = camera.size();
    let mut all = vec![
        ("program".to_string(), P::command().get_name().to_string()),
        ("version of the program".into(), NUMBER.into()),
        ("scene".into(), format!("{world:016x}")),
        ("picture size".into(), format!("{w} x {h}")),
        ("camera".into(), words(&camera.numbers())),
        ("set of points".into(), points(camera)),
        ("filter".into(), words(&filter.numbers())),
        ("seed".into(), common.seed.to_string()),
        ("component".into(), name(common.component.to_possible_value())),
        ("--source-rays".into(), common.source_rays.to_string()),
        ("choice of surface layers".into(), name(common.surface_layers.to_possible_value())),
    ];
    let options = P::Params::augment_args(Command::new("options"));
    for option in options.get_arguments() {
        let id = option.get_id().as_str();
        // What is read from a file counts, not the file's name.
        let counts = !help::is_for_figures(option)
            && !id.ends_with("_in")
            && !id.ends_with("_out")
            && !WITHOUT_EFFECT.contains(&id);
        if let (true, Some(long)) = (counts, option.get_long()) {
            all.push((format!("--{long}"), value_of(option, matches)));
        }
    }
    all
}

/// Options that change no pass, in addition to those for files and figures: which pixel is drawn, how photons are stored, and when
/// the run ends.
const WITHOUT_EFFECT: [&str; 3] = ["pixel", "layout", "stop_at_error"];

/// What was given for an option, or its default, in words.
fn value_of(option: &Arg, matches: &ArgMatches) -> String {
    let id = option.get_id().as_str();
    match option.get_action() {
        // A flag that turns something off is false when it is given.
        ArgAction::SetFalse if matches.get_flag(id) => return "not given".into(),
        ArgAction::SetFalse => return "given".into(),
        ArgAction::SetTrue if matches.get_flag(id) => return "given".into(),
        ArgAction::SetTrue => return "not given".into(),
        _ => {}
    }
    let values = matches.try_get_raw(id).ok().flatten().into_iter().flatten();
    let values: Vec<String> = values.map(|v| plain(&v.to_string_lossy())).collect();
    if values.is_empty() { "not given".into() } else { values.join(",") }
}

/// A value, without what does not change it: `0.50` is 0.5.
fn plain(value: &str) -> String {
    value.parse::<f64>().map_or_else(|_| value.to_string(), |number| number.to_string())
}

/// The sensors in place of a camera, as a checksum.
fn points(camera: &Camera) -> String {
    let Some(sensors) = camera.sensors() else { return "none".into() };
    let numbers = sensors.iter().flat_map(|s| s.p.to_array().into_iter().chain(s.n.to_array()));
    format!("{:016x}", checksum(&numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()))
}

/// Numbers in words; the same words are the same bits.
fn words(numbers: &[f32]) -> String {
    let words: Vec<String> = numbers.iter().map(f32::to_string).collect();
    words.join(" ")
}
