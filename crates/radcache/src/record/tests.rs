use super::*;
use crate::sh::index;
use crate::sh::tests::gauss_legendre;
use gi_core::math::Rgb;
use gi_core::rng::Pcg;
use lightcache::gradients::Gradient;
use lightcache::hemisphere::{Seen, Strata};

const ORDER: usize = 5;

fn site(reach: f32) -> Site {
    Site { n: Vec3::Z, p: Vec3::ZERO, radii: [reach; 2], axis: Vec3::X, least: 0.0, clear: 1.0 }
}

fn irradiance(e: Rgb, reach: f32) -> Record {
    let gradient = Gradient::default();
    Record { e, site: site(reach), rotational: gradient, translational: gradient }
}

fn see(rays: u32, seed: u64, look: impl Fn(Vec3) -> (f32, f32)) -> Hemisphere {
    let mut rng = Pcg::new(seed, 11);
    Hemisphere::gather(
        Strata::of(rays),
        |_| rng.next_2d(),
        |_, direction| {
            let (l, distance) = look(direction);
            Seen { direction, radiance: Rgb::grey(l), distance, normal: -Vec3::Z }
        },
    )
}

/// A bright rectangle in a ceiling at height 1.
const LOW: Vec2 = Vec2::new(-0.2, -0.5);
const HIGH: Vec2 = Vec2::new(0.9, 0.4);

fn rectangle(w: Vec3) -> (f32, f32) {
    let q = w / w.z;
    let inside = q.x > LOW.x && q.x < HIGH.x && q.y > LOW.y && q.y < HIGH.y;
    (f32::from(u8::from(inside)), q.length())
}

/// Its coefficients at a moved point, by brute force over the ceiling.
fn exact(basis: Basis, moved: Vec2) -> Vec<f64> {
    let (n, mut y) = (200, [0.0; MAX_FUNCTIONS]);
    let step = (HIGH - LOW) / n as f32;
    let mut sum = vec![0.0; ORDER * ORDER];
    for i in 0..n * n {
        let q = LOW + step * (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) - moved;
        let to = q.extend(1.0);
        basis.evaluate(ORDER, to.normalize(), &mut y);
        let solid_angle = f64::from(step.x * step.y) / f64::from(to.length()).powi(3);
        sum.iter_mut().zip(y).for_each(|(s, y)| *s += solid_angle * f64::from(y));
    }
    sum
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn coefficients_and_gradients_are_those_of_a_rectangle_and_its_finite_differences() {
    let own = Frame::from_normal(Vec3::Z);
    // The gradients are not limited here, because the reach is small.
    let record = |basis, seed| {
        let h = see(2000, seed, rectangle);
        RadianceRecord::new(irradiance(Rgb::WHITE, 1e-9), &own, &h, basis, ORDER)
    };
    for basis in [Basis::Sh, Basis::Hsh] {
        let records: Vec<_> = (0..100).map(|seed| record(basis, seed)).collect();
        let count = ORDER * ORDER;
        let value = exact(basis, Vec2::ZERO);
        let d = 1e-2;
        let difference = |v: Vec2| -> Vec<f64> {
            let (ahead, back) = (exact(basis, v * d), exact(basis, -v * d));
            ahead.iter().zip(back).map(|(a, b)| (a - b) / f64::from(2.0 * d)).collect()
        };
        let [by_s, by_t] = [own.s, own.t].map(|v| difference(v.truncate()));
        let all = [value, by_s, by_t].concat();
        let largest = |part: usize| {
            all[part * count..(part + 1) * count].iter().fold(0.0f64, |m, v| m.max(v.abs()))
        };
        for (k, exact) in all.iter().enumerate() {
            let found: Vec<f64> = records.iter().map(|r| f64::from(r.light[k].x)).collect();
            let (found, error) = mean_and_error(&found);
            // The bias of gradients: walls move at the borders of strata, not at the edge of the rectangle, which is
            // off by half of one of 25 rings.
            let bias = if k < count { 0.0 } else { 0.5 / 25.0 * largest(k / count) };
            assert!(
                (found - exact).abs() < bias + 4.5 * error + 1e-4,
                "{basis:?}, {k}: {found} +- {error} is not {exact}"
            );
        }
    }
}

#[test]
fn with_the_cosine_as_brdf_the_dot_product_is_the_irradiance() {
    // The cosine in both bases, by quadrature over the upper half.
    let order = 10;
    let (own, mut y) = (Frame::from_normal(Vec3::Z), [0.0; MAX_FUNCTIONS]);
    for basis in [Basis::Sh, Basis::Hsh] {
        let mut cosine = [0.0f64; MAX_FUNCTIONS];
        for (z, w) in gauss_legendre(20).into_iter().map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)) {
            basis.evaluate(order, Vec3::new((1.0 - z * z).sqrt() as f32, 0.0, z as f32), &mut y);
            for l in 0..order {
                let k = index(l, 0);
                cosine[k] += w * std::f64::consts::TAU * z * f64::from(y[k]);
            }
        }
        let off = |seed| {
            let h = see(1000, seed, |w| (0.2 + (2.0 * w.x).max(w.z), 1.0));
            let e = h.irradiance();
            let record = RadianceRecord::new(irradiance(e, 1.0), &own, &h, basis, order);
            let dot = |k: usize| f64::from(record.light[k].x) * cosine[k];
            (0..order * order).map(dot).sum::<f64>() / f64::from(e.r) - 1.0
        };
        let (mean, error) = mean_and_error(&(0..50).map(off).collect::<Vec<_>>());
        // Bands from 10 on contain 3e-4 of the cosine's energy. Hemispherical harmonics represent the cosine exactly.
        assert!(mean.abs() < 2e-3 + 4.5 * error, "{basis:?}: {mean} +- {error}");
    }
}

#[test]
fn at_its_own_point_a_record_gives_its_light_in_any_frame_of_the_query() {
    let h = see(500, 3, |w| (w.x.max(0.0) + 0.2, 1.0));
    let own = Frame::from_normal(Vec3::Z);
    let q = Query { p: Vec3::ZERO, n: Vec3::Z };
    let mut y = [0.0; MAX_FUNCTIONS];
    for basis in [Basis::Sh, Basis::Hsh] {
        let record = RadianceRecord::new(irradiance(Rgb::WHITE, 1.0), &own, &h, basis, ORDER);
        let direction = Vec3::new(0.6, 0.2, 0.5).normalize();
        let mut seen = Vec::new();
        for angle in [0.0f32, 0.7, 2.5] {
            let s = Vec3::new(angle.cos(), angle.sin(), 0.0);
            let frame = Frame { s, t: Vec3::Z.cross(s), n: Vec3::Z };
            let mut light = [Vec3A::ZERO; MAX_FUNCTIONS];
            record.add_to(&mut light, &q, &frame, basis, true, 1.0);
            if basis == Basis::Sh {
                crate::rotate::Turn::into_frame(&frame).apply(ORDER, &mut light);
            }
            basis.evaluate(ORDER, frame.to_local(direction), &mut y);
            seen.push(light.iter().zip(y).map(|(c, y)| c.x * y).sum::<f32>());
        }
        assert!((seen[0] - seen[1]).abs() < 1e-5 && (seen[0] - seen[2]).abs() < 1e-5, "{seen:?}");
    }
}
