//! BSDFs that contain other BSDFs: `twosided`, `blendbsdf`, and those with a single child; and filters.

use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use crate::builder::Builder;
use crate::document::{Class, Node};

impl Builder<'_> {
    /// A BSDF that transmits light already has two sides. A mask around an opaque BSDF swaps places with `twosided`,
    /// which must be innermost in Mitsuba 3.
    pub(super) fn twosided(&mut self, node: Node<'_>) -> Option<Material> {
        let children = node.children(Class::Bsdf);
        let sides: Vec<usize> = children.iter().map(|n| self.material(*n)).collect();
        let (front, back) = match sides.as_slice() {
            [both] => (*both, *both),
            [front, back] => (*front, *back),
            other => {
                node.wrong_count("bsdfs", other.len(), "expected one or two");
                return None;
            }
        };
        if !self.transmits[front] && !self.transmits[back] {
            return Some(Material::TwoSided { front, back });
        }
        match self.parts.materials[front].clone() {
            Material::Mask { opacity, inner } if front == back && !self.transmits[inner] => {
                let solid = Material::TwoSided { front: inner, back: inner };
                Some(Material::Mask { opacity, inner: self.push_material(solid, None) })
            }
            inside => {
                node.warn("`twosided` around a bsdf that transmits light is ignored");
                Some(inside)
            }
        }
    }

    pub(super) fn blend(&mut self, node: Node<'_>) -> Option<Material> {
        let weight = self.one_channel_share(node, "weight", 0.5);
        match node.children(Class::Bsdf).as_slice() {
            [a, b] => {
                let (first, second) = (self.material(*a), self.material(*b));
                Some(Material::Blend { weight, first, second })
            }
            other => {
                node.wrong_count("bsdfs", other.len(), "expected two");
                None
            }
        }
    }

    /// A sheet that filters polarised light; of unpolarised light it transmits this fraction.
    pub(super) fn filter(&mut self, node: Node<'_>, fraction: f32) -> Material {
        node.ignore(&["theta", "delta", "left_handed"]);
        Material::ThinDielectric {
            eta: 1.0,
            reflectance: Texture::grey(1.0),
            transmittance: self.share(node, "transmittance", 1.0).scaled(Rgb::grey(fraction)),
        }
    }

    pub(super) fn only_child(&mut self, node: Node<'_>) -> Option<usize> {
        match node.children(Class::Bsdf).as_slice() {
            [inner] => Some(self.material(*inner)),
            other => {
                node.wrong_count("bsdfs", other.len(), "expected one: a `<bsdf>` inside it");
                None
            }
        }
    }

    pub(super) fn only_texture(&mut self, node: Node<'_>) -> Option<Texture> {
        match node.children(Class::Texture).as_slice() {
            [texture] => self.texture_object(*texture, 0),
            other => {
                node.wrong_count("textures", other.len(), "expected one: a `<texture>` inside it");
                None
            }
        }
    }
}
