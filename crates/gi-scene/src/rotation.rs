//! Transforms of emitters at infinity.

use glam::{Affine3A, Vec3};

use crate::document::Node;

/// The linear part of `to_world`: translation has no effect on a light at infinity.
pub(crate) fn rotation(node: Node<'_>) -> Affine3A {
    let mut m = node.transform("to_world");
    m.translation = Vec3::ZERO.into();
    if !m.inverse().is_finite() {
        node.report.error(node.span_of("to_world"), "`to_world` cannot be inverted", "");
        return Affine3A::IDENTITY;
    }
    m
}
