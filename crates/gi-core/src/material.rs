//! Materials as the scene describes them: their parameters are textures. [`crate::bsdf::Bsdf`] is a material at a
//! point.

use crate::math::Rgb;
use crate::texture::Texture;

/// Distribution of microfacet normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Trowbridge-Reitz.
    Ggx,
    /// Gaussian slopes.
    Beckmann,
}

/// Roughness of a microfacet surface.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// The distribution.
    pub distribution: Distribution,
    /// Width along the first tangent.
    pub alpha_u: Texture,
    /// Width along the second tangent.
    pub alpha_v: Texture,
}

/// Corrections of bent shading normals that face away from the eye or the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BentNormals {
    /// Whether normals that face away from the eye are flipped about the unbent normal \[Schuessler17\].
    pub flipped: bool,
    /// Whether light fades out toward directions from which the unbent normal faces away \[Estevez19\].
    pub shadowed: bool,
}

impl Default for BentNormals {
    fn default() -> Self {
        BentNormals { flipped: true, shadowed: true }
    }
}

/// Parameters of the principled model \[Burley12, Burley15\], with the names of Mitsuba 3. All except `eta` are in [0,
/// 1].
#[derive(Clone, Debug)]
pub struct Principled {
    /// Colour of the base, of metals, and of refracted light.
    pub base_color: Texture,
    /// Square root of the facets' width.
    pub roughness: Texture,
    /// How much the facets' widths differ between the two tangents.
    pub anisotropic: Texture,
    /// Fraction of metal.
    pub metallic: Texture,
    /// Fraction of glass in the part that is not metal.
    pub spec_trans: Texture,
    /// Index inside over index outside.
    pub eta: f32,
    /// How much of the colour's hue the dielectric reflection has.
    pub spec_tint: Texture,
    /// Strength of the sheen.
    pub sheen: Texture,
    /// How much of the colour's hue the sheen has.
    pub sheen_tint: Texture,
    /// Fraction of the flattened form in the base.
    pub flatness: Texture,
    /// Strength of the clearcoat.
    pub clearcoat: Texture,
    /// Sharpness of the clearcoat's reflection.
    pub clearcoat_gloss: Texture,
}

/// Parameters of the principled model of a sheet \[Burley15\], with the names of Mitsuba 3. All except `eta` and
/// `diff_trans` are in [0, 1].
#[derive(Clone, Debug)]
pub struct PrincipledThin {
    /// Colour of the base, and of transmitted light.
    pub base_color: Texture,
    /// Square root of the facets' width.
    pub roughness: Texture,
    /// How much the facets' widths differ between the two tangents.
    pub anisotropic: Texture,
    /// Fraction of the facets, which reflect and transmit light.
    pub spec_trans: Texture,
    /// Twice the fraction of the base that transmits light diffusely, in [0, 2].
    pub diff_trans: Texture,
    /// Index of the sheet over the index around it.
    pub eta: Texture,
    /// How much of the colour's hue the reflection has.
    pub spec_tint: Texture,
    /// Strength of the sheen.
    pub sheen: Texture,
    /// How much of the colour's hue the sheen has.
    pub sheen_tint: Texture,
    /// Fraction of the flattened form in the base.
    pub flatness: Texture,
}

/// How a surface scatters light. Children are indices into the same table of materials, and must come before their
/// parent.
#[derive(Clone, Debug)]
pub enum Material {
    /// Lambert.
    Diffuse {
        /// Albedo.
        reflectance: Texture,
    },
    /// Oren-Nayar's qualitative model.
    RoughDiffuse {
        /// Albedo.
        reflectance: Texture,
        /// Root mean square slope of the facets.
        alpha: Texture,
    },
    /// Metal: smooth without `roughness`.
    Conductor {
        /// Real part of the index of refraction.
        eta: Rgb,
        /// Imaginary part. `eta = 0, k = 1` is a perfect mirror.
        k: Rgb,
        /// Factor on the reflection.
        reflectance: Texture,
        /// Facets, if rough.
        roughness: Option<Roughness>,
    },
    /// Glass: smooth without `roughness`.
    Dielectric {
        /// Index inside over index outside.
        eta: f32,
        /// Factor on reflection.
        reflectance: Texture,
        /// Factor on transmission.
        transmittance: Texture,
        /// Facets, if rough.
        roughness: Option<Roughness>,
    },
    /// A pane: both interfaces at once, no refraction.
    ThinDielectric {
        /// Index of the pane over the index around it.
        eta: f32,
        /// Factor on reflection.
        reflectance: Texture,
        /// Factor on transmission.
        transmittance: Texture,
    },
    /// A diffuse base under a dielectric coat: smooth without `roughness`.
    Plastic {
        /// Index of the coat over index outside.
        eta: f32,
        /// Albedo of the base.
        diffuse: Texture,
        /// Factor on the coat's reflection.
        specular: Texture,
        /// Whether light that is reflected inside the coat is tinted each time.
        nonlinear: bool,
        /// Facets of the coat, if rough (isotropic; `alpha_u` counts and must be constant).
        roughness: Option<Roughness>,
    },
    /// Modified Phong \[Lafortune94\].
    Phong {
        /// Diffuse albedo.
        diffuse: Texture,
        /// Albedo of the lobe.
        specular: Texture,
        /// Exponent of the lobe.
        exponent: Texture,
    },
    /// Burley's principled model of a body's surface.
    Principled(Box<Principled>),
    /// Burley's principled model of a sheet without thickness.
    PrincipledThin(Box<PrincipledThin>),
    /// No surface: light passes straight through.
    Null,
    /// A partly transparent surface.
    Mask {
        /// Opacity: 1 is opaque, 0 transmits all light.
        opacity: Texture,
        /// The material of the opaque part.
        inner: usize,
    },
    /// Two one-sided materials, one for each side.
    TwoSided {
        /// On the side of the normal.
        front: usize,
        /// On the opposite side.
        back: usize,
    },
    /// A mixture.
    Blend {
        /// Weight of `second`, in [0, 1].
        weight: Texture,
        /// The material for weight 0.
        first: usize,
        /// The material for weight 1.
        second: usize,
    },
    /// Shading normals from a height field.
    Bump {
        /// Height in world units per unit of texture coordinates.
        height: Texture,
        /// The material whose normals are changed.
        inner: usize,
        /// Corrections of normals that face away.
        normals: BentNormals,
    },
    /// Shading normals from a picture: (r, g, b) = (n + 1) / 2 in the frame (dp/du, dp/dv, n).
    NormalMap {
        /// Encoded normals, linear.
        map: Texture,
        /// The material whose normals are changed.
        inner: usize,
        /// Corrections of normals that face away.
        normals: BentNormals,
    },
}

impl Material {
    /// The materials that this one uses.
    pub fn children(&self) -> Vec<usize> {
        match self {
            Material::Mask { inner, .. }
            | Material::Bump { inner, .. }
            | Material::NormalMap { inner, .. } => vec![*inner],
            Material::TwoSided { front, back } => vec![*front, *back],
            Material::Blend { first, second, .. } => vec![*first, *second],
            _ => Vec::new(),
        }
    }
}
