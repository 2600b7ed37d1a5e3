//! Generated meshes, and the rays that a path tracer would trace through them.

use std::collections::HashMap;
use std::f32::consts::TAU;

use gi_bvh::ray::Ray;
use gi_bvh::{Bvh, Triangle};
use glam::{Mat3, Vec3};

use crate::random::Pcg;

/// Vertices and faces.
#[derive(Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// A closed box with shared corners.
    fn cuboid(min: Vec3, max: Vec3) -> Mesh {
        let pick = |k: usize, axis: usize| if k >> axis & 1 == 1 { max[axis] } else { min[axis] };
        let vertices = (0..8).map(|k| Vec3::new(pick(k, 0), pick(k, 1), pick(k, 2))).collect();
        let quads =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        Mesh { vertices, faces }
    }

    /// The unit sphere: an octahedron, each triangle subdivided in four `levels` times.
    fn sphere(levels: u32) -> Mesh {
        let vertices = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let faces = vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ];
        let mut mesh = Mesh { vertices, faces };
        for _ in 0..levels {
            mesh.subdivide();
        }
        mesh.map(Vec3::normalize)
    }

    /// The icosphere with 20 * 4^levels triangles.
    fn icosphere(levels: u32) -> Mesh {
        let t = (1.0 + 5f32.sqrt()) / 2.0;
        let plane = |f: fn(f32, f32) -> Vec3| [f(-1.0, t), f(1.0, t), f(-1.0, -t), f(1.0, -t)];
        let [xy, yz] = [plane(|a, b| Vec3::new(a, b, 0.0)), plane(|a, b| Vec3::new(0.0, a, b))];
        let zx = [
            Vec3::new(t, 0.0, -1.0),
            Vec3::new(t, 0.0, 1.0),
            Vec3::new(-t, 0.0, -1.0),
            Vec3::new(-t, 0.0, 1.0),
        ];
        let faces = vec![
            [0, 11, 5],
            [0, 5, 1],
            [0, 1, 7],
            [0, 7, 10],
            [0, 10, 11],
            [1, 5, 9],
            [5, 11, 4],
            [11, 10, 2],
            [10, 7, 6],
            [7, 1, 8],
            [3, 9, 4],
            [3, 4, 2],
            [3, 2, 6],
            [3, 6, 8],
            [3, 8, 9],
            [4, 9, 5],
            [2, 4, 11],
            [6, 2, 10],
            [8, 6, 7],
            [9, 8, 1],
        ];
        let mut mesh = Mesh { vertices: [xy, yz, zx].concat(), faces }.map(Vec3::normalize);
        for _ in 0..levels {
            mesh.subdivide();
            mesh = mesh.map(Vec3::normalize);
        }
        mesh
    }

    /// A closed cylinder from 0 to `height` along y.
    fn cylinder(radius: f32, height: f32, sides: u32) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..sides {
            let (s, c) = (i as f32 / sides as f32 * TAU).sin_cos();
            mesh.vertices.extend([
                Vec3::new(radius * c, 0.0, radius * s),
                Vec3::new(radius * c, height, radius * s),
            ]);
        }
        mesh.vertices.extend([Vec3::ZERO, Vec3::Y * height]);
        for i in 0..sides {
            let (a, b, n) = (2 * i, 2 * ((i + 1) % sides), 2 * sides);
            mesh.faces.extend([[a, a + 1, b + 1], [a, b + 1, b], [a, b, n], [a + 1, n + 1, b + 1]]);
        }
        mesh
    }

    fn subdivide(&mut self) {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32, vertices: &mut Vec<Vec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]) * 0.5);
                vertices.len() as u32 - 1
            })
        };
        let old = std::mem::take(&mut self.faces);
        for t in old {
            let v = &mut self.vertices;
            let (a, b, c) = (middle(t[0], t[1], v), middle(t[1], t[2], v), middle(t[2], t[0], v));
            self.faces.extend([[t[0], a, c], [a, t[1], b], [c, b, t[2]], [a, b, c]]);
        }
    }

    fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Mesh {
        self.vertices.iter_mut().for_each(|p| *p = f(*p));
        self
    }

    fn add(&mut self, other: Mesh) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        self.faces.extend(other.faces.iter().map(|t| t.map(|i| i + base)));
    }

    pub(crate) fn triangles(&self) -> Vec<Triangle> {
        let corner = |i: u32| self.vertices[i as usize];
        (0..).zip(&self.faces).map(|(id, f)| Triangle { v: f.map(corner), id }).collect()
    }
}

/// A mesh, a camera inside it, and a square light.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    eye: Vec3,
    at: Vec3,
    light: [Vec3; 3],
}

const NAMES: [&str; 4] = ["cave", "clutter", "blob", "cornell"];

/// The scenes whose name contains `filter`.
pub(crate) fn scenes(filter: &str) -> impl Iterator<Item = Scene> {
    NAMES.into_iter().filter(move |n| n.contains(filter)).map(scene)
}

fn scene(name: &'static str) -> Scene {
    let mut mesh = Mesh::cuboid(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0));
    let light = [Vec3::new(-0.3, 1.999, -0.3), Vec3::X * 0.6, Vec3::Z * 0.6];
    let eye = Vec3::new(0.05, 1.5, 0.95);
    match name {
        "cave" => {
            let light = [Vec3::new(-0.15, 0.6, -0.15), Vec3::X * 0.3, Vec3::Z * 0.3];
            let mesh = Mesh::icosphere(8).map(|p| p * (1.0 + rock(p)));
            Scene {
                name,
                mesh,
                eye: Vec3::new(0.0, 0.05, 0.1),
                at: Vec3::new(0.3, 0.0, -1.0),
                light,
            }
        }
        "clutter" => {
            add_clutter(&mut mesh);
            Scene { name, mesh, eye, at: Vec3::Y * 0.7, light }
        }
        "blob" => {
            let blob =
                |p: Vec3| p * (0.45 + 0.1 * noise(p, 4.0) + 0.02 * noise(p, 13.0)) + Vec3::Y * 0.62;
            mesh.add(Mesh::icosphere(6).map(blob));
            Scene { name, mesh, eye: Vec3::new(0.1, 1.1, 0.97), at: Vec3::Y * 0.7, light }
        }
        _ => {
            for (x, z, height, angle) in [(-0.35, -0.3, 1.2, 0.3), (0.35, 0.3, 0.6, -0.3)] {
                let block = Mesh::cuboid(Vec3::new(-0.3, 0.0, -0.3), Vec3::new(0.3, height, 0.3));
                let turn = Mat3::from_rotation_y(angle);
                mesh.add(block.map(|p| turn * p + Vec3::new(x, 0.001, z)));
            }
            Scene { name, mesh, eye: Vec3::new(0.0, 1.0, 0.97), at: Vec3::Y * 0.95, light }
        }
    }
}

/// Smooth waves that look irregular.
fn noise(p: Vec3, f: f32) -> f32 {
    let waves = (p.x * f + 1.3).sin() * (p.y * f * 1.1 + 0.7).cos()
        + (p.y * f * 0.9 + 2.1).sin() * (p.z * f * 1.2).cos()
        + (p.z * f + 0.2).sin() * (p.x * f * 1.05 - 1.0).cos();
    waves / 3.0
}

fn rock(p: Vec3) -> f32 {
    0.25 * noise(p, 3.0) + 0.12 * noise(p, 9.0) + 0.05 * noise(p, 31.0) + 0.02 * noise(p, 101.0)
}

/// 2400 thin boxes, cylinders and spheres, half of them rotated at random: long thin triangles.
fn add_clutter(mesh: &mut Mesh) {
    let mut rng = Pcg::new(7, 0);
    for i in 0..2400 {
        let turn = if i % 2 == 0 { Mat3::IDENTITY } else { random_rotation(&mut rng) };
        let [x, z] = rng.next_2d().map(|u| u * 1.9 - 0.95);
        let at = Vec3::new(x, rng.next_f32() * rng.next_f32() * 1.9, z);
        let size = 0.15 + 0.6 * rng.next_f32() * rng.next_f32();
        let thing = match i % 6 {
            0..=2 => Mesh::cuboid(Vec3::new(-0.5, -0.01, -0.03), Vec3::new(0.5, 0.01, 0.03)),
            3 => Mesh::cylinder(0.015, 1.0, 32),
            4 => Mesh::cylinder(0.1, 0.3, 64),
            _ => Mesh::sphere(3).map(|p| p * 0.12),
        };
        let (low, high) = (Vec3::new(-0.99, 0.005, -0.99), Vec3::new(0.99, 1.98, 0.99));
        mesh.add(thing.map(|p| (turn * (p * size) + at).clamp(low, high)));
    }
}

fn random_rotation(rng: &mut Pcg) -> Mat3 {
    let direction = on_sphere(rng);
    Mat3::from_axis_angle(direction, rng.next_f32() * TAU)
}

fn on_sphere(rng: &mut Pcg) -> Vec3 {
    let z = 2.0 * rng.next_f32() - 1.0;
    let (s, c) = (rng.next_f32() * TAU).sin_cos();
    Vec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
}

/// Three sets of rays of equal size.
pub(crate) struct Rays {
    /// From the eye, in scanline order.
    pub(crate) primary: Vec<Ray>,
    /// Three cosine-distributed bounces per path, in path order.
    pub(crate) bounce: Vec<Ray>,
    /// From the hit points to the light.
    pub(crate) shadow: Vec<Ray>,
}

/// The rays of a small path tracer; about `count` in each set.
pub(crate) fn rays(scene: &Scene, bvh: &Bvh, count: usize) -> Rays {
    let width = (count as f64).sqrt() as usize;
    let mut rng = Pcg::new(3, 0);
    let primary = primary_rays(scene, width, &mut rng);
    let triangles = scene.mesh.triangles();
    let (mut bounce, mut shadow) = (Vec::new(), Vec::new());
    let mut pixel = 0;
    while bounce.len() < primary.len() || shadow.len() < primary.len() {
        let mut ray = primary[pixel % primary.len()];
        pixel += 3;
        for _ in 0..3 {
            let Some(hit) = bvh.closest(&ray) else { break };
            let [a, b, c] = triangles[hit.prim as usize].v;
            let ng = (b - a).cross(c - a).normalize_or_zero();
            if ng == Vec3::ZERO {
                break;
            }
            let ng = if ng.dot(ray.d) > 0.0 { -ng } else { ng };
            let p = a + (b - a) * hit.u + (c - a) * hit.v;
            let [x, y] = rng.next_2d();
            let to_light =
                bvh.shadow_ray(p, ng, scene.light[0] + scene.light[1] * x + scene.light[2] * y);
            if to_light.d.dot(ng) > 0.0 {
                shadow.push(to_light);
            }
            let [x, y] = rng.next_2d();
            let (s, c) = (y * TAU).sin_cos();
            let (side, up) = ng.any_orthonormal_pair();
            let d = side * (x.sqrt() * c) + up * (x.sqrt() * s) + ng * (1.0 - x).sqrt();
            ray = Ray::new(bvh.offset_origin(p, ng, d), d);
            bounce.push(ray);
        }
    }
    bounce.truncate(primary.len());
    shadow.truncate(primary.len());
    Rays { primary, bounce, shadow }
}

fn primary_rays(scene: &Scene, width: usize, rng: &mut Pcg) -> Vec<Ray> {
    let forward = (scene.at - scene.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize() * 0.7;
    let up = right.cross(forward);
    let mut rays = Vec::with_capacity(width * width);
    for y in 0..width {
        for x in 0..width {
            let on_screen = |k: usize, u: f32| (k as f32 + u) / width as f32 * 2.0 - 1.0;
            let [u, v] = rng.next_2d();
            let d = forward + right * on_screen(x, u) - up * on_screen(y, v);
            rays.push(Ray::new(scene.eye, d.normalize()));
        }
    }
    rays
}
