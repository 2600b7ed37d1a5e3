//! Which program on which machine: what a picture says about where it comes from.

use std::time::SystemTime;

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
