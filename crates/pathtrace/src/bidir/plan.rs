//! What paths from both ends decide once, before the first pass: the radius of merging, and the number of light paths.

use gi_core::eye::{EyeEvent, EyeWalk, PathLimits};
use gi_core::math::median;
use gi_core::technique::Setting;
use gi_core::walk::{LightEvent, LightWalk, Roulette, walk_in_order};

use super::{CHUNK, light_sampler};
use crate::params::{Mode, Params};

/// Number of the pilot pass. It is not added to the picture.
const PILOT: u32 = u32::MAX;
/// Number of light paths of the pilot pass.
const PILOT_PATHS: u32 = 4 * CHUNK;
/// The pilot pass looks at this many pixels across and down, at most.
const PILOT_SIDE: usize = 64;
/// Automatic radius of the first pass, in widths of the pixels. There is a light path per pixel, so discs then hold about the same
/// number of vertices in pictures of any size. Chosen by measurement on seven scenes.
const PIXELS: f32 = 0.6;
/// Largest automatic radius, in scene radii.
const OF_SCENE: f32 = 0.012;

/// See the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Radius of merging in the first pass, world units; zero if nothing is merged.
    pub(crate) radius: f32,
    /// Number of light paths per pass: one per pixel, or fewer if more would need too much memory.
    pub(crate) light_paths: u32,
}

impl Plan {
    /// Make the plan. It depends on the setting and the parameters only.
    pub(crate) fn make(setting: &Setting, params: &Params) -> Self {
        let radius = match params.mode {
            Mode::Vcm if params.radius > 0.0 => params.radius * setting.scene.radius(),
            Mode::Vcm => automatic_radius(setting, params.limits),
            _ => 0.0,
        };
        Plan { radius, light_paths: light_paths(setting, params) }
    }
}

/// A fraction of a pixel's width where most pixels look, but not more than a fraction of the scene.
fn automatic_radius(setting: &Setting, limits: PathLimits) -> f32 {
    let [w, h] = setting.camera.size();
    let [across, down] = [w, h].map(|n| n.min(PILOT_SIDE));
    let pixels = (0..across * down).map(|i| {
        let (x, y) = (i % across, i / across);
        [(2 * x + 1) * w / (2 * across), (2 * y + 1) * h / (2 * down)]
    });
    let most = OF_SCENE * setting.scene.radius();
    let widths = pixels.filter_map(|pixel| pixel_width(setting, limits, pixel));
    median(widths).map_or(most, |width| most.min(PIXELS * width))
}

/// Width of a pixel at the first surface where its path can be merged, world units.
fn pixel_width(setting: &Setting, limits: PathLimits, pixel: [usize; 2]) -> Option<f32> {
    let mut walk = EyeWalk::through_pixel(setting, limits, pixel, PILOT);
    walk.use_media(setting.camera_medium());
    while let Some(event) = &walk.next_event() {
        let goes_on = match event {
            EyeEvent::Surface(v) if !v.bsdf.is_delta() => {
                return Some(setting.camera.pixel_width_at(v.length));
            }
            EyeEvent::Surface(v) => walk.scatter(v),
            EyeEvent::Medium(v) => walk.scatter_within(v),
        };
        if !goes_on {
            break;
        }
    }
    None
}

/// One light path per pixel, or as many as leave the wanted number of vertices. The vertices of a path are estimated from a pilot
/// pass.
fn light_paths(setting: &Setting, params: &Params) -> u32 {
    let pixels = setting.camera.size().iter().product::<usize>() as u32;
    let scene = setting.scene;
    let vertices = walk_in_order(PILOT_PATHS.min(pixels), CHUNK, |path, left: &mut Vec<()>| {
        let sampler = light_sampler(setting, PILOT, path);
        let Some(mut walk) = LightWalk::begin(scene, sampler) else { return };
        walk.use_media();
        let roulette = Roulette::ByAlbedo { from: params.limits.rr_depth };
        while let Some(event) = &walk.next_event() {
            if !params.limits.goes_on(event.depth() + 1) {
                return;
            }
            left.push(());
            let goes_on = match event {
                LightEvent::Surface(v) => walk.scatter(v, roulette),
                LightEvent::Medium(v) => walk.scatter_within(v, roulette),
            };
            if !goes_on {
                return;
            }
        }
    });
    let vertices: usize = vertices.iter().map(Vec::len).sum();
    let per_path = vertices as f64 / f64::from(PILOT_PATHS.min(pixels));
    let most = params.light_vertices as f64 / per_path.max(1.0);
    pixels.min(most as u32).max(1)
}

#[cfg(test)]
mod tests {
    use gi_core::film::Show;
    use gi_tests::World;

    use super::*;

    #[test]
    fn fewer_light_paths_are_traced_where_their_vertices_would_need_too_much_memory() {
        let world = World::load("cornell-box.xml", [64, 64], &[]);
        let setting = world.setting(1, Show::All);
        let plan = |light_vertices| {
            let params = Params { mode: Mode::Bdpt, light_vertices, ..Params::default() };
            Plan::make(&setting, &params)
        };
        assert_eq!(plan(1_000_000), Plan { radius: 0.0, light_paths: 4096 });
        let few = plan(2000).light_paths;
        // Paths in the box have between 1 and 4 vertices.
        assert!((500..2000).contains(&few), "{few}");
    }

    #[test]
    fn the_radius_of_merging_follows_what_the_picture_shows_and_its_size() {
        let params = Params { mode: Mode::Vcm, ..Params::default() };
        let radius = |world: &World| Plan::make(&world.setting(1, Show::All), &params).radius;
        let room = |side| World::load("cornell-box.xml", [side, side], &[]);
        assert_eq!(radius(&room(16)), OF_SCENE * room(16).scene.radius());
        let ratio = radius(&room(256)) / radius(&room(512));
        assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
        // The roof is about 2 m away, and 16 pixels see 2 tan(0.5) of it per metre.
        let wide = World::roof_over_wide_ground();
        let expected = PIXELS * 2.0 * (2.0 * 0.5f32.tan() / 16.0);
        let found = radius(&wide);
        assert!((0.7 * expected..1.3 * expected).contains(&found), "{found}, not {expected}");
        assert!(found < 0.5 * OF_SCENE * wide.scene.radius(), "{found}");
    }
}
