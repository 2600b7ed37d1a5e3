//! Virtual point lights: where light paths meet surfaces, light starts again [slides 47-50, Keller97].
//!
//! Made once, by the one light walk, for instant radiosity and for lightcuts. A light's power is already divided by the
//! number of paths: to light a point is to add up all lights.

#![forbid(unsafe_code)]

mod energy;
mod illuminate;
mod options;
mod points;
mod prepared;
mod shoot;

use std::path::Path;

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::files::is_table;
use gi_core::geometry::Surface;
use gi_core::light::PointSource;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;

pub use energy::Energy;
pub use illuminate::{Connection, Receiver};
pub use options::{BoundOptions, Compensation, Direct, Termination};
pub use points::{LightNumbers, points};
pub use prepared::Prepared;
pub use shoot::{Pilot, Shooting, shoot};

/// Width of the narrowest lobe that virtual lights light, or scatter by, as that of microfacets. Narrower ones are sampled by
/// paths: of a mirror's reflection of a thousand points hardly any is seen, and the one that is is far too bright. Mitsuba's
/// default width, 0.1, is not narrow: on `cornell-glossy` paths have twice the error there.
pub const MIN_ROUGHNESS: f32 = 0.1;

/// A virtual point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vpl {
    /// Position, world; without meaning for parallel light.
    pub p: Vec3,
    /// Unit geometric normal of the surface, on the side that it lights; the way that parallel light travels.
    pub n: Vec3,
    /// Unit shading normal on that side: nothing leaves against it. The same as `n` where there is none.
    pub ns: Vec3,
    /// What it shines with; by kind: intensity on the normal (oriented: it falls off as the cosine), intensity (omni,
    /// spot), irradiance across it (directional), power that arrives (glossy). Divided by the number of paths.
    pub power: Rgb,
    /// How it shines.
    pub kind: Kind,
    /// Scatterings on its path, its own included: 0 for points of lights.
    pub depth: u32,
    /// The flat primitive that it lies on, see [`Scene::transmittance_to`].
    pub on: Option<u32>,
}

/// How a virtual point light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As the cosine with the geometric normal: a point of a Lambertian surface, or of an area light.
    Oriented,
    /// Alike in all directions.
    Omni,
    /// As the scene's spot light of this number.
    Spot(u32),
    /// In parallel, from infinity.
    Directional,
    /// As the BSDF of its surface scatters: index into [`Vpls::surfaces`].
    Glossy(u32),
}

/// Where a glossy light lies.
#[derive(Clone, Copy, Debug)]
pub struct LitSurface {
    /// The surface.
    pub surface: Surface,
    /// Unit direction to where its light came from.
    pub wo: Vec3,
}

impl LitSurface {
    /// How it scatters the light on, narrow lobes apart.
    pub fn bsdf<'a>(&self, scene: &'a Scene) -> Option<Bsdf<'a>> {
        scene.bsdf(&self.surface, self.wo, Transport::Power).broad(self.wo, MIN_ROUGHNESS)
    }
}

/// A set of virtual point lights.
#[derive(Clone, Debug, Default)]
pub struct Vpls {
    /// The lights, by depth: those with fewer scatterings first.
    pub lights: Vec<Vpl>,
    /// Where the glossy ones lie.
    pub surfaces: Vec<LitSurface>,
    /// Light paths that were walked.
    pub paths: u64,
    /// Power that all surfaces received, all scatterings together.
    pub arrived: Rgb,
    /// Power that left the lights.
    pub emitted: Rgb,
}

impl Vpls {
    /// The lights whose paths have at most `depth` scatterings.
    pub fn up_to(&self, depth: u32) -> &[Vpl] {
        &self.lights[..self.lights.partition_point(|v| v.depth <= depth)]
    }

    /// What the set occupies.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.lights[..]) + size_of_val(&self.surfaces[..])
    }
}

impl Vpl {
    /// The light that a path starts from.
    fn of_emission(scene: &Scene, emission: &gi_core::light::Emission, paths: f32) -> Self {
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

/// Lights as a file of points: a table or a point cloud, by the file's name. `origin` is that of the scene.
pub fn to_file(path: &Path, vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    if is_table(path) { to_csv(vpls, origin).into_bytes() } else { to_ply(vpls, origin) }
}

/// Lights as a point cloud, `origin` being that of the scene: position, normal, power, depth.
pub fn to_ply(vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    let floats = ["x", "y", "z", "nx", "ny", "nz", "power_r", "power_g", "power_b"];
    let mut out = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", vpls.len());
    floats.iter().for_each(|p| out += &format!("property float {p}\n"));
    out += "property uint depth\nend_header\n";
    let mut out = out.into_bytes();
    for v in vpls {
        let numbers = [(v.p + origin).to_array(), v.n.to_array(), v.power.to_array()].concat();
        numbers.iter().for_each(|f| out.extend(f.to_le_bytes()));
        out.extend(v.depth.to_le_bytes());
    }
    out
}

/// Lights as a table, `origin` being that of the scene.
pub fn to_csv(vpls: &[Vpl], origin: Vec3) -> String {
    let mut out = String::from("x,y,z,nx,ny,nz,power_r,power_g,power_b,depth,kind\n");
    for v in vpls {
        let numbers = [(v.p + origin).to_array(), v.n.to_array(), v.power.to_array()].concat();
        let row: Vec<String> = numbers.iter().map(f32::to_string).collect();
        let kind = match v.kind {
            Kind::Oriented => "oriented",
            Kind::Omni => "omni",
            Kind::Spot(_) => "spot",
            Kind::Directional => "directional",
            Kind::Glossy(_) => "glossy",
        };
        out += &format!("{},{},{kind}\n", row.join(","), v.depth);
    }
    out
}
