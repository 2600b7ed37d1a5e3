//! Checks what every program guarantees for its runs: no run is lost, and no input is overwritten. Starts the real
//! programs as a user would.
#![cfg(unix)]

/// Full disks, closed pipes, folders that disappear.
mod faults;
/// Help and versions.
mod help;
/// Inputs that are also named as outputs.
mod inputs;
/// Kernels for each instruction set.
mod instruction_sets;
/// The live page in a browser.
mod page;
/// Irradiance at points.
mod points;
/// Previews.
mod previews;
/// The Python package.
mod python;
/// The commands of the README and of the pages.
mod readme;
/// The programs, and helpers for running programs.
mod running;
/// The live page's server.
mod serve;
/// Runs whose live page is served, and a client of it.
mod served;
/// Runs that are divided into ranges of passes.
mod shards;
/// Signals.
mod signals;
