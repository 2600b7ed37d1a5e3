//! Generates meshes, and writes them as binary PLY.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

/// Triangles with optional normals.
#[derive(Clone, Default)]
pub(crate) struct Mesh {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// One planar quadrilateral; its normal follows the right-hand rule around the corners.
    pub(crate) fn quad(corners: [Vec3; 4]) -> Self {
        Mesh {
            positions: corners.to_vec(),
            normals: Vec::new(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    /// An axis-aligned box, normals outward.
    pub(crate) fn cuboid(min: Vec3, max: Vec3) -> Self {
        let corner = |k: u32| {
            let pick =
                |bit: u32, axis: usize| if k >> bit & 1 == 0 { min[axis] } else { max[axis] };
            Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        };
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        faces.iter().fold(Mesh::default(), |m, f| m.with(&Mesh::quad(f.map(corner))))
    }

    /// A surface of revolution around the y axis. The profile lists (radius, height) from bottom to top. Normals point
    /// away from the axis; they are smooth where the profile turns by less than 40 degrees.
    pub(crate) fn lathe(profile: &[Vec2], segments: u32) -> Self {
        let mut mesh = Mesh::default();
        let out = |a: Vec2, b: Vec2| Vec2::new(b.y - a.y, a.x - b.x).normalize();
        let normals: Vec<Vec2> = profile.windows(2).map(|w| out(w[0], w[1])).collect();
        for (k, w) in profile.windows(2).enumerate() {
            let joined = |j: usize| {
                let near = normals.get(j).copied().filter(|n| n.dot(normals[k]) > 0.766);
                near.map_or(normals[k], |n| (n + normals[k]).normalize())
            };
            let (n0, n1) = (joined(k.wrapping_sub(1)), joined(k + 1));
            let base = mesh.positions.len() as u32;
            for s in 0..=segments {
                // The last column equals the first one exactly, so that the surface is closed.
                let (sin, cos) = (TAU * (s % segments) as f32 / segments as f32).sin_cos();
                for (p, n) in [(w[0], n0), (w[1], n1)] {
                    mesh.positions.push(Vec3::new(p.x * cos, p.y, p.x * sin));
                    mesh.normals.push(Vec3::new(n.x * cos, n.y, n.x * sin));
                }
            }
            for s in 0..segments {
                let i = base + 2 * s;
                mesh.triangles.push([i, i + 1, i + 3]);
                mesh.triangles.push([i, i + 3, i + 2]);
            }
        }
        mesh
    }

    /// The mesh with its faces turned toward the side of `n`.
    pub(crate) fn facing(mut self, n: Vec3) -> Self {
        for t in &mut self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            if (b - a).cross(c - a).dot(n) < 0.0 {
                t.swap(1, 2);
            }
        }
        self
    }

    /// A corner of a room: floor and two walls with side length 2 `size`.
    pub(crate) fn corner(size: f32) -> Self {
        let (s, h) = (size, 2.0 * size);
        let v = |x, y, z| Vec3::new(x, y, z);
        let floor = Mesh::quad([v(-s, 0.0, -s), v(-s, 0.0, s), v(s, 0.0, s), v(s, 0.0, -s)]);
        let back = Mesh::quad([v(-s, 0.0, -s), v(s, 0.0, -s), v(s, h, -s), v(-s, h, -s)]);
        let left = Mesh::quad([v(-s, 0.0, s), v(-s, 0.0, -s), v(-s, h, -s), v(-s, h, s)]);
        floor.with(&back).with(&left)
    }

    /// A ring around the y axis: `major` is the distance from the axis to the centre of the tube, `minor` the radius of
    /// the tube.
    pub(crate) fn torus(major: f32, minor: f32, [around, across]: [u32; 2]) -> Self {
        let vertex = |i: u32, j: u32| {
            let (sin_u, cos_u) = (TAU * i as f32 / around as f32).sin_cos();
            let (sin_v, cos_v) = (TAU * j as f32 / across as f32).sin_cos();
            let n = Vec3::new(cos_v * cos_u, sin_v, cos_v * sin_u);
            (Vec3::new(cos_u, 0.0, sin_u) * major + n * minor, n)
        };
        let mut mesh = Mesh::default();
        for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
            let (p, n) = vertex(i, j);
            mesh.positions.push(p);
            mesh.normals.push(n);
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        mesh
    }

    /// A height field over a square around the y axis with half side `half`, `n` cells per side, normals upward.
    pub(crate) fn height_field(half: f32, n: u32, height: impl Fn(f32, f32) -> f32) -> Self {
        let mut mesh = Mesh::default();
        let step = 2.0 * half / n as f32;
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let (x, z) = (i as f32 * step - half, j as f32 * step - half);
            let slope = |dx: f32, dz: f32| {
                (height(x + dx, z + dz) - height(x - dx, z - dz)) / (2.0 * (dx + dz))
            };
            let (d, y) = (1e-2 * step, height(x, z));
            mesh.positions.push(Vec3::new(x, y, z));
            mesh.normals.push(Vec3::new(-slope(d, 0.0), 1.0, -slope(0.0, d)).normalize());
            if i < n && j < n {
                let at = |i: u32, j: u32| i * (n + 1) + j;
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    /// The mesh rotated about the origin.
    pub(crate) fn turned(mut self, by: Quat) -> Self {
        self.positions.iter_mut().chain(&mut self.normals).for_each(|v| *v = by * *v);
        self
    }

    /// Both meshes as one. Both have normals, or neither.
    pub(crate) fn with(mut self, other: &Mesh) -> Self {
        let base = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
        self
    }

    /// The mesh moved.
    pub(crate) fn moved(mut self, by: Vec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p += by);
        self
    }

    /// Binary little-endian PLY.
    pub(crate) fn to_ply(&self) -> Vec<u8> {
        let with_normals = !self.normals.is_empty();
        let normal_lines = if with_normals {
            "property float nx\nproperty float ny\nproperty float nz\n"
        } else {
            ""
        };
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             {normal_lines}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len()
        )
        .into_bytes();
        for (i, p) in self.positions.iter().enumerate() {
            let normal = with_normals.then(|| self.normals[i]);
            for v in [Some(*p), normal].into_iter().flatten().flat_map(|v| v.to_array()) {
                bytes.extend(v.to_le_bytes());
            }
        }
        for t in &self.triangles {
            bytes.push(3);
            t.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        }
        bytes
    }
}
