//! Scenes of any number of elements, one kind each.

use std::fmt::Write;
use std::path::PathBuf;

use super::common::Folder;

/// A kind of scene.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Write a scene of `n` elements.
    pub(crate) write: fn(&Folder, usize) -> PathBuf,
}

/// A scene with a camera, of the text of `n` elements and some text after them.
fn xml(folder: &Folder, n: usize, element: impl Fn(&mut String, usize), end: &str) -> PathBuf {
    let mut body = String::from("<scene version='3.0.0'><sensor type='perspective'/>\n");
    (0..n).for_each(|k| element(&mut body, k));
    body += end;
    body += "</scene>";
    folder.write("scene.xml", body)
}

/// The same in pbrt's format.
fn pbrt(folder: &Folder, n: usize, element: impl Fn(&mut String, usize)) -> PathBuf {
    let mut text = String::from("Camera \"perspective\"\nWorldBegin\n");
    (0..n).for_each(|k| element(&mut text, k));
    folder.write("scene.pbrt", text)
}

macro_rules! kinds {
    ($($name:literal: |$folder:ident, $n:ident| $write:expr;)*) => {
        /// All kinds.
        pub(crate) const KINDS: &[Kind] = &[
            $(Kind { name: $name, write: |$folder, $n| $write },)*
        ];
    };
}

/// Text per element, from a format string whose only argument is the element's number.
macro_rules! each {
    ($text:literal) => {
        |out: &mut String, k: usize| writeln!(out, $text, k = k).expect("memory can be written to")
    };
}

const SHAPE: &str = "<shape type='sphere'/>";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

kinds! {
    "shapes": |f, n| xml(f, n, each!("<shape type='sphere' id='s{k}'/>"), "");
    "unknown references": |f, n| {
        let mut ids = String::new();
        (0..n).for_each(|k| each!("<bsdf type='null' id='b{k}'/>")(&mut ids, k));
        xml(f, n, each!("<ref id='c{k}'/>"), &ids)
    };
    "unknown aliases": |f, n| xml(f, n, each!("<bsdf type='null' id='b{k}'/><alias id='c{k}' as='d{k}'/>"), SHAPE);
    "shapes with an unknown parameter": |f, n| {
        xml(f, n, each!("<shape type='sphere'><float name='radus{k}' value='1'/></shape>"), "")
    };
    "unknown parameters of one shape": |f, n| {
        let body = each!("<float name='radus{k}' value='1'/>");
        let mut all = String::from("<shape type='sphere'>");
        (0..n).for_each(|k| body(&mut all, k));
        xml(f, 0, each!("{k}"), &(all + "</shape>"))
    };
    "unknown tags": |f, n| xml(f, n, each!("<aaa{k}/>"), SHAPE);
    "unknown plugins": |f, n| xml(f, n, each!("<shape type='sfere{k}'/>"), "");
    "numbers that are none": |f, n| {
        xml(f, n, each!("<shape type='sphere'><float name='radius' value='x{k}'/></shape>"), "")
    };
    "ids used twice": |f, n| xml(f, n, each!("<shape type='sphere' id='a'/><!--{k}-->"), "");
    "names (default)": |f, n| xml(f, n, each!("<default name='d{k}' value='1'/>"), SHAPE);
    "names that are used": |f, n| {
        xml(f, n, each!("<default name='d{k:07}' value='1'/><shape type='sphere'><float name='radius' value='$d{k:07}'/></shape>"), "")
    };
    "names that are not defined": |f, n| {
        xml(f, n, each!("<default name='d{k}' value='1'/><shape type='sphere'><float name='radius' value='$e{k}'/></shape>"), "")
    };
    "an included file used 1,000 times": |f, n| {
        let times = 1000.min(n);
        let mut part = String::from("<scene version='3.0.0'>");
        (0..n / times).for_each(|_| part += SHAPE);
        f.write("part.xml", part + "</scene>");
        xml(f, times, |out, _| *out += "<include filename='part.xml'/>\n", "")
    };
    "meshes that are missing": |f, n| {
        xml(f, n, each!("<shape type='obj'><string name='filename' value='{k}.obj'/></shape>"), "")
    };
    "search folders and missing meshes": |f, n| {
        xml(f, n, each!("<path value='p{k}'/><shape type='obj'><string name='filename' value='{k}.obj'/></shape>"), "")
    };
    "uses of one mesh": |f, n| {
        f.write("m.obj", format!("{TRIANGLE}f 1 2 3\n"));
        xml(f, n, each!("<shape type='obj'><string name='filename' value='m.obj'/></shape><!--{k}-->"), "")
    };
    "meshes of one file": |f, n| {
        f.write("m.serialized", [0u8; 1000]);
        xml(f, n, each!("<shape type='serialized'><string name='filename' value='m.serialized'/><integer name='shape_index' value='{k}'/></shape>"), "")
    };
    "uses of one picture": |f, n| {
        f.write("p.pfm", [b"PF\n64 64\n-1.0\n".as_slice(), &[0; 64 * 64 * 12]].concat());
        let head = "<bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='p.pfm'/></texture></bsdf><!--";
        xml(f, n, |out, k| { *out += head; each!("{k}-->")(out, k); }, SHAPE)
    };
    "attributes of one element": |f, n| {
        let mut all = String::from("<shape type='sphere'");
        (0..n).for_each(|k| each!(" a{k}=''")(&mut all, k));
        xml(f, 0, each!("{k}"), &(all + "/>"))
    };
    "nested namespaces": |f, n| xml(f, n, each!("<shape xmlns:n{k}='u{k}'>"), &"</shape>".repeat(n));
    "nested elements": |f, n| xml(f, n, each!("<shape type='sphere'><!--{k}-->"), &"</shape>".repeat(n));
    "materials of an OBJ file": |f, n| {
        let mut obj = String::from("mtllib a.mtl\n") + TRIANGLE;
        let mut library = String::new();
        (0..n).for_each(|k| each!("newmtl m{k}\nKd 0.5\nmap_Ks a.png")(&mut library, k));
        (0..n).for_each(|k| each!("usemtl m{k}\nf 1 2 3")(&mut obj, k));
        f.write("a.mtl", library);
        f.write("a.obj", obj)
    };
    "unknown materials of an OBJ file": |f, n| {
        let mut obj = String::from(TRIANGLE);
        (0..n).for_each(|k| each!("usemtl m{k}\nf 1 2 3")(&mut obj, k));
        f.write("a.obj", obj)
    };
    "libraries that are missing": |f, n| {
        let mut obj = String::from(TRIANGLE);
        (0..n).for_each(|k| each!("mtllib l{k}.mtl")(&mut obj, k));
        f.write("a.obj", obj + "f 1 2 3\n")
    };
    "errors of a library": |f, n| {
        let mut library = String::from("newmtl m\n");
        (0..n).for_each(|k| each!("Kd x{k}")(&mut library, k));
        f.write("a.mtl", library);
        f.write("a.obj", format!("mtllib a.mtl\n{TRIANGLE}f 1 2 3\n"))
    };
    "faces of an OBJ file": |f, n| {
        let mut obj = String::new();
        (0..n).for_each(|k| each!("v {k} 0 0\nv {k} 1 0\nv {k} 0 1\nf -1 -2 -3")(&mut obj, k));
        f.write("a.obj", obj)
    };
    "faces of a PLY file": |f, n| {
        let mut ply = format!("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face {n}\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n");
        (0..n).for_each(|_| ply += "3 0 1 2\n");
        f.write("m.ply", ply);
        xml(f, 1, each!("<!--{k}-->"), "<shape type='ply'><string name='filename' value='m.ply'/></shape>")
    };
    "faces around one point, with max_smooth_angle": |f, n| {
        let mut obj = String::from("v 0 0 0\n");
        for k in 0..=n {
            let (sin, cos) = (k as f64 / n as f64 * 6.0).sin_cos();
            writeln!(obj, "v {cos} {sin} {}", 0.5 + 0.4 * (k as f64).sin()).expect("memory can be written to");
        }
        (0..n).for_each(|k| writeln!(obj, "f 1 {} {}", k + 2, k + 3).expect("memory can be written to"));
        f.write("a.obj", obj);
        let mesh = "<shape type='obj'><string name='filename' value='a.obj'/><float name='max_smooth_angle' value='40'/></shape>";
        xml(f, 0, each!("{k}"), mesh)
    };
    "pbrt shapes": |f, n| pbrt(f, n, each!("Translate 0 0 {k}\nShape \"sphere\""));
    "pbrt meshes": |f, n| pbrt(f, n, each!("Shape \"trianglemesh\" \"point3 P\" [{k} 0 0 1 0 0 0 1 0]"));
    "numbers of a pbrt mesh": |f, n| {
        let mut points = String::from("Shape \"trianglemesh\" \"point3 P\" [");
        (0..n).for_each(|k| each!("{k} 0 0 1 0 0 0 1 0")(&mut points, k));
        points += "] \"integer indices\" [";
        (0..n).for_each(|k| write!(points, "{} {} {} ", 3 * k, 3 * k + 1, 3 * k + 2).expect("memory can be written to"));
        pbrt(f, 1, |out, _| { *out += &points; *out += "]"; })
    };
    "pbrt materials": |f, n| {
        pbrt(f, n, each!("MakeNamedMaterial \"m{k}\" \"string type\" \"diffuse\"\nNamedMaterial \"m{k}\"\nShape \"sphere\""))
    };
    "unknown pbrt materials": |f, n| {
        pbrt(f, n, each!("MakeNamedMaterial \"m{k}\" \"string type\" \"diffuse\"\nNamedMaterial \"l{k}\"\nShape \"sphere\""))
    };
    "pbrt textures": |f, n| {
        pbrt(f, n, each!("Texture \"t{k}\" \"float\" \"checkerboard\"\nShape \"sphere\" \"texture alpha\" \"t{k}\""))
    };
    "attributes of pbrt": |f, n| {
        pbrt(f, n, each!("Attribute \"shape\" \"float a{k}\" 1\nAttributeBegin\nShape \"sphere\"\nAttributeEnd"))
    };
    "unknown pbrt directives": |f, n| pbrt(f, n, each!("Spere{k} \"a\" \"float b\" 1"));
    "unknown pbrt parameters": |f, n| pbrt(f, n, each!("Shape \"sphere\" \"float radus{k}\" 1"));
    "parameters of one pbrt shape": |f, n| {
        let mut all = String::from("Shape \"sphere\"");
        (0..n).for_each(|k| each!(" \"float radus{k}\" 1")(&mut all, k));
        pbrt(f, 1, |out, _| *out += &all)
    };
    "open pbrt attributes": |f, n| pbrt(f, n, each!("AttributeBegin # {k}"));
    "open strings of pbrt": |f, n| pbrt(f, n, each!("Shape \"sphere{k}"));
    "pbrt instances": |f, n| {
        pbrt(f, n, each!("ObjectBegin \"o{k}\"\nShape \"sphere\"\nObjectEnd\nObjectInstance \"o{k}\""))
    };
    "pbrt area lights": |f, n| pbrt(f, n, each!("AreaLightSource \"diffuse\" \"float scale\" {k}\nShape \"sphere\""));
    "an included pbrt file": |f, n| {
        let times = 1000.min(n);
        f.write("part.pbrt", "Shape \"sphere\"\n".repeat(n / times));
        pbrt(f, times, |out, _| *out += "Include \"part.pbrt\"\n")
    };
    "shapes that share a mesh": |f, n| {
        f.write("a.obj", format!("{TRIANGLE}f 1 2 3\n"));
        xml(f, n, each!("<shape type='obj'><string name='filename' value='a.obj'/></shape><!--{k}-->"), "")
    };
}
