//! The layers that describe a surface: albedo, normal and depth.

use super::EyeWalk;
use crate::bsdf::{Bsdf, Transport};
use crate::geometry::Surface;
use crate::options::SurfaceLayers;
use crate::ray::Hit;

impl EyeWalk<'_> {
    /// Fill in the layers. The surface is at distance `t` from the start of the segment, which is `before` from the start
    /// of the path (world units). Surfaces that the eye does not see (`null`, open masks) have none.
    #[inline]
    pub(super) fn describe(&mut self, surface: &Surface, bsdf: &Bsdf, t: f32, before: f32) {
        let albedo = bsdf.albedo();
        if albedo.is_black() && !bsdf.straight_through(-self.ray.d).is_black() {
            return;
        }
        let albedo = match self.surface_layers {
            SurfaceLayers::First => albedo,
            SurfaceLayers::NonSpecular => {
                // What mirrors, glass and media transmit. Roulette may have raised it above one.
                let transmitted = self.throughput * self.eta_sq;
                (albedo * transmitted).map(|v| v.min(1.0))
            }
        };
        let depth = before - self.start_length + t;
        (self.sample.albedo, self.sample.normal, self.sample.depth) = (albedo, surface.ns(), depth);
        // A mirror stands for what it shows if the path ends before it reaches another surface.
        self.is_described = self.surface_layers == SurfaceLayers::First || !bsdf.is_delta();
    }

    /// The same for the surface ahead, which `hit` is on or behind. The path does not reach it, because a medium scatters it
    /// before.
    pub(super) fn describe_ahead(&mut self, hit: Hit) {
        let (mut ray, mut next) = (self.ray, Some(hit));
        while let Some(hit) = next {
            let surface = self.scene.surface(&ray, &hit);
            let bsdf = self.scene.bsdf(&surface, -ray.d, Transport::Radiance);
            self.describe(&surface, &bsdf, hit.t, self.length);
            if self.is_described || bsdf.straight_through(-ray.d).is_black() {
                return;
            }
            ray = self.scene.tree().beyond(&ray, hit.t);
            next = self.scene.closest(&ray);
        }
    }

    /// Whether the layers are filled in.
    pub fn is_described(&self) -> bool {
        self.is_described
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::film::Sample;
    use crate::geometry::{Geometry, Shape};
    use crate::material::Material;
    use crate::math::{Frame, Rgb};
    use crate::options::PathLimits;
    use crate::ray::Ray;
    use crate::sampler::Sampler;
    use crate::scene::{Scene, SceneParts};
    use crate::texture::Texture;

    /// The layers along a path that meets a sphere of radius 1 at a distance of 2. A wall of albedo 0.8 surrounds it at radius 10.
    fn layers(sphere: Material, surface_layers: SurfaceLayers, index: u32) -> Sample {
        let around_origin = |name, radius, material| {
            let axes = Frame::from_normal(Vec3::Z);
            Shape::new(name, Geometry::Sphere { center: Vec3::ZERO, radius, axes }, material)
        };
        let wall = Shape { flip_normals: true, ..around_origin("wall", 10.0, 0) };
        let shapes = vec![wall, around_origin("sphere", 1.0, 1)];
        let materials = vec![Material::Diffuse { reflectance: Texture::grey(0.8) }, sphere];
        let scene = Scene::new(SceneParts { shapes, materials, ..SceneParts::default() });
        let scene = scene.expect("a scene");
        let ray = Ray::new(3.0 * Vec3::Z, Vec3::NEG_Z);
        let mut walk = EyeWalk::new(&scene, PathLimits::default(), ray, Sampler::new(1, 0, index));
        walk.surface_layers = surface_layers;
        while let Some(v) = &walk.next_vertex() {
            if !walk.scatter(v) {
                break;
            }
        }
        walk.sample()
    }

    fn mirror() -> Material {
        let (eta, k) = (Rgb::BLACK, Rgb::WHITE);
        Material::Conductor { eta, k, reflectance: Texture::grey(0.5), roughness: None }
    }

    #[test]
    fn layers_describe_the_first_surface_or_what_a_mirror_shows() {
        let first = layers(mirror(), SurfaceLayers::First, 0);
        assert!((first.albedo.g - 0.5).abs() < 1e-6 && (first.depth - 2.0).abs() < 1e-5);
        assert!(first.normal.distance(Vec3::Z) < 1e-5);
        let behind = layers(mirror(), SurfaceLayers::NonSpecular, 0);
        assert!((behind.albedo.g - 0.5 * 0.8).abs() < 1e-6, "{behind:?}");
        assert!((behind.depth - (2.0 + 9.0)).abs() < 1e-4, "{behind:?}");
        assert!(behind.normal.distance(Vec3::NEG_Z) < 1e-5, "{behind:?}");
    }

    #[test]
    fn the_albedo_behind_clear_glass_is_that_of_the_wall() {
        let glass = || Material::Dielectric {
            eta: 1.5,
            reflectance: Texture::grey(1.0),
            transmittance: Texture::grey(1.0),
            roughness: None,
        };
        let (mut reflected, paths) = (0, 500);
        for index in 0..paths {
            let behind = layers(glass(), SurfaceLayers::NonSpecular, index);
            // Every path ends at the wall, whatever the index of refraction on its way.
            assert!((behind.albedo.g - 0.8).abs() < 1e-5, "{behind:?}");
            reflected += u32::from((behind.depth - 11.0).abs() < 1e-3);
        }
        // 4 % reflect at once. 3.5 standard deviations of the count.
        let expected = 0.04 * paths as f32;
        assert!((reflected as f32 - expected).abs() < 3.5 * expected.sqrt(), "{reflected}");
    }

    #[test]
    fn surfaces_that_the_eye_does_not_see_have_no_layers() {
        for surface_layers in [SurfaceLayers::First, SurfaceLayers::NonSpecular] {
            let wall = layers(Material::Null, surface_layers, 0);
            assert!((wall.albedo.g - 0.8).abs() < 1e-6, "{wall:?}");
            assert!((wall.depth - 13.0).abs() < 1e-4, "{wall:?}");
        }
    }

    #[test]
    fn a_mirror_that_shows_the_sky_is_described_itself() {
        let axes = Frame::from_normal(Vec3::Z);
        let sphere = Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes };
        let parts = SceneParts {
            shapes: vec![Shape::new("sphere", sphere, 0)],
            materials: vec![mirror()],
            ..SceneParts::default()
        };
        let scene = Scene::new(parts).expect("a scene");
        let ray = Ray::new(3.0 * Vec3::Z, Vec3::NEG_Z);
        let mut walk = EyeWalk::new(&scene, PathLimits::default(), ray, Sampler::new(1, 0, 0));
        walk.surface_layers = SurfaceLayers::NonSpecular;
        while let Some(v) = &walk.next_vertex() {
            if !walk.scatter(v) {
                break;
            }
        }
        let sample = walk.sample();
        assert!((sample.albedo.g - 0.5).abs() < 1e-6 && (sample.depth - 2.0).abs() < 1e-5);
        assert!(sample.normal.distance(Vec3::Z) < 1e-5);
    }
}
