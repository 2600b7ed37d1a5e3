//! The scene's integrator. Our programs replace it; a warning names the settings that would change the picture.

use crate::diagnostics::Report;
use crate::document::{Class, Document, Node, Value};

/// Integrators that compute something other than all light, and what computes it here.
const PARTIAL: [(&str, &str); 6] = [
    ("direct", "`--max-depth 2` shows direct light only"),
    ("ao", "ambient occlusion is not supported"),
    ("aov", "the layers of the EXR hold the other properties of a pixel"),
    ("field", "the layers of the EXR hold the other properties of a pixel"),
    ("depth", "the layer `Z` of the EXR holds the depth"),
    ("stokes", "polarisation is not supported"),
];
/// Options that change the picture.
const SWITCHES: [(&str, &str); 1] = [("strict_normals", "shading normals do not stop light")];

/// Read the longest path of the scene's integrator; -1 means unlimited.
pub(crate) fn read(doc: &Document, report: &Report) -> Option<i32> {
    let integrators =
        doc.nodes(report).filter(|n| n.class() == Class::Ignored && n.object().tag == "integrator");
    let mut depth = None;
    for (k, node) in integrators.enumerate() {
        depth = depth.or(max_depth(node));
        if k == 0 {
            note_partial(node);
        }
        for (name, instead) in SWITCHES {
            if let Some((Value::Bool(true), span)) = node.peek(name) {
                report.warn(span, format!("the integrator's `{name}` is ignored: {instead}"));
            }
        }
    }
    depth
}

/// Whether the scene's integrator hides light sources from the camera.
pub(crate) fn hides_emitters(doc: &Document, report: &Report, has_media: bool) -> bool {
    let mut integrators =
        doc.nodes(report).filter(|n| n.class() == Class::Ignored && n.object().tag == "integrator");
    let asked = integrators.find_map(|node| match node.peek("hide_emitters") {
        Some((Value::Bool(true), span)) => Some(span),
        _ => None,
    });
    if let (Some(span), true) = (asked, has_media) {
        let message = "`hide_emitters` is ignored in a scene with media: lamps are visible";
        report.warn(span, message);
    }
    asked.is_some() && !has_media
}

fn max_depth(node: Node<'_>) -> Option<i32> {
    match node.peek("max_depth")?.0 {
        Value::Integer(depth) => i32::try_from(*depth).ok(),
        _ => None,
    }
}

fn note_partial(node: Node<'_>) {
    if let Some((name, here)) = PARTIAL.iter().find(|(name, _)| *name == node.plugin()) {
        node.warn(format!("the integrator `{name}` is ignored, all light is shown: {here}"));
    }
}
