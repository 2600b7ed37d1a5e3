use super::*;
use crate::rng::Pcg;

fn cameras() -> [Camera; 3] {
    let mut spec = CameraSpec::look_at(
        Vec3::new(1.0, 2.0, -4.0),
        Vec3::new(0.0, 1.0, 1.0),
        Vec3::Y,
        0.8,
        [64, 48],
    );
    let pinhole = Camera::new(&spec);
    spec.projection =
        Projection::Perspective { fov_x: 0.8, aperture_radius: 0.1, focus_distance: 3.0 };
    let lens = Camera::new(&spec);
    spec.projection = Projection::Orthographic;
    spec.to_world *= Affine3A::from_scale(Vec3::new(2.0, 2.0, 1.0));
    [pinhole, lens, Camera::new(&spec)]
}

#[test]
fn a_point_seen_by_a_pixel_connects_back_to_it() {
    let mut rng = Pcg::new(3, 0);
    for camera in cameras() {
        for _ in 0..1000 {
            let film = [64.0 * rng.next_f32(), 48.0 * rng.next_f32()];
            let u = rng.next_2d();
            let ray = camera.ray(film, u);
            let back = camera.connect(ray.at(5.0), u, 0.0).expect("in the picture");
            assert!(
                (back.film[0] - film[0]).abs() < 1e-2 && (back.film[1] - film[1]).abs() < 1e-2,
                "{back:?}"
            );
            assert!((back.wi + ray.d).length() < 1e-4);
            let importance = camera.importance(ray.d, 5.0);
            assert!((back.importance / importance - 1.0).abs() < 1e-3, "{back:?} {importance}");
        }
        assert!(
            camera.connect(camera.ray([32.0, 24.0], [0.5; 2]).at(-1.0), [0.5; 2], 0.0).is_none()
        );
    }
}

#[test]
fn connections_end_at_the_start_of_the_cameras_ray() {
    let mut rng = Pcg::new(4, 0);
    for near in [0.0, 0.7] {
        for camera in cameras().map(|camera| Camera { near, ..camera }) {
            for _ in 0..100 {
                let (film, u) = ([64.0 * rng.next_f32(), 48.0 * rng.next_f32()], rng.next_2d());
                let ray = camera.ray(film, u);
                let back = camera.connect(ray.at(5.0), u, 0.0).expect("in the picture");
                assert!((back.end - ray.at(ray.tmin)).length() < 1e-5, "{back:?}");
            }
        }
    }
}

#[test]
fn the_picture_is_upright_and_not_mirrored() {
    let spec = CameraSpec::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::Y, 0.8, [64, 64]);
    let camera = Camera::new(&spec);
    // Looking along -z with +y up, +x is to the right.
    let corner = camera.ray([64.0, 0.0], [0.5; 2]).d;
    assert!(corner.x > 0.0 && corner.y > 0.0, "{corner}");
}

#[test]
fn importance_integrates_to_the_number_of_pixels() {
    // A Lambertian plane of radiance 1 across the view, sampled uniformly by area: the sum of cos * importance *
    // area over the pixels must be one per pixel.
    for camera in cameras() {
        let mid = camera.ray([32.0, 24.0], [0.5; 2]);
        let (center, n) = (mid.at(6.0), -mid.d);
        let frame = crate::math::Frame::from_normal(n);
        let (mut rng, side, samples) = (Pcg::new(9, 1), 12.0f32, 200_000);
        let mut sum = 0.0f64;
        for _ in 0..samples {
            let p = center
                + frame.s * (side * (rng.next_f32() - 0.5))
                + frame.t * (side * (rng.next_f32() - 0.5));
            if let Some(c) = camera.connect(p, rng.next_2d(), 0.0) {
                sum += f64::from(c.wi.dot(n) * c.importance);
            }
        }
        let pixels = sum * f64::from(side * side) / samples as f64;
        assert!((pixels / (64.0 * 48.0) - 1.0).abs() < 0.02, "{pixels} pixels");
    }
}
