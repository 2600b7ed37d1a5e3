//! Pictures are the same, bit for bit, for any number of threads, and differ between seeds.

use gi_core::film::Show;
use gi_tests::World;
use pathtrace::{Mode, Params, PathTracer};

fn bits(world: &World, mode: Mode, threads: usize, seed: u32) -> Vec<(String, Vec<u32>)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let params = Params { mode, ..Params::default() };
    let film = pool.install(|| world.render::<PathTracer>(&params, 3, seed, Show::All));
    let channels = film.layers().channels;
    channels.into_iter().map(|(name, v)| (name, v.iter().map(|x| x.to_bits()).collect())).collect()
}

#[test]
fn every_layer_has_the_same_bits_at_1_2_and_4_threads() {
    const ALL: [Mode; 5] = [Mode::Path, Mode::Light, Mode::Bdpt, Mode::Vcm, Mode::VolPath];
    for (scene, size, modes) in [
        ("cornell-spheres.xml", [50, 40], &ALL[..4]),
        ("patio.xml", [40, 30], &ALL[..3]),
        ("fog.xml", [40, 40], &ALL[1..]),
        ("marble.xml", [40, 40], &ALL[3..]),
    ] {
        for &mode in modes {
            let world = World::load(scene, size, &[]);
            let one = bits(&world, mode, 1, 7);
            for threads in [2, 4] {
                // The tree is also built again with that many threads.
                let pool =
                    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
                let world = pool.install(|| World::load(scene, size, &[]));
                assert!(
                    bits(&world, mode, threads, 7) == one,
                    "{scene}, {mode:?}: {threads} threads differ from one"
                );
            }
            assert!(
                bits(&world, mode, 2, 8) != one,
                "{scene}, {mode:?}: another seed gives the same picture"
            );
        }
    }
}
