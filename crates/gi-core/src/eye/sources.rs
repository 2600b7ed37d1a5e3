//! Extra camera rays that look only for light sources, also in mirrors and through glass.
//!
//! A technique whose paths take long makes few passes. A lamp is much brighter than what it illuminates, so the edges of lamps are
//! then the largest error of the picture. These rays cost little and find nothing else: many of them fit into a pass.

use rayon::prelude::*;

use super::{EyeWalk, PathLimits};
use crate::film::{Components, Film, Show};
use crate::filter::FilterPlaces;
use crate::math::Rgb;
use crate::medium::MediumId;
use crate::progress;
use crate::technique::Setting;

/// The name of the step that traces these rays.
const STEP: &str = "light sources in view";
/// Separates the random numbers of these rays from those of the paths.
const STREAM: u32 = 0x736f_7572;

/// Rays that look for the light sources in view. The paths of the technique leave these sources out
/// ([`Setting::leaves_out_sources`]).
pub struct SourceRays<'a> {
    /// The setting of the rays.
    setting: Setting<'a>,
    /// Number of rays per pixel and pass.
    count: u32,
    limits: PathLimits,
    /// Set if media attenuate the light: the medium around the camera.
    media: Option<Option<MediumId>>,
}

impl<'a> SourceRays<'a> {
    /// The rays that a setting asks for; `None` if it asks for none, or if the picture does not show the sources.
    pub fn new(setting: &Setting<'a>, limits: PathLimits, through_media: bool) -> Option<Self> {
        let is_shown = matches!(setting.show, Show::All | Show::Direct);
        if !is_shown || !setting.leaves_out_sources() {
            return None;
        }
        let media = through_media.then(|| setting.camera_medium());
        let (seed, count) = (setting.seed ^ STREAM, setting.source_rays);
        let setting = Setting { seed, source_rays: 0, show: Show::Direct, ..*setting };
        Some(SourceRays { setting, count, limits, media })
    }

    /// Bytes that the light of a picture of `size` pixels takes during a pass.
    pub fn memory([w, h]: [usize; 2]) -> u64 {
        (w * h * size_of::<Components>()) as u64
    }

    /// Add what the rays see to the next pass of the film. `index` is the number of that pass.
    pub fn add_to_pass(&self, index: u32, film: &mut Film) {
        let places = FilterPlaces::new(film.filter().filter());
        let [w, h] = film.size();
        progress::begin(STEP, h as u64);
        let [along_x, along_y] =
            [w, h].map(|n| (0..n).map(|pixel| places.mean_weight(pixel, n)).collect::<Vec<f32>>());
        let pixels = (0..w * h).into_par_iter().with_min_len(w);
        let seen = pixels.map(|i| {
            let [x, y] = [i % w, i / w];
            // An abandoned pass is dropped.
            let sum = if progress::is_abandoned() {
                Rgb::BLACK
            } else {
                self.sum_of_sources(&places, [x, y], index)
            };
            progress::advance(u64::from(x == 0));
            let direct = sum / (self.count as f32 * along_x[x] * along_y[y]);
            Components { direct, ..Components::default() }
        });
        film.bring(seen.collect());
    }

    /// Sum over the rays of a pixel: the radiance of the sources that they see, multiplied by the filter's weight.
    fn sum_of_sources(&self, places: &FilterPlaces, pixel: [usize; 2], index: u32) -> Rgb {
        let (mut sum, size) = (Rgb::BLACK, self.setting.camera.size());
        for k in 0..self.count {
            let number = index.wrapping_mul(self.count).wrapping_add(k);
            let mut weight = 1.0;
            let place = |u| {
                let (at, w) = places.sample_2d(u, pixel, size);
                weight = w;
                at
            };
            let walk = EyeWalk::through_pixel_at(&self.setting, self.limits, pixel, number, place);
            sum += self.sources_on(walk) * weight;
        }
        sum
    }

    /// The light of the sources on a path over mirrors and glass.
    fn sources_on(&self, mut walk: EyeWalk) -> Rgb {
        walk.is_described = true;
        if let Some(medium) = self.media {
            walk.use_media(medium);
        }
        while walk.has_source_ahead() {
            let Some(v) = &walk.next_vertex() else { break };
            walk.add_emitted(v);
            if !walk.scatter(v) || walk.non_delta > 0 {
                break;
            }
        }
        walk.sample.radiance.direct
    }
}

impl EyeWalk<'_> {
    /// Trace the next segment. Returns whether it may lead to a light source over delta lobes only.
    fn has_source_ahead(&mut self) -> bool {
        let hit = self.scene.closest_on(&mut self.line, &self.ray, self.ray.tmax);
        self.ahead = Some(hit);
        hit.is_none_or(|hit| self.scene.may_shine(&hit))
    }
}
