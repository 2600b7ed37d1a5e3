//! Chooses the origin of a scene that is far from the origin of its coordinates. Everything is placed relative to it in
//! double precision before it is rounded to single precision. A small scene loses no digits that way.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DVec3};

use crate::diagnostics::Report;
use crate::document::{Class, Document, Node, ObjectId, Value};

/// A scene or mesh that is farther from the origin than this many of its radii is moved.
const FAR: f64 = 8.0;

/// Where a scene is.
#[derive(Debug, Default)]
pub(crate) struct Local {
    /// The scene's own origin in the coordinates of its file. It has no more digits than single precision.
    pub(crate) origin: DVec3,
    /// Shapes in groups. They have the coordinates of their group.
    pub(crate) in_groups: HashSet<ObjectId>,
}

/// A bounding box in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    min: DVec3,
    max: DVec3,
}

impl Extent {
    /// The box around points; `None` without points.
    pub(crate) fn of(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        points.into_iter().map(|p| Extent { min: p, max: p }).reduce(Extent::union)
    }

    fn around(center: DVec3, half: DVec3) -> Self {
        Extent { min: center - half, max: center + half }
    }

    fn union(self, other: Self) -> Self {
        Extent { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn transformed(self, m: &DAffine3) -> Self {
        let end =
            |k: usize, axis: usize| (if k >> axis & 1 == 0 { self.min } else { self.max })[axis];
        let corner = |k: usize| m.transform_point3(DVec3::new(end(k, 0), end(k, 1), end(k, 2)));
        Extent::of((0..8).map(corner)).unwrap_or(self)
    }

    /// The centre, rounded to single precision, if everything is far from the origin; otherwise the origin.
    pub(crate) fn origin(&self) -> DVec3 {
        let (center, radius) = (0.5 * (self.min + self.max), 0.5 * (self.max - self.min).length());
        let rounded = center.as_vec3();
        let far = center.length() > FAR * radius && rounded.is_finite();
        if far { rounded.as_dvec3() } else { DVec3::ZERO }
    }
}

/// The place of a scene. `mesh` is the box around the mesh that a shape names, in the coordinates of its file.
pub(crate) fn place(
    doc: &Document,
    report: &Report,
    mesh: impl Fn(ObjectId) -> Option<Extent>,
) -> Local {
    let Some(scene) = doc.nodes(report).next() else { return Local::default() };
    let shapes: Vec<Node> = scene.all_children().filter(|n| n.class() == Class::Shape).collect();
    let is_group = |n: &Node| n.plugin() == "shapegroup";
    let mut in_groups = HashSet::new();
    let mut groups: HashMap<ObjectId, Option<Extent>> = HashMap::new();
    for group in shapes.iter().flat_map(|n| with_children(*n)).filter(is_group) {
        groups.entry(group.id).or_insert_with(|| {
            let members = group.all_children().filter(|n| n.class() == Class::Shape);
            let extents = members.filter_map(|n| {
                in_groups.insert(n.id);
                extent(n, &mesh)
            });
            extents.reduce(Extent::union)
        });
    }
    // A shape that is in the scene and in a group has both kinds of coordinates.
    if shapes.iter().any(|n| in_groups.contains(&n.id)) {
        return Local { origin: DVec3::ZERO, in_groups };
    }
    let extents = shapes.iter().filter_map(|n| match n.plugin() {
        "shapegroup" => None,
        "instance" => {
            let group = n.all_children().find(is_group)?;
            Some((*groups.get(&group.id)?)?.transformed(&to_world(*n)))
        }
        _ => extent(*n, &mesh),
    });
    let origin = extents.reduce(Extent::union).map_or(DVec3::ZERO, |all| all.origin());
    Local { origin, in_groups }
}

/// A shape and its children.
fn with_children(node: Node<'_>) -> impl Iterator<Item = Node<'_>> {
    std::iter::once(node).chain(node.all_children())
}

/// The box around a shape, which may be slightly too large.
fn extent(node: Node<'_>, mesh: &impl Fn(ObjectId) -> Option<Extent>) -> Option<Extent> {
    let point = |name: &str, default| match node.peek(name) {
        Some((Value::Vector(p), _)) => *p,
        _ => default,
    };
    let radius = || match node.peek("radius") {
        Some((Value::Float(r), _)) => DVec3::splat(f64::from(*r).abs()),
        _ => DVec3::ONE,
    };
    let own = match node.plugin() {
        "rectangle" | "disk" => Extent::around(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)),
        "cube" => Extent::around(DVec3::ZERO, DVec3::ONE),
        "sphere" => Extent::around(point("center", DVec3::ZERO), radius()),
        "cylinder" => {
            let ends = [point("p0", DVec3::ZERO), point("p1", DVec3::Z)];
            ends.map(|p| Extent::around(p, radius())).into_iter().reduce(Extent::union)?
        }
        _ => mesh(node.id)?,
    };
    Some(own.transformed(&to_world(node)))
}

fn to_world(node: Node<'_>) -> DAffine3 {
    match node.peek("to_world") {
        Some((Value::Transform(m), _)) => **m,
        _ => DAffine3::IDENTITY,
    }
}
