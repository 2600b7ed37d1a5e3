//! Statistics for tests and comparisons: hypothesis tests, running moments, errors of pictures.
//! No dependencies.
#![forbid(unsafe_code)]

mod chi2;
pub mod flip;
mod means;
pub mod metrics;
mod running;
mod slope;
mod special;
mod split;

pub use chi2::{Chi2, chi2_test};
pub use means::{sidak, student_two_sided, welch_t_test, z_test};
pub use running::Running;
pub use slope::log_log_line;
pub use split::{Split, split};
