use super::*;
use crate::bound::{Site, error};
use crate::cut::Rule;
use crate::light::At;
use crate::test_scenes::{Checked, in_cube, lights, rubble, unshadowed};
use crate::tree::Forest;
use gi_core::bsdf::{Bsdf, Transport};
use gi_core::geometry::Surface;
use gi_core::medium::MediumId;
use gi_core::ray::Ray;
use gi_core::rng::Pcg;
use gi_core::scene::Scene;
use glam::Vec3;
use vpl::{Prepared, Receiver};

/// A surface point, the direction from which it is seen, and its BSDF.
type Point<'a> = (Surface, Vec3, Bsdf<'a>);

/// Up to `count` points seen through a random pixel: rays from one point whose directions differ by about `spread`.
fn points<'a>(scene: &'a Scene, count: u32, spread: f32, rng: &mut Pcg) -> Vec<Point<'a>> {
    let eye = 1.5 * in_cube(rng);
    let axis = (0.7 * in_cube(rng) - eye).normalize_or(Vec3::Z);
    let ray = |_| Ray::new(eye, (axis + spread * in_cube(rng)).normalize());
    let rays: Vec<Ray> = (0..count).map(ray).collect();
    let point = |ray: &Ray| {
        let (surface, _) = scene.intersect(ray)?;
        let bsdf = scene.bsdf(&surface, -ray.d, Transport::Radiance);
        (!bsdf.is_delta()).then_some((surface, -ray.d, bsdf))
    };
    rays.iter().filter_map(point).collect()
}

/// Gather points of random strengths; some are seen indirectly, some have a negative weight, and some are in media in front of the
/// surfaces.
fn gathers<'s, 'a>(
    scene: &Scene,
    points: &'s [Point<'a>],
    most: f32,
    rng: &mut Pcg,
) -> Vec<Gather<'s, 'a>> {
    let gather = |(surface, wo, bsdf): &'s Point<'a>| {
        let at = if rng.next_below(4) == 0 {
            let medium = MediumId::new(rng.next_below(scene.media().len() as u32) as usize);
            let p = surface.p + *wo * rng.next_f32();
            At {
                receiver: Receiver::in_medium(scene, p, *wo, medium),
                site: Site::in_medium(p, *wo, scene.medium(medium).phase),
                deepest: u32::MAX,
                direct: true,
            }
        } else {
            At {
                receiver: Receiver::new(surface, *wo, bsdf),
                site: Site::new(surface, *wo, bsdf, most),
                deepest: u32::MAX,
                direct: true,
            }
        };
        let strength = Rgb::from([0; 3].map(|_| rng.next_f32().powi(2)));
        let [seen, negative] = [0; 2].map(|_| rng.next_below(8) == 0);
        Gather::new(at, strength, !seen, negative)
    };
    points.iter().map(gather).collect()
}

/// Call `test` with the product of the gather points of random pixels and random lights.
fn at_pixels(
    seeds: std::ops::Range<u64>,
    [light_count, each]: [u32; 2],
    mut test: impl FnMut(&Product),
) {
    for seed in seeds {
        let mut rng = Pcg::new(41, seed);
        let scene = rubble(seed);
        let set = lights(&scene, light_count, &mut rng);
        let prepared = Prepared::new(&set, &scene);
        let forest = Forest::build(&scene, &set, false, 1);
        let lights = Lights { scene: &scene, prepared: &prepared, forest: &forest };
        for k in 0..each {
            let spread = [0.003, 0.03, 0.3, 3.0][k as usize % 4];
            let count = 1 + rng.next_below(24);
            let points = points(&scene, count, spread, &mut rng);
            let most = [f32::INFINITY, 4.0, 0.1][rng.next_below(3) as usize];
            let gathers = gathers(&scene, &points, most, &mut rng);
            let c = scene.radius();
            let trees = GatherTree::build_all(&gathers, c);
            if !trees.is_empty() {
                test(&Product { lights: &lights, gathers: &gathers, trees: &trees, c, seed: k });
            }
        }
    }
}

/// For every node of a light tree: the unshadowed light that it brings to a gather point.
fn brought(product: &Product, point: u32, tree: u32) -> Vec<Rgb> {
    let gather = &product.gathers[point as usize];
    let shape = &product.lights.forest.trees[tree as usize];
    let mut brings = vec![Rgb::BLACK; shape.nodes().len()];
    for k in (0..brings.len()).rev() {
        let node = shape.node(k as u32);
        brings[k] = match node.children() {
            None => {
                let direct = shape.is_direct();
                unshadowed(product.lights, &gather.at, node.representative, direct)
                    * gather.strength
            }
            Some([a, b]) => brings[a as usize] + brings[b as usize],
        };
    }
    brings
}

/// The unshadowed estimate of a pair.
fn unshadowed_estimate(product: &Product, gather: NodeId, light: NodeId) -> Rgb {
    let node = product.trees[gather.tree as usize].node(gather.node);
    let tree = &product.lights.forest.trees[light.tree as usize];
    let representative = tree.node(light.node).representative;
    let power = product.lights.prepared.set().lights[representative as usize].power;
    let members = product.trees[gather.tree as usize].members(gather.node);
    let point = &product.gathers[members[light.node as usize % members.len()] as usize];
    let value = unshadowed(product.lights, &point.at, representative, tree.is_direct());
    let unit =
        value.zip(power, |v, p| if p > 0.0 { v / p } else { 0.0 }).zip(point.colour, |v, c| v / c);
    unit * tree.node(light.node).power * node.strength
}

/// Check all pairs of a gather tree and a light tree: their light, and the bound of the error of their estimate.
fn check_pairs(product: &Product, [g, l]: [u32; 2], checked: &mut Checked) {
    let gather_tree = &product.trees[g as usize];
    let light_tree = &product.lights.forest.trees[l as usize];
    let mut brings: Vec<Vec<Rgb>> = vec![Vec::new(); gather_tree.len() as usize];
    for k in (0..gather_tree.len()).rev() {
        let node = gather_tree.node(k);
        brings[k as usize] = match node.children() {
            None => brought(product, gather_tree.members(k)[0], l),
            Some([a, b]) => {
                let both = brings[a as usize].iter().zip(&brings[b as usize]);
                both.map(|(a, b)| *a + *b).collect()
            }
        };
        for i in 0..light_tree.nodes().len() as u32 {
            if node.children().is_none() && light_tree.node(i).children().is_none() {
                continue;
            }
            let (gather, light) = (NodeId { tree: g, node: k }, NodeId { tree: l, node: i });
            let truth = brings[k as usize][i as usize];
            let pair = Pair { error: 0.0, gather, light, point: 0, unit: Rgb::BLACK, kept: 1.0 };
            let bound = product.bound(&pair);
            checked.check(truth, bound.unwrap_or_default(), &(light_tree.family, k, i));
            let Some(bound) = bound else { continue };
            let estimate = unshadowed_estimate(product, gather, light);
            let (far, said) =
                ((estimate.luminance() - truth.luminance()).abs(), error(estimate, bound));
            assert!(far <= said, "the error is {far}, but its bound is {said}");
        }
    }
}

fn check_products(seeds: std::ops::Range<u64>, each: u32) -> Checked {
    let mut checked = Checked::default();
    at_pixels(seeds, [120, each], |product| {
        for g in 0..product.trees.len() as u32 {
            for l in 0..product.lights.forest.trees.len() as u32 {
                check_pairs(product, [g, l], &mut checked);
            }
        }
    });
    checked
}

#[test]
fn no_pair_exceeds_its_bound() {
    let Checked { cases, lit, tight, dark } = check_products(0..16, 32);
    assert!(cases > 1_000_000, "{cases} cases");
    // A bound that is far too large would pass too, so require cases near the bound.
    assert!(
        lit > cases / 8 && tight > cases / 40 && dark > cases / 20,
        "{lit} {tight} {dark} {cases}"
    );
}

#[test]
#[ignore = "minutes: many millions of pairs"]
fn no_pair_of_very_many_exceeds_its_bound() {
    let checked = check_products(100..400, 64);
    assert!(checked.cases > 25_000_000, "{}", checked.cases);
}

/// The light that every light brings to every gather point.
fn by_brute_force(product: &Product) -> Lit {
    let mut lit = Lit::default();
    for gather in product.gathers {
        let at_point = product.lights.light_by_all(&gather.at);
        let strength = gather.strength * if gather.kind.negative { -1.0 } else { 1.0 };
        let (direct, indirect) = (at_point.direct * strength, at_point.indirect * strength);
        *(if gather.kind.seen { &mut lit.direct } else { &mut lit.indirect }) += direct;
        lit.indirect += indirect;
        lit.rays += at_point.rays;
    }
    lit
}

#[test]
fn with_error_zero_every_light_is_connected_with_every_gather_point() {
    let (mut some, mut pairs) = (0, 0);
    at_pixels(0..6, [150, 24], |product| {
        let exact = by_brute_force(product);
        let limits = Limits { error: 0.0, rule: Rule::Whole, max_cut: None };
        let mut cut = Cut::default();
        choose(product, &limits, &mut cut);
        let lit = product.add_up(&mut cut, &limits);
        // Sums of thousands of terms in a different order; with negative weights some of them cancel.
        let whole: f32 = cut.clusters().iter().map(|p| product.estimate(p).luminance()).sum();
        for (a, b) in [(lit.direct, exact.direct), (lit.indirect, exact.indirect)] {
            assert!((a - b).luminance().abs() <= 2e-4 * whole, "{lit:?} is not {exact:?}");
        }
        assert!(!lit.at_most);
        some += u32::from(whole > 0.0);
        pairs += lit.size;
    });
    assert!(some > 80 && pairs > 40_000, "{some} pixels are lit, {pairs} pairs");
}

#[test]
fn every_cut_partitions_the_pairs_that_can_contribute() {
    at_pixels(0..4, [60, 12], |product| {
        for max_cut in [1, 30, 300, u32::MAX] {
            let mut cut = Cut::default();
            let limits = Limits { error: 0.02, rule: Rule::Cluster, max_cut: Some(max_cut) };
            choose(product, &limits, &mut cut);
            let count = product.lights.prepared.set().lights.len();
            let mut seen = vec![vec![0; count]; product.gathers.len()];
            for pair in cut.clusters() {
                let lights = &product.lights.forest.trees[pair.light.tree as usize];
                let gathers = &product.trees[pair.gather.tree as usize];
                assert!(gathers.members(pair.gather.node).contains(&pair.point));
                for &point in gathers.members(pair.gather.node) {
                    let row = &mut seen[point as usize];
                    lights.members(pair.light.node).iter().for_each(|&k| row[k as usize] += 1);
                }
            }
            for (gather, row) in product.gathers.iter().zip(seen) {
                for (k, n) in row.into_iter().enumerate() {
                    let brings = !product.lights.one(&gather.at, k as u32).is_black();
                    assert!(n == 1 || n == 0 && !brings, "light {k} is in {n} pairs");
                }
            }
            let roots = product.trees.len() * product.lights.forest.trees.len();
            assert!(cut.clusters().len() <= (max_cut as usize).max(roots));
        }
    });
}

#[test]
fn no_pair_of_a_finished_cut_exceeds_the_allowed_error_and_larger_errors_give_smaller_cuts() {
    let (mut sizes, mut pairs) = ([0u32; 3], 0u32);
    at_pixels(0..4, [200, 16], |product| {
        let exact = by_brute_force(product);
        for (k, error) in [0.005, 0.02, 0.1].into_iter().enumerate() {
            let limits = Limits { error, rule: Rule::Cluster, max_cut: Some(u32::MAX) };
            let mut cut = Cut::default();
            choose(product, &limits, &mut cut);
            let lit = product.add_up(&mut cut, &limits);
            sizes[k] += lit.size;
            let allowed = error * lit.all().luminance().abs() * (1.0 + 1e-3) + 1e-6;
            assert!(cut.clusters().iter().all(|pair| pair.error <= allowed), "{allowed}");
            pairs += exact.rays;
        }
    });
    assert!(sizes[0] > sizes[1] && sizes[1] > sizes[2], "{sizes:?}");
    assert!(2 * sizes[1] < pairs / 3, "{sizes:?} of {} pairs", pairs / 3);
}

#[test]
fn every_gather_node_contains_its_points() {
    let mut nodes = 0;
    at_pixels(0..6, [4, 40], |product| {
        let mut seen = vec![0; product.gathers.len()];
        for tree in product.trees {
            tree.members(0).iter().for_each(|&k| seen[k as usize] += 1);
            for k in 0..tree.len() {
                let node = tree.node(k);
                let members = tree.members(k);
                if let Some(children) = node.children() {
                    assert_eq!(children.map(|c| tree.members(c)).concat(), members);
                }
                let mut strength = Rgb::BLACK;
                for gather in members.iter().map(|&k| &product.gathers[k as usize]) {
                    assert!(gather.kind == tree.kind);
                    assert!(node.bounds.with(gather.at.site.p) == node.bounds);
                    let cos = node.cone.axis.dot(gather.normal);
                    assert!(cos >= node.cone.angle.cos() - 1e-5);
                    strength += gather.strength * gather.colour;
                }
                assert!((strength.g - node.strength.g).abs() <= 1e-5 * strength.g);
                nodes += 1;
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
    });
    assert!(nodes > 1000, "{nodes}");
}

#[test]
fn points_are_representatives_in_proportion_to_their_strength() {
    let scene = rubble(1);
    let mut rng = Pcg::new(43, 0);
    let points = points(&scene, 100, 3.0, &mut rng);
    let gathers = gathers(&scene, &points[..12], f32::INFINITY, &mut rng);
    let (trials, mut counts) = (4000, [0u32; 12]);
    for tree in GatherTree::build_all(&gathers, scene.radius()) {
        for _ in 0..trials {
            counts[tree.draw(0, rng.next_f32()) as usize] += 1;
        }
    }
    let n = f64::from(trials);
    for tree in GatherTree::build_all(&gathers, scene.radius()) {
        for &k in tree.members(0) {
            let gather = &gathers[k as usize];
            let mine = (gather.strength * gather.colour).luminance();
            let share = f64::from(mine / tree.node(0).strength.luminance());
            let z = (f64::from(counts[k as usize]) - n * share)
                / (n * share * (1.0 - share)).max(1.0).sqrt();
            // One of twelve cases is beyond 4.5 standard deviations by chance in fewer than one of ten thousand runs.
            assert!(z.abs() < 4.5, "point {k}: {z} standard deviations off {share}");
        }
    }
}
