//! What every program promises about its runs: no run is lost, no input is overwritten. Real programs, run as users run them.
#![cfg(unix)]

/// Full disks, closed pipes, folders that vanish.
mod faults;
/// Help and versions.
mod help;
/// Inputs that are named as outputs.
mod inputs;
/// Previews.
mod previews;
/// The programs, and runs that are under way.
mod running;
/// Signals.
mod signals;
