//! Warnings about the media of a scene.

use crate::medium::MediumId;
use std::collections::{BTreeSet, HashMap};

use glam::Vec3;

use super::Scene;
use crate::geometry::{Geometry, Shape, Surface};
use crate::medium::{Medium, first_equal};
use crate::ray::Ray;

/// Number of points per boundary from which its neighbours are searched.
const POINTS: usize = 64;

/// A point of a boundary and its normal there.
type Post = (Vec3, Vec3);

impl Scene {
    /// One warning per problem: boundaries that are not closed, and neighbouring boundaries that disagree about the
    /// medium between them, for example because media overlap.
    pub fn media_warnings(&self) -> Vec<String> {
        if !self.has_media {
            return Vec::new();
        }
        let mut warnings = Vec::new();
        for medium in (0..self.media.len())
            .map(MediumId::new)
            .filter(|&id| first_equal(&self.media, id) == id)
        {
            warnings.extend(self.open_boundary(self.medium(medium)));
        }
        warnings.extend(self.disagreements());
        warnings
    }

    /// A warning if the boundaries of a medium, taken together, have edges where an odd number of triangles meet.
    fn open_boundary(&self, medium: &Medium) -> Option<String> {
        let is_it = |side: Option<MediumId>| side.is_some_and(|m| self.medium(m) == medium);
        let bounds = |s: &&Shape| is_it(s.interior) || is_it(s.exterior);
        let mut edges: HashMap<[[u32; 3]; 2], (u32, &str)> = HashMap::new();
        for shape in self.shapes.iter().filter(bounds) {
            match &shape.geometry {
                Geometry::Mesh(mesh) => {
                    for k in 0..mesh.triangles.len() {
                        count_edges(mesh.corners(k), &shape.name, &mut edges);
                    }
                }
                Geometry::Sphere { .. } => {}
                // These have curved rims that no mesh fits exactly, so it is unknown whether they are closed.
                Geometry::Disk { .. } | Geometry::Cylinder { .. } => return None,
            }
        }
        let open: BTreeSet<&str> =
            edges.values().filter(|(count, _)| count % 2 == 1).map(|(_, name)| *name).collect();
        let names = listed(open.into_iter())?;
        Some(format!(
            "a medium's boundary is not closed at {names}: a path is in the medium from where it crosses the boundary \
             inward to where it crosses one outward, and never comes in where the boundary is open"
        ))
    }

    /// Warnings about boundaries that face each other and disagree, and about media without an end.
    fn disagreements(&self) -> Vec<String> {
        let (mut pairs, mut endless) = (BTreeSet::new(), BTreeSet::new());
        let own = self.shapes.len() - self.group_shapes.iter().map(|g| g.len()).sum::<usize>();
        for shape in self.shapes[..own].iter().filter(|s| s.is_boundary()) {
            // Shading normals may flip the normal, so take it from a hit.
            for surface in posts(shape).into_iter().filter_map(|(p, n)| self.surface_at(p, n)) {
                for d in [surface.ng, -surface.ng] {
                    let here = self.medium_beside(&surface, d);
                    let ray = self.spawn(&surface, d);
                    if let Some(other) = self.first_boundary(ray, false) {
                        if self.medium_beside(&other, -d) != here {
                            let name = self.shapes[other.shape as usize].name.as_str();
                            let own = shape.name.as_str();
                            pairs.insert([own.min(name), own.max(name)]);
                        }
                    } else if here.is_some() && self.closest(&ray).is_none() {
                        endless.insert(shape.name.as_str());
                    }
                }
            }
        }
        let say = |[a, b]: [&str; 2]| {
            format!(
                "boundaries \"{a}\" and \"{b}\" do not name the same medium for the space between them: each counts where it \
                 is crossed (give a solid inside a medium that medium as its `exterior`)"
            )
        };
        let endless = listed(endless.into_iter()).map(|names| {
            format!("the medium at {names} is unbounded on one side: it is treated as infinite")
        });
        pairs.into_iter().map(say).chain(endless).collect()
    }

    /// The medium that a boundary names for its side toward `d`.
    fn medium_beside(&self, surface: &Surface, d: Vec3) -> Option<&Medium> {
        self.medium_toward(surface, d, None).map(|m| self.medium(m))
    }

    /// The surface at a point of a boundary, hit by a ray from slightly above.
    fn surface_at(&self, p: Vec3, n: Vec3) -> Option<Surface> {
        let gap = 1e-4 * self.radius();
        let ray = Ray { tmax: 2.0 * gap, ..Ray::new(p + n * gap, -n) };
        let (surface, _) = self.intersect(&ray)?;
        self.shapes[surface.shape as usize].is_boundary().then_some(surface)
    }
}

/// Count the edges of a triangle. Points with equal coordinates are the same.
fn count_edges<'a>(
    corners: [Vec3; 3],
    name: &'a str,
    edges: &mut HashMap<[[u32; 3]; 2], (u32, &'a str)>,
) {
    // -0 and 0 are the same coordinate.
    let bits = corners.map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
    for k in 0..3 {
        let mut edge = [bits[k], bits[(k + 1) % 3]];
        edge.sort_unstable();
        // Skip edges without length, which fans at a pole have.
        if edge[0] != edge[1] {
            edges.entry(edge).or_insert((0, name)).0 += 1;
        }
    }
}

/// Whether shapes, taken together, have no open edge.
pub(super) fn is_closed<'s>(shapes: impl Iterator<Item = &'s Shape>) -> bool {
    let mut edges: HashMap<[[u32; 3]; 2], (u32, &str)> = HashMap::new();
    for shape in shapes {
        match &shape.geometry {
            Geometry::Mesh(mesh) => (0..mesh.triangles.len())
                .for_each(|k| count_edges(mesh.corners(k), &shape.name, &mut edges)),
            Geometry::Sphere { .. } => {}
            Geometry::Disk { .. } | Geometry::Cylinder { .. } => return false,
        }
    }
    edges.values().all(|(count, _)| count % 2 == 0)
}

/// Points spread over a shape.
fn posts(shape: &Shape) -> Vec<Post> {
    match &shape.geometry {
        Geometry::Mesh(mesh) => {
            let step = mesh.triangles.len().div_ceil(POINTS).max(1);
            let triangles = (0..mesh.triangles.len()).step_by(step);
            triangles
                .filter_map(|k| {
                    let [a, b, c] = mesh.corners(k);
                    let n = (b - a).cross(c - a).try_normalize()?;
                    // Not at the centre, because a ray would then hit neighbours of the same construction at their
                    // edges.
                    Some((a * 0.41 + b * 0.27 + c * 0.32, n))
                })
                .collect()
        }
        Geometry::Sphere { center, radius, .. } => (0..POINTS)
            .map(|k| {
                let u = [(k as f32 + 0.5) / POINTS as f32, (k as f32 * 0.618_034).fract()];
                let n = crate::warp::sphere(u);
                (*center + n * *radius, n)
            })
            .collect(),
        Geometry::Disk { center, du, dv } => {
            vec![(*center + *du * 0.21 + *dv * 0.34, du.cross(*dv).normalize_or(Vec3::Y))]
        }
        Geometry::Cylinder { p0, p1, radius } => {
            let n = (*p1 - *p0).any_orthogonal_vector().normalize_or(Vec3::X);
            vec![(p0.lerp(*p1, 0.43) + n * *radius, n)]
        }
    }
}

/// The first few names, quoted; `None` without names.
fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> Option<String> {
    const MOST: usize = 4;
    let count = names.len();
    let mut text = names.take(MOST).map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    if count > MOST {
        text += &format!(" and {} more", count - MOST);
    }
    (count > 0).then_some(text)
}
