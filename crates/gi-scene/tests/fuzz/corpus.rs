//! Small valid files of each kind.

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use gi_core::image_io::{ImageFile, Layers, write_file};

use super::common::Folder;

const SENSOR: &str = "<sensor type='perspective'>\n<float name='fov' value='40'/>\n<transform name='to_world'>\
    <lookat origin='0, 0, 5' target='0 0 0' up='0 1 0'/></transform>\n<film type='hdrfilm'>\
    <integer name='width' value='32'/><integer name='height' value='24'/><rfilter type='box'/></film>\n</sensor>\n";
const LIBRARY: &str = "newmtl m\nKd 0.8 0.2 0.1\nKs 0.1\nNs 20\nillum 2\nmap_Kd -s 2 1 -o 0.5 p.pfm\nnewmtl glass # clear\n\
    Ni 1.5\nillum 4\nTf 1 0.9 0.8\nd 0.5\nnewmtl lamp\nKe 3 3 3\nmap_d p.pfm\nTr 0.25\nbump b.png\n";
pub(crate) const OBJ: &str = "# a square\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0\nvt 0.5 1\nvn 0 0 1\n\
    usemtl m\nf 1/1/1 2/2/1 3/3/1 4/1/1\nusemtl lamp\nf -4 -3 \\\n -2\no x\ng y\ns 1\nusemtl glass\nf 1//1 2//1 4//1\n";

/// The files that others name.
pub(crate) fn write_companions(folder: &Folder) {
    folder.write("a.mtl", LIBRARY);
    folder.write("a.obj", OBJ);
    folder.write("m.ply", &ply()[0]);
    folder.write("m.serialized", &serialized()[0]);
    folder.write("p.pfm", &pictures("pfm")[0]);
    folder.write("v.vol", &volumes()[0]);
    folder.write("meshes/square.ply", &ply()[0]);
    for name in ["picture.pfm", "sky.pfm"] {
        folder.write(name, &pictures("pfm")[0]);
    }
    folder.write("part.xml", "<scene version='3.0.0'><bsdf type='diffuse' id='part'/></scene>");
}

fn scene(version: &str, body: &str) -> Vec<u8> {
    format!("<?xml version='1.0'?>\n<scene version='{version}'>\n{SENSOR}{body}</scene>\n")
        .into_bytes()
}

pub(crate) fn xml() -> Vec<Vec<u8>> {
    let materials = "<default name='a' value='0.3'/>\n<integrator type='path'><integer name='max_depth' value='8'/></integrator>\n\
        <bsdf type='twosided' id='w'><bsdf type='diffuse'><rgb name='reflectance' value='0.7 $a #'/></bsdf></bsdf>\n\
        <bsdf type='roughconductor' id='c'><float name='alpha' value='$a'/><string name='material' value='Au'/></bsdf>\n\
        <bsdf type='dielectric' id='g'><float name='int_ior' value='1.5'/></bsdf>\n\
        <bsdf type='principled' id='p'><float name='metallic' value='0.5'/><float name='roughness' value='$a'/></bsdf>\n\
        <bsdf type='mask' id='k'><float name='opacity' value='0.5'/><ref id='w'/></bsdf>\n"
        .replace(" #'", "'");
    let shapes = "<shape type='rectangle'><ref id='w'/><transform name='to_world'><rotate x='1' angle='-90'/>\
        <scale value='2'/><translate x='0' y='-1' z='0'/></transform></shape>\n\
        <shape type='sphere'><float name='radius' value='0.5'/><point name='center' value='1 0 0'/><ref id='c'/></shape>\n\
        <shape type='cylinder'><point name='p0' x='0' y='0' z='0'/><point name='p1' x='0' y='1' z='0'/><ref id='p'/></shape>\n\
        <shape type='disk'><emitter type='area'><rgb name='radiance' value='3'/></emitter></shape>\n\
        <shape type='cube'><ref id='k'/><medium type='homogeneous' name='interior'><float name='albedo' value='0.5'/>\
        <float name='sigma_t' value='1'/><phase type='hg'><float name='g' value='0.3'/></phase></medium></shape>\n\
        <shape type='cube'><medium type='heterogeneous' name='interior'><volume type='gridvolume' name='sigma_t'>\
        <string name='filename' value='v.vol'/></volume><float name='scale' value='3'/></medium></shape>\n\
        <shape type='shapegroup' id='group'><shape type='cube'/></shape>\n<shape type='instance'><ref id='group'/>\
        <transform name='to_world'><matrix value='1 0 0 2  0 1 0 0  0 0 1 0  0 0 0 1'/></transform></shape>\n";
    let files = "<include filename='part.xml'/>\n<shape type='obj'><string name='filename' value='a.obj'/><ref id='part'/></shape>\n\
        <shape type='ply'><string name='filename' value='m.ply'/><boolean name='face_normals' value='true'/></shape>\n\
        <shape type='serialized'><string name='filename' value='m.serialized'/><integer name='shape_index' value='0'/>\
        <float name='max_smooth_angle' value='30'/></shape>\n\
        <bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='p.pfm'/>\
        <transform name='to_uv'><scale value='3'/></transform></texture></bsdf>\n\
        <emitter type='envmap'><string name='filename' value='p.pfm'/><float name='scale' value='2'/></emitter>\n";
    let lights = "<emitter type='point'><point name='position' value='0 2 0'/><spectrum name='intensity' value='400:1, 700:2'/></emitter>\n\
        <emitter type='spot'><float name='cutoff_angle' value='20'/><float name='beam_width' value='10'/></emitter>\n\
        <emitter type='directional'><vector name='direction' value='0 -1 0'/></emitter>\n<emitter type='constant'/>\n\
        <shape type='sphere'/>\n";
    let old = "<luminaire type='constant'><blackbody name='radiance' temperature='5000K'/></luminaire>\n\
        <shape type='sphere'><transform name='toWorld'><lookAt origin='0 0 5' target='0 0 0' up='0 1 0'/></transform>\n\
        <bsdf type='phong'><srgb name='diffuseReflectance' value='#808080'/><float name='exponent' value='20'/></bsdf></shape>\n\
        <bsdf type='diffuse' id='x'/><alias id='x' as='y'/>\n";
    vec![
        scene("3.0.0", &(materials.clone() + shapes)),
        scene("3.0.0", &(materials + files)),
        scene("3.0.0", lights),
        scene("0.6.0", old),
    ]
}

/// Scenes with a sky, which takes longer to compute than anything else in a small scene.
fn sky() -> Vec<Vec<u8>> {
    let body = "<emitter type='sunsky'><float name='turbidity' value='3'/><rgb name='albedo' value='0.1 0.2 0.3'/>\
        <vector name='sun_direction' value='0.3 0.9 0'/><float name='sun_scale' value='2'/></emitter>\n\
        <emitter type='sky'><transform name='to_world'><rotate x='1' angle='90'/></transform></emitter>\n\
        <shape type='sphere'/>\n";
    vec![scene("3.0.0", body), scene("0.6.0", &body.replace("sun_d", "sunD"))]
}

/// Small valid files of a kind that the loaders read.
pub(crate) fn files(kind: &str) -> Vec<Vec<u8>> {
    match kind {
        "xml" => xml(),
        "sky" => sky(),
        "pbrt" => pbrt(),
        "obj" => obj(),
        "mtl" => mtl(),
        "ply" => ply(),
        "serialized" => serialized(),
        "vol" => volumes(),
        "jpg" | "tga" | "bmp" => files_in("crates/gi-scene/tests/fuzz/pictures", kind),
        _ => pictures(kind),
    }
}

/// The files of this kind in a folder of the repository.
fn files_in(folder: &str, kind: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(crate::ROOT).join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let of_kind = paths.iter().filter(|path| path.extension().is_some_and(|e| e == kind));
    of_kind.map(|path| std::fs::read(path).unwrap()).collect()
}

/// The scenes of the tests of the format, and one that uses the companions.
pub(crate) fn pbrt() -> Vec<Vec<u8>> {
    let companions = "WorldBegin\nLightSource \"infinite\" \"string filename\" \"p.pfm\"\n\
        Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"p.pfm\"\n\
        Material \"conductor\" \"texture roughness\" \"t\" \"string normalmap\" \"p.pfm\"\n\
        Shape \"plymesh\" \"string filename\" \"m.ply\" \"texture alpha\" \"t\"\n";
    let mut files = files_in("crates/gi-scene/tests/pbrt/scenes", "pbrt");
    files.push(companions.into());
    files
}

pub(crate) fn obj() -> Vec<Vec<u8>> {
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 0 1e3\nf 1/1 2/2 3/3\n";
    let wide = OBJ.replace("usemtl m\n", "usemtl \"m\"\r\n");
    [OBJ, plain, &wide].map(|text| text.as_bytes().to_vec()).to_vec()
}

pub(crate) fn mtl() -> Vec<Vec<u8>> {
    let other = "newmtl m\nKd spectral a.rfl\nKd xyz 0.3 0.3\nKd 0.5\nmap_Ke p.pfm\nmap_Kd -clamp on p.pfm # red\nNs 1e3\n";
    [LIBRARY, other].map(|text| text.as_bytes().to_vec()).to_vec()
}

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n\
         element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

pub(crate) fn ply() -> Vec<Vec<u8>> {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5f32]];
    let mut text = ply_header("ascii").into_bytes();
    let mut little = ply_header("binary_little_endian").into_bytes();
    let mut big = ply_header("binary_big_endian").into_bytes();
    for [x, y, z] in points {
        let numbers = [x, y, z, 0.0, 0.0, 1.0, x, y];
        text.extend(numbers.map(|v| format!("{v} ")).concat().bytes().chain(*b"\n"));
        little.extend(numbers.map(f32::to_le_bytes).concat());
        big.extend(numbers.map(f32::to_be_bytes).concat());
    }
    text.extend(*b"3 0 1 2\n3 0 2 3\n");
    for face in [[0, 1, 2], [0, 2, 3i32]] {
        little.push(3);
        little.extend(face.map(i32::to_le_bytes).concat());
        big.push(3);
        big.extend(face.map(i32::to_be_bytes).concat());
    }
    vec![text, little, big]
}

pub(crate) fn serialized() -> Vec<Vec<u8>> {
    [Compression::none(), Compression::best()].map(one_serialized).to_vec()
}

/// Two meshes: one of floats with normals and coordinates, one of doubles. Without compression, damage reaches their
/// numbers, though not their checksum.
fn one_serialized(level: Compression) -> Vec<u8> {
    let (mut out, mut offsets) = (Vec::new(), Vec::new());
    for flags in [0x1003u32, 0x2000] {
        offsets.push(out.len() as u64);
        out.extend([0x041cu16, 4].map(u16::to_le_bytes).concat());
        let mut zip = ZlibEncoder::new(&mut out, level);
        let mut body = flags.to_le_bytes().to_vec();
        body.extend(*b"name\0");
        body.extend([3u64, 1].map(u64::to_le_bytes).concat());
        let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f64];
        if flags & 0x2000 != 0 {
            body.extend(positions.map(f64::to_le_bytes).concat());
        } else {
            body.extend(positions.map(|v| (v as f32).to_le_bytes()).concat());
            body.extend([[0.0, 0.0, 1.0f32]; 3].concat().iter().flat_map(|v| v.to_le_bytes()));
            body.extend([0.0, 0.0, 1.0, 0.0, 0.0, 1.0f32].map(f32::to_le_bytes).concat());
        }
        body.extend([0u32, 1, 2].map(u32::to_le_bytes).concat());
        zip.write_all(&body).unwrap();
        zip.finish().unwrap();
    }
    offsets.iter().for_each(|at| out.extend(at.to_le_bytes()));
    out.extend(2u32.to_le_bytes());
    out
}

/// Grids of one and of three channels.
pub(crate) fn volumes() -> Vec<Vec<u8>> {
    let one = |size: [i32; 3], channels: i32| {
        let mut out = b"VOL\x03".to_vec();
        let [x, y, z] = size;
        out.extend([1, x, y, z, channels].map(i32::to_le_bytes).concat());
        out.extend([0.0, 0.0, 0.0, 1.0, 2.0, 1.0f32].map(f32::to_le_bytes).concat());
        let count = x * y * z * channels;
        out.extend((0..count).flat_map(|k| (k as f32 / count as f32).to_le_bytes()));
        out
    };
    vec![one([2, 2, 2], 1), one([3, 1, 2], 3)]
}

pub(crate) fn scene_of_volume() -> String {
    let volume = |name, wrap| {
        format!(
            "<volume type='gridvolume' name='{name}'><string name='filename' value='v.vol'/>\
             <string name='wrap_mode' value='{wrap}'/><boolean name='use_grid_bbox' value='true'/></volume>"
        )
    };
    let body = format!(
        "<medium type='heterogeneous' id='m'>{}{}</medium>\n<shape type='cube'><ref name='interior' id='m'/></shape>\n",
        volume("sigma_t", "mirror"),
        volume("albedo", "clamp")
    );
    String::from_utf8(scene("3.0.0", &body)).expect("text")
}

/// Pictures of a format that we write.
pub(crate) fn pictures(kind: &str) -> Vec<Vec<u8>> {
    let folder = Folder::new();
    let picture = |[w, h]: [usize; 2], more: &[&str]| {
        let path = folder.path(&format!("a.{kind}"));
        let format = ImageFile::from_path(&path).expect("a known format");
        let pixels = (0..w * h).map(|i| [i as f32 / 8.0, 0.5, 1.0 / (i + 1) as f32]);
        let mut layers = Layers::of_rgb([w, h], pixels);
        layers.channels.extend(more.iter().map(|name| (name.to_string(), vec![0.5; w * h])));
        write_file(&path, format, &layers).unwrap();
        std::fs::read(path).unwrap()
    };
    vec![picture([2, 2], &[]), picture([5, 3], &[]), picture([16, 9], &["Z", "Direct.R"])]
}

pub(crate) fn scene_of_mesh(kind: &str) -> String {
    let shape = format!(
        "<shape type='{kind}'><string name='filename' value='m.{kind}'/></shape>\n\
         <shape type='{kind}'><string name='filename' value='m.{kind}'/><float name='max_smooth_angle' value='40'/></shape>\n"
    );
    String::from_utf8(scene("3.0.0", &shape)).expect("text")
}

pub(crate) fn scene_of_picture(kind: &str) -> String {
    let file = format!("<string name='filename' value='p.{kind}'/>");
    let body = format!(
        "<shape type='rectangle'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>{file}</texture></bsdf></shape>\n\
         <shape type='rectangle'><emitter type='area'><texture type='bitmap' name='radiance'>{file}</texture></emitter></shape>\n\
         <emitter type='envmap'>{file}</emitter>\n"
    );
    String::from_utf8(scene("3.0.0", &body)).expect("text")
}
