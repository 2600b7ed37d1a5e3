//! Bare OBJ files and material libraries with the names and lines that exporters write.

mod common;

use common::Folder;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::texture::Texture;
use gi_scene::{Loaded, Options, load};
use glam::Vec3;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Load an OBJ file of one triangle with a material of this name.
fn one(folder: &Folder, head: &str, material: &[u8]) -> Result<Loaded, String> {
    let text = [head.as_bytes(), b"usemtl ", material, b"\n", TRIANGLE.as_bytes()].concat();
    load(&folder.write("a.obj", text), &Options::default())
        .map_err(|e| folder.strip(&e.to_string()))
}

/// The diffuse colour of the first shape, black if its material was not found.
fn diffuse(loaded: &Loaded) -> Rgb {
    let materials = &loaded.parts.materials;
    match &materials[loaded.parts.shapes[0].material] {
        Material::TwoSided { front, .. } => match &materials[*front] {
            Material::Diffuse { reflectance } => reflectance.mean(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

const RED: &str = "Kd 0.9 0.1 0.1\n";

#[test]
fn an_obj_that_begins_with_a_byte_order_mark_keeps_its_library() {
    let folder = Folder::new();
    folder.write("a.mtl", format!("\u{feff}newmtl m\n{RED}"));
    let loaded = one(&folder, "\u{feff}mtllib a.mtl\n", b"m").unwrap();
    assert_eq!(diffuse(&loaded), Rgb::new(0.9, 0.1, 0.1));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let wide: Vec<u8> =
        "\u{feff}newmtl m\nKd 0.9 0.1 0.1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    folder.write("a.mtl", wide);
    assert_eq!(diffuse(&one(&folder, "mtllib a.mtl\n", b"m").unwrap()), Rgb::new(0.9, 0.1, 0.1));
}

#[test]
fn names_with_blanks_and_hashes_are_whole() {
    let folder = Folder::new();
    let library = format!(
        "newmtl Material #26\n{RED}newmtl plain # a comment\n{RED}newmtl Material\nKd 0 0 0\n"
    );
    folder.write("my materials #2.mtl", library);
    for name in ["Material #26", "plain", "plain # another", "Material #26 # the red one"] {
        let loaded = one(&folder, "mtllib my materials #2.mtl\n", name.as_bytes()).unwrap();
        let red = Rgb::new(0.9, 0.1, 0.1);
        // After a name with a hash, a comment cannot be distinguished from the name.
        let found = name != "Material #26 # the red one";
        assert_eq!(diffuse(&loaded), if found { red } else { Rgb::BLACK }, "{name}");
    }
}

#[test]
fn names_in_latin_1_are_the_same_in_both_files() {
    let folder = Folder::new();
    folder.write("a.mtl", b"newmtl gr\xfcn\nKd 0 1 0\nnewmtl gr\xf6n\nKd 1 0 0\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"gr\xfcn").unwrap();
    assert_eq!(diffuse(&loaded), Rgb::new(0.0, 1.0, 0.0));
    let loaded = one(&folder, "mtllib a.mtl\n", "gr\u{fc}n".as_bytes()).unwrap();
    assert_eq!(diffuse(&loaded), Rgb::new(0.0, 1.0, 0.0));
}

#[test]
fn one_statement_names_several_libraries() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl other\nKd 0 0 0\n");
    folder.write("b.mtl", format!("newmtl m\n{RED}"));
    let loaded = one(&folder, "mtllib a.mtl b.mtl # both\n", b"m").unwrap();
    assert_eq!(diffuse(&loaded), Rgb::new(0.9, 0.1, 0.1));
    let loaded = one(&folder, "mtllib a.mtl c.mtl\n", b"m").unwrap();
    assert!(loaded.warnings[0].contains("cannot find the material library `c.mtl`"));
    let loaded = one(&folder, "mtllib no such.mtl\n", b"m").unwrap();
    assert!(loaded.warnings[0].contains("the material library `no such.mtl`"));
}

#[test]
fn a_reflectance_above_one_is_clamped_with_a_warning() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl m\nKd 2 0.5 -1\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
    assert_eq!(diffuse(&loaded), Rgb::new(1.0, 0.5, 0.0));
    assert!(loaded.warnings[0].contains("a.mtl:2: `Kd` is outside [0, 1]: clamped"));
    folder.write("a.mtl", "newmtl m\nKd 1\nKs 0.5\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
    assert!(
        loaded.warnings[0].contains("`Kd` and `Ks` sum to 1.5: scaled"),
        "{:?}",
        loaded.warnings
    );
}

#[test]
fn a_picture_of_light_alone_emits() {
    let folder = Folder::new();
    let picture =
        [b"PF\n1 1\n-1.0\n".as_slice(), &[3f32; 3].map(f32::to_le_bytes).concat()].concat();
    folder.write("a picture.pfm", picture);
    for (light, mean) in [("map_Ke a picture.pfm", 3.0), ("Ke 2\nmap_Ke a picture.pfm", 6.0)] {
        folder.write("a.mtl", format!("newmtl m\n{light}\n"));
        let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
        let emission = loaded.parts.shapes[0].emission.as_ref().expect("light");
        assert_eq!(emission.mean(), Rgb::grey(mean), "{light}");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }
    folder.write("a.mtl", "newmtl m\nKe 0 0 0\nmap_Ke a picture.pfm\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
    assert!(
        loaded.parts.shapes[0].emission.is_some() && loaded.warnings[0].contains("`Ke` is black")
    );
    folder.write("a.mtl", "newmtl m\nmap_Kd -clamp on -s 2 3 -mm 0 1 a picture.pfm\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
    let Material::TwoSided { front, .. } = loaded.parts.materials[1] else { panic!() };
    let Material::Diffuse { reflectance: Texture::Bitmap { to_uv, .. } } =
        &loaded.parts.materials[front]
    else {
        panic!()
    };
    assert_eq!(to_uv.matrix2.x_axis.x, 2.0);
    assert!(loaded.warnings[0].contains("the option `-mm` is ignored"), "{:?}", loaded.warnings);
}

#[test]
fn faces_of_one_and_two_corners_are_skipped_with_one_warning() {
    let folder = Folder::new();
    let path = folder.write("a.obj", format!("{TRIANGLE}f 1\nf 1 2\nf 3\n"));
    let loaded = load(&path, &Options::default()).unwrap();
    let shown = folder.strip(&loaded.warnings.join("\n"));
    assert_eq!(shown, "`a.obj`: 3 faces of one or two corners skipped, the first in line 5");
    let body = "<shape type='obj'><string name='filename' value='a.obj'/></shape>";
    let loaded = folder.scene("3.0.0", body).unwrap();
    assert!(loaded.warnings[0].contains("3 faces of one or two corners"), "{:?}", loaded.warnings);
}

#[test]
fn ignored_statements_of_many_materials_are_counted() {
    let folder = Folder::new();
    let library: String =
        (0..100).map(|k| format!("newmtl m{k}\nKd 0.5\nmap_Ks a.png\n")).collect();
    folder.write("a.mtl", library);
    let loaded = one(&folder, "mtllib a.mtl\n", b"m3").unwrap();
    assert_eq!(loaded.warnings.len(), 4);
    assert_eq!(loaded.warnings[3], "and 97 more like this: `map_Ks` is ignored");
}

#[test]
fn a_mistake_in_a_library_is_shown_with_its_line_and_does_not_refuse_the_file() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl m\nNi glass\nKd 0.25\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
    let shown = folder.strip(&loaded.warnings.join("\n"));
    assert_eq!(shown, "a.mtl:2: material `m`: `Ni`: `glass` is not a number: ignored");
    assert_eq!(diffuse(&loaded), Rgb::grey(0.25));
    // Glass with an index that no glass has.
    folder.write("a.mtl", "newmtl m\nillum 7\nNi 1e6\n");
    let loaded = one(&folder, "mtllib a.mtl\n", b"m").unwrap();
    assert!(loaded.warnings[0].contains("1.5 is used"), "{:?}", loaded.warnings);
}

/// A library and an OBJ file with `n` materials, each used `uses` times.
fn many(folder: &Folder, n: usize, uses: usize) -> std::path::PathBuf {
    let library: String = (0..n).map(|k| format!("newmtl m{k}\nKd 0.5 0.5 0.5\n")).collect();
    folder.write("a.mtl", library);
    let mut obj = String::from("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    (0..n * uses).for_each(|k| obj += &format!("usemtl m{}\nf 1 2 3\n", k % n));
    folder.write("a.obj", obj)
}

#[test]
fn many_materials_are_all_found() {
    // Searching all names at each `usemtl` would take 10^10 steps here.
    let folder = Folder::new();
    let loaded = load(&many(&folder, 100_000, 1), &Options::default()).unwrap();
    assert_eq!(loaded.parts.shapes.len(), 100_000);
    assert!(loaded.warnings.is_empty());
    let loaded = load(&many(&folder, 10, 10_000), &Options::default()).unwrap();
    assert_eq!(loaded.parts.shapes.len(), 10);
}

#[test]
fn an_added_light_lights_a_file_that_has_none() {
    let folder = Folder::new();
    let path = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let lights =
        |light| load(&path, &Options { light, ..Options::default() }).unwrap().parts.lights;
    assert!(lights(None).is_empty());
    let count = |name| lights(gi_scene::AddedLight::named(name)).len();
    assert_eq!(gi_scene::AddedLight::NAMES.map(count), [2, 1, 1]);
    let LightSource::Point { position, intensity } =
        lights(Some(gi_scene::AddedLight::Headlight))[0]
    else {
        panic!()
    };
    let center = Vec3::new(0.5, 0.5, 0.0);
    let irradiance = intensity.r / position.distance_squared(center);
    assert!((irradiance - std::f32::consts::PI).abs() < 1e-4, "white is 1 at the centre");
}
