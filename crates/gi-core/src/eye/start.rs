//! The start of eye paths: at the camera, or with a gather ray at a surface.

use super::remainder::Remainder;
use super::{EyeWalk, PathLimits};
use crate::film::{Sample, Show};
use crate::light::LightTree;
use crate::math::Rgb;
use crate::options::SurfaceLayers;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::{Line, Scene};
use crate::technique::Setting;

/// The start of a gather ray, that is, of a path that does not begin at the camera.
#[derive(Clone, Copy)]
pub struct GatherRay {
    /// The ray; its origin is offset from the surface.
    pub ray: Ray,
    /// Number of segments from the camera, this one included.
    pub segments: u32,
    /// Length of the path from the camera up to the ray's start, world units.
    pub length: f32,
}

impl<'a> EyeWalk<'a> {
    /// A path through a random point of a pixel: sample number `index` of that pixel. If sensors stand in place of the camera, the
    /// path begins at one of them, and the value of its sample is irradiance.
    #[inline(always)]
    pub fn through_pixel(
        setting: &Setting<'a>,
        limits: PathLimits,
        pixel: [usize; 2],
        index: u32,
    ) -> Self {
        Self::through_pixel_at(setting, limits, pixel, index, |u| u)
    }

    /// The same; `place` maps two random numbers to the film position, in pixels from the pixel's corner. The position may
    /// be in another pixel: filters reach that far.
    #[inline(always)]
    pub fn through_pixel_at(
        setting: &Setting<'a>,
        limits: PathLimits,
        [x, y]: [usize; 2],
        index: u32,
        place: impl FnOnce([f32; 2]) -> [f32; 2],
    ) -> Self {
        let camera = setting.camera;
        let stream = (y * camera.size()[0] + x) as u32;
        let mut sampler = Sampler::new(setting.seed, stream, index);
        if let Some(sensor) = camera.sensor_at([x, y]) {
            return Self::at_sensor(setting, limits, sensor, sampler);
        }
        let [u, v] = place(sampler.next_2d());
        let lens = if camera.has_lens() { sampler.next_2d() } else { [0.5; 2] };
        let ray = camera.ray([x as f32 + u, y as f32 + v], lens);
        let mut walk = Self::new(setting.scene, limits, ray, sampler);
        walk.show = setting.show;
        walk.surface_layers = setting.surface_layers;
        walk.sample.offset = [u - 0.5, v - 0.5];
        walk.leaves_out_sources = setting.leaves_out_sources();
        if setting.scene.hides_emitters() {
            walk.hides_background = true;
            walk.ray = setting.scene.behind_lamps(walk.ray);
        }
        walk
    }

    /// Path number `path` through a random pixel, without Russian roulette. Prepasses use it to find the points that
    /// matter for the picture. `stream` separates the random numbers of one use from those of another.
    pub fn through_picture(setting: &Setting<'a>, stream: u32, path: u32) -> Self {
        let mut sampler = Sampler::new(setting.seed ^ stream, 0, path);
        let limits = PathLimits { max_depth: None, rr_depth: u32::MAX };
        let [w, h] = setting.camera.size().map(|n| n as f32);
        let [x, y] = sampler.next_2d();
        let pixel = [(x * w) as usize, (y * h) as usize];
        if let Some(sensor) = setting.camera.sensor_at(pixel) {
            return Self::at_sensor(setting, limits, sensor, sampler);
        }
        let ray = setting.camera.ray([x * w, y * h], sampler.next_2d());
        Self::new(setting.scene, limits, ray, sampler)
    }

    /// A path along a gather ray. Only light that was scattered at least once more, not by a delta lobe, counts: it is
    /// stored in [`crate::film::Components::indirect`] of the sample. The sample's depth is the distance to the first
    /// surface.
    #[inline]
    pub fn along(scene: &'a Scene, limits: PathLimits, start: GatherRay, sampler: Sampler) -> Self {
        let mut walk = Self::new(scene, limits, start.ray, sampler);
        walk.show = Show::Indirect;
        walk.non_delta = 1;
        (walk.segments, walk.length) = (start.segments, start.length);
        walk.start_length = start.length;
        walk
    }

    /// Choose light samples by this tree, or by power without one.
    #[inline]
    pub fn choose_lights_by(&mut self, tree: Option<&'a LightTree>) {
        self.light_tree = tree;
    }

    #[inline(always)]
    pub(super) fn new(scene: &'a Scene, limits: PathLimits, ray: Ray, sampler: Sampler) -> Self {
        EyeWalk {
            sampler,
            scene,
            limits,
            show: Show::All,
            surface_layers: SurfaceLayers::First,
            ray,
            throughput: Rgb::WHITE,
            remainder: Remainder::ALL,
            light_tree: scene.tree_of_many_lights(),
            last: None,
            non_delta: 0,
            after_delta: false,
            eta_sq: 1.0,
            segments: 1,
            length: 0.0,
            start_length: 0.0,
            knows_media: false,
            medium: None,
            entered: None,
            hides_background: false,
            leaves_out_sources: false,
            ahead: None,
            line: Line::default(),
            estimate: None,
            is_remainder: false,
            sample: Sample::default(),
            is_described: false,
        }
    }
}
