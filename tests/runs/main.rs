//! Checks what every program guarantees for its runs: no run is lost, and no input is overwritten. Starts the real
//! programs as a user would.
#![cfg(unix)]

/// Full disks, closed pipes, folders that disappear.
mod faults;
/// Help and versions.
mod help;
/// Inputs that are also named as outputs.
mod inputs;
/// Previews.
mod previews;
/// The programs, and helpers for running programs.
mod running;
/// Signals.
mod signals;
