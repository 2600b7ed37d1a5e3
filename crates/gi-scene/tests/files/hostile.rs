//! Files that would take all memory, or all time, or that are no files.

use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::texture::Texture;

use super::*;

/// Load a scene with a limit on the memory.
fn within(folder: &Folder, max_memory: u64, body: &str) -> Result<gi_scene::Loaded, String> {
    let text = format!("<scene version='3.0.0'>\n<sensor type='perspective'/>{body}\n</scene>\n");
    let options = Options { max_memory, ..Options::default() };
    load(&folder.write("scene.xml", text), &options).map_err(|e| folder.strip(&e.to_string()))
}

fn textured(name: &str) -> String {
    format!(
        "<shape type='rectangle'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>
         <string name='filename' value='{name}'/></texture></bsdf></shape>"
    )
}

#[test]
fn of_an_exr_with_24_channels_only_the_needed_ones_take_memory() {
    let folder = Folder::new();
    let size = [128, 512];
    let plane = |v: f32| (0..size[0] * size[1]).map(|i| v + i as f32 * 1e-6).collect::<Vec<_>>();
    let mut channels: Vec<_> =
        (0..21).map(|k| (format!("c{k:02}"), plane(k as f32 + 10.0))).collect();
    channels.extend([("R", 0.1), ("G", 0.2), ("B", 0.3)].map(|(n, v)| (n.to_owned(), plane(v))));
    let [width, height] = size;
    let layers = Layers { width, height, channels, metadata: Vec::new() };
    write_file(&folder.path("a.exr"), ImageFile::Exr, &layers).unwrap();
    // All channels take 6.3 MB, three of them 0.8 MB.
    let loaded = within(&folder, 3_000_000, &textured("a.exr")).unwrap();
    let gi_core::material::Material::Diffuse { reflectance: Texture::Bitmap { bitmap, .. } } =
        &loaded.parts.materials[0]
    else {
        panic!()
    };
    let texel = bitmap.texel(3, 2).to_array();
    let nth = (3 + 2 * width) as f32 * 1e-6;
    assert_eq!(texel, [0.1, 0.2, 0.3].map(|v| v + nth));
    let shown = within(&folder, 500_000, &textured("a.exr")).unwrap_err();
    assert!(shown.contains("`a.exr`") && shown.contains("--max-memory"), "{shown}");
}

#[test]
fn an_exr_header_that_claims_100_channels_is_refused() {
    let folder = Folder::new();
    folder.write("header.exr", include_bytes!("../fuzz/found/header-100-channels.exr"));
    let shown = within(&folder, 100_000_000, &textured("header.exr")).unwrap_err();
    assert!(shown.contains("100 channels of 8192 x 8192 pixels"), "{shown}");
}

#[test]
fn a_scene_whose_tree_would_take_more_than_the_budget_is_refused_before_it_is_built() {
    let folder = Folder::new();
    folder.write("m.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(20_000)));
    let body = "<shape type='obj'><string name='filename' value='m.obj'/></shape>";
    within(&folder, 8_000_000, body).expect("mesh and tree take about 6 MB");
    let shown = within(&folder, 5_000_000, body).unwrap_err();
    assert!(shown.contains("no tree over 20000 primitives"), "{shown}");
    assert!(shown.contains("--max-memory"), "{shown}");
}

#[test]
fn a_mesh_used_by_200_shapes_takes_no_more_than_the_budget() {
    let folder = Folder::new();
    let vertices: String =
        (0..3000).map(|k| format!("v {k} 0 0\nv {k} 1 0\nv {k} 0 1\n")).collect();
    folder.write("m.obj", vertices + &"f -1 -2 -3\n".repeat(10));
    let faces: String =
        (0..9000).step_by(3).map(|k| format!("f {} {} {}\n", k + 1, k + 2, k + 3)).collect();
    folder.write("m.obj", std::fs::read_to_string(folder.path("m.obj")).unwrap() + &faces);
    let shapes = "<shape type='obj'><string name='filename' value='m.obj'/></shape>\n".repeat(200);
    assert_eq!(within(&folder, 1 << 30, &shapes).unwrap().parts.shapes.len(), 200);
    let shown = within(&folder, 20_000_000, &shapes).unwrap_err();
    assert!(shown.contains("most by `m.obj`"), "{shown}");
    assert!(shown.contains("200 shapes use the mesh `m.obj`"), "{shown}");
}

#[test]
fn shapes_that_use_one_mesh_share_its_triangles() {
    let folder = Folder::new();
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    let shape = |place: &str| {
        format!(
            "<shape type='obj'><string name='filename' value='m.obj'/>\
             <transform name='to_world'>{place}</transform></shape>"
        )
    };
    // A mirroring transform turns the triangles round, so that they need a copy.
    let places = ["<translate x='1'/>", "<scale value='2'/>", "<scale x='-1'/>"];
    let body: String = places.into_iter().map(shape).collect();
    let loaded = folder.scene("3.0.0", &body).unwrap();
    let shared = loaded.parts.shapes.iter().map(|shape| match &shape.geometry {
        gi_core::geometry::Geometry::Mesh(mesh) => mesh.triangles.is_shared(),
        other => panic!("{other:?}"),
    });
    assert_eq!(shared.collect::<Vec<_>>(), [true, true, false]);
}

#[test]
fn text_that_a_name_multiplies_is_counted() {
    let folder = Folder::new();
    let long = "x".repeat(60_000);
    let uses = "<shape type='sphere'><string name='a' value='$a'/></shape>\n".repeat(200);
    let body = format!("<default name='a' value='{long}'/>{uses}");
    assert!(within(&folder, 1 << 30, &body).is_ok());
    let shown = within(&folder, 8_000_000, &body).unwrap_err();
    assert!(shown.contains("`text that replaces names`"), "{shown}");
}

#[cfg(unix)]
#[test]
fn a_fifo_or_a_device_is_refused_at_once() {
    let folder = Folder::new();
    let refused = |shown: String| {
        assert!(shown.contains("not a regular file"), "{shown}");
    };
    let fifo = |name: &str| {
        let made = std::process::Command::new("mkfifo").arg(folder.path(name)).status();
        assert!(made.unwrap().success());
    };
    for name in ["a.xml", "b.obj"] {
        fifo(name);
        refused(load(&folder.path(name), &Options::default()).unwrap_err().to_string());
    }
    refused(folder.problems("<include filename='a.xml'/>"));
    for name in ["a.png", "a.exr", "a.pfm", "a.hdr"] {
        fifo(name);
        refused(folder.problems(&textured(name)));
    }
    for name in ["z.obj", "z.ply", "z.serialized", "z.png", "z.exr", "z.pfm"] {
        std::os::unix::fs::symlink("/dev/zero", folder.path(name)).unwrap();
        let kind = name.split('.').next_back().unwrap();
        let shape =
            format!("<shape type='{kind}'><string name='filename' value='{name}'/></shape>");
        let mesh = ["obj", "ply", "serialized"].contains(&kind);
        refused(folder.problems(&if mesh { shape } else { textured(name) }));
    }
    std::os::unix::fs::symlink("/dev/zero", folder.path("z.mtl")).unwrap();
    let obj = folder.write("c.obj", "mtllib z.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    refused(load(&obj, &Options::default()).unwrap_err().to_string());
}

#[test]
fn a_colour_of_two_numbers_gives_a_warning() {
    let folder = Folder::new();
    for (line, warnings) in [("Kd 0.8", 0), ("Kd 0.8 0.2", 1)] {
        folder.write("m.mtl", format!("newmtl m\n{line}\n"));
        let obj = "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let loaded = load(&folder.write("m.obj", obj), &Options::default()).unwrap();
        assert_eq!(loaded.warnings.len(), warnings, "{:?}", loaded.warnings);
    }
}

#[test]
fn search_folders_are_limited() {
    let folder = Folder::new();
    let paths = "<path value='x'/>".repeat(100);
    assert!(folder.problems(&paths).contains("more than 16 `path`s"));
}

#[test]
fn included_text_is_limited_counting_repeats() {
    let folder = Folder::new();
    folder.write(
        "part.xml",
        format!("<scene version='3.0.0'><!--{}--></scene>", " ".repeat(1 << 20)),
    );
    let shown = folder.problems(&"<include filename='part.xml'/>".repeat(300));
    assert!(shown.contains("all included text is longer"), "{shown}");
}
