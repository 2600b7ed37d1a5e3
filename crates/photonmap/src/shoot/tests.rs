use super::collect::{CHUNK, ROUND};
use super::*;
use crate::test_scenes::{glass_below_a_hole, glass_over_floor, lit_sphere};
use gi_core::walk::PhotonKind;
use gi_stats::{Running, welch_t_test};

fn source(scene: &Scene, seed: u32) -> Source<'_> {
    Source { scene, seed, max_segments: None, media: false }
}

fn assert_equal_means(a: &[Running; 2], b: &[Running; 2]) {
    for (a, b) in a.iter().zip(b) {
        let p = welch_t_test(a, b);
        assert!(p > 1e-3, "{} is not {}: p = {p:.1e}", a.mean(), b.mean());
    }
}

#[test]
fn first_hits_in_a_closed_scene_carry_the_emitted_power_and_all_hits_its_geometric_sum() {
    // A point light of intensity 1 in a sphere of albedo 1/2: first hits carry 4 pi, all hits 4 pi / (1 - 1/2).
    let scene = lit_sphere();
    let shot = source(&scene, 1).shoot(Wanted::Global, 100_000);
    let sum = |first: bool| -> f64 {
        let counts = |s: &&Stored| !first || s.photon.payload.kind() == PhotonKind::Direct;
        let power = |s: &Stored| f64::from(s.photon.payload.power.to_rgb().g);
        shot.photons.iter().filter(counts).map(power).sum()
    };
    let emitted = 4.0 * std::f64::consts::PI;
    // All photons have one power: eight bits, dithered, leave 1e-5 on average.
    assert!((sum(true) / emitted - 1.0).abs() < 1e-4, "{}", sum(true) / emitted);
    // Path lengths are geometric with mean and variance 2: over n paths 2 +- sqrt(2 / n).
    let error = (2.0 / shot.emitted as f64).sqrt();
    assert!((sum(false) / emitted - 2.0).abs() < 4.0 * error, "{}", sum(false) / emitted);
}

#[test]
fn the_path_that_reaches_the_number_is_the_last() {
    let scene = lit_sphere();
    for count in [1, 1000, 70_000] {
        let shot = source(&scene, 2).shoot(Wanted::Global, count);
        let n = shot.photons.len();
        // Photons of the last path begin at its first segment.
        let last = shot.photons.iter().rposition(|s| s.depth == 1).expect("a first hit");
        assert!(n >= count && last < count, "{n} photons for {count}, the last path from {last}");
        let first_hits = shot.photons.iter().filter(|s| s.depth == 1).count();
        assert_eq!(first_hits as u64, shot.emitted);
    }
}

#[test]
fn what_hardly_comes_is_given_up_early_and_is_right_in_the_mean() {
    // One path in `rarity` brings a hit. Ten thousand are wanted, 256 paths each are the most, 8 are always tried.
    let (count, fewest, most) = (10_000, 80_000, 2_560_000);
    let shoot = |rarity: u32| {
        let walk = |_: &ProjectionMap, chunk| {
            let mut out = Chunk::new();
            for path in paths(chunk) {
                if hash_words(&[path as u32, rarity]) < u32::MAX / rarity {
                    out.hits.push(path);
                }
                out.end_path(None);
            }
            out
        };
        let Hits { chunks, emitted, gave_up } = collect(count, walk);
        (chunks.iter().map(Vec::len).sum::<usize>(), emitted, gave_up)
    };
    // Rounds are whole.
    let round = CHUNK * ROUND;
    let (hits, emitted, gave_up) = shoot(u32::MAX);
    assert!(gave_up && hits == 0 && emitted >= fewest && emitted < fewest + round);
    let (hits, emitted, gave_up) = shoot(200);
    assert!(!gave_up && hits == count && emitted < most);
    for rarity in [400, 1000, 4000] {
        let (hits, emitted, gave_up) = shoot(rarity);
        // Emission ends where emitted^2 / hits is what it is to be: half of the error of the hits, and a round.
        let expected = most as f64 * (256.0 / f64::from(rarity));
        let slack = 2.0 / (expected / f64::from(rarity)).sqrt() + round as f64 / expected;
        let off = (emitted as f64 / expected - 1.0).abs();
        assert!(gave_up && off < slack, "one in {rarity}: {off} of {slack}");
        let mean = emitted as f64 / f64::from(rarity);
        assert!((hits as f64 - mean).abs() < 4.0 * mean.sqrt(), "{hits} hits, not {mean}");
    }
}

#[test]
fn aimed_paths_bring_the_power_that_blind_ones_bring_and_more_photons() {
    let scene = glass_over_floor();
    let targets = scene.focusing();
    assert!(!targets.is_empty());
    let (mut aimed, mut blind) = ([Running::default(); 2], [Running::default(); 2]);
    let mut paths = [0, 0];
    for seed in 0..48 {
        let source = source(&scene, seed);
        let shots = [source.shoot_caustic(&targets, 4000), source.shoot(Wanted::Global, 40_000)];
        for (k, shot) in shots.into_iter().enumerate() {
            let caustic = |s: &&Stored| s.photon.payload.kind() == PhotonKind::Caustic;
            let sums = |weight: fn(Vec3) -> f32| -> f64 {
                let power = |s: &Stored| s.photon.payload.power.to_rgb().g * weight(s.photon.p());
                shot.photons.iter().filter(caustic).map(|s| f64::from(power(s))).sum()
            };
            // The whole power, and where it falls.
            let out = if k == 0 { &mut aimed } else { &mut blind };
            out[0].push(sums(|_| 1.0));
            out[1].push(sums(|p| p.x * p.x + p.z * p.z));
            let n = shot.photons.iter().filter(caustic).count();
            paths[k] += shot.emitted / n.max(1) as u64;
        }
    }
    assert_equal_means(&aimed, &blind);
    assert!(paths[0] * 10 < paths[1], "paths a photon: aimed {}, blind {}", paths[0], paths[1]);
}

#[test]
fn paths_learn_where_a_hole_lets_them_pass_and_bring_the_same_power() {
    let scene = glass_below_a_hole();
    let targets = scene.focusing();
    let (mut learned, mut blind) = ([Running::default(); 2], [Running::default(); 2]);
    let mut paths = [0, 0];
    for seed in 0..16 {
        let source = source(&scene, seed);
        let unlearned = ProjectionMap::default();
        let trace =
            |starts: &ProjectionMap, chunk| source.chunk(Wanted::Caustic(&targets, starts), chunk);
        let shots = [collect(40_000, trace), collect(4000, |_, chunk| trace(&unlearned, chunk))];
        for (k, Hits { chunks, emitted, .. }) in shots.into_iter().enumerate() {
            let photons: Vec<_> = chunks.into_iter().flatten().collect();
            let sum = |weight: fn(Vec3) -> f32| -> f64 {
                let powers = photons.iter().map(|q| f64::from(q.power.g * weight(q.p)));
                powers.sum::<f64>() / emitted as f64
            };
            // The whole power, and where it falls.
            let out = if k == 0 { &mut learned } else { &mut blind };
            out[0].push(sum(|_| 1.0));
            out[1].push(sum(|p| p.x * p.x + p.z * p.z));
            paths[k] += emitted / photons.len() as u64;
        }
    }
    assert_equal_means(&learned, &blind);
    assert!(paths[0] * 2 < paths[1], "paths a photon: {} of {}", paths[0], paths[1]);
}
