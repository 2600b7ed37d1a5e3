//! Straight lines through many transparent surfaces.
//!
//! A path that passes straight through a surface continues on the same line. Its next ray starts again at the root of
//! the tree. Boxes of nested shells contain each other, so each of these rays visits all of them, and a path through n
//! shells would take time n^2. After a few crossings, one traversal therefore collects several hits, and each later
//! traversal four times as many: n crossings need about log n traversals.

use gi_bvh::Bvh;

use super::Scene;
use crate::ray::{Hit, Ray};

/// Number of crossings that are traced one by one. Most lines have fewer.
const FEW: u32 = 6;
/// Number of hits that a traversal collects at first, and at most.
const FIRST: usize = 32;
const LARGEST: usize = 1 << 16;
/// Factor by which each traversal collects more hits than the one before.
const GROWTH: usize = 4;
/// Most surfaces that light passes straight through before it scatters. Further light is lost.
pub const MOST_CROSSINGS: u32 = 1 << 16;

/// The surfaces that a path has passed straight through since it last changed its direction.
#[derive(Default)]
pub(crate) struct Line {
    crossed: u32,
    ahead: Option<Box<Ahead>>,
}

/// Hits that are known already.
struct Ahead {
    /// The ray that found them.
    ray: Ray,
    /// In reverse order.
    hits: Vec<Hit>,
    /// Number of hits that the traversal looked for.
    most: usize,
    /// Whether the ray has no other hits.
    complete: bool,
}

impl Line {
    /// The path changes its direction.
    #[inline(always)]
    pub(crate) fn turn(&mut self) {
        if self.crossed > 0 {
            *self = Line::default();
        }
    }

    /// The path passes straight through a surface. Returns whether it may continue.
    #[inline]
    pub(crate) fn cross(&mut self) -> bool {
        self.crossed += 1;
        self.crossed <= MOST_CROSSINGS
    }

    #[cold]
    fn next(&mut self, tree: &Bvh, ray: &Ray, tmax: f32) -> Option<Hit> {
        if self.ahead.as_ref().is_some_and(|ahead| ahead.ray.d != ray.d) {
            self.ahead = None;
        }
        let ahead = self.ahead.get_or_insert_with(|| Box::new(Ahead::along(tree, ray, FIRST)));
        loop {
            while let Some(hit) = ahead.hits.last() {
                let t = ahead.parameter(ray, hit.t);
                if t > tmax {
                    return None;
                }
                let hit = Hit { t, ..*hit };
                ahead.hits.pop();
                if t > ray.tmin {
                    return Some(hit);
                }
            }
            if ahead.complete {
                return None;
            }
            **ahead = Ahead::along(tree, ray, (GROWTH * ahead.most).min(LARGEST));
        }
    }
}

impl Ahead {
    fn along(tree: &Bvh, ray: &Ray, most: usize) -> Self {
        let (mut hits, complete) = tree.nearest(ray, most);
        hits.reverse();
        Ahead { ray: *ray, hits, most, complete }
    }

    /// The parameter on `ray` of the point at `t`. Both rays have the same direction.
    fn parameter(&self, ray: &Ray, t: f32) -> f32 {
        if ray.o == self.ray.o {
            return t;
        }
        (self.ray.at(t) - ray.o).dot(ray.d) / ray.d.length_squared()
    }
}

impl Scene {
    /// The first hit before `tmax` along `ray`, which continues `line`.
    #[inline(always)]
    pub(crate) fn closest_on(&self, line: &mut Line, ray: &Ray, tmax: f32) -> Option<Hit> {
        if line.crossed < FEW {
            // Copy the ray only if `tmax` differs. The ray was just computed, so store-to-load forwarding would fail for a copy.
            if tmax == ray.tmax {
                self.tree.closest(ray)
            } else {
                self.tree.closest(&Ray { tmax, ..*ray })
            }
        } else {
            line.next(&self.tree, ray, tmax)
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::{Geometry, Shape};
    use crate::light::LightSource;
    use crate::material::Material;
    use crate::math::{Frame, Rgb};
    use crate::sampler::Sampler;
    use crate::scene::SceneParts;
    use crate::texture::Texture;
    use crate::walk::{LightWalk, Roulette};

    /// Spheres around a point light, all of them masks of this opacity.
    fn shells(count: usize, opacity: f32) -> Scene {
        let axes = Frame::from_normal(Vec3::Z);
        let shell = |k: usize| {
            let radius = 1.0 + k as f32 / count as f32;
            Shape::new("shell", Geometry::Sphere { center: Vec3::ZERO, radius, axes }, 1)
        };
        let black = Material::Diffuse { reflectance: Texture::grey(0.0) };
        let mask = Material::Mask { opacity: Texture::grey(opacity), inner: 0 };
        let parts = SceneParts {
            shapes: (0..count).map(shell).collect(),
            materials: vec![black, mask],
            lights: vec![LightSource::Point { position: Vec3::ZERO, intensity: Rgb::WHITE }],
            ..SceneParts::default()
        };
        Scene::new(parts).expect("a scene")
    }

    #[test]
    fn light_through_many_shells_is_the_product_of_their_transmittances() {
        let d = Vec3::new(0.36, 0.48, 0.8);
        for count in [10, 100, 1000] {
            let scene = shells(count, 0.001);
            let found = scene.transmittance(Ray::new(Vec3::ZERO, d)).r;
            let expected = 0.999f32.powi(count as i32);
            assert!((found / expected - 1.0).abs() < 1e-4, "{count}: {found}, not {expected}");
        }
    }

    #[test]
    fn a_path_meets_every_shell_once_and_in_order() {
        let scene = shells(1000, 0.0);
        let mut walk = LightWalk::begin(&scene, Sampler::new(1, 0, 0)).expect("it shines");
        let (mut met, mut radius) = (0, 0.0);
        while let Some(vertex) = walk.next_vertex() {
            let here = vertex.surface.p.length();
            assert!(here > radius, "{here} after {radius}");
            assert_eq!(vertex.wo, -walk.emission().d, "it stays on its line");
            (met, radius) = (met + 1, here);
            if !walk.scatter(&vertex, Roulette::Off) {
                break;
            }
        }
        assert_eq!(met, 1000);
    }

    #[test]
    fn a_line_through_nested_shells_needs_few_traversals() {
        let scene = shells(16_000, 0.0);
        let mut ray = Ray::new(Vec3::ZERO, Vec3::new(0.36, 0.48, 0.8));
        let (mut line, mut met) = (Line::default(), 0);
        while let Some(hit) = scene.closest_on(&mut line, &ray, ray.tmax) {
            assert!(line.cross());
            ray = scene.tree().beyond(&ray, hit.t);
            met += 1;
        }
        assert_eq!(met, 16_000);
        // The number of hits that the last traversal looked for tells how many traversals there were.
        let traversals = (line.ahead.expect("many hits").most / FIRST).ilog(GROWTH) + 1;
        assert!(traversals <= 6, "{traversals}");
    }
}
