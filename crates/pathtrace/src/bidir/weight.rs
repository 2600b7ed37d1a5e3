//! Weights of multiple importance sampling for paths that are sampled from both ends, in a closed recursion
//! \[Georgiev12b\]. Numbers in brackets are equations of that report.
//!
//! A path with n segments can be found in up to n + 1 ways by connecting, and in n - 1 ways by merging. The weight of one
//! way is its density to the power beta, divided by the sum over all ways. Three sums per subpath ([`Partials`]) are enough
//! to compute it, and they follow from those of the vertex before.
//!
//! The densities here are functions of the path alone. Where the sampled density is not, as with Russian roulette, the
//! choice of a lobe, and the distance in a medium, they leave it out. This is allowed: any weights that sum to one are unbiased.
//!
//! A density says nothing of how evenly the samples are spread. The samples of a pixel are stratified over the lights that
//! its first point sees, and light paths are not stratified over pixels. So for direct light, the ways that end a path from
//! the eye count [`STRATIFIED`] times as much, as in variance-aware weights \[Grittmann19\].

use gi_core::light::LightEnd;

use crate::params::Heuristic;

/// Second moment divided by variance, for direct light that is found from the eye. An assumption; it is not measured per
/// scene.
const STRATIFIED: f64 = 4.0;

/// How many samples each way gets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ways {
    pub(crate) heuristic: Heuristic,
    /// Number of light paths per pass.
    pub(crate) light_paths: f32,
    /// Density of merging relative to connecting: number of light paths times the area of the disc, world units squared.
    /// Zero if nothing is merged (20).
    pub(crate) merges: f32,
}

impl Ways {
    /// A density to the power beta.
    #[inline]
    fn of(&self, density: f32) -> f64 {
        let density = f64::from(density);
        match self.heuristic {
            Heuristic::Balance => density,
            Heuristic::Power => density * density,
        }
    }

    /// Factor on the densities of the ways s = 0 and s = 1. `direct`: the scattering next to the light is the only one that
    /// is not by a delta lobe.
    #[inline]
    fn stratified(&self, direct: bool) -> f64 {
        match self.heuristic {
            _ if !direct => 1.0,
            Heuristic::Balance => STRATIFIED,
            Heuristic::Power => STRATIFIED * STRATIFIED,
        }
    }

    /// Merging at a vertex, relative to connecting there.
    #[inline]
    fn merging(&self, merges: bool) -> f64 {
        if merges { self.of(self.merges) } else { 0.0 }
    }

    /// Connecting relative to merging; zero where nothing is merged.
    #[inline]
    fn connecting(&self) -> f64 {
        if self.merges > 0.0 { 1.0 / self.of(self.merges) } else { 0.0 }
    }
}

/// Sums of the densities of the other ways to find a subpath, divided by the density of the way that found it. Factors that
/// depend on the next vertex are still missing. Before [`Partials::reach`], the last vertex is the one that the path leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Partials {
    /// For the way that ends the subpath one vertex earlier (31).
    vcm: f64,
    /// For all shorter ones, by connecting and by merging (32). The sum of the report for merging (33) is this one times
    /// [`Ways::connecting`].
    vc: f64,
}

/// Densities at the last vertex of a subpath, for a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    /// Density per area with which the path from the other side would have reached the vertex.
    pub(crate) reached: f32,
    /// Density per solid angle with which that path would have continued to the vertex before this one.
    pub(crate) reverse: f32,
    /// Whether photons are merged here.
    pub(crate) merges: bool,
}

impl Partials {
    /// The first vertex of a light path (31)-(33). `facing` is the cosine at this vertex.
    pub(crate) fn of_light(ways: &Ways, end: &LightEnd, facing: f32) -> Self {
        let traced = ways.of(end.emit * facing);
        Partials { vcm: ways.of(end.direct) / traced, vc: ways.of(end.reach) / traced }
    }

    /// The first vertex of a path from the eye. `importance` is the density of rays per perpendicular area.
    pub(crate) fn of_eye(ways: &Ways, importance: f32, facing: f32) -> Self {
        Partials { vcm: ways.of(ways.light_paths / (importance * facing)), vc: 0.0 }
    }

    /// After scattering in a direction with density `pdf_w` and cosine `facing`. `reverse` is the density of
    /// the direction back to the vertex before (34), (35).
    #[inline]
    pub(crate) fn scatter(
        &self,
        ways: &Ways,
        facing: f32,
        [pdf_w, reverse]: [f32; 2],
        merges: bool,
    ) -> Self {
        let (ratio, reverse) = (ways.of(facing / pdf_w), ways.of(reverse));
        Partials {
            vcm: ways.of(1.0 / pdf_w),
            vc: ratio * (self.vc * reverse + self.vcm + ways.merging(merges)),
        }
    }

    /// After scattering by a delta lobe: nothing can be connected or merged there, and both directions have the same
    /// density (53)-(55).
    #[inline]
    pub(crate) fn scatter_delta(&self, ways: &Ways, facing: f32) -> Self {
        let facing = ways.of(facing);
        Partials { vcm: 0.0, vc: self.vc * facing }
    }

    /// At the next vertex: densities per area there instead of per solid angle.
    #[inline]
    pub(crate) fn reach(&self, ways: &Ways, facing: f32, distance_sq: f32) -> Self {
        let facing = ways.of(facing);
        Partials { vcm: self.vcm * ways.of(distance_sq) / facing, vc: self.vc / facing }
    }

    /// One side's part of the weight of a connection (40), (41), (46). Shorter subpaths on this side count `factor` times.
    #[inline]
    fn connected(&self, ways: &Ways, joint: &Joint, factor: f64) -> f64 {
        let shorter = self.vcm + self.vc * ways.of(joint.reverse);
        ways.of(joint.reached) * (ways.merging(joint.merges) + shorter * factor)
    }
}

/// Weight of a path from the eye that hits the light (42), (43). `eye` are the partials before [`Partials::reach`].
/// `direct`: see [`Ways::stratified`], here and below.
#[inline]
pub(crate) fn hit_light(ways: &Ways, eye: &Partials, end: &LightEnd, direct: bool) -> f32 {
    let sampled = ways.of(end.direct / end.reach) * eye.vcm;
    let others = ways.of(end.emit / end.reach) * eye.vc / ways.stratified(direct);
    (1.0 / (1.0 + sampled + others)) as f32
}

/// Weight of a light sample (44), (45). `pdf_w` is the density with which scattering samples the direction to the light,
/// and `reached` of `joint` the cosine at the vertex.
#[inline]
pub(crate) fn light_sample(
    ways: &Ways,
    eye: &Partials,
    end: &LightEnd,
    pdf_w: f32,
    joint: &Joint,
    direct: bool,
) -> f32 {
    let hit = ways.of(pdf_w * end.reach / end.direct);
    let joint = Joint { reached: joint.reached * end.emit / end.direct, ..*joint };
    (1.0 / (1.0 + hit + eye.connected(ways, &joint, 1.0) / ways.stratified(direct))) as f32
}

/// Weight of a connection of a light path with the camera (46), (47). `reached` of `joint` is the camera's density per
/// area at the vertex.
#[inline]
pub(crate) fn camera(ways: &Ways, light: &Partials, joint: &Joint, direct: bool) -> f32 {
    let joint = Joint { reached: joint.reached / ways.light_paths, ..*joint };
    (1.0 / (1.0 + light.connected(ways, &joint, ways.stratified(direct)))) as f32
}

/// Weight of a connection of two vertices (40), (41).
#[inline]
pub(crate) fn connection(ways: &Ways, eye: (&Partials, &Joint), light: (&Partials, &Joint)) -> f32 {
    (1.0 / (1.0 + eye.0.connected(ways, eye.1, 1.0) + light.0.connected(ways, light.1, 1.0))) as f32
}

/// Weight of merging a photon with a vertex of the eye (38), (39). `forward` is the density per solid angle with which the
/// path from the eye continues toward the photon's light, `backward` that of the light path toward the eye.
#[inline]
pub(crate) fn merging(
    ways: &Ways,
    [eye, light]: [&Partials; 2],
    [forward, backward]: [f32; 2],
    direct: bool,
) -> f32 {
    let part = |p: &Partials, pdf_w| ways.connecting() * (p.vcm + p.vc * ways.of(pdf_w));
    let found_by_eye = part(light, forward) * ways.stratified(direct);
    (1.0 / (1.0 + found_by_eye + part(eye, backward))) as f32
}
