//! The order in which photons are given to a tree.

/// The order in which photons are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Any.
    Any,
    /// That of [`crate::map::PhotonMap::photons`] of a map of the same layout: the tree is then the same, bit for bit.
    Tree,
}
