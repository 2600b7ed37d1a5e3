//! Compares every sampling routine with its density, by chi^2 tests: warps, BSDFs, lights.

mod bsdfs;
mod grid;
mod lights;
mod principled;
mod warps;
