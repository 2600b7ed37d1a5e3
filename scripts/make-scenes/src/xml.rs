//! Writes Mitsuba 3 XML as text.

use std::fmt::Display;

use glam::Vec3;

/// A scene: the camera, then the shapes and materials.
pub(crate) fn scene(about: &str, camera: &Camera, body: &[String]) -> String {
    let body: String = body.concat();
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- {about} Made by scripts/make-scenes. -->\n\
         <scene version=\"3.0.0\">\n{}{body}</scene>\n",
        indent(&camera.to_xml())
    )
}

/// A perspective camera.
pub(crate) struct Camera {
    pub(crate) origin: Vec3,
    pub(crate) target: Vec3,
    /// Horizontal field of view, degrees.
    pub(crate) fov: f32,
    pub(crate) size: [u32; 2],
}

impl Camera {
    fn to_xml(&self) -> String {
        let [w, h] = self.size;
        format!(
            "<default name=\"spp\" value=\"64\"/>\n\
             <integrator type=\"path\"/>\n\
             <sensor type=\"perspective\">\n\
             \x20   <float name=\"fov\" value=\"{}\"/>\n\
             \x20   <transform name=\"to_world\">\n\
             \x20       <lookat origin=\"{}\" target=\"{}\" up=\"0, 1, 0\"/>\n\
             \x20   </transform>\n\
             \x20   <sampler type=\"independent\">\n\
             \x20       <integer name=\"sample_count\" value=\"$spp\"/>\n\
             \x20   </sampler>\n\
             \x20   <film type=\"hdrfilm\">\n\
             \x20       <integer name=\"width\" value=\"{w}\"/>\n\
             \x20       <integer name=\"height\" value=\"{h}\"/>\n\
             \x20       <rfilter type=\"box\"/>\n\
             \x20   </film>\n\
             </sensor>\n",
            self.fov,
            list(self.origin),
            list(self.target)
        )
    }
}

/// A comment line.
pub(crate) fn comment(text: &str) -> String {
    format!("\n    <!-- {text} -->\n")
}

/// A scene parameter with its default.
pub(crate) fn default(name: &str, value: impl Display) -> String {
    format!("    <default name=\"{name}\" value=\"{value}\"/>\n")
}

/// A named material.
pub(crate) fn bsdf(id: &str, inner: &str) -> String {
    let inner = inner.replacen("<bsdf ", &format!("<bsdf id=\"{id}\" "), 1);
    indent(&inner)
}

/// A two-sided Lambertian material.
pub(crate) fn diffuse(rgb: [f32; 3]) -> String {
    two_sided(&format!("<bsdf type=\"diffuse\">\n    {}\n</bsdf>\n", color("reflectance", rgb)))
}

/// A material on both sides.
pub(crate) fn two_sided(inner: &str) -> String {
    format!("<bsdf type=\"twosided\">\n{}</bsdf>\n", indent(inner))
}

/// Clear glass.
pub(crate) fn glass() -> String {
    "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"1.5\"/>\n    <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n".into()
}

/// A metal, rough if `alpha` > 0.
pub(crate) fn metal(name: &str, alpha: f32) -> String {
    let material = format!("    <string name=\"material\" value=\"{name}\"/>\n");
    if alpha > 0.0 {
        format!(
            "<bsdf type=\"roughconductor\">\n{material}    <string name=\"distribution\" value=\"ggx\"/>\n    <float name=\"alpha\" value=\"{alpha}\"/>\n</bsdf>\n"
        )
    } else {
        format!("<bsdf type=\"conductor\">\n{material}</bsdf>\n")
    }
}

/// A plastic with a rough coat.
pub(crate) fn rough_plastic(rgb: [f32; 3], alpha: f32) -> String {
    format!(
        "<bsdf type=\"roughplastic\">\n    {}\n    <string name=\"distribution\" value=\"ggx\"/>\n    <float name=\"alpha\" value=\"{alpha}\"/>\n</bsdf>\n",
        color("diffuse_reflectance", rgb)
    )
}

/// A color parameter.
pub(crate) fn color(name: &str, [r, g, b]: [f32; 3]) -> String {
    format!("<rgb name=\"{name}\" value=\"{r}, {g}, {b}\"/>")
}

/// A mesh with a material, and optionally the radiance that it emits.
pub(crate) fn mesh(file: &str, material: &str, radiance: Option<[f32; 3]>) -> String {
    shape(
        "ply",
        &format!("<string name=\"filename\" value=\"meshes/{file}.ply\"/>\n"),
        material,
        radiance,
    )
}

/// A shape that separates media: `interior` is on the side opposite to its normal, `exterior` on the side of it.
pub(crate) fn parting(shape: &str, interior: Option<&str>, exterior: Option<&str>) -> String {
    let line = |side: &str, id: Option<&str>| {
        id.map_or(String::new(), |id| format!("        <ref name=\"{side}\" id=\"{id}\"/>\n"))
    };
    let media = line("interior", interior) + &line("exterior", exterior);
    shape.replace("    </shape>", &format!("{media}    </shape>"))
}

/// A sphere.
pub(crate) fn sphere(
    center: Vec3,
    radius: f32,
    material: &str,
    radiance: Option<[f32; 3]>,
) -> String {
    let body =
        format!("{}\n<float name=\"radius\" value=\"{radius}\"/>\n", point("center", center));
    shape("sphere", &body, material, radiance)
}

/// A shape of the given type.
pub(crate) fn shape(kind: &str, body: &str, material: &str, radiance: Option<[f32; 3]>) -> String {
    let emitter = radiance.map_or(String::new(), |c| {
        format!("<emitter type=\"area\">\n    {}\n</emitter>\n", color("radiance", c))
    });
    let inner = format!("{body}<ref id=\"{material}\"/>\n{emitter}");
    indent(&format!("<shape type=\"{kind}\">\n{}</shape>\n", indent(&inner)))
}

/// Sun and sky, with their scales as parameters and the zenith along y. `sun` is the world direction to the sun.
pub(crate) fn sun_and_sky(sun: Vec3) -> String {
    format!(
        "    <emitter type=\"sunsky\">\n\
         \x20       <float name=\"turbidity\" value=\"3\"/>\n\
         \x20       <vector name=\"sun_direction\" x=\"{}\" y=\"{}\" z=\"{}\"/>\n\
         \x20       <float name=\"sun_scale\" value=\"$sun\"/>\n\
         \x20       <float name=\"sky_scale\" value=\"$sky\"/>\n\
         \x20       <transform name=\"to_world\">\n\
         \x20           <rotate x=\"1\" angle=\"-90\"/>\n\
         \x20       </transform>\n\
         \x20   </emitter>\n",
        sun.x, sun.y, sun.z
    )
}

/// A point parameter.
pub(crate) fn point(name: &str, p: Vec3) -> String {
    format!("<point name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z)
}

/// Three numbers as text.
pub(crate) fn list(p: Vec3) -> String {
    format!("{}, {}, {}", p.x, p.y, p.z)
}

/// Indent every line by four spaces.
pub(crate) fn indent(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
}
