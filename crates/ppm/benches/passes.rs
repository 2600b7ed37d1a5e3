//! Measures photons traced and pixels gathered per second, in the Cornell box with a mirror and a glass ball.
//!
//! `cargo bench -p ppm --bench passes`. Of several rounds, the smallest time counts. All threads of the pool work.

use std::time::Instant;

use gi_core::camera::Camera;
use gi_core::film::{Film, Show};
use gi_core::options::SurfaceLayers;
use gi_core::scene::Scene;
use gi_core::technique::{Setting, Technique};
use ppm::{Method, Params, Ppm};

const SIZE: [usize; 2] = [256, 256];
const ROUNDS: u32 = 8;

fn main() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell-spheres.xml");
    let options = gi_scene::Options { size: Some(SIZE), ..Default::default() };
    let loaded = gi_scene::load(path.as_ref(), &options)
        .unwrap_or_else(|problems| panic!("{path}: {problems}"));
    let scene = Scene::new(loaded.parts).expect("the scene is sound");
    let camera = Camera::new(&loaded.camera);
    let seconds = |method, photons, show| {
        let setting = Setting {
            scene: &scene,
            world: 0,
            camera: &camera,
            seed: 1,
            show,
            surface_layers: SurfaceLayers::First,
            source_rays: 0,
        };
        let params = Params { method, photons, ..Params::default() };
        let mut film = Film::new(SIZE, loaded.filter, show);
        let mut ppm = Ppm::prepare(setting, &params).expect("valid parameters");
        let pass = |k| {
            let clock = Instant::now();
            ppm.pass(k, &mut film);
            clock.elapsed().as_secs_f64()
        };
        (0..ROUNDS).map(pass).fold(f64::INFINITY, f64::min)
    };
    let pixels = (SIZE[0] * SIZE[1]) as f64;
    let paths = SIZE[0] as u32 * SIZE[1] as u32;
    println!("256 x 256 pixels, {} threads; millions per second", rayon::current_num_threads());
    for method in [Method::Ppm, Method::Sppm, Method::Ppa, Method::Adaptive] {
        // With one photon path, only the eye's half of a pass remains. Eight times the paths add seven times the time
        // for photons.
        let [eye, one, eight] = [1, paths, 8 * paths].map(|n| seconds(method, n, Show::All));
        let photons = 7.0 * f64::from(paths) / (eight - one);
        println!(
            "{method:?}: {:.1} passes per second; {:.2} pixels looked through and gathered, {:.2} paths walked, stored and sorted; \
             without photons {:.2} pixels",
            1.0 / one,
            1e-6 * pixels / one,
            1e-6 * photons,
            1e-6 * pixels / eye
        );
    }
}
