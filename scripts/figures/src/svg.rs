//! Helpers for drawings that contain pictures.

use base64::Engine;

/// Bytes as a data URI for a page.
pub(crate) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// Text escaped for XML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The fonts of all drawings.
pub(crate) const FONT: &str = "sans-serif";
