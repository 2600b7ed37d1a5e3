//! Statistics that tests and comparisons stand on: tests of hypotheses, running moments, errors of pictures.
//! No dependencies.
#![forbid(unsafe_code)]

mod chi2;
pub mod flip;
mod means;
pub mod metrics;
mod running;
mod special;

pub use chi2::{Chi2, chi2_test};
pub use means::{sidak, welch_t_test, z_test};
pub use running::Running;
