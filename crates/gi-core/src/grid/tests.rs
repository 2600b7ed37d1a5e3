use super::*;
use crate::rng::Pcg;

/// Photons on the walls of the unit cube and in a cluster, in chunks of different sizes; the value is the photon's
/// index.
fn photons(n: usize) -> Vec<Vec<Item<u32>>> {
    let mut rng = Pcg::new(5, 1);
    let mut chunks = vec![Vec::new()];
    for i in 0..n {
        let mut p = Vec3::from_array([rng.next_f32(), rng.next_f32(), rng.next_f32()]);
        if i % 3 == 0 {
            p = p * 0.02 + Vec3::new(0.4, 0.0, 0.7);
        } else {
            p[i % 3] = (i % 2) as f32;
        }
        if rng.next_below(700) == 0 {
            chunks.push(Vec::new());
        }
        chunks.last_mut().expect("a chunk").push(Item { p, value: i as u32 });
    }
    chunks
}

fn found(grid: &Grid<u32>, p: Vec3, radius: f32) -> Vec<u32> {
    let mut found = Vec::new();
    grid.within(p, radius, |_, a, _| found.push(*a));
    found.sort_unstable();
    found
}

fn brute_force(chunks: &[Vec<Item<u32>>], p: Vec3, radius: f32) -> Vec<u32> {
    let near = |q: &&Item<u32>| {
        let d = q.p - p;
        d.x * d.x + d.y * d.y + d.z * d.z < radius * radius
    };
    chunks.iter().flatten().filter(near).map(|q| q.value).collect()
}

/// Test queries in and around the box of the photons, with radii from far below to far above the cell size.
fn assert_finds_each_once(name: &str, grid: &Grid<u32>, chunks: &[Vec<Item<u32>>]) {
    let mut rng = Pcg::new(9, 2);
    let mut total = 0;
    for case in 0..400 {
        let mut p = Vec3::from_array([rng.next_f32(), rng.next_f32(), rng.next_f32()]);
        match case % 4 {
            0 => p = p * 0.02 + Vec3::new(0.4, 0.0, 0.7),
            1 => p[case % 3] = 1.0,
            // Outside the box, but within reach of photons.
            2 => p[case % 3] = 1.02,
            _ => {}
        }
        let radius = 0.003 * 300f32.powf(rng.next_f32());
        let (got, expected) = (found(grid, p, radius), brute_force(chunks, p, radius));
        assert_eq!(got, expected, "{name}, case {case}: {p}, radius {radius}");
        total += got.len();
    }
    assert!(total > 10_000, "{name}: only {total} photons were found");
}

#[test]
fn a_query_finds_the_same_photons_as_a_linear_scan() {
    let chunks = photons(6000);
    for cell in [0.5, 0.08, 0.01, 0.001] {
        let grid = Grid::build(&chunks, cell);
        assert_eq!(grid.len(), 6000);
        let dense = matches!(grid.layout, Layout::Dense { .. });
        assert_eq!(dense, cell > 0.05, "cells of {cell}");
        assert_finds_each_once(&format!("cells of {cell}"), &grid, &chunks);
    }
}

#[test]
fn cells_that_share_a_bucket_do_not_count_a_photon_twice() {
    let chunks = photons(6000);
    for bits in [0, 1, 4, 8] {
        let (cell, last) = cells(bounds(&chunks), 0.05);
        let layout = Layout::Hashed { bits };
        let grid = Grid::with_layout(&chunks, bounds(&chunks).min, cell, last, layout);
        assert_finds_each_once(&format!("{} buckets", 1 << bits), &grid, &chunks);
    }
    // With 16 buckets, some of the nine rows of a query share a bucket: without the check, photons would count twice.
    let layout = Layout::Hashed { bits: 4 };
    let rows = (0..9).flat_map(|k| layout.row(IVec3::new(4, 4 + k % 3, 4 + k / 3), 3));
    let mut buckets: Vec<usize> = rows.flatten().collect();
    assert_eq!(buckets.len(), 27);
    buckets.sort_unstable();
    buckets.dedup();
    assert!(buckets.len() < 27);
}

#[test]
fn the_order_is_by_path_within_a_cell_for_any_number_of_threads_and_any_chunks() {
    let chunks = photons(5000);
    let one: Vec<Item<u32>> = chunks.iter().flatten().copied().collect();
    for cell in [0.08, 0.01] {
        let expected = Grid::build(std::slice::from_ref(&one), cell);
        for threads in [1, 2, 4] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let grid = pool.expect("threads").install(|| Grid::build(&chunks, cell));
            assert!(grid.start == expected.start && grid.columns == expected.columns);
            assert!(grid.values == expected.values, "{threads} threads");
        }
        for bucket in expected.start.windows(2) {
            let order: Vec<u32> = expected.values[bucket[0] as usize..bucket[1] as usize].to_vec();
            assert!(order.is_sorted(), "{order:?}");
        }
    }
}

#[test]
fn no_photons_one_photon_and_photons_in_one_place() {
    let at = |p| Item { p, value: 0 };
    let none = Grid::build(&[], 0.1);
    assert_eq!((none.len(), found(&none, Vec3::ZERO, 9.0).len()), (0, 0));
    let one = Grid::build(&[vec![at(Vec3::ONE)], Vec::new()], 0.1);
    assert_eq!(found(&one, Vec3::ONE, 1e-3).len(), 1);
    assert_eq!(found(&one, Vec3::ZERO, 1.7).len(), 0);
    let many = Grid::build(&[vec![at(Vec3::ONE); 100]], 0.1);
    assert_eq!(found(&many, Vec3::new(1.0, 1.0, 1.05), 0.06).len(), 100);
}
