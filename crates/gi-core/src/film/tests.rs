use super::*;

#[test]
fn every_pixel_gets_its_own_samples_and_their_variance() {
    let mut film = Film::new([37, 21], Filter::Box, Show::All);
    for pass in 0..3u32 {
        film.add_pass(|[x, y]| Sample {
            radiance: Components {
                direct: Rgb::grey((x + 100 * y) as f32 + pass as f32),
                ..Default::default()
            },
            ..Default::default()
        });
    }
    let layers = film.layers();
    let (r, v) = (layers.channel("R").expect("R"), layers.channel("Variance.R").expect("variance"));
    for i in 0..37 * 21 {
        assert_eq!(r[i], (i % 37 + 100 * (i / 37)) as f32 + 1.0);
        // Values k, k+1, k+2: variance 1, of the mean of three 1/3.
        assert!((v[i] - 1.0 / 3.0).abs() < 1e-6);
    }
}

#[test]
fn samples_of_a_tile_reach_their_pixels() {
    for filter in [Filter::Box, Filter::Tent] {
        let sample = |[x, y]: [usize; 2]| Sample {
            radiance: Components { direct: Rgb::grey((x + 100 * y) as f32), ..Default::default() },
            offset: [0.2, -0.3],
            ..Default::default()
        };
        let mut films = [0, 1].map(|_| Film::new([37, 21], filter, Show::All));
        films[0].add_pass(sample);
        films[1].add_pass_by_tile(|tile| tile.iter().map(|&at| sample(at)).collect());
        let [one, other] = films.map(|film| film.layers().channel("R").expect("R").to_vec());
        assert_eq!(one, other);
    }
}

#[test]
fn the_stated_memory_is_what_a_film_allocates() {
    for filter in [Filter::Box, Filter::Gaussian { stddev: 0.5 }] {
        let mut film = Film::new([70, 33], filter, Show::All);
        film.add_pass(|_| Sample::default());
        let bytes = size_of_val(&film.pixels[..]) + size_of_val(&film.kept.floats[..]);
        assert_eq!(Film::memory(film.size(), filter), bytes as u64);
        film.end_passes();
        assert!(film.kept.floats.is_empty());
        // A later pass allocates it again.
        film.add_pass(|_| Sample::default());
        assert_eq!(film.passes(), 2);
    }
}

#[test]
fn a_constant_picture_stays_constant_under_every_filter_and_an_edge_gets_its_share() {
    for filter in [Filter::Tent, Filter::Gaussian { stddev: 0.5 }, Filter::Lanczos { lobes: 3 }] {
        let mut film = Film::new([20, 20], filter, Show::All);
        let mut rng = crate::rng::Pcg::new(2, 9);
        for _ in 0..200 {
            let offsets: Vec<[f32; 2]> = (0..400).map(|_| rng.next_2d().map(|u| u - 0.5)).collect();
            film.add_pass(|[x, y]| {
                let offset = offsets[20 * y + x];
                // One everywhere; in the second component one right of x = 10.
                let right = if x as f32 + 0.5 + offset[0] > 10.0 { 1.0 } else { 0.0 };
                let radiance = Components {
                    direct: Rgb::WHITE,
                    indirect: Rgb::grey(right),
                    ..Default::default()
                };
                Sample { radiance, offset, ..Default::default() }
            });
        }
        let layers = film.layers();
        let (direct, edge) = (
            layers.channel("Direct.G").expect("a layer"),
            layers.channel("Indirect.G").expect("a layer"),
        );
        assert!(direct.iter().all(|v| (v - 1.0).abs() < 1e-5), "{filter:?}");
        // The step through the filter: one half at the edge, in symmetry about it.
        let column = |x: usize| (4..16).map(|y| edge[20 * y + x]).sum::<f32>() / 12.0;
        assert!(
            (column(9) + column(10) - 1.0).abs() < 0.02,
            "{filter:?}: {} {}",
            column(9),
            column(10)
        );
        let step = column(10) - column(9);
        // Integral of the filter from -1/2 to 1/2 of a pixel.
        let table = FilterTable::new(filter);
        let total: f32 = (-400..400).map(|i| table.weight((i as f32 + 0.5) * 0.01)).sum();
        let middle: f32 = (-50..50).map(|i| table.weight((i as f32 + 0.5) * 0.01)).sum();
        assert!(
            (step - middle / total).abs() < 0.02,
            "{filter:?}: {step} is not {}",
            middle / total
        );
    }
}
