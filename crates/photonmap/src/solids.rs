//! Solid bodies of a translucent medium: which media fill them, and which surfaces bound the same one.

use gi_core::medium::MediumId;
use std::collections::HashMap;

use gi_core::geometry::{Geometry, Shape};
use gi_core::scene::Scene;
use glam::Vec3;

/// Corners closer than this, in units of the largest coordinate, are one corner.
const SAME_CORNER: f32 = 1e-6;
/// A disk is the lid of a cylinder if it fits to this, in units of the cylinder's radius.
const SAME_RIM: f32 = 1e-3;

/// Which media of a scene fill solid bodies: those whose boundaries all refract.
pub(crate) struct Solids {
    /// By medium: whether only refracting surfaces bound it.
    solid: Vec<bool>,
    /// By medium: whether it contains lights.
    lit: Vec<bool>,
}

impl Solids {
    /// Find the media that fill solid bodies.
    pub(crate) fn of(scene: &Scene) -> Self {
        let media = scene.media();
        let is_it =
            |m: usize, side: Option<MediumId>| side.is_some_and(|s| media[s.index()] == media[m]);
        let bounds = |shape: &Shape, m| is_it(m, shape.interior) || is_it(m, shape.exterior);
        let lights = 0..scene.lights().all().len();
        let lit = (0..media.len())
            .map(|m| lights.clone().any(|light| is_it(m, scene.medium_round_light(light))));
        let solid = (0..media.len()).map(|m| {
            let mut boundaries = scene.shapes().iter().filter(|shape| bounds(shape, m)).peekable();
            boundaries.peek().is_some() && boundaries.all(|shape| scene.refracts(shape.material))
        });
        Solids { solid: solid.collect(), lit: lit.collect() }
    }

    /// Whether a medium fills solid bodies only, and no point of it is reached by light straight from a light.
    pub(crate) fn is_dark(&self, medium: MediumId) -> bool {
        self.solid[medium.index()] && !self.lit[medium.index()]
    }
}

/// Which boundaries of media belong to one body.
///
/// Triangles that share a corner, to rounding, bound one body. So do cylinders and the disks that are their lids. Every other
/// boundary counts as a body of its own: a cavity in a body, for instance, and all copies of an instanced body together.
pub(crate) struct Bodies {
    /// By primitive: the number of the body, that of its first primitive.
    body_of: Vec<u32>,
}

impl Bodies {
    /// Find which boundaries are connected.
    pub(crate) fn of(scene: &Scene) -> Self {
        let shapes = scene.shapes();
        let count: usize = shapes.iter().map(|shape| shape.geometry.primitive_count()).sum();
        let mut joined = Joined::new(count);
        let mut at: HashMap<[i64; 3], u32> = HashMap::new();
        let boundaries: Vec<usize> =
            (0..shapes.len()).filter(|&k| shapes[k].is_boundary()).collect();
        let meshes = boundaries.iter().filter_map(|&k| match &shapes[k].geometry {
            Geometry::Mesh(mesh) => Some((scene.first_primitive(k), mesh)),
            _ => None,
        });
        let largest = meshes.clone().fold(0.0f32, |largest, (_, mesh)| {
            mesh.positions.iter().fold(largest, |most, p| most.max(p.abs().max_element()))
        });
        let reach = (SAME_CORNER * largest).max(f32::MIN_POSITIVE);
        for (first, mesh) in meshes {
            for triangle in 0..mesh.triangles.len() {
                let prim = first + triangle as u32;
                for cell in mesh.corners(triangle).into_iter().flat_map(|p| cells(p, reach)) {
                    joined.join(*at.entry(cell).or_insert(prim), prim);
                }
            }
        }
        for &k in &boundaries {
            let Geometry::Cylinder { p0, p1, radius } = shapes[k].geometry else { continue };
            for &lid in &boundaries {
                let Geometry::Disk { center, du, .. } = shapes[lid].geometry else { continue };
                let near = |p: Vec3| p.distance(center) < SAME_RIM * radius;
                if (near(p0) || near(p1)) && (du.length() - radius).abs() < SAME_RIM * radius {
                    joined.join(scene.first_primitive(k), scene.first_primitive(lid));
                }
            }
        }
        Bodies { body_of: (0..count as u32).map(|prim| joined.first(prim)).collect() }
    }

    /// The body that a primitive bounds.
    pub(crate) fn body(&self, prim: u32) -> u32 {
        self.body_of[prim as usize]
    }
}

/// The grid cells, four times as wide as `reach`, that overlap the cube of half width `reach` around a point. Mostly one.
fn cells(p: Vec3, reach: f32) -> impl Iterator<Item = [i64; 3]> {
    let cell = |x: f32| (f64::from(x) / f64::from(4.0 * reach)).floor() as i64;
    let [low, high] = [p - reach, p + reach].map(|q| q.to_array().map(cell));
    (low[0]..=high[0]).flat_map(move |x| {
        (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
    })
}

/// Disjoint sets. Each is known by its smallest member.
struct Joined(Vec<u32>);

impl Joined {
    fn new(count: usize) -> Self {
        Joined((0..count as u32).collect())
    }

    fn first(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            // Path halving: later calls take fewer steps.
            self.0[k as usize] = self.0[self.0[k as usize] as usize];
            k = self.0[k as usize];
        }
        k
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::geometry::Mesh;
    use gi_core::material::Material;
    use gi_core::math::Rgb;
    use gi_core::medium::{Medium, Phase};
    use gi_core::scene::SceneParts;
    use gi_core::texture::Texture;

    /// Some faces of a tetrahedron with its first corner at `p`.
    fn tetrahedron(p: Vec3, faces: &[[u32; 3]]) -> Mesh {
        let positions = vec![p, p + Vec3::X, p + Vec3::Y, p + Vec3::Z];
        Mesh { positions, triangles: faces.to_vec().into(), ..Mesh::default() }
    }

    #[test]
    fn surfaces_that_share_corners_bound_one_body_and_null_ones_bound_none() {
        let glass = Material::Dielectric {
            eta: 1.5,
            reflectance: Texture::grey(1.0),
            transmittance: Texture::grey(1.0),
            roughness: None,
        };
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2]];
        let boundary = |geometry, material, inside| Shape {
            interior: Some(MediumId::new(inside)),
            ..Shape::new("boundary", geometry, material)
        };
        // One mesh of two bodies, the lid of one of them as a shape of its own, and a cloud.
        let mut two = tetrahedron(Vec3::ZERO, &sides);
        let far = tetrahedron(Vec3::splat(5.0), &sides);
        two.triangles.extend(far.triangles.iter().map(|t| t.map(|i| i + 4)));
        two.positions.extend(far.positions);
        let lid = tetrahedron(Vec3::splat(5.000_002), &[[1, 2, 3]]);
        let cloud = tetrahedron(Vec3::splat(-5.0), &sides);
        let grey = |s| Medium::homogeneous(Rgb::grey(s), Rgb::grey(0.5), Phase::Isotropic);
        // A cylinder, of which one lid fits and one is too small.
        let (p0, p1) = (Vec3::Z * 9.0, Vec3::new(1.0, 2.0, 9.0));
        let (du, dv) = (p1 - p0).normalize().any_orthonormal_pair();
        let disk = |center, r| Geometry::Disk { center, du: du * r, dv: dv * r };
        let round = [Geometry::Cylinder { p0, p1, radius: 0.5 }, disk(p1, 0.5), disk(p0, 0.4)];
        let mut shapes = vec![
            boundary(Geometry::Mesh(two), 0, 0),
            boundary(Geometry::Mesh(lid), 0, 0),
            boundary(Geometry::Mesh(cloud), 1, 1),
        ];
        shapes.extend(round.map(|geometry| boundary(geometry, 0, 0)));
        let parts = SceneParts {
            shapes,
            materials: vec![glass, Material::Null],
            media: vec![grey(1.0), grey(2.0), grey(3.0)],
            ..SceneParts::default()
        };
        let scene = Scene::new(parts).expect("a scene");
        let solids = Solids::of(&scene);
        assert_eq!(solids.solid, [true, false, false]);
        assert!(solids.is_dark(MediumId::new(0)) && !solids.is_dark(MediumId::new(1)));
        let found = Bodies::of(&scene);
        let bodies: Vec<u32> = (0..13).map(|prim| found.body(prim)).collect();
        assert_eq!(bodies, [0, 0, 0, 3, 3, 3, 3, 7, 7, 7, 10, 10, 12]);
    }
}
