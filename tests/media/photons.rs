//! Photons in media, compared with the volumetric path tracer.

use super::*;

/// A ball of mist with a point light beside it, over a floor: `volpath` finds all of its light.
fn misty() -> World {
    let floor = [[-2.0, -1.0, -2.0], [-2.0, -1.0, 2.0], [2.0, -1.0, 2.0], [2.0, -1.0, -2.0]];
    let mist = Medium { sigma_t: Rgb::new(2.0, 1.5, 1.0), ..medium(0.0, 0.9, 0.4) };
    let parts = SceneParts {
        shapes: vec![
            ball(Vec3::ZERO, 0.8, 1, 0),
            Shape::new("floor", polygon(&floor.map(Vec3::from_array)), 0),
        ],
        materials: vec![grey(0.5), Material::Null],
        media: vec![mist],
        lights: vec![LightSource::Point {
            position: Vec3::new(-0.9, 0.9, 0.3),
            intensity: Rgb::WHITE,
        }],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::new(0.3, 0.2, 2.6), Vec3::ZERO, Vec3::Y, 0.6, [24, 24]);
    World::new(parts, &camera)
}

/// Largest fraction of light that photons in a ball of medium lose because discs extend beyond the edge. Beyond a flat
/// edge, the part of the disc is mirrored back. For a disc of radius r, the edge of a ball of radius R curves away from
/// that plane by r^2 / 2 R. Times 3 / R of surface per volume, this gives 1.5 (r / R)^2. With uniform density, r is (k
/// / n)^(1/3) times R; at the lit side, it is at most twice that.
fn lost_over_the_edge(k: usize, n: usize) -> f64 {
    2.0 * 1.5 * (k as f64 / n as f64).powf(2.0 / 3.0)
}

#[test]
fn photons_in_a_medium_agree_with_the_volumetric_path_tracer() {
    let world = misty();
    for (max_depth, show, k, n) in [
        (None, Show::Direct, 12, 5_000),
        (None, Show::Indirect, 12, 40_000),
        (None, Show::Indirect, 3, 160_000),
        (Some(3), Show::Indirect, 3, 160_000),
    ] {
        let limits = PathLimits { max_depth, ..PathLimits::default() };
        let params = Params { mode: Mode::VolPath, limits, ..Params::default() };
        let (truth, noise) = mean_and_variance(&world.render::<PathTracer>(&params, 512, 1, show));
        let params = photonmap::Params {
            limits,
            photons: 20_000,
            volume_photons: n,
            volume_lookup: k,
            ..photonmap::Params::default()
        };
        // The variance between maps of the same size is estimated from several seeds.
        let mut means = gi_stats::Running::default();
        for seed in 0..6 {
            means.push(mean_and_variance(&world.render::<PhotonMapping>(&params, 8, seed, show)).0);
        }
        let error = (noise + means.variance_of_mean()).sqrt() / truth;
        // Single scattering is sampled, without bias.
        let lost = if show == Show::Direct { 0.0 } else { lost_over_the_edge(k, n) };
        let off = means.mean() / truth - 1.0;
        let name = format!("{show:?}, {max_depth:?}, k = {k}, n = {n}");
        assert!(error < 0.008, "{name}: noise {error:.1e}");
        assert!(off < 4.0 * error && off > -lost - 4.0 * error, "{name}: {off:.1e} +- {error:.1e}");
    }
}

#[test]
fn a_glass_ball_with_photons_of_albedo_one_is_invisible_in_a_white_furnace() {
    // Light enters and leaves only through a dielectric boundary: no light is sampled, so all light is in the map.
    let glass = Material::Dielectric {
        eta: 1.5,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness: None,
    };
    let parts = SceneParts {
        shapes: vec![ball(Vec3::ZERO, 0.6, 0, 0)],
        materials: vec![glass],
        media: vec![medium(4.0, 1.0, 0.0)],
        lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::new(0.0, 0.0, -2.0), Vec3::ZERO, Vec3::Y, 0.4, [16, 16]);
    let world = World::new(parts, &camera);
    let mut means = gi_stats::Running::default();
    // No surface here can store a photon.
    let (photons, caustic_photons, volume_photons) = (1, 0, 40_000);
    let params = photonmap::Params {
        photons,
        caustic_photons,
        volume_photons,
        volume_lookup: 3,
        ..photonmap::Params::default()
    };
    for seed in 0..10 {
        let film = world.render::<PhotonMapping>(&params, 8, seed, Show::All);
        means.push(mean_and_variance(&film).0);
    }
    let error = means.variance_of_mean().sqrt();
    assert!(error < 0.01, "noise {error:.1e}");
    let (off, lost) = (means.mean() - 1.0, lost_over_the_edge(3, volume_photons));
    assert!(off < 4.0 * error && off > -lost - 4.0 * error, "{off:.1e} +- {error:.1e}");
}
