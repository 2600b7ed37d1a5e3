use super::*;
use gi_core::rng::Pcg;

/// Points in a few clusters, with radii, and a tree of them.
fn tree(n: usize, seed: u64) -> (Octree, Vec<(Vec3, f32)>) {
    let mut rng = Pcg::new(seed, 0);
    let mut point = || Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
    let centers: Vec<Vec3> = (0..8).map(|_| point()).collect();
    let items: Vec<(Vec3, f32)> = (0..n)
        .map(|i| {
            let spread = if i % 3 == 0 { 1.0 } else { 0.05 };
            let p = centers[i % 8] * (1.0 - spread) + point() * spread;
            (p, 0.15 * point().x.powi(3) + 0.002)
        })
        .collect();
    let mut tree = Octree::new(Bounds { min: Vec3::ZERO, max: Vec3::ONE });
    items.iter().for_each(|&(p, r)| {
        tree.insert(p, r);
    });
    (tree, items)
}

#[test]
fn a_lookup_finds_the_same_items_as_a_scan() {
    let (tree, items) = tree(3000, 1);
    let mut rng = Pcg::new(2, 0);
    let mut found_some = 0;
    for _ in 0..2000 {
        // Points inside the box and beyond it.
        let p = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 1.2 - 0.1;
        for slack in [1.0, 2.0] {
            let mut found = Vec::new();
            tree.visit(p, slack, |id| found.push(id));
            found.sort_unstable();
            let scan = (0..items.len() as Id).filter(|&i| {
                let (q, r) = items[i as usize];
                (q - p).length_squared() <= (r * slack).powi(2)
            });
            assert_eq!(found, scan.collect::<Vec<_>>());
            found_some += usize::from(!found.is_empty());
        }
    }
    assert!(found_some > 1000, "only {found_some} lookups found an item");
}

#[test]
fn every_cell_has_fewer_than_three_items_unless_items_coincide() {
    let (tree, _) = tree(3000, 3);
    let (mut items, mut volume) = (0, 0.0);
    for cell in tree.cells() {
        assert!(cell.items < 3);
        items += cell.items;
        volume += (cell.cube.max - cell.cube.min).as_dvec3().element_product();
    }
    assert_eq!(items, 3000);
    // With the empty cells, they fill the root.
    let root = f64::from(tree.nodes[0].side).powi(3);
    assert!((volume / root - 1.0).abs() < 1e-4, "{volume} of {root}");
    let mut same = Octree::new(Bounds { min: Vec3::ZERO, max: Vec3::ONE });
    (0..10).for_each(|_| {
        same.insert(Vec3::splat(0.3), 0.1);
    });
    let mut found = 0;
    same.visit(Vec3::splat(0.35), 1.0, |_| found += 1);
    assert_eq!(found, 10);
}

#[test]
fn neighbours_lower_each_other_as_a_scan_would() {
    let slope = 0.1;
    let (mut tree, mut items) = tree(500, 5);
    let mut rng = Pcg::new(6, 0);
    for _ in 0..300 {
        let p = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let scan = items.iter().map(|&(q, r)| r + slope * (q - p).length());
        let allowed = scan.fold(f32::INFINITY, f32::min);
        assert_eq!(tree.cone_at(p, slope), allowed);
        let radius = allowed.min(0.1 * rng.next_f32());
        let least = |id: Id| 0.001 * (id % 5) as f32;
        let mut told = Vec::new();
        tree.lower(&Cone { p, radius, slope }, &least, &mut |id, r| told.push((id, r)));
        let mut expected = Vec::new();
        for (id, (q, r)) in items.iter_mut().enumerate() {
            let limit = (radius + slope * (*q - p).length()).max(least(id as Id));
            if *r > limit {
                *r = limit;
                expected.push((id as Id, limit));
            }
        }
        told.sort_by_key(|t| t.0);
        assert_eq!(told, expected);
        tree.insert(p, radius);
        items.push((p, radius));
    }
    let mut found = Vec::new();
    tree.visit(Vec3::splat(0.5), 1.0, |id| found.push(id));
    found.sort_unstable();
    let reaches =
        |&i: &Id| (items[i as usize].0 - 0.5).length_squared() <= items[i as usize].1.powi(2);
    assert_eq!(found, (0..items.len() as Id).filter(reaches).collect::<Vec<_>>());
}
