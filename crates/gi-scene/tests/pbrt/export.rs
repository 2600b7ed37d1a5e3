//! pbrt scenes as XML.

use gi_scene::export_mitsuba;
use glam::Vec3;

use super::*;

/// The names of all scenes.
fn names() -> Vec<String> {
    let entries = std::fs::read_dir(path("")).unwrap();
    let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".pbrt")).collect();
    names.sort();
    names
}

/// What an export must keep of a shape: its place, its side and what it emits.
fn outline(shape: &Shape) -> (Vec3, Vec3, String, bool) {
    let bounds = shape.geometry.bounds();
    let emission = match &shape.emission {
        Some(texture) => format!("{:.4?}", texture.mean().to_array()),
        None => String::new(),
    };
    // Spheres keep the side in a flag, meshes in their winding.
    let outward = match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.oriented_normal(0).z > 0.0,
        _ => true,
    };
    (bounds.min, bounds.max, emission, outward != shape.flip_normals)
}

#[test]
fn exported_scenes_are_the_same() {
    for name in names() {
        let folder = common::Folder::new();
        let out = folder.path("out.xml");
        export_mitsuba(&path(&name), &Options::default(), &out)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let (ours, back) = (scene(&name), load(&out, &Options::default()));
        let back = back.unwrap_or_else(|problems| panic!("{name}: {problems}"));
        let (a, b) = (&ours.parts, &back.parts);
        assert_eq!(a.shapes.len(), b.shapes.len(), "{name}");
        assert_eq!((a.lights.len(), a.media.len()), (b.lights.len(), b.media.len()), "{name}");
        assert_eq!(a.instances.len(), b.instances.len(), "{name}");
        for (n, (x, y)) in a.shapes.iter().zip(&b.shapes).enumerate() {
            let (x, y) = (outline(x), outline(y));
            let near = (x.0 - y.0).length() + (x.1 - y.1).length() < 1e-4;
            assert!(near && (&x.2, x.3) == (&y.2, y.3), "{name}, shape {n}: {x:?} {y:?}");
        }
        assert_eq!(ours.filter, back.filter, "{name}");
        let difference =
            (ours.camera.to_world.translation - back.camera.to_world.translation).length();
        assert!(difference < 1e-5, "{name}: {:?} {:?}", ours.camera, back.camera);
    }
}
