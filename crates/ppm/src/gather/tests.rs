use super::*;
use crate::photons::{Photon, Photons};
use gi_core::bsdf::Transport;
use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::material::Material;
use gi_core::ray::Ray;
use gi_core::scene::SceneParts;
use gi_core::texture::Texture;

/// The square from -1 to 1 in the plane y = 0, with its normal up.
fn floor(material: Material) -> Scene {
    let at = |x, z| Vec3::new(x, 0.0, z);
    let positions = vec![at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let mesh = Geometry::Mesh(Mesh { positions, triangles: triangles.into(), ..Mesh::default() });
    let materials = vec![material, Material::TwoSided { front: 0, back: 0 }];
    let shapes = vec![Shape::new("floor", mesh, 1)];
    Scene::new(SceneParts { shapes, materials, ..SceneParts::default() }).expect("a scene")
}

fn grey(albedo: f32) -> Material {
    Material::Diffuse { reflectance: Texture::grey(albedo) }
}

/// The result of gathering `photons` at the point that an eye above the origin sees.
fn seen(scene: &Scene, photons: Vec<Photon>, max_segments: Option<u32>) -> Gathered {
    let ray = Ray::new(Vec3::new(0.1, 1.0, 0.0), Vec3::new(-0.1, -1.0, 0.0).normalize());
    let (surface, _) = scene.intersect(&ray).expect("the floor");
    let wo = -ray.d;
    let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
    let covers = covers(&bsdf, wo, 0.1).expect("rough enough");
    let point =
        Point { surface: &surface, wo, bsdf: &bsdf, covers, max_segments, throughput: Rgb::WHITE };
    let discs = Discs { radius: 0.5, derivative: Some(0.6) };
    gather(&Photons::build(&[photons], 0.5), &point, discs)
}

/// A photon of power 2 from `wi` on a surface with normal `ng`.
fn photon(p: Vec3, wi: Vec3, ng: Vec3, kind: PhotonKind) -> Photon {
    let wi = wi.normalize();
    let normal = (ng * 127f32.copysign(wi.dot(ng))).to_array().map(|v| v.round() as i8);
    let value = Arrival { power: Rgb::grey(2.0), wi, normal, kind, segments: 2 };
    Photon { p, value }
}

#[test]
fn photons_count_by_their_kind_with_the_brdf() {
    let near = |kind| photon(Vec3::X * 0.4, Vec3::new(0.3, 1.0, 0.2), Vec3::Y, kind);
    let found = seen(
        &floor(grey(0.5)),
        vec![near(PhotonKind::Caustic), near(PhotonKind::Indirect), near(PhotonKind::Indirect)],
        None,
    );
    assert_eq!(found.photons, 3);
    let one = 2.0 * 0.5 * gi_core::math::INV_PI;
    assert!((found.caustic.g - one).abs() < 1e-6 && (found.indirect.g - 2.0 * one).abs() < 1e-6);
}

#[test]
fn photons_from_behind_change_neither_count_nor_flux() {
    let below =
        |x: f32, y: f32| photon(Vec3::new(x, y, 0.0), -Vec3::Y, Vec3::Y, PhotonKind::Indirect);
    // On the other side of a sheet without thickness, and on the far side of a thin plate.
    let behind = vec![below(0.1, 0.0), below(-0.2, 0.0), below(0.0, -0.01)];
    for material in [grey(0.5), plastic()] {
        let found = seen(&floor(material), behind.clone(), None);
        assert_eq!((found.photons, found.indirect), (0, Rgb::BLACK));
        assert_eq!((found.laplacian, found.squares), (0.0, 0.0));
    }
}

#[test]
fn photons_that_are_absorbed_or_on_another_surface_do_not_count() {
    let up = |p, ng| photon(p, Vec3::new(0.4, 1.0, 0.0), ng, PhotonKind::Indirect);
    assert_eq!(seen(&floor(grey(0.0)), vec![up(Vec3::X * 0.2, Vec3::Y)], None).photons, 0);
    // Photons on a wall that stands on the floor, outside the radius, or on a path that is too long.
    let wall = up(Vec3::new(0.1, 0.1, 0.0), Vec3::X);
    assert_eq!(seen(&floor(grey(0.5)), vec![wall], None).photons, 0);
    let far = up(Vec3::X * 0.51, Vec3::Y);
    assert_eq!(seen(&floor(grey(0.5)), vec![far], None).photons, 0);
    for (most, count) in [(1, 0), (2, 1)] {
        let found = seen(&floor(grey(0.5)), vec![up(Vec3::X * 0.2, Vec3::Y)], Some(most));
        assert_eq!(found.photons, count);
    }
}

fn plastic() -> Material {
    Material::Plastic {
        eta: 1.5,
        diffuse: Texture::grey(0.5),
        specular: Texture::grey(1.0),
        nonlinear: false,
        roughness: None,
    }
}

#[test]
fn any_number_of_photons_can_be_gathered() {
    let mut rng = gi_core::rng::Pcg::new(1, 1);
    let photons: Vec<Photon> = (0..100_000)
        .map(|_| {
            let [x, z] = rng.next_2d().map(|u| 0.3 * (u - 0.5));
            photon(Vec3::new(x, 0.0, z), Vec3::Y, Vec3::Y, PhotonKind::Caustic)
        })
        .collect();
    assert_eq!(seen(&floor(grey(0.5)), photons, None).photons, 100_000);
}
