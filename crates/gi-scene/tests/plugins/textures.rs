//! Textures of one channel, and bent normals in files of each version.

use gi_core::material::BentNormals;

use super::*;
use crate::common::Folder;

const BOARD: &str =
    "<float name='color0' value='0.1'/><float name='color1' value='0.3'/></texture>";

/// The value of a checkerboard's first square.
fn first(texture: &Texture) -> f32 {
    texture.eval(Vec2::splat(0.25)).r
}

#[test]
fn a_checkerboard_of_roughness_or_opacity_has_the_colours_of_mitsuba_3_swapped() {
    let rough = format!(
        "<bsdf type='roughconductor'><texture type='checkerboard' name='alpha'>{BOARD}</bsdf>"
    );
    let Material::Conductor { roughness: Some(r), .. } = material(&rough) else { panic!() };
    assert_eq!([first(&r.alpha_u), first(&r.alpha_v)], [0.3, 0.3]);
    let mask = format!(
        "<bsdf type='mask'><texture type='checkerboard' name='opacity'>{BOARD}<bsdf type='diffuse'/></bsdf>"
    );
    let Material::Mask { opacity, .. } = material(&mask) else { panic!() };
    assert_eq!(first(&opacity), 0.3);
    let old = old_scene(&format!("<shape type='cube'>{mask}</shape>"));
    let Material::Mask { opacity, .. } = of_only_shape(&old) else { panic!() };
    assert_eq!(first(&opacity), 0.1);
    let paint = format!(
        "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'>{BOARD}</bsdf>"
    );
    let Material::Diffuse { reflectance } = material(&paint) else { panic!() };
    assert_eq!(first(&reflectance), 0.1);
}

#[test]
fn bump_maps_in_files_of_mitsuba_2_are_repaired_as_mitsuba_3_does() {
    let body = "<shape type='cube'><bsdf type='bumpmap'><texture type='checkerboard'/>
        <bsdf type='diffuse'/></bsdf></shape>";
    let normals = |version: &str| match of_only_shape(&Folder::new().scene(version, body).unwrap())
    {
        Material::Bump { normals, .. } => normals,
        other => panic!("{other:?}"),
    };
    let of = |repaired| BentNormals { flipped: repaired, shadowed: repaired };
    assert_eq!([normals("0.6.0"), normals("2.1.0")], [of(false), of(true)]);
}
