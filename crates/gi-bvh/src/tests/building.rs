//! Input of the build: empty, degenerate, invalid and pathological. The tree must not depend on the number of threads.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::*;

fn down(x: f32, y: f32) -> Ray {
    Ray::new(Vec3::new(x, y, 5.0), Vec3::NEG_Z)
}

#[test]
fn an_empty_tree_is_never_hit() {
    for_each_kernel(build(&[]), |bvh, isa| {
        assert!(
            bvh.closest(&down(0.0, 0.0)).is_none() && !bvh.occluded(&down(0.0, 0.0)),
            "{isa:?}"
        );
        assert!(bvh.bounds().is_empty());
    });
    let holder =
        Solid::Instance { tree: Arc::new(build(&[])), to_world: Affine3A::IDENTITY, index: 0 };
    let bvh = Bvh::build(&[], &[(holder, 0)]).expect("sound input");
    assert!(bvh.closest(&down(0.0, 0.0)).is_none());
}

#[test]
fn each_of_a_few_triangles_is_hit() {
    for count in 1..=40u16 {
        let at = |k: u16| Vec3::new(2.0 * f32::from(k), 0.0, 0.0);
        let triangles: Vec<Triangle> = (0..count)
            .map(|k| Triangle {
                v: [at(k), at(k) + Vec3::X, at(k) + Vec3::Y],
                id: u32::from(k) + 7,
            })
            .collect();
        for_each_kernel(build(&triangles), |bvh, isa| {
            for k in 0..count {
                let hit = bvh.closest(&down(2.0 * f32::from(k) + 0.25, 0.5));
                let expected = Hit {
                    t: 5.0,
                    u: 0.25,
                    v: 0.5,
                    prim: u32::from(k) + 7,
                    instance: Hit::NO_INSTANCE,
                };
                assert_eq!(hit, Some(expected), "{isa:?}, {count} triangles");
            }
        });
    }
}

#[test]
fn bad_coordinates_are_refused_with_their_primitive() {
    let mut rng = Pcg::new(3, 0);
    for (bad, large) in [
        (f32::NAN, false),
        (f32::INFINITY, false),
        (f32::NEG_INFINITY, false),
        (2e12, true),
        (-1e30, true),
    ] {
        for corner in 0..3 {
            let mut triangles = soup(&mut rng, 50, 0.1);
            triangles[20].v[corner][corner] = bad;
            let expected = if large {
                BuildError::TooLarge { id: 20 }
            } else {
                BuildError::NonFinite { id: 20 }
            };
            assert_eq!(Bvh::build(&triangles, &[]).err(), Some(expected));
            let solids = [(Solid::Sphere { center: triangles[20].v[corner], radius: 1.0 }, 20)];
            assert_eq!(Bvh::build(&[], &solids).err(), Some(expected));
        }
    }
    let solids = [
        Solid::Sphere { center: Vec3::ZERO, radius: f32::NAN },
        Solid::Disk { center: Vec3::ZERO, du: Vec3::X, dv: Vec3::splat(f32::NAN) },
        Solid::Cylinder { p0: Vec3::ZERO, p1: Vec3::X * f32::INFINITY, radius: 1.0 },
        Solid::Cylinder { p0: Vec3::ZERO, p1: Vec3::X, radius: f32::NAN },
    ];
    for solid in solids {
        assert_eq!(
            Bvh::build(&[], &[(solid.clone(), 5)]).err(),
            Some(BuildError::NonFinite { id: 5 }),
            "{solid:?}"
        );
    }
}

#[test]
fn bad_instances_are_refused_with_their_primitive() {
    let place =
        |tree: &Arc<Bvh>, to_world| Solid::Instance { tree: Arc::clone(tree), to_world, index: 0 };
    let inner = Arc::new(build(&icosphere(0)));
    let outer =
        Arc::new(Bvh::build(&[], &[(place(&inner, Affine3A::IDENTITY), 1)]).expect("one level"));
    let nested = Bvh::build(&[], &[(place(&outer, Affine3A::IDENTITY), 2)]);
    assert_eq!(nested.err(), Some(BuildError::NestedInstance { id: 2 }));
    let flat =
        Bvh::build(&[], &[(place(&inner, Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0))), 3)]);
    assert_eq!(flat.err(), Some(BuildError::Singular { id: 3 }));
    let lost =
        Bvh::build(&[], &[(place(&inner, Affine3A::from_translation(Vec3::splat(f32::NAN))), 4)]);
    assert_eq!(lost.err(), Some(BuildError::NonFinite { id: 4 }));
}

#[test]
fn triangles_without_area_are_never_hit() {
    let mut rng = Pcg::new(9, 0);
    let mut triangles = soup(&mut rng, 300, 0.3);
    for t in triangles.iter_mut().step_by(3) {
        t.v[2] = t.v[1];
    }
    for t in triangles.iter_mut().skip(1).step_by(7) {
        t.v = [t.v[0]; 3];
    }
    let points = vec![Triangle { v: [Vec3::ONE; 3], id: 0 }; 500];
    for_each_kernel(build(&points), |bvh, isa| {
        let aimed = Ray::new(Vec3::ZERO, Vec3::ONE);
        assert!(bvh.closest(&aimed).is_none() && !bvh.occluded(&aimed), "{isa:?}");
    });
    for_each_kernel(build(&triangles), |bvh, isa| {
        for _ in 0..2000 {
            let hit = bvh.closest(&Ray::new(in_cube(&mut rng), on_sphere(&mut rng)));
            let flat = |id: u32| id.is_multiple_of(3) || id % 7 == 1;
            assert!(hit.is_none_or(|h| !flat(h.prim)), "{isa:?}: {hit:?}");
        }
    });
    let solids = [
        (Solid::Sphere { center: Vec3::ZERO, radius: 0.0 }, 0),
        (Solid::Disk { center: Vec3::ZERO, du: Vec3::X, dv: Vec3::X }, 1),
        (Solid::Cylinder { p0: Vec3::ZERO, p1: Vec3::ZERO, radius: 1.0 }, 2),
    ];
    let bvh = Bvh::build(&[], &solids).expect("sound input");
    assert!(bvh.closest(&down(0.0, 0.0)).is_none() && bvh.bounds().is_empty());
}

/// Input on which simple builders take quadratic time or reach a huge depth.
fn pathological() -> Vec<(&'static str, Vec<Triangle>)> {
    let mut rng = Pcg::new(6, 0);
    let one = soup(&mut rng, 1, 1.0)[0];
    let chain = |count: u32, ratio: f32| {
        let link = |id: u32| {
            let k = ratio.powi(id as i32);
            Triangle {
                v: [Vec3::new(k, 0.0, 0.0), Vec3::new(2.0 * k, k, 0.0), Vec3::new(2.0 * k, 0.0, k)],
                id,
            }
        };
        (0..count).map(link).collect::<Vec<_>>()
    };
    let nested = |id: u32| {
        let s = (id + 1) as f32;
        Triangle {
            v: [Vec3::new(-s, -s, 0.0), Vec3::new(s, -s, 0.0), Vec3::new(0.0, 2.0 * s, 0.0)],
            id,
        }
    };
    let spike =
        |id: u32| Triangle { v: [Vec3::ZERO, on_sphere(&mut rng) * 100.0, Vec3::splat(1e-3)], id };
    vec![
        ("identical", (0..100_000).map(|id| Triangle { id, ..one }).collect()),
        ("one point", vec![Triangle { v: [Vec3::ONE; 3], id: 0 }; 100_000]),
        ("geometric series", chain(20_000, 0.999)),
        ("powers of two", chain(140, 0.5)),
        ("common centre", (0..50_000).map(nested).collect()),
        ("spikes", (0..20_000).map(spike).collect()),
        ("huge", mapped(&soup(&mut Pcg::new(7, 0), 20_000, 0.1), |p| p * 9e11)),
        ("tiny", mapped(&soup(&mut Pcg::new(7, 0), 20_000, 0.1), |p| p * 1e-30)),
    ]
}

#[test]
fn pathological_input_builds_fast_and_shallow() {
    for (name, triangles) in pathological() {
        let start = Instant::now();
        let bvh = build(&triangles);
        let time = start.elapsed();
        assert!(bvh.depth() <= MAX_DEPTH, "{name}: depth {}", bvh.depth());
        // A quadratic build of 100,000 triangles takes minutes; this one takes 0.1 s.
        assert!(time < Duration::from_secs(10), "{name}: {time:?}");
    }
}

#[test]
fn a_halved_tree_finds_the_same_hits() {
    let triangles = soup(&mut Pcg::new(8, 0), 5000, 0.2);
    let (a, b) =
        (build(&triangles), Bvh::build_by(Method::Halves, &triangles, &[]).expect("sound input"));
    let mut rng = Pcg::new(8, 1);
    for _ in 0..5000 {
        let ray = Ray::new(in_cube(&mut rng), on_sphere(&mut rng));
        assert_eq!(a.closest(&ray), b.closest(&ray));
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let mut triangles = soup(&mut Pcg::new(10, 0), 100_000, 0.05);
    triangles.extend(mapped(&soup(&mut Pcg::new(11, 0), 20, 1.0), |p| p * 2.0));
    let words = |bvh: &Bvh| -> Vec<u32> {
        let nodes = bvh.tree.nodes.iter().flat_map(|n| {
            n.bounds
                .as_flattened()
                .iter()
                .map(|x| x.to_bits())
                .chain(n.child)
                .chain(n.order)
                .collect::<Vec<_>>()
        });
        nodes.chain(bvh.tree.blocks.iter().flat_map(|b| b.id)).collect()
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        words(&pool.install(|| build(&triangles)))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(4));
}
