//! Every sampling routine against its density, by chi^2: warps, BSDFs, lights.

mod bsdfs;
mod grid;
mod lights;
mod principled;
mod warps;
