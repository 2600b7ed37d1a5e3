use super::*;
use crate::photon::{PhotonKind, Rgbe};
use gi_core::math::Rgb;
use gi_core::rng::Pcg;

/// Photons on two walls, in a cluster, and some twice; the power says the number.
fn photons(n: usize) -> Vec<Stored> {
    let mut rng = Pcg::new(9, n as u64);
    (0..n)
        .map(|k| {
            let [u, v] = rng.next_2d();
            let p = match k % 4 {
                0 => Vec3::new(u, 0.0, v),
                1 => Vec3::new(0.0, u, v),
                2 => Vec3::new(0.4, 0.4, 0.4) + Vec3::new(u, v, u * v) * 0.01,
                _ => Vec3::splat((8.0 * u).floor() / 8.0),
            };
            let n = if k % 3 == 0 { Vec3::Y } else { -Vec3::Y };
            let photon = Photon::new(
                p,
                Rgbe::nearest(Rgb::WHITE),
                Vec3::from_array([u, v, 0.1]).normalize(),
                n,
                PhotonKind::Indirect,
            );
            Stored { photon, depth: (k % 5) as u8 }
        })
        .collect()
}

#[test]
fn the_nearest_are_what_sorting_finds_in_both_layouts() {
    for n in [0, 1, 2, 31, 32, 33, 64, 65, 1000, 5000] {
        let all = photons(n);
        for layout in [Layout::Jensen, Layout::Fast] {
            let map = PhotonMap::build(all.clone(), 1, layout, Order::Any, true);
            assert_eq!(map.len(), n);
            let mut rng = Pcg::new(4, 0);
            for case in 0..100 {
                // Inside, and outside of the box of all photons but within reach.
                let u: [f32; 3] = std::array::from_fn(|_| rng.next_f32() * 1.4 - 0.2);
                let p = Vec3::from_array(u);
                let (k, radius_sq) = (1 + case % 60, [0.01, 0.3, f32::INFINITY][case % 3]);
                let accept = |p: &Payload, depth: u8| p.normal().y > 0.0 && depth < 4;
                let mut expected: Vec<f32> = all
                    .iter()
                    .filter(|s| accept(&s.photon.payload, s.depth))
                    .map(|s| s.photon.p().distance_squared(p))
                    .filter(|d2| *d2 < radius_sq)
                    .collect();
                expected.sort_by(f32::total_cmp);
                expected.truncate(k);
                let mut got = Vec::new();
                let found = map.nearest(p, k, radius_sq, accept, |_, d2, _| got.push(d2));
                got.sort_by(f32::total_cmp);
                assert_eq!(got.len(), expected.len(), "{layout:?}, {n} photons, case {case}");
                for (a, b) in got.iter().zip(&expected) {
                    assert!((a - b).abs() <= 1e-6 * b, "{layout:?}, {n}: {a} is not {b}");
                }
                assert_eq!(found.count, got.len());
                let last = if got.len() == k { got[k - 1] } else { radius_sq };
                assert_eq!(found.radius_sq, last, "{layout:?}, {n}");
            }
        }
    }
}

#[test]
fn one_near_is_at_most_twice_as_far_as_the_nearest() {
    let all = photons(3000);
    let mut rng = Pcg::new(5, 0);
    for layout in [Layout::Jensen, Layout::Fast] {
        let map = PhotonMap::build(all.clone(), 1, layout, Order::Any, false);
        for case in 0..500 {
            let u: [f32; 3] = std::array::from_fn(|_| rng.next_f32());
            let (p, radius_sq) = (Vec3::from_array(u), [1e-3, 1e-2, 9.0][case % 3]);
            let accept = |p: &Payload| p.normal().y > 0.0;
            let mut nearest = radius_sq;
            map.nearest(p, 1, radius_sq, |p, _| accept(p), |_, d2, _| nearest = d2);
            // Directions tell the photons apart.
            let found = map.near_one(p, radius_sq, accept).map(|(_, payload)| payload);
            let is = |s: &&Stored| {
                found.is_some_and(|f| f.direction() == s.photon.payload.direction() && accept(&f))
            };
            let least = all.iter().filter(is).map(|s| s.photon.p().distance_squared(p));
            let least = least.fold(f32::INFINITY, f32::min);
            assert!(found.is_none() == (nearest == radius_sq), "{layout:?}, case {case}");
            assert!(found.is_none() || least <= 4.0 * nearest, "{layout:?}: {least}, {nearest}");
        }
    }
}

#[test]
fn no_photon_is_lost_and_the_trees_are_small() {
    let all = photons(10_000);
    let sum = |photons: &mut dyn Iterator<Item = Stored>| {
        photons.map(|s| f64::from(s.photon.p().dot(Vec3::new(1.0, 3.0, 7.0)))).sum::<f64>()
    };
    let expected = sum(&mut all.iter().copied());
    for layout in [Layout::Jensen, Layout::Fast] {
        let map = PhotonMap::build(all.clone(), 1, layout, Order::Any, false);
        assert!((sum(&mut map.photons()) - expected).abs() < 1e-6 * expected);
        let in_order: Vec<Stored> = map.photons().collect();
        let again = PhotonMap::build(in_order.clone(), 1, layout, Order::Tree, false);
        assert!(again.photons().eq(in_order), "{layout:?}: the order was not kept");
        let same = |p: Vec3| {
            let mut sums = [&map, &again].map(|map| {
                let mut sum = 0.0;
                map.nearest(p, 40, 1.0, |_, _| true, |_, d2, _| sum += d2);
                sum
            });
            sums[0] -= sums[1];
            sums[0] == 0.0
        };
        assert!(all.iter().step_by(97).all(|s| same(s.photon.p())), "{layout:?}");
        // 20 bytes and at most a tenth.
        assert!(map.bytes() as f64 <= 22.0 * all.len() as f64, "{layout:?}: {}", map.bytes());
    }
}
