//! An export contains the scene as the loader understood it.

mod common;

use common::{Folder, assert_same, describe, text};
use gi_core::camera::Projection;
use gi_core::material::Material;
use gi_scene::{CameraOverride, Options, export_mitsuba, load};
use glam::Vec3;

const SCENE: &str = "<scene version='0.6.0'><default name='gi.irrcache.accuracy' value='0.1'/>
  <integrator type='photonmapper'><integer name='maxDepth' value='9'/></integrator>
  <sensor type='thinlens'><float name='fov' value='33'/><float name='apertureRadius' value='0.1'/>
    <float name='focusDistance' value='4'/><film type='ldrfilm'><integer name='width' value='64'/>
    <integer name='height' value='48'/><rfilter type='tent'/></film>
    <transform name='toWorld'><lookAt origin='1 2 5' target='0 0 0' up='0 1 0'/></transform></sensor>
  <bsdf type='twosided' id='wall.paint'><bsdf type='roughplastic'><rgb name='diffuseReflectance' value='.3 .2 .1'/></bsdf></bsdf>
  <bsdf type='mask' id='leaf'><float name='opacity' value='0.25'/><ref id='wall.paint'/></bsdf>
  <bsdf type='blendbsdf' id='mix'><texture type='checkerboard' name='weight'><float name='uscale' value='4'/></texture>
    <bsdf type='roughconductor'><string name='material' value='Au'/></bsdf><bsdf type='dielectric'/></bsdf>
  <bsdf type='bumpmap' id='bump'><texture type='checkerboard'/><bsdf type='diffuse'/></bsdf>
  <medium type='homogeneous' id='fog'><rgb name='sigmaS' value='3 2 1'/><rgb name='sigmaA' value='1'/>
    <phase type='hg'><float name='g' value='0.4'/></phase></medium>
  <shape type='obj' id='tri'><string name='filename' value='data/tri.obj'/><ref id='leaf'/></shape>
  <shape type='obj'><string name='filename' value='data/tri.obj'/><boolean name='faceNormals' value='true'/>
    <transform name='toWorld'><translate x='3'/></transform><ref id='mix'/></shape>
  <shape type='obj'><string name='filename' value='data/end.obj'/><ref id='bump'/></shape>
  <shape type='rectangle'><transform name='toWorld'><scale x='-2'/></transform>
    <emitter type='area'><rgb name='radiance' value='5 4 3'/></emitter></shape>
  <shape type='sphere'><point name='center' value='1 2 3'/><float name='radius' value='0.7'/>
    <transform name='toWorld'><rotate x='1' angle='30'/></transform><ref name='interior' id='fog'/><bsdf type='dielectric'/></shape>
  <shape type='disk'><transform name='toWorld'><scale x='-1' y='2'/></transform></shape>
  <shape type='cylinder'><point name='p1' value='0 0 3'/><float name='radius' value='0.2'/></shape>
  <shape type='shapegroup' id='g'><shape type='cube'/></shape>
  <shape type='instance'><ref id='g'/><transform name='toWorld'><translate y='5'/></transform></shape>
  <emitter type='point'><point name='position' value='0 1 2'/></emitter>
  <emitter type='spot'><transform name='toWorld'><lookAt origin='1 2 5' target='0 0 0' up='0 1 0'/></transform></emitter>
  <emitter type='directional'><vector name='direction' value='0 -1 0'/></emitter>
  <emitter type='sunsky'><float name='turbidity' value='4'/></emitter></scene>";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write(
        "data/tri.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt .5 .25\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\n",
    );
    folder.write("data/end.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n");
    folder.write("scene.xml", SCENE);
    folder
}

#[test]
fn an_export_read_back_gives_the_same_parts() {
    let folder = folder();
    let (first, second) = (folder.path("out/one.xml"), folder.path("out/deeper/two.xml"));
    std::fs::create_dir_all(second.parent().unwrap()).unwrap();
    export_mitsuba(&folder.path("scene.xml"), &Options::default(), &first).unwrap();
    export_mitsuba(&first, &Options::default(), &second).unwrap();
    let [a, b, c] = [folder.path("scene.xml"), first, second]
        .map(|p| load(&p, &Options::default()).unwrap_or_else(|e| panic!("{e}")));
    assert_eq!(b.warnings, Vec::<String>::new(), "an export is clean");
    assert_same(&describe(&b), &describe(&c));
    // Names of shapes are not exported.
    let plain = |l: &gi_scene::Loaded| {
        let mut l = l.clone();
        l.parts.shapes.iter_mut().for_each(|s| s.name.clear());
        l
    };
    let (a, b) = (plain(&a), plain(&b));
    for (x, y) in a.parts.shapes.iter().zip(&b.parts.shapes) {
        assert_eq!(format!("{:?}", x.geometry), format!("{:?}", y.geometry));
        assert_eq!(
            (x.flip_normals, x.interior, x.exterior),
            (y.flip_normals, y.interior, y.exterior)
        );
        assert_eq!(format!("{:?}", x.emission), format!("{:?}", y.emission));
        assert_eq!(
            resolved(&a.parts.materials, x.material),
            resolved(&b.parts.materials, y.material)
        );
    }
    assert_eq!(a.parts.shapes.len(), b.parts.shapes.len());
    assert_eq!(format!("{:?}", a.parts.media), format!("{:?}", b.parts.media));
    assert_eq!(format!("{:?}", a.parts.instances), format!("{:?}", b.parts.instances));
    assert_eq!(a.parts.lights.len(), b.parts.lights.len());
    assert_eq!(
        (a.presets, a.integrator_max_depth, a.filter),
        (b.presets, b.integrator_max_depth, b.filter)
    );
}

/// A material with its nested materials, as text.
fn resolved(materials: &[Material], i: usize) -> String {
    let inside = match &materials[i] {
        Material::Mask { inner, .. }
        | Material::Bump { inner, .. }
        | Material::NormalMap { inner, .. } => {
            vec![*inner]
        }
        Material::TwoSided { front, back } => vec![*front, *back],
        Material::Blend { first, second, .. } => vec![*first, *second],
        _ => vec![],
    };
    let mut text = format!("{:?}", materials[i]);
    for key in ["inner: ", "front: ", "back: ", "first: ", "second: "] {
        if let Some(at) = text.find(key) {
            let start = at + key.len();
            let end = start + text[start..].find(|c: char| !c.is_ascii_digit()).unwrap();
            text.replace_range(start..end, "_");
        }
    }
    inside.iter().fold(text, |t, &c| t + "(" + &resolved(materials, c) + ")")
}

#[test]
fn an_export_names_files_from_its_own_folder_and_converts_what_mitsuba_refuses() {
    let folder = folder();
    let out = folder.path("out/one.xml");
    std::fs::create_dir_all(out.parent().unwrap()).unwrap();
    export_mitsuba(&folder.path("scene.xml"), &Options::default(), &out).unwrap();
    let xml = text(&out);
    assert!(xml.contains("value=\"../data/tri.obj\""), "{xml}");
    assert!(!xml.contains("end.obj") && xml.contains("value=\"one-files/0000.ply\""), "{xml}");
    assert!(xml.contains("<default name=\"gi.irrcache.accuracy\" value=\"0.1\"/>"));
    assert!(xml.contains("id=\"wall_paint\"") && xml.contains("<ref id=\"wall_paint\"/>"));
    for old in ["toWorld", "diffuseReflectance", "$", "photonmapper"] {
        assert!(!xml.contains(old), "{old}");
    }
}

#[test]
fn a_failed_export_writes_nothing() {
    let folder = Folder::new();
    let bad = folder.write("bad.xml", "<scene version='3.0.0'><shape type='teapot'/></scene>");
    let out = folder.write("out.xml", "what was there");
    assert!(export_mitsuba(&bad, &Options::default(), &out).is_err());
    assert_eq!(text(&out), "what was there");
}

#[test]
fn a_bare_obj_is_a_scene() {
    let folder = Folder::new();
    folder.write(
        "box.mtl",
        "newmtl lamp\nKd 0 0 0\nKe 5 6 7\nnewmtl shiny\nKd .5 .4 .3\nKs .2 .2 .2\nNs 30\nillum 2\n\
         newmtl mirror\nKs .9 .9 .9\nillum 3\nnewmtl glass\nNi 1.4\nTf .9 .8 .7\nillum 7\nnewmtl leaf\nd 0.5\n",
    );
    let quad = |name: &str, z: i32| {
        format!("usemtl {name}\nv 0 0 {z}\nv 1 0 {z}\nv 1 1 {z}\nv 0 1 {z}\nf -4 -3 -2 -1\n")
    };
    let names = ["lamp", "shiny", "mirror", "glass", "leaf"];
    let body: String = names.iter().zip(0..).map(|(n, z)| quad(n, z)).collect();
    let path = folder.write("box.obj", format!("mtllib box.mtl\n{body}"));
    let loaded = load(&path, &Options::default()).unwrap();
    let of = |i: usize| &loaded.parts.materials[loaded.parts.shapes[i].material];
    let inner = |i: usize| match of(i) {
        Material::TwoSided { front, .. } => &loaded.parts.materials[*front],
        other => panic!("{other:?}"),
    };
    assert_eq!(
        loaded.parts.shapes[0].emission.as_ref().unwrap().mean().to_array(),
        [5.0, 6.0, 7.0]
    );
    assert!(matches!(inner(1), Material::Phong { .. }));
    assert!(matches!(inner(2), Material::Conductor { .. }));
    assert!(matches!(of(3), Material::Dielectric { eta, .. } if *eta == 1.4));
    assert!(matches!(of(4), Material::Mask { .. }));
    let camera = CameraOverride {
        origin: Some(Vec3::new(0.0, 0.0, 9.0)),
        fov: Some(30.0),
        ..Default::default()
    };
    let seen =
        load(&path, &Options { camera, size: Some([40, 30]), ..Options::default() }).unwrap();
    assert_eq!(
        (Vec3::from(seen.camera.to_world.translation), seen.camera.size),
        (Vec3::new(0.0, 0.0, 9.0), [40, 30])
    );
    assert!(
        matches!(seen.camera.projection, Projection::Perspective { fov_x, .. } if (fov_x.to_degrees() - 30.0).abs() < 1e-4)
    );
    let out = folder.path("box.xml");
    let notes = export_mitsuba(&path, &Options::default(), &out).unwrap();
    assert!(notes.iter().any(|n| n.contains("phong")));
    assert_eq!(load(&out, &Options::default()).unwrap().parts.shapes.len(), 5);
}

#[test]
fn principled_materials_and_projectors_are_exported_and_read_back() {
    let folder = Folder::new();
    folder.write("a.pfm", [b"PF\n1 1\n-1.0\n".as_slice(), &[0; 12]].concat());
    let body = "<sensor type='perspective'/>
        <emitter type='spot'><texture type='checkerboard' name='texture'/><transform name='to_world'>
        <scale x='-1'/><lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform></emitter>
        <shape type='cube'><bsdf type='principled'><float name='metallic' value='0.25'/><float name='specular' value='0.75'/>
        <texture type='checkerboard' name='roughness'/></bsdf></shape>
        <shape type='cube'><bsdf type='principledthin'><float name='diff_trans' value='1.5'/><float name='eta' value='1.25'/></bsdf></shape>";
    folder.scene("3.0.0", body).unwrap();
    let out = folder.path("out.xml");
    export_mitsuba(&folder.path("scene.xml"), &Options::default(), &out).unwrap();
    let describe = |path: &std::path::Path| {
        let parts = load(path, &Options::default()).unwrap().parts;
        format!("{:#?}\n{:#?}", parts.materials, parts.lights)
    };
    let (before, after) = (describe(&folder.path("scene.xml")), describe(&out));
    assert!(before.contains("PrincipledThin") && before.contains("Projector"));
    common::assert_same(&before, &after);
}
