//! A virtual point light, and a set of them.

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::geometry::Surface;
use gi_core::light::{Emission, PointSource};
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;

/// Smallest microfacet roughness of a lobe that virtual lights illuminate or scatter by. Narrower lobes are sampled by
/// paths: a nearly specular lobe sees few of the lights, and those far too bright. At 0.1, the default roughness in
/// Mitsuba, virtual lights have half the error of paths on `cornell-glossy`.
pub const MIN_ROUGHNESS: f32 = 0.1;

/// A virtual point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vpl {
    /// Position, world; unused for parallel light.
    pub p: Vec3,
    /// Unit geometric normal of the surface, on the lit side; for parallel light, the direction in which it travels.
    pub n: Vec3,
    /// Unit shading normal on that side; no light leaves below it. Equal to `n` for lights without a surface.
    pub ns: Vec3,
    /// Oriented: intensity along the normal. Omni and spot: intensity. Directional: irradiance on a plane across the
    /// light. Glossy: arriving power. Already divided by the number of paths.
    pub power: Rgb,
    /// How it emits.
    pub kind: Kind,
    /// Number of scatterings on its path, including its own; 0 for points on light sources.
    pub depth: u32,
    /// The flat primitive that it lies on, see [`Scene::transmittance_to`].
    pub on: Option<u32>,
}

/// How a virtual point light emits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Proportional to the cosine with the geometric normal: a point on a Lambertian surface or an area light.
    Oriented,
    /// Equally in all directions.
    Omni,
    /// Like the scene's spot light of this index.
    Spot(u32),
    /// Parallel light from infinity.
    Directional,
    /// As the BSDF of its surface scatters; the index is into [`Vpls::surfaces`].
    Glossy(u32),
}

/// The surface point of a glossy light.
#[derive(Clone, Copy, Debug)]
pub struct LitSurface {
    /// The surface.
    pub surface: Surface,
    /// Unit direction toward where its light came from.
    pub wo: Vec3,
}

impl LitSurface {
    /// The BSDF that scatters the light, without narrow lobes.
    pub fn bsdf<'a>(&self, scene: &'a Scene) -> Option<Bsdf<'a>> {
        scene.bsdf(&self.surface, self.wo, Transport::Power).broad(self.wo, MIN_ROUGHNESS)
    }
}

/// A set of virtual point lights.
#[derive(Clone, Debug, Default)]
pub struct Vpls {
    /// The lights, sorted by depth: fewest scatterings first.
    pub lights: Vec<Vpl>,
    /// The surface points of the glossy lights.
    pub surfaces: Vec<LitSurface>,
    /// Number of light paths.
    pub paths: u64,
    /// Power that arrived at surfaces, summed over all scatterings.
    pub arrived: Rgb,
    /// Power that the light sources emitted.
    pub emitted: Rgb,
}

impl Vpls {
    /// The lights whose paths have at most `depth` scatterings.
    pub fn up_to(&self, depth: u32) -> &[Vpl] {
        &self.lights[..self.lights.partition_point(|v| v.depth <= depth)]
    }

    /// Memory of the set in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.lights[..]) + size_of_val(&self.surfaces[..])
    }
}

impl Vpl {
    /// The light that a path starts from.
    pub(crate) fn of_emission(scene: &Scene, emission: &Emission, paths: f32) -> Self {
        let (kind, power) = match emission.source {
            PointSource::Oriented(power) => (Kind::Oriented, power),
            PointSource::Omni(power) => (Kind::Omni, power),
            PointSource::Spot(power) => (Kind::Spot(emission.light), power),
            PointSource::Directional(power) => (Kind::Directional, power),
        };
        let n = if kind == Kind::Oriented { emission.ng } else { emission.d };
        let on = scene.flat_light(emission.light);
        Vpl { p: emission.p, n, ns: n, power: power / paths, kind, depth: 0, on }
    }
}
