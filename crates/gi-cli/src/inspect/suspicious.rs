//! What looks like a mistake in a scene, or makes it hard.

use gi_core::geometry::{Geometry, Shape};
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Bounds;
use gi_core::scene::SceneParts;
use glam::Vec3;

use super::short;
use super::solid::Solid;

/// Most messages of a kind.
const MOST: usize = 5;
/// Most lights that are searched inside solids.
const MOST_LIGHTS: usize = 256;
/// A ground is much larger than the rest if it is this many times as wide.
const WIDE: f32 = 20.0;

/// All findings, in a fixed order. `eye` is the position of the camera.
pub(super) fn find(parts: &SceneParts, eye: Vec3) -> Vec<String> {
    let solids: Vec<Solid> = parts.shapes.iter().filter_map(Solid::of).collect();
    let mut out = Vec::new();
    add(&mut out, inverted(parts, &solids, eye));
    let lamps = lamps(parts);
    add(&mut out, swallowed(parts, &solids, &lamps));
    add(&mut out, behind_glass(parts, &solids, &lamps));
    out.extend(wide_ground(&parts.shapes));
    let shines = parts.shapes.iter().chain(parts.groups.iter().flatten());
    if parts.lights.is_empty() && shines.into_iter().all(|s| s.emission.is_none()) {
        out.push("nothing shines: the picture will be black; `--light sky` adds a light".into());
    }
    out
}

/// Add messages of one kind; many are counted.
fn add(out: &mut Vec<String>, found: Vec<String>) {
    let more = found.len().saturating_sub(MOST);
    out.extend(found.into_iter().take(MOST));
    if more > 0 {
        out.push(format!("and {more} more like this"));
    }
}

/// How light passes a material.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Passes {
    /// Not at all.
    Opaque,
    /// It is refracted, so that only paths that happen to hit a lamp find it.
    Refracted,
    /// Straight, at least partly.
    Straight,
}

fn passes(materials: &[Material], id: usize) -> Passes {
    let of = |children: [usize; 2]| {
        let all = children.map(|c| passes(materials, c));
        let has = |wanted| all.contains(&wanted);
        match (has(Passes::Straight), has(Passes::Refracted)) {
            (true, _) => Passes::Straight,
            (_, true) => Passes::Refracted,
            _ => Passes::Opaque,
        }
    };
    match &materials[id] {
        Material::Dielectric { .. } => Passes::Refracted,
        Material::Principled(p) if !p.spec_trans.is_black() => Passes::Refracted,
        Material::ThinDielectric { .. } | Material::Null | Material::Mask { .. } => {
            Passes::Straight
        }
        Material::PrincipledThin(_) => Passes::Straight,
        Material::TwoSided { front, back } => of([*front, *back]),
        Material::Blend { first, second, .. } => of([*first, *second]),
        Material::Bump { inner, .. } | Material::NormalMap { inner, .. } => of([*inner; 2]),
        _ => Passes::Opaque,
    }
}

/// Closed shapes whose normals point inward, where this matters: lamps, glass, one-sided surfaces seen from outside.
fn inverted(parts: &SceneParts, solids: &[Solid], eye: Vec3) -> Vec<String> {
    let message = |solid: &Solid| {
        let name = &solid.shape.name;
        let two_sided = matches!(parts.materials[solid.shape.material], Material::TwoSided { .. });
        let why = if solid.shape.emission.is_some() {
            "it shines inward only"
        } else if passes(&parts.materials, solid.shape.material) == Passes::Refracted {
            "inside and outside of the glass are exchanged"
        } else if !two_sided && !solid.contains(eye) {
            "a one-sided material is black from outside"
        } else {
            return None;
        };
        Some(format!("`{name}` is closed and its normals point inward: {why}"))
    };
    solids.iter().filter(|solid| solid.is_inverted()).filter_map(message).collect()
}

/// A light with a place.
struct Lamp<'a> {
    name: String,
    center: Vec3,
    radius: f32,
    shape: Option<&'a Shape>,
}

fn lamps(parts: &SceneParts) -> Vec<Lamp<'_>> {
    let shapes = parts.shapes.iter().filter(|s| s.emission.is_some()).map(|shape| {
        let bounds = shape.geometry.bounds();
        // A point of the surface: the middle of a lamp may be outside of what surrounds it.
        let center = match &shape.geometry {
            Geometry::Mesh(mesh) if !mesh.triangles.is_empty() => {
                mesh.corners(0).into_iter().sum::<Vec3>() / 3.0
            }
            _ => bounds.center(),
        };
        let radius = 0.5 * bounds.extent().length();
        Lamp { name: shape.name.clone(), center, radius, shape: Some(shape) }
    });
    let points = parts.lights.iter().filter_map(|light| {
        let (kind, center) = match light {
            LightSource::Point { position, .. } => ("point", *position),
            LightSource::Spot { position, .. } => ("spot", *position),
            LightSource::Projector { position, .. } => ("light with a picture", *position),
            _ => return None,
        };
        Some(Lamp { name: kind.into(), center, radius: 0.0, shape: None })
    });
    shapes.chain(points).take(MOST_LIGHTS).collect()
}

/// The solids around a lamp that are not the lamp itself.
fn around<'a>(solids: &'a [Solid<'a>], lamp: &'a Lamp<'a>) -> impl Iterator<Item = &'a Solid<'a>> {
    let is_itself = |solid: &Solid| lamp.shape.is_some_and(|s| std::ptr::eq(s, solid.shape));
    solids.iter().filter(move |solid| !is_itself(solid) && solid.contains(lamp.center))
}

/// Lamps inside of opaque solids that do not contain everything else too.
fn swallowed(parts: &SceneParts, solids: &[Solid], lamps: &[Lamp]) -> Vec<String> {
    let whole = bounds_without(&parts.shapes, usize::MAX);
    let is_room = |solid: &Solid| solid.bounds.extent().length() > 0.5 * whole.extent().length();
    let inside = |lamp: &Lamp| {
        let opaque = |s: &&Solid| passes(&parts.materials, s.shape.material) == Passes::Opaque;
        let solid = around(solids, lamp).filter(opaque).find(|solid| !is_room(solid))?;
        Some(format!("the light `{}` is inside `{}`, which is opaque", lamp.name, solid.shape.name))
    };
    lamps.iter().filter_map(inside).collect()
}

/// Small lamps inside of glass.
fn behind_glass(parts: &SceneParts, solids: &[Solid], lamps: &[Lamp]) -> Vec<String> {
    let inside = |lamp: &Lamp| {
        let is_shell = |s: &&Solid| {
            let small = lamp.radius < 0.5 * s.bounds.extent().length();
            small && passes(&parts.materials, s.shape.material) == Passes::Refracted
        };
        let shell = around(solids, lamp).find(is_shell)?;
        Some(format!(
            "the light `{}` is small and inside the glass `{}`: paths from the eye find it rarely",
            lamp.name, shell.shape.name
        ))
    };
    lamps.iter().filter_map(inside).collect()
}

/// The box around all shapes but one.
fn bounds_without(shapes: &[Shape], left_out: usize) -> Bounds {
    let others = shapes.iter().enumerate().filter(|(k, _)| *k != left_out);
    others.map(|(_, s)| s.geometry.bounds()).fold(Bounds::EMPTY, Bounds::union)
}

/// A shape that is much wider than all others together.
fn wide_ground(shapes: &[Shape]) -> Option<String> {
    let width = |k: usize| shapes[k].geometry.bounds().extent().length();
    let widest = (0..shapes.len()).max_by(|a, b| width(*a).total_cmp(&width(*b)))?;
    let others = bounds_without(shapes, widest);
    let rest = others.extent().length();
    if others.is_empty() || rest == 0.0 || width(widest) < WIDE * rest {
        return None;
    }
    let (name, ratio) = (&shapes[widest].name, width(widest) / rest);
    Some(format!(
        "`{name}` is {} times as wide as all other shapes: options in scene radii are too large for these shapes, and photons \
         are spread over the whole scene",
        short(ratio)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::math::{Frame, Rgb};
    use gi_core::texture::Texture;

    fn ball(name: &str, center: Vec3, radius: f32, material: usize) -> Shape {
        let axes = Frame::from_normal(Vec3::Z);
        Shape::new(name, Geometry::Sphere { center, radius, axes }, material)
    }

    /// Materials: 0 diffuse, 1 glass.
    fn parts(shapes: Vec<Shape>) -> SceneParts {
        let glass = Material::Dielectric {
            eta: 1.5,
            reflectance: Texture::grey(1.0),
            transmittance: Texture::grey(1.0),
            roughness: None,
        };
        let diffuse = Material::Diffuse { reflectance: Texture::grey(0.5) };
        SceneParts { shapes, materials: vec![diffuse, glass], ..SceneParts::default() }
    }

    fn lit(mut shape: Shape) -> Shape {
        shape.emission = Some(Texture::Constant(Rgb::WHITE));
        shape
    }

    const EYE: Vec3 = Vec3::new(0.0, 0.0, 9.0);

    #[test]
    fn lamps_inside_opaque_solids_and_inside_glass_are_found() {
        let far = || ball("far", Vec3::new(30.0, 0.0, 0.0), 1.0, 0);
        let lamp = || lit(ball("lamp", Vec3::ZERO, 0.1, 0));
        let found =
            |shell| find(&parts(vec![far(), lamp(), ball("shell", Vec3::ZERO, 1.0, shell)]), EYE);
        assert_eq!(found(0), ["the light `lamp` is inside `shell`, which is opaque"]);
        let glass = found(1);
        assert_eq!(glass.len(), 1);
        assert!(glass[0].contains("`lamp` is small and inside the glass `shell`"), "{glass:?}");
        // A lamp beside the shell, and a lamp that fills it.
        let beside = lit(ball("lamp", Vec3::X * 3.0, 0.1, 0));
        assert!(
            find(&parts(vec![far(), beside, ball("shell", Vec3::ZERO, 1.0, 0)]), EYE).is_empty()
        );
        // A room is no mistake.
        assert!(find(&parts(vec![lamp(), ball("room", Vec3::ZERO, 1.5, 0)]), EYE).is_empty());
    }

    #[test]
    fn inverted_normals_are_found_where_they_matter() {
        let inverted = |shape: Shape| Shape { flip_normals: true, ..shape };
        let found =
            |shape: Shape| find(&parts(vec![lit(ball("lamp", Vec3::X * 9.0, 2.0, 0)), shape]), EYE);
        let says = |shape: Shape, what: &str| {
            let found = found(shape);
            assert!(found.len() == 1 && found[0].contains(what), "{found:?}");
        };
        says(inverted(ball("a", Vec3::ZERO, 1.0, 1)), "of the glass are exchanged");
        says(inverted(ball("a", Vec3::ZERO, 1.0, 0)), "black from outside");
        says(inverted(lit(ball("a", Vec3::ZERO, 1.0, 0))), "shines inward only");
        assert!(found(ball("a", Vec3::ZERO, 1.0, 1)).is_empty());
        // Seen from inside, a room must face inward.
        assert!(found(inverted(ball("room", Vec3::ZERO, 20.0, 0))).is_empty());
    }

    #[test]
    fn a_ground_to_the_horizon_and_a_scene_without_light_are_found() {
        let disk = Geometry::Disk { center: Vec3::ZERO, du: Vec3::X * 1e3, dv: Vec3::Y * 1e3 };
        let ground = Shape::new("ground", disk, 0);
        let found = find(&parts(vec![ground, ball("a", Vec3::ZERO, 1.0, 0)]), EYE);
        assert!(found[0].starts_with("`ground` is 816.5 times as wide"), "{found:?}");
        assert!(found[1].contains("nothing shines") && found.len() == 2, "{found:?}");
    }
}
