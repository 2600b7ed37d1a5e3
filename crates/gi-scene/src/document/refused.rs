//! Plugins of Mitsuba that are known but not supported: why, and what to use instead.

/// Tag, plugin, reason, advice.
#[rustfmt::skip]
const REFUSED: [(&str, &str, &str, &str); 30] = [
    ("shape", "bsplinecurve", CURVES, TUBES),
    ("shape", "linearcurve", CURVES, TUBES),
    ("shape", "hair", CURVES, TUBES),
    ("shape", "ellipsoids", "clouds of ellipsoids are not traced", SPHERES),
    ("shape", "ellipsoidsmesh", "clouds of ellipsoids are not traced", SPHERES),
    ("shape", "merge", "it only joins meshes", "put its shapes into the scene themselves: they need no joining here"),
    ("shape", "heightfield", "height fields are not traced", "convert it to a mesh"),
    ("shape", "deformable", "nothing moves here", "use the mesh of one moment"),
    ("bsdf", "hair", "there are no curves that it could be on", "use `roughplastic` or `principled`"),
    ("bsdf", "measured", MEASURED, "fit a `principled` or `roughconductor` to it"),
    ("bsdf", "measured_polarized", MEASURED, "fit a `principled` or `roughconductor` to it"),
    ("bsdf", "irawan", "woven cloth is not supported", "use `roughdiffuse` or `principled` with sheen"),
    ("bsdf", "hk", "subsurface scattering in a layer is not supported", "use `principledthin` with `diff_trans`"),
    ("bsdf", "difftrans", "it transmits diffuse light only", "use `principledthin` with `diff_trans` 2"),
    ("emitter", "directionalarea", "paths from the eye cannot find light in a single direction", "use `directional`, or `spot` with a small angle"),
    ("emitter", "timed_sunsky", "skies are of one moment", "use `sunsky` with an hour"),
    ("texture", "volume", "textures are functions of the surface", "bake it into a `bitmap`"),
    ("texture", "curvature", "textures do not know the geometry", "bake it into a `bitmap`"),
    ("texture", "wireframe", "textures do not know the geometry", "bake it into a `bitmap`, or use `gridtexture`"),
    ("texture", "vertexcolors", "it is the old name of `mesh_attribute`", "use `mesh_attribute` with the name `vertex_color`"),
    ("texture", "exrtexture", OLD_BITMAP, "use `bitmap`"),
    ("texture", "ldrtexture", OLD_BITMAP, "use `bitmap`"),
    ("phase", "rayleigh", PHASE, "use `isotropic`, which has the same mean cosine"),
    ("phase", "sggx", PHASE, "use `isotropic` or `hg`"),
    ("phase", "kkay", PHASE, "use `isotropic` or `hg`"),
    ("phase", "tabphase", PHASE, "use `hg` with the table's mean cosine"),
    ("phase", "blendphase", PHASE, "use `hg` with the mean cosine of the blend"),
    ("sensor", "spherical", "only flat pictures are made", "use `perspective`"),
    ("sensor", "irradiancemeter", "only pictures are made", "look at the shape with `orthographic`"),
    ("sensor", "radiancemeter", "only pictures are made", "use `perspective` with a small angle"),
];

const CURVES: &str = "curves are not traced";
const TUBES: &str = "convert them to meshes of thin tubes";
const SPHERES: &str = "use `sphere` with a `to_world`, or a mesh";
const MEASURED: &str = "measured tables are not read";
const OLD_BITMAP: &str = "it is an old name";
const PHASE: &str = "only `isotropic`, `hg` and `rayleigh` are supported";

/// Why a plugin is not supported, and what to use instead; `None` if it is not known either.
pub(super) fn reason(tag: &str, plugin: &str) -> Option<(&'static str, &'static str)> {
    let known = REFUSED.iter().find(|(t, p, ..)| (*t, *p) == (tag, plugin))?;
    Some((known.2, known.3))
}
