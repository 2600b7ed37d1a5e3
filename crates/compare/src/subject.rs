//! A run whose errors have not been measured yet.

use crate::{Finished, Picture, Stats};

/// The pictures of such a run.
pub(crate) struct Subject {
    pub(crate) label: String,
    pub(crate) finished: Option<Finished>,
    pub(crate) picture: Picture,
    /// Pictures of all seeds, including the first, if there are several seeds.
    pub(crate) seeds: Vec<Picture>,
    /// Statistics and pictures of smaller budgets.
    pub(crate) rungs: Vec<(Stats, Picture)>,
}
