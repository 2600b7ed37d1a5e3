use super::*;

/// Two computed pictures, with values up to `scale`.
fn pictures(scale: f32) -> (Vec<f32>, Vec<f32>) {
    let (w, h) = (48usize, 32usize);
    let reference = |i: usize, k: usize| {
        let (x, y) = ((i % w) as f32 / w as f32, (i / w) as f32 / h as f32);
        let bar = if ((i % w) / 6).is_multiple_of(2) { 0.25 } else { 0.0 };
        scale * (0.1 + 0.5 * [x, y, 1.0 - x][k] * (1.0 - 0.5 * y) + bar)
    };
    let noise = |i: usize, k: usize| ((i * 7 + k * 13) % 17) as f32 / 17.0 - 0.5;
    let truth: Vec<f32> = (0..w * h).flat_map(|i| [0, 1, 2].map(|k| reference(i, k))).collect();
    let test = (0..w * h)
        .flat_map(|i| [0, 1, 2].map(|k| (reference(i, k) * (1.0 + 0.4 * noise(i, k))).max(0.0)))
        .collect();
    (test, truth)
}

fn mean(map: &[f64]) -> f64 {
    map.iter().sum::<f64>() / map.len() as f64
}

#[test]
fn equal_pictures_do_not_differ_and_black_on_white_differs_fully() {
    let (_, truth) = pictures(1.0);
    assert!(flip_ldr(&truth, &truth, 48, 32, PIXELS_PER_DEGREE).iter().all(|v| *v == 0.0));
    let (black, white) = (vec![0.0; 300], vec![1.0; 300]);
    let found = mean(&flip_ldr(&black, &white, 10, 10, PIXELS_PER_DEGREE));
    assert!(found > 0.9 && found <= 1.0, "{found}");
}

#[test]
fn xyz_and_back() {
    let c = [0.2, 0.5, 0.7];
    let back = to_rgb(from_opponent(to_opponent(c)));
    assert!((0..3).all(|k| (c[k] - back[k]).abs() < 1e-12), "{back:?}");
}

#[test]
fn agrees_with_the_authors_implementation() {
    // Means from the authors' evaluator (1.7), which uses single precision, on the same pictures.
    let (test, truth) = pictures(1.0);
    let ldr = mean(&flip_ldr(&test, &truth, 48, 32, PIXELS_PER_DEGREE));
    assert!((ldr - LDR).abs() < 1e-6, "{ldr} is not {LDR}");
    let (test, truth) = pictures(20.0);
    let hdr = mean(&flip_hdr(&test, &truth, 48, 32, PIXELS_PER_DEGREE));
    assert!((hdr - HDR).abs() < 3e-6, "{hdr} is not {HDR}");
}

const LDR: f64 = 0.046_830_17;
const HDR: f64 = 0.035_533_07;
