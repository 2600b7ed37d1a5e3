//! Lights and media.

use super::*;

#[test]
fn lights_have_their_defaults() {
    let light = |inner: &str| scene(inner).parts.lights[0].clone();
    let LightSource::Spot { cutoff, beam, direction, intensity, .. } =
        light("<emitter type='spot'/>")
    else {
        panic!()
    };
    assert!((cutoff.to_degrees() - 20.0).abs() < 1e-4 && (beam.to_degrees() - 15.0).abs() < 1e-4);
    assert_eq!((direction, intensity), (Vec3::Z, Rgb::WHITE));
    let moved =
        "<emitter type='point'><transform name='to_world'><translate y='2'/></transform></emitter>";
    let LightSource::Point { position, .. } = light(moved) else { panic!() };
    assert_eq!(position, Vec3::new(0.0, 2.0, 0.0));
    let sunny = "<emitter type='directional'><vector name='direction' x='0' y='-2'/></emitter>";
    let LightSource::Directional { direction, .. } = light(sunny) else { panic!() };
    assert_eq!(direction, -Vec3::Y);
    assert!(matches!(
        light("<emitter type='constant'/>"),
        LightSource::Constant { radiance: Rgb::WHITE }
    ));
    let old = old_scene("<emitter type='constant'><spectrum name='radiance' value='2'/></emitter>");
    assert!(
        matches!(old.parts.lights[0], LightSource::Constant { radiance } if radiance == Rgb::grey(2.0))
    );
    let new = light("<emitter type='constant'><spectrum name='radiance' value='1'/></emitter>");
    let LightSource::Constant { radiance } = new else { panic!() };
    assert!((radiance.r - 1.204_794).abs() < 1e-6, "one number is equal energy in Mitsuba 3");
}

#[test]
fn sunsky_is_a_picture_and_a_disc() {
    let loaded = scene("<emitter type='sunsky'/>");
    let [LightSource::Environment { .. }, LightSource::DistantDisc { direction, .. }] =
        loaded.parts.lights.as_slice()
    else {
        panic!()
    };
    let mitsuba = Vec3::new(0.051_385, 0.691_748, 0.720_308);
    assert!((*direction - mitsuba).length() < 5e-3, "{direction}");
    assert_eq!(scene("<emitter type='sun'/>").parts.lights.len(), 1);
    assert_eq!(scene("<emitter type='sky'/>").parts.lights.len(), 1);
    let night = scene("<emitter type='sunsky'><float name='hour' value='1'/></emitter>");
    assert!(night.parts.lights.is_empty() && !night.warnings.is_empty());
}

#[test]
fn a_shape_may_refer_to_an_area_light_of_the_scene() {
    let loaded = scene(
        "<sensor type='perspective'/><emitter type='area' id='e'><rgb name='radiance' value='2'/></emitter>
         <shape type='rectangle'><ref id='e'/></shape>",
    );
    assert_eq!(constant(loaded.parts.shapes[0].emission.as_ref().unwrap()), Rgb::grey(2.0));
    assert!(loaded.warnings.is_empty() && loaded.parts.lights.is_empty());
    let lost = scene("<emitter type='area'/><shape type='cube'/>");
    assert!(lost.warnings[0].contains("belongs to no shape: ignored"), "{:?}", lost.warnings);
}

#[test]
fn a_spot_with_a_picture_is_a_projector() {
    let light = |inner: &str| {
        scene(&format!("<sensor type='perspective'/><emitter type='spot'>{inner}</emitter>"))
    };
    let board = "<texture type='checkerboard' name='texture'><rgb name='color0' value='0.5'/>
        <rgb name='color1' value='4'/></texture><rgb name='intensity' value='3'/>";
    let LightSource::Projector { axes, intensity, picture, .. } =
        light(board).parts.lights[0].clone()
    else {
        panic!()
    };
    assert_eq!((axes, intensity), ([Vec3::X, Vec3::Y, Vec3::Z], Rgb::grey(12.0)));
    assert_eq!(picture.mean(), Rgb::grey((0.5 + 4.0) / 2.0 / 4.0), "at most one");
    assert!(light(board).warnings.is_empty());
}

#[test]
fn a_projector_is_a_camera_that_shines() {
    let light = |inner: &str| {
        let loaded = scene(&format!(
            "<emitter type='projector'><float name='fov' value='90'/>{inner}</emitter>"
        ));
        loaded.parts.lights[0].clone()
    };
    let LightSource::Projector {
        intensity, cutoff, beam, window: Window::Irradiance(half), ..
    } = light("<float name='scale' value='2'/><rgb name='irradiance' value='3'/>")
    else {
        panic!()
    };
    assert!(
        (half - Vec2::ONE).length() < 1e-6
            && (cutoff.tan() - 2f32.sqrt()).abs() < 1e-5
            && beam == cutoff
    );
    // Irradiance pi * 6 at distance one: the intensity toward the corners is that over cos^3.
    let expected = std::f32::consts::PI * 6.0 * 3f32.powf(1.5);
    assert!((intensity.r / expected - 1.0).abs() < 1e-5, "{intensity:?}");
}

#[test]
fn a_collimated_beam_becomes_a_narrow_spot_of_the_same_power() {
    let loaded = scene("<emitter type='collimated'><rgb name='power' value='3'/></emitter>");
    let LightSource::Spot { intensity, cutoff, beam, direction, .. } = loaded.parts.lights[0]
    else {
        panic!()
    };
    assert_eq!((cutoff, direction), (beam, Vec3::Z));
    let solid_angle = f64::from(cutoff).powi(2) * std::f64::consts::PI;
    assert!((f64::from(intensity.r) * solid_angle - 3.0).abs() < 1e-4);
    assert!(loaded.warnings.iter().any(|w| w.contains("approximated by a spot")));
}

#[test]
fn media_have_their_defaults_and_either_parametrisation() {
    let medium = |inner: &str| {
        let body = format!(
            "<medium type='homogeneous' id='m'>{inner}</medium>
            <shape type='sphere'><bsdf type='null'/><ref name='interior' id='m'/></shape>"
        );
        let loaded = scene(&body);
        assert_eq!(
            (loaded.parts.shapes[0].interior, loaded.parts.shapes[0].exterior),
            (Some(MediumId::new(0)), None)
        );
        loaded.parts.media[0].clone()
    };
    let plain = Medium::homogeneous(Rgb::WHITE, Rgb::grey(0.75), Phase::Isotropic);
    assert_eq!(medium(""), plain);
    let split = medium(
        "<rgb name='sigmaS' value='1 2 3'/><rgb name='sigmaA' value='1 0 1'/><float name='scale' value='2'/>
         <phase type='hg'><float name='g' value='0.3'/></phase>",
    );
    assert_eq!(split.sigma_t, Rgb::new(4.0, 4.0, 8.0));
    assert_eq!(split.albedo, Rgb::new(0.5, 1.0, 0.75));
    assert_eq!(split.phase, Phase::HenyeyGreenstein { g: 0.3 });
}

#[test]
fn a_boundary_of_media_without_a_bsdf_is_invisible_in_the_old_format() {
    let body = "<shape type='sphere'><medium type='homogeneous' name='interior'/></shape>";
    assert!(matches!(of_only_shape(&old_scene(body)), Material::Null));
    assert!(matches!(of_only_shape(&scene(body)), Material::Diffuse { .. }));
}

#[test]
fn media_have_the_names_of_mitsuba_0_6() {
    let medium = |inner: &str| {
        let body = format!(
            "<medium type='homogeneous' id='m'>{inner}</medium>
            <shape type='sphere'><bsdf type='null'/><ref name='interior' id='m'/></shape>"
        );
        old_scene(&body).parts.media[0].clone()
    };
    let named =
        medium("<string name='material' value='wholemilk'/><float name='scale' value='0.5'/>");
    let scattered = named.albedo * named.sigma_t;
    for (got, want) in scattered.to_array().into_iter().zip([127.5, 160.5, 188.5]) {
        assert!((got - want).abs() < 1e-3, "{scattered:?}");
    }
    assert_eq!(medium(""), medium("<string name='material' value='Skin1'/>"));
    let wrong = "<medium type='homogeneous'><string name='material' value='wholemilc'/></medium>";
    let shown = common::Folder::new().problems(wrong);
    assert!(shown.contains("unknown medium `wholemilc`") && shown.contains("Wholemilk"), "{shown}");
}
