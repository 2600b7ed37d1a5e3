//! Helpers of the tests that involve several crates: scenes with known answers, rendering them, and running programs.

pub mod browser;
pub mod pictures;
pub mod program;

use gi_core::camera::{Camera, CameraSpec};
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::{Frame, Rgb};
use gi_core::options::SurfaceLayers;
use gi_core::scene::{Scene, SceneParts};
use gi_core::technique::{Setting, Technique};
use gi_core::texture::Texture;
use gi_stats::z_test;
use glam::{Affine3A, Vec3, Vec3A};

/// A scene and its camera. Pictures use the box filter, so that pixels are independent.
pub struct World {
    /// Surfaces and lights.
    pub scene: Scene,
    /// The eye.
    pub camera: Camera,
}

impl World {
    /// A world of `parts` seen through `camera`.
    pub fn new(mut parts: SceneParts, camera: &CameraSpec) -> Self {
        // The camera moves with the scene, as in the programs.
        let mut camera = camera.clone();
        camera.to_world.translation += Vec3A::from(parts.recentre());
        let scene = Scene::new(parts).expect("a valid scene");
        World { scene, camera: Camera::new(&camera) }
    }

    /// The world of a Mitsuba 3 scene; `body` is everything inside the outermost tags. The pictures of [`pictures`] are
    /// in the same folder.
    pub fn of_xml(body: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.xml");
        pictures::write(folder.path());
        let text = format!("<scene version=\"3.0.0\">{body}</scene>");
        std::fs::write(&path, text).expect("written");
        let loaded = gi_scene::load(&path, &gi_scene::Options::default());
        let loaded = loaded.unwrap_or_else(|problems| panic!("{problems}\n{body}"));
        World::new(loaded.parts, &loaded.camera)
    }

    /// The world of a scene file, with its picture scaled to `size`.
    pub fn load(path: &str, size: [usize; 2], defines: &[(&str, &str)]) -> Self {
        Self::load_with(path, size, defines, |_, _| {})
    }

    /// The same; `change` modifies the parts and the camera first.
    pub fn load_with(
        path: &str,
        size: [usize; 2],
        defines: &[(&str, &str)],
        change: impl FnOnce(&mut SceneParts, &mut CameraSpec),
    ) -> Self {
        let defines = defines.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        let options = gi_scene::Options { defines, size: Some(size), ..Default::default() };
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(path);
        let mut loaded =
            gi_scene::load(&path, &options).unwrap_or_else(|problems| panic!("{problems}"));
        change(&mut loaded.parts, &mut loaded.camera);
        World::new(loaded.parts, &loaded.camera)
    }

    /// The setting that a technique is prepared with.
    pub fn setting(&self, seed: u32, show: Show) -> Setting<'_> {
        Setting {
            scene: &self.scene,
            world: 0,
            camera: &self.camera,
            seed,
            show,
            surface_layers: SurfaceLayers::First,
            source_rays: 0,
        }
    }

    /// The world of a scene file with meshes and spheres, scaled by `scale`.
    pub fn load_scaled(path: &str, size: [usize; 2], scale: f32) -> Self {
        let options = gi_scene::Options { size: Some(size), ..Default::default() };
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(path);
        let mut loaded =
            gi_scene::load(&path, &options).unwrap_or_else(|problems| panic!("{problems}"));
        let map = Affine3A::from_scale(Vec3::splat(scale));
        for shape in &mut loaded.parts.shapes {
            match &mut shape.geometry {
                Geometry::Mesh(mesh) => mesh.transform(&map),
                Geometry::Sphere { center, radius, .. } => {
                    *center *= scale;
                    *radius *= scale;
                }
                other => panic!("no {other:?} in this scene"),
            }
        }
        loaded.camera.to_world.translation *= scale;
        World::new(loaded.parts, &loaded.camera)
    }

    /// A roof of 4 m over 400 m of ground under a white sky, seen from below. All of its light comes from the ground, and
    /// most of the ground does not matter.
    pub fn roof_over_wide_ground() -> Self {
        let shapes = vec![
            Shape::new("ground", square(200.0, 0.0), 1),
            Shape::new("roof", square(2.0, 2.0), 1),
        ];
        let parts = SceneParts {
            shapes,
            materials: vec![grey(0.5), both_sides()],
            lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
            ..SceneParts::default()
        };
        let eye = Vec3::new(0.3, 0.2, 0.2);
        let camera = CameraSpec::look_at(eye, Vec3::new(0.0, 2.0, 0.0), Vec3::Z, 1.0, [16, 16]);
        World::new(parts, &camera)
    }

    /// A Cornell box, seen from one side of its opening.
    pub fn from_the_side(self) -> Self {
        let (eye, target) = (Vec3::new(200.0, 273.0, -750.0), Vec3::new(278.0, 273.0, 0.0));
        let camera = CameraSpec::look_at(eye, target, Vec3::Y, 0.65, self.camera.size());
        World { camera: Camera::new(&camera), ..self }
    }

    /// The film after the given number of passes of a technique.
    pub fn render<'a, T: Technique<'a>>(
        &'a self,
        params: &T::Params,
        passes: u32,
        seed: u32,
        show: Show,
    ) -> Film {
        self.run::<T>(params, passes, seed, show).1
    }

    /// The same, with the technique in its final state.
    pub fn run<'a, T: Technique<'a>>(
        &'a self,
        params: &T::Params,
        passes: u32,
        seed: u32,
        show: Show,
    ) -> (T, Film) {
        let setting = self.setting(seed, show);
        let mut film = Film::new(self.camera.size(), Filter::Box, show);
        let mut technique = T::prepare(setting, params).expect("valid parameters");
        (0..passes).for_each(|k| technique.pass(k, &mut film));
        (technique, film)
    }
}

/// Mean over the picture of the three channels, and the variance of that mean as estimated by the film.
pub fn mean_and_variance(film: &Film) -> (f64, f64) {
    let layers = film.layers();
    let n = (3 * layers.width * layers.height) as f64;
    let sum = |names: [&str; 3]| -> f64 {
        names
            .iter()
            .flat_map(|name| layers.channel(name).expect("a layer"))
            .map(|v| f64::from(*v))
            .sum()
    };
    let mean = sum(["R", "G", "B"]) / n;
    // The channels of a pixel may be the same number three times: treat them as fully correlated.
    (mean, 3.0 * sum(["Variance.R", "Variance.G", "Variance.B"]) / (n * n))
}

/// Probability below which a deviation is not due to chance. Seeds are fixed, so a test that passes keeps passing.
pub const ALPHA: f64 = 1e-3;

/// Compare the mean of a film with an exact value, using the film's own variance.
#[track_caller]
pub fn assert_mean(name: &str, film: &Film, expected: f64) {
    let (mean, variance) = mean_and_variance(film);
    let p = z_test(mean, variance + (1e-5 * expected).powi(2), expected, 0.0); // floats have seven digits
    assert!(
        p > ALPHA,
        "{name}: {mean} is not {expected} (standard error {:.2e}, p = {p:.1e})",
        variance.sqrt()
    );
}

/// A Lambertian material of grey albedo.
pub fn grey(albedo: f32) -> Material {
    Material::Diffuse { reflectance: Texture::grey(albedo) }
}

/// A two-sided version of the material with index 0.
pub fn both_sides() -> Material {
    Material::TwoSided { front: 0, back: 0 }
}

/// A sphere around `center`.
pub fn sphere(center: Vec3, radius: f32) -> Geometry {
    Geometry::Sphere { center, radius, axes: Frame::from_normal(Vec3::Z) }
}

/// The inside of the cube from -1 to 1, normals inward.
pub fn cube_inside() -> Geometry {
    let corner = |k: usize| {
        Vec3::from_array([0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -1.0 } else { 1.0 }))
    };
    let faces =
        [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Geometry::Mesh(Mesh { positions: (0..8).map(corner).collect(), triangles, ..Mesh::default() })
}

/// A planar polygon; its normal follows the right-hand rule around the corners.
pub fn polygon(corners: &[Vec3]) -> Geometry {
    let triangles = (2..corners.len() as u32).map(|k| [0, k - 1, k]).collect();
    Geometry::Mesh(Mesh { positions: corners.to_vec(), triangles, ..Mesh::default() })
}

/// A horizontal square of half-width `half` at height `y`; its normal points up.
pub fn square(half: f32, y: f32) -> Geometry {
    let at = |x, z| Vec3::new(x * half, y, z * half);
    polygon(&[at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)])
}

/// A closed box whose walls emit radiance 1 and have albedo `a`: radiance is 1 / (1 - a) everywhere.
pub fn furnace(a: f32) -> (SceneParts, CameraSpec) {
    let walls = Shape {
        emission: Some(Texture::Constant(Rgb::WHITE)),
        ..Shape::new("walls", cube_inside(), 0)
    };
    let parts =
        SceneParts { shapes: vec![walls], materials: vec![grey(a)], ..SceneParts::default() };
    let camera = CameraSpec::look_at(
        Vec3::new(0.1, -0.2, -0.7),
        Vec3::new(0.2, 0.1, 1.0),
        Vec3::Y,
        1.4,
        [16, 16],
    );
    (parts, camera)
}

/// The page about adding a technique. Its code is compiled and run as a test of documentation.
#[cfg(doctest)]
#[doc = include_str!("../docs/add-a-technique.md")]
pub struct AddingATechnique;
