use super::*;
use crate::geometry::Shape;
use crate::light::tree::LightTree;
use crate::light::tree::bounds::LightBounds;
use crate::light::tree::tests::{lights, vantage};
use crate::light::{Light, Lights};
use crate::rng::Pcg;

/// Whether each light is hidden everywhere: those on one side are.
fn hidden(lights: &Lights, shapes: &[Shape]) -> Vec<bool> {
    let is_hidden =
        |light: &Light| LightBounds::of(light, shapes).is_some_and(|of| of.bounds.center().x < 0.0);
    lights.all().iter().map(is_hidden).collect()
}

/// Points, and a tree that has learned there from 20 samples per point and pass.
fn taught(lights: &Lights, hidden: &[bool], points: &[Vantage]) -> LightTree {
    let mut tree = points[0].tree.expect("a tree").learning(lights.sphere());
    for pass in 0..20 {
        let rng = &mut Pcg::new(8, pass);
        for at in points {
            for _ in 0..20 {
                let (k, p, _) = tree.choose(at, rng.next_2d()).expect("a light");
                tree.learn(at, k as u32, if hidden[k] { 0.0 } else { 1.0 / p });
            }
        }
        tree.update();
    }
    tree
}

/// Call `test` with lights of all kinds, points, and a tree that has learned.
fn with_taught(test: impl Fn(&Lights, &[bool], &[Vantage], &LightTree)) {
    for distant in [false, true] {
        let (shapes, lights) = lights(700, distant, 3);
        let rng = &mut Pcg::new(7, 1);
        let points: Vec<Vantage> = (0..40).map(|_| vantage(&shapes, &lights, rng)).collect();
        let hidden = hidden(&lights, &shapes);
        test(&lights, &hidden, &points, &taught(&lights, &hidden, &points));
    }
}

#[test]
fn every_light_keeps_a_probability_and_hidden_lights_lose_most_of_theirs() {
    with_taught(|_, is_hidden, points, tree| {
        assert!(tree.regions() > 20);
        let mut fewer = 0;
        for at in points {
            let plain = at.tree.expect("a tree");
            let (mut sum, mut hidden, mut hidden_before) = (0.0, 0.0, 0.0);
            for (k, is_hidden) in is_hidden.iter().enumerate() {
                let [p, before] = [tree, plain].map(|t| f64::from(t.probability(at, k)));
                assert!(p >= 0.9 * PLAIN * before, "light {k}: {p} after, {before} before");
                sum += p;
                if *is_hidden {
                    (hidden, hidden_before) = (hidden + p, hidden_before + before);
                }
            }
            assert!((sum - 1.0).abs() < 1e-4, "{sum} at {at:?}");
            fewer += u32::from(hidden < 0.8 * hidden_before);
        }
        assert!(fewer > 20, "hidden lights lost at {fewer} of {} points", points.len());
    });
}

#[test]
fn lights_are_chosen_with_the_learned_probability() {
    with_taught(|lights, _, points, tree| {
        let (rng, n) = (&mut Pcg::new(3, 1), 20_000);
        for at in &points[..10] {
            let mut counts = vec![0u32; lights.all().len()];
            for _ in 0..n {
                let (k, p, rest) = tree.choose(at, rng.next_2d()).expect("lights");
                assert!((0.0..1.0).contains(&rest));
                let expected = tree.probability(at, k);
                assert!((p / expected - 1.0).abs() < 1e-4, "light {k}: {p}, not {expected}");
                counts[k] += 1;
            }
            for (k, &count) in counts.iter().enumerate() {
                let p = f64::from(tree.probability(at, k));
                let n = f64::from(n);
                let deviation = (n * p * (1.0 - p)).sqrt();
                // One of 20 x 700 counts is beyond 6 standard deviations in one of ten thousand runs.
                let far = (f64::from(count) - p * n).abs();
                assert!(far <= 6.0 * deviation.max(1.0), "{k}: {count} of {n}, p = {p}");
            }
        }
    });
}

#[test]
fn a_tree_continues_from_what_was_saved() {
    with_taught(|lights, _, points, tree| {
        let mut w = Writer::default();
        tree.save(&mut w);
        let bytes = w.into_bytes();
        let mut copy = points[0].tree.expect("a tree").learning(lights.sphere());
        let mut r = Reader::new(&bytes);
        copy.restore(&mut r).expect("whole bytes");
        r.end().expect("no more bytes");
        for at in points {
            for k in 0..lights.all().len() {
                let [a, b] = [tree, &copy].map(|t| t.probability(at, k).to_bits());
                assert_eq!(a, b);
            }
        }
        let mut copy = points[0].tree.expect("a tree").learning(lights.sphere());
        assert!(copy.restore(&mut Reader::new(&bytes[..bytes.len() - 1])).is_err());
    });
}
