//! The part of a disc on a surface that is visible from just above its centre.
//!
//! A density estimate divides the light on a disc by its area. At the edge of a surface a part of the disc lies in the
//! air, and behind a thin wall a part belongs to another room. Photons there must not count, and the area must exclude
//! the same part.

use glam::Vec3;

use crate::bsdf::Transport;
use crate::math::Frame;
use crate::ray::Ray;
use crate::scene::Scene;
use crate::warp;

/// Height of the viewpoint above the surface, in radii of the disc. Lower obstacles do not hide photons, and a surface
/// whose curvature stays below this height counts as one surface.
const HEIGHT: f32 = 0.25;
/// Largest depth of the surface below the disc, in radii.
const DEPTH: f32 = 0.5;
/// Smallest height, in units of the offset of ray origins.
const LEAST_LIFTS: f32 = 16.0;
/// [`Disc::inverse_share`] makes this many runs after a failed trial, each with at most this many trials.
const RUNS: u32 = 4;
const MOST_TRIALS: u32 = 20;
/// Maximum number of transparent sheets that a probe passes.
const MOST_SHEETS: u32 = 16;

/// A disc on a surface.
#[derive(Clone, Copy)]
pub struct Disc<'a> {
    scene: &'a Scene,
    p: Vec3,
    frame: Frame,
    radius: f32,
    /// Smallest cosine between the disc's normal and that of a surface that belongs to it.
    min_cos: f32,
    height: f32,
    /// Offset of ray origins from a surface.
    lift: f32,
}

impl<'a> Disc<'a> {
    /// The disc of `radius` around the surface point `p`, seen from the side of the unit normal `n`. A surface belongs
    /// to it if the cosine between the normals is at least `min_cos`.
    pub fn new(scene: &'a Scene, p: Vec3, n: Vec3, radius: f32, min_cos: f32) -> Self {
        let lift = scene.tree().offset_origin(p, n, n).distance(p);
        let height = (HEIGHT * radius).max(LEAST_LIFTS * lift);
        Disc { scene, p, frame: Frame::from_normal(n), radius, min_cos, height, lift }
    }

    /// The same, with the viewpoint lowered to half the height of the nearest obstacle above.
    pub fn lowered(self) -> Self {
        let n = self.frame.n;
        let o = self.scene.tree().offset_origin(self.p, n, n);
        let up = Ray { o, tmin: 0.0, d: n, tmax: self.height };
        let height = self.scene.closest(&up).map_or(self.height, |hit| 0.5 * hit.t);
        Disc { height, ..self }
    }

    /// Whether nothing stands between the viewpoint and the point `q` of a surface.
    #[inline]
    pub fn sees(&self, q: Vec3) -> bool {
        let o = self.p + self.frame.n * self.height;
        let sight = Ray { o, tmin: 0.0, d: q + self.frame.n * self.lift - o, tmax: 1.0 };
        !self.scene.transmittance(sight).is_black()
    }

    /// Whether a random point of the disc (`u` uniform) lies on a visible surface that belongs to it.
    pub fn meets(&self, u: [f32; 2]) -> bool {
        let q = warp::disk(u) * self.radius;
        let above = self.p + self.frame.to_world(Vec3::new(q.x, q.y, self.height));
        self.below(above).is_some_and(|q| self.sees(q))
    }

    /// The surface point of the disc below a point above it.
    fn below(&self, above: Vec3) -> Option<Vec3> {
        let n = self.frame.n;
        let depth = self.height + DEPTH * self.radius;
        let mut ray = Ray { o: above, tmin: 0.0, d: -n, tmax: depth };
        for _ in 0..MOST_SHEETS {
            let (surface, t) = self.scene.intersect(&ray)?;
            if surface.ng.dot(n).abs() >= self.min_cos {
                return Some(surface.p);
            }
            // A transparent sheet across the disc hides nothing.
            let bsdf = self.scene.bsdf(&surface, n, Transport::Radiance);
            if bsdf.straight_through(n).is_black() {
                return None;
            }
            ray = self.scene.tree().beyond(&ray, t);
        }
        None
    }

    /// Fraction of the disc that lies on visible surfaces, from `count` evenly spaced probes; `offset` shifts them.
    pub fn share(&self, count: u32, offset: [f32; 2]) -> f32 {
        // A golden-ratio lattice.
        let u = |i: u32| {
            let lattice = [(i as f32 + 0.5) / count as f32, i as f32 * 0.618_034];
            [0, 1].map(|k| (lattice[k] + offset[k]).fract())
        };
        (0..count).filter(|i| self.meets(u(*i))).count() as f32 / count as f32
    }

    /// An unbiased estimate of one over the visible fraction of the disc: the number of random points until one is
    /// visible has that mean. A fully visible disc needs one trial. `u` gives uniform points.
    pub fn inverse_share(&self, mut u: impl FnMut() -> [f32; 2]) -> f32 {
        let first = u();
        if self.meets(first) {
            return 1.0;
        }
        let disc = self.lowered();
        if disc.meets(first) {
            return 1.0;
        }
        let mut run = || 1 + (1..MOST_TRIALS).take_while(|_| !disc.meets(u())).count();
        1.0 + (0..RUNS).map(|_| run()).sum::<usize>() as f32 / RUNS as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Mesh, Shape};
    use crate::material::Material;
    use crate::rng::Pcg;
    use crate::scene::SceneParts;
    use crate::texture::Texture;

    fn mesh(corners: [[f32; 3]; 4]) -> Geometry {
        let positions = corners.map(Vec3::from_array).to_vec();
        Geometry::Mesh(Mesh {
            positions,
            triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
            ..Mesh::default()
        })
    }

    /// A floor from -1 to 1. Above the line x = 0.05 stands a wall of the given material, which may be transparent.
    fn scene(wall: Material) -> Scene {
        let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
        let across = [[0.05, 0.0, -1.0], [0.05, 0.0, 1.0], [0.05, 1.0, 1.0], [0.05, 1.0, -1.0]];
        let shapes = vec![Shape::new("floor", mesh(floor), 0), Shape::new("wall", mesh(across), 1)];
        let materials = vec![Material::Diffuse { reflectance: Texture::grey(0.5) }, wall];
        Scene::new(SceneParts { shapes, materials, ..SceneParts::default() }).expect("a scene")
    }

    /// Fraction of a disc of radius 1 on one side of a chord at distance `h` from its centre, the side with the centre.
    fn beside_chord(h: f32) -> f32 {
        1.0 - (h.acos() - h * (1.0 - h * h).sqrt()) / std::f32::consts::PI
    }

    #[test]
    fn parts_beyond_an_edge_or_behind_a_wall_are_excluded() {
        let diffuse = Material::Diffuse { reflectance: Texture::grey(0.5) };
        let scenes = [scene(diffuse), scene(Material::Null)];
        let mut rng = Pcg::new(3, 1);
        let at = |x: f32, z: f32| Vec3::new(x, 0.0, z);
        for (name, scene, p, expected) in [
            ("in the middle", &scenes[0], at(0.5, 0.0), 1.0),
            ("at an edge", &scenes[0], at(-0.92, 0.0), beside_chord(0.8)),
            ("at a wall", &scenes[0], at(0.03, 0.0), beside_chord(0.2)),
            ("at a sheet that lets light pass", &scenes[1], at(0.03, 0.0), 1.0),
        ] {
            let disc = Disc::new(scene, p, Vec3::Y, 0.1, 0.5);
            let share = disc.share(256, rng.next_2d());
            assert!((share - expected).abs() < 0.02, "{name}: {share} is not {expected}");
            let (mut sum, mut square, n) = (0.0, 0.0, 4000.0);
            for _ in 0..4000 {
                let inverse = f64::from(disc.inverse_share(|| rng.next_2d()));
                sum += inverse;
                square += inverse * inverse;
            }
            let (mean, expected) = (sum / n, 1.0 / f64::from(expected));
            let error = ((square / n - mean * mean) / n).sqrt();
            assert!((mean - expected).abs() < 4.0 * error + 1e-9, "{name}: {mean} +- {error}");
        }
        let disc = Disc::new(&scenes[0], at(0.0, 0.0), Vec3::Y, 0.2, 0.5);
        assert!(disc.sees(at(-0.1, 0.0)) && !disc.sees(at(0.1, 0.0)));
    }

    #[test]
    fn an_obstacle_close_above_lowers_the_viewpoint() {
        let shelf = [[-1.0, 0.01, -1.0], [-1.0, 0.01, 1.0], [0.5, 0.01, 1.0], [0.5, 0.01, -1.0]];
        let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
        let shapes = [floor, shelf].map(|m| Shape::new("square", mesh(m), 0)).to_vec();
        let materials = vec![Material::Diffuse { reflectance: Texture::grey(0.5) }];
        let scene = Scene::new(SceneParts { shapes, materials, ..SceneParts::default() });
        let scene = scene.expect("a scene");
        let disc = Disc::new(&scene, Vec3::ZERO, Vec3::Y, 0.2, 0.5);
        let beside = Vec3::new(0.1, 0.0, 0.0);
        assert!(!disc.sees(beside) && disc.lowered().sees(beside));
        assert_eq!(disc.lowered().share(64, [0.5; 2]), 1.0);
        assert!(!disc.lowered().sees(Vec3::new(0.1, 0.01, 0.0) + Vec3::Y * 1e-3));
    }
}
