//! Materials as a scene gives them: parameters are textures. [`crate::bsdf::Bsdf`] is a material at a point.

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
    /// Which distribution.
    pub distribution: Distribution,
    /// Width along the first tangent.
    pub alpha_u: Texture,
    /// Width along the second tangent.
    pub alpha_v: Texture,
}

/// What is done about bent shading normals that face away from the eye or the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BentNormals {
    /// Whether those that face away from the eye are flipped about the unbent normal \[Schuessler17\].
    pub flipped: bool,
    /// Whether light fades out toward where the unbent normal faces away from it \[Estevez19\].
    pub shadowed: bool,
}

impl Default for BentNormals {
    fn default() -> Self {
        BentNormals { flipped: true, shadowed: true }
    }
}

/// Parameters of the principled model \[Burley12, Burley15\], as Mitsuba 3 names them. All but `eta` lie in [0, 1].
#[derive(Clone, Debug)]
pub struct Principled {
    /// Colour of the base, of metals and of what is refracted.
    pub base_color: Texture,
    /// Root of the facets' width.
    pub roughness: Texture,
    /// How much the facets' widths differ along the two tangents.
    pub anisotropic: Texture,
    /// Share of the metal.
    pub metallic: Texture,
    /// Share of the glass in what is not metal.
    pub spec_trans: Texture,
    /// Index inside over index outside.
    pub eta: f32,
    /// How much of the colour's hue the dielectric reflection takes on.
    pub spec_tint: Texture,
    /// Strength of the sheen.
    pub sheen: Texture,
    /// How much of the colour's hue the sheen takes on.
    pub sheen_tint: Texture,
    /// Share of the flattened form in the base.
    pub flatness: Texture,
    /// Strength of the clearcoat.
    pub clearcoat: Texture,
    /// How sharp the clearcoat's reflection is.
    pub clearcoat_gloss: Texture,
}

/// Parameters of the principled model of a sheet \[Burley15\], as Mitsuba 3 names them. All but `eta` and `diff_trans` lie
/// in [0, 1].
#[derive(Clone, Debug)]
pub struct PrincipledThin {
    /// Colour of the base, and of what passes.
    pub base_color: Texture,
    /// Root of the facets' width.
    pub roughness: Texture,
    /// How much the facets' widths differ along the two tangents.
    pub anisotropic: Texture,
    /// Share of the facets that reflect and let light pass.
    pub spec_trans: Texture,
    /// Twice the share of the base that lets light pass diffusely, in [0, 2].
    pub diff_trans: Texture,
    /// Index of the sheet over index round it.
    pub eta: Texture,
    /// How much of the colour's hue the reflection takes on.
    pub spec_tint: Texture,
    /// Strength of the sheen.
    pub sheen: Texture,
    /// How much of the colour's hue the sheen takes on.
    pub sheen_tint: Texture,
    /// Share of the flattened form in the base.
    pub flatness: Texture,
}

/// How a surface scatters light. Children are indices into the same table of materials
/// and must stand before their parent.
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
        /// Index of the pane over index round it.
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
        /// Whether light that bounces inside the coat is tinted each time.
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
    /// Nothing there: light passes straight through.
    Null,
    /// Partly there.
    Mask {
        /// 1 is opaque, 0 lets all light through.
        opacity: Texture,
        /// What is there.
        inner: usize,
    },
    /// A one-sided material on both sides.
    TwoSided {
        /// On the side of the normal.
        front: usize,
        /// Against the normal.
        back: usize,
    },
    /// A mixture.
    Blend {
        /// Share of `second`, in [0, 1].
        weight: Texture,
        /// At weight 0.
        first: usize,
        /// At weight 1.
        second: usize,
    },
    /// Shading normals bent by a height field.
    Bump {
        /// Height in world units per unit of texture coordinate stretch.
        height: Texture,
        /// What is bent.
        inner: usize,
        /// What is done about normals that face away.
        normals: BentNormals,
    },
    /// Shading normals from a picture: (r, g, b) = (n + 1) / 2 in the frame (dp/du, dp/dv, n).
    NormalMap {
        /// Encoded normals, linear.
        map: Texture,
        /// What is bent.
        inner: usize,
        /// What is done about normals that face away.
        normals: BentNormals,
    },
}

impl Material {
    /// The materials that this one is made of.
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
