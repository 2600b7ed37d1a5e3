//! A pixel: its data from pass to pass, and its work in a pass.

use gi_core::bsdf::Transport;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Sample;
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::rng::hash_words;
use gi_core::sampler::Sampler;
use gi_core::technique::Setting;
use glam::Vec3;

use crate::error::Moments;
use crate::gather::{Discs, Gathered, Point, covers, gather_seen};
use crate::methods::{Method, adaptive_radius, derivative_radius, probabilistic_radius};
use crate::params::Params;
use crate::photons::Photons;
use crate::statistics::{Pass, Statistics};

/// Data that a pixel keeps from pass to pass.
#[derive(Clone, Debug, Default)]
pub(crate) struct Region {
    /// R, N and tau of the pixel; with [`Method::Ppm`], of its first hit point.
    pub(crate) statistics: Statistics,
    /// Initial R, world units.
    pub(crate) initial: f64,
    /// The photons of the last pass, which are not yet in the statistics.
    pub(crate) pass: Pass,
    /// Sums for the error estimate, if it is needed.
    pub(crate) moments: Moments,
    /// The hit points of [`Method::Ppm`].
    pub(crate) hits: Vec<Hit>,
}

/// A hit point that all passes share.
#[derive(Clone, Debug)]
pub(crate) struct Hit {
    pub(crate) surface: Surface,
    pub(crate) wo: Vec3,
    pub(crate) covers: Covers,
    /// What one unit of radiance adds to the pixel.
    pub(crate) throughput: Rgb,
    pub(crate) segments: u32,
    /// Number of scatterings before it that were not by delta lobes.
    pub(crate) non_delta: u32,
    pub(crate) statistics: Statistics,
    /// The photons of the last pass, which are not yet in the statistics.
    pub(crate) pass: Pass,
}

/// Separates the random numbers of disc probes from those of eye paths.
const PROBES: u32 = 0x6469_7363;

/// 1 / (area of a disc).
fn per_area(radius: f64) -> f32 {
    (1.0 / (std::f64::consts::PI * radius * radius)) as f32
}

/// Settings of a pass.
#[derive(Clone, Copy)]
pub(crate) struct Look<'s, 'a> {
    pub(crate) setting: &'s Setting<'a>,
    pub(crate) params: &'s Params,
    /// Number of the pass.
    pub(crate) index: u32,
    /// Whether the error is estimated.
    pub(crate) moments: bool,
}

impl<'a> Look<'_, 'a> {
    /// The path through a pixel, sample number `index`.
    pub(crate) fn walk(&self, pixel: [usize; 2], index: u32) -> EyeWalk<'a> {
        EyeWalk::through_pixel(self.setting, self.params.limits, pixel, index)
    }

    /// Maximum number of segments of a photon, if the eye path has `segments`.
    fn photon_segments(&self, segments: u32) -> Option<u32> {
        self.params.limits.max_depth.map(|most| most - segments.min(most))
    }

    /// Whether photons cover direct light too.
    fn direct(&self, covers: Covers) -> bool {
        self.params.direct_by_photons && matches!(covers, Covers::NonDelta)
    }

    /// Marks the light from photons as found, so that the path does not add it. Its value is zero, because the photons
    /// are added elsewhere.
    pub(crate) fn nothing(&self, covers: Covers) -> Estimate {
        let direct = self.direct(covers).then_some(Rgb::BLACK);
        Estimate { covers, direct, indirect: Rgb::BLACK, caustic: Some(Rgb::BLACK) }
    }

    /// The scattering that photons cover at a vertex; `None` if the path continues.
    pub(crate) fn covers(&self, v: &EyeVertex) -> Option<Covers> {
        if v.wants_estimate() { covers(&v.bsdf, v.wo, self.params.min_roughness) } else { None }
    }

    /// Follow a path through a pixel, and gather photons at its vertices.
    pub(crate) fn pixel(&self, at: [usize; 2], region: &mut Region, grid: &Photons) -> Sample {
        self.choose_radius(region);
        let (sample, gathered) = match self.params.method {
            Method::Ppm => self.at_hit_points(at, region, grid),
            _ => self.anew(at, region, grid),
        };
        region.pass = gathered.pass();
        if self.moments {
            let radiance = f64::from(sample.radiance.all().luminance());
            region.moments.add(radiance, &gathered, region.statistics.radius);
        }
        sample
    }

    /// Choose the radius for methods that do not derive it from R, N and M.
    pub(crate) fn choose_radius(&self, region: &mut Region) {
        let radius = match self.params.method {
            Method::Ppm | Method::Sppm => return,
            Method::Ppa => region.initial * probabilistic_radius(self.index, self.params.alpha),
            Method::Adaptive => {
                let most = region.initial * derivative_radius(self.index);
                adaptive_radius(self.index, &region.moments, most).0
            }
        };
        let share = radius / region.statistics.radius;
        region.statistics.scale(share * share);
    }

    /// Random numbers that probe the disc at gather point number `index` of a pixel.
    fn probes(&self, [x, y]: [usize; 2], index: u32) -> impl FnMut() -> [f32; 2] {
        let stream = (y * self.setting.camera.size()[0] + x) as u32;
        let seed = hash_words(&[self.setting.seed, PROBES, index]);
        let mut sampler = Sampler::new(seed, stream, self.index);
        move || sampler.next_2d()
    }

    fn discs(&self, radius: f64, initial: f64) -> Discs {
        let derivative = self.moments.then(|| (initial * derivative_radius(self.index)) as f32);
        Discs { radius: radius as f32, derivative }
    }

    /// Find new hit points, and gather at all of them with the radius of the pixel.
    fn anew(&self, at: [usize; 2], region: &Region, grid: &Photons) -> (Sample, Gathered) {
        let scene = self.setting.scene;
        let radius = region.statistics.radius;
        let (discs, density) = (self.discs(radius, region.initial), per_area(radius));
        let (mut total, mut points) = (Gathered::default(), 0);
        let mut walk = self.walk(at, self.index);
        while let Some(v) = &walk.next_vertex() {
            walk.add_emitted(v);
            if let Some(covers) = self.covers(v) {
                let point = Point {
                    surface: &v.surface,
                    wo: v.wo,
                    bsdf: &v.bsdf,
                    covers,
                    max_segments: self.photon_segments(v.segments),
                    throughput: v.throughput,
                };
                let found = gather_seen(scene, grid, &point, discs, self.probes(at, points));
                points += 1;
                total.add(&found, v.throughput);
                let (indirect, caustic) = (found.indirect * density, Some(found.caustic * density));
                let direct = self.direct(covers).then(|| found.direct * density);
                walk.add_estimate(v, Estimate { covers, direct, indirect, caustic });
            }
            walk.add_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        (walk.sample(), total)
    }

    /// Gather at the stored hit points. The path only finds the light that photons do not cover.
    fn at_hit_points(
        &self,
        at: [usize; 2],
        region: &mut Region,
        grid: &Photons,
    ) -> (Sample, Gathered) {
        let scene = self.setting.scene;
        let mut walk = self.walk(at, self.index);
        while let Some(v) = &walk.next_vertex() {
            walk.add_emitted(v);
            if let Some(covers) = self.covers(v) {
                walk.add_estimate(v, self.nothing(covers));
            }
            walk.add_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        let mut sample = walk.sample();
        let mut total = Gathered::default();
        let initial = region.initial;
        for (index, hit) in region.hits.iter_mut().enumerate() {
            let bsdf = scene.bsdf(&hit.surface, hit.wo, Transport::Radiance);
            let point = Point {
                surface: &hit.surface,
                wo: hit.wo,
                bsdf: &bsdf,
                covers: hit.covers,
                max_segments: self.photon_segments(hit.segments),
                throughput: hit.throughput,
            };
            let radius = hit.statistics.radius;
            let (discs, probes) = (self.discs(radius, initial), self.probes(at, index as u32));
            let found = gather_seen(scene, grid, &point, discs, probes);
            total.add(&found, hit.throughput);
            let factor = hit.throughput * per_area(radius);
            *sample.radiance.of_path(hit.non_delta + 1, false) += factor * found.direct;
            *sample.radiance.of_path(hit.non_delta + 2, false) += factor * found.indirect;
            *sample.radiance.of_path(hit.non_delta + 1, true) += factor * found.caustic;
            let mut seen = Gathered::default();
            seen.add(&found, hit.throughput);
            hit.pass = seen.pass();
        }
        (sample, total)
    }

    /// The hit points of a pixel, from `count` paths.
    pub(crate) fn hit_points(&self, at: [usize; 2], count: u32, radius: f64) -> Vec<Hit> {
        let mut hits = Vec::new();
        for index in 0..count {
            let mut walk = self.walk(at, index);
            while let Some(v) = &walk.next_vertex() {
                if let Some(covers) = self.covers(v) {
                    hits.push(Hit {
                        surface: v.surface,
                        wo: v.wo,
                        covers,
                        throughput: v.throughput * (1.0 / count as f32),
                        segments: v.segments,
                        non_delta: v.non_delta,
                        statistics: Statistics::new(radius),
                        pass: Pass::default(),
                    });
                    walk.add_estimate(v, self.nothing(covers));
                }
                walk.skip_direct(v);
                if !walk.scatter(v) {
                    break;
                }
            }
        }
        hits
    }
}
