//! Caches that are saved to a file and read again.

use super::*;

#[test]
fn a_saved_cache_gives_the_same_picture_and_helps_another_view() {
    for bounces in [None, Some(2)] {
        let world = World::load("cornell-box.xml", [40, 40], &[]);
        let params = Params { bounces, rays: 100, ..Params::default() };
        let (fresh, film) = world.run::<IrradianceCaching>(&params, 2, 7, Show::All);
        let folder = Folder::make();
        let again = Params { files: saved(&folder, &fresh.saved()), ..params.clone() };
        let (read, second) = world.run::<IrradianceCaching>(&again, 2, 7, Show::All);
        assert_eq!(film.layers().channels, second.layers().channels);
        assert_eq!(statistic(&read, "records_made"), 0.0);
        // A view from the side: records of the first view are reused.
        let side = world.from_the_side();
        let (alone, _) = side.run::<IrradianceCaching>(&params, 1, 7, Show::All);
        let (helped, _) = side.run::<IrradianceCaching>(&again, 1, 7, Show::All);
        let (alone, helped) =
            (statistic(&alone, "records_made"), statistic(&helped, "records_made"));
        assert!(
            helped < 0.5 * alone,
            "{helped} new records with the saved cache, {alone} without it"
        );
    }
}

/// Save a cache to a file, and return options that read it.
fn saved(folder: &Folder, cache: &SavedCache) -> CacheFiles {
    let path = folder.path().join("a.cache");
    std::fs::write(&path, cache.to_bytes()).expect("written");
    CacheFiles { cache_in: Some(path), ..CacheFiles::default() }
}

fn statistic(technique: &IrradianceCaching, name: &str) -> f64 {
    let all = technique.statistics();
    all.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no {name}")).1
}

#[test]
fn a_cache_of_another_world_or_of_other_settings_is_refused() {
    let world = World::load("cornell-box.xml", [8, 8], &[]);
    let params = Params { rays: 20, ..Params::default() };
    let (made, _) = world.run::<IrradianceCaching>(&params, 1, 7, Show::All);
    let folder = Folder::make();
    let refusal = |cache: SavedCache, params: Params| {
        let setting = world.setting(1, Show::All);
        let params = Params { files: saved(&folder, &cache), ..params };
        IrradianceCaching::prepare(setting, &params).err().expect("a refusal")
    };
    let other = SavedCache { world: 99, ..made.saved() };
    assert!(refusal(other, params.clone()).contains("another scene"));
    let finer = Params { accuracy: 0.05, ..params };
    let text = refusal(made.saved(), finer);
    assert!(text.contains("--accuracy 0.1") && text.contains("--accuracy 0.05"), "{text}");
}
