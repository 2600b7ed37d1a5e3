//! A run whose errors are not measured yet.

use crate::{Finished, Picture, Stats};

/// Pictures of a run, not yet measured.
pub(crate) struct Subject {
    pub(crate) label: String,
    pub(crate) finished: Option<Finished>,
    pub(crate) picture: Picture,
    /// Of all seeds, the first among them, if there are several.
    pub(crate) seeds: Vec<Picture>,
    /// Of smaller budgets.
    pub(crate) rungs: Vec<(Stats, Picture)>,
}
