//! Material parameters with their own ranges.

use gi_core::texture::Texture;

use crate::builder::Builder;
use crate::document::{Meaning, Node};
use crate::textures::one_channel;

/// Largest roughness.
const MAX_ALPHA: f32 = 10.0;
/// Largest exponent of Phong's lobe: the lobe is a hundredth of a degree wide, which looks like a mirror.
const MAX_EXPONENT: f32 = 1e6;

impl Builder<'_> {
    /// A roughness: 0 is smooth, 1 is very rough; some files go slightly beyond 1.
    pub(super) fn alpha(
        &mut self,
        node: Node<'_>,
        name: &'static str,
        default: Texture,
    ) -> Texture {
        if !node.has(name) && node.child(name).is_none() {
            return default;
        }
        let alpha = one_channel(node, self.texture(node, name, default.clone(), Meaning::Factor));
        let [least, most] = self.origins.range(&alpha);
        if 0.0 <= least && most <= MAX_ALPHA {
            return alpha;
        }
        let value = if least < 0.0 { least } else { most };
        let message = format!("`{name}` is {value}");
        node.report.error(node.place_of(name), message, "expected 0 to 10");
        default
    }

    /// Phong's exponent.
    pub(super) fn exponent(&mut self, node: Node<'_>) -> Texture {
        let default = Texture::grey(30.0);
        let exponent = self.texture(node, "exponent", default.clone(), Meaning::Factor);
        let [least, most] = self.origins.range(&exponent);
        if least < 0.0 {
            let message = format!("`exponent` is {least}");
            node.report.error(node.place_of("exponent"), message, "expected 0 or more");
            return default;
        }
        match exponent {
            Texture::Constant(c) if most > MAX_EXPONENT => {
                let message = format!("`exponent` {most} is clamped to {MAX_EXPONENT}");
                node.report.warn(node.place_of("exponent"), message);
                Texture::Constant(c.map(|v| v.min(MAX_EXPONENT)))
            }
            texture => texture,
        }
    }
}
