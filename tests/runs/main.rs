//! What every program promises about its runs: no run is lost, no input is overwritten. Real programs, run as users run them.
#![cfg(unix)]

/// Full disks, closed pipes, folders that vanish.
mod faults;
/// Help and versions.
mod help;
/// Inputs that are named as outputs.
mod inputs;
/// The live page in a browser.
mod page;
/// Previews.
mod previews;
/// The programs, and runs that are under way.
mod running;
/// The live page's server.
mod serve;
/// Runs whose live page is served, and a client of it.
mod served;
/// Signals.
mod signals;
