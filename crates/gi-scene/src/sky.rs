//! Sun and sky.

use crate::build::Builder;
use crate::document::Node;

/// What a `sun`, `sky` or `sunsky` says, in world space.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SunSky {}

/// Add the lights of a `sun`, `sky` or `sunsky`.
pub(crate) fn add(_builder: &mut Builder<'_>, node: Node<'_>) {
    node.error("sun and sky are to come", "");
}
