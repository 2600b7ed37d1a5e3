use super::*;

fn ramp(wrap: Wrap, lookup: Lookup) -> Bitmap {
    Bitmap::new(4, 1, Texels::Float((0..4).map(|i| Rgb::grey(i as f32)).collect()), wrap, lookup)
}

#[test]
fn every_texel_is_found_in_its_tile() {
    // Sizes that are not multiples of a tile's.
    let (w, h) = (SIDE * 2 + 3, SIDE + 1);
    let texels: Vec<[u8; 3]> = (0..w * h).map(|i| [i as u8, 2 * i as u8, 255]).collect();
    let floats = texels.iter().map(|t| Rgb::from(t.map(|c| f32::from(c) / 255.0))).collect();
    for stored in [Texels::Linear8(texels), Texels::Float(floats)] {
        let b = Bitmap::new(w, h, stored, Wrap::Clamp, Lookup::Nearest);
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let (texel, i) = (b.texel(x, y), (y * w + x) as f32);
            let expected = Rgb::new(i, 2.0 * i, 255.0) * (1.0 / 255.0);
            assert!((texel - expected).map(f32::abs).max() < 1e-6, "({x}, {y}): {texel:?}");
        }
    }
}

#[test]
fn bilinear_lookup_reads_texel_centres_exactly_and_means_between() {
    let b = ramp(Wrap::Repeat, Lookup::Bilinear);
    for i in 0..4 {
        assert_eq!(b.eval(Vec2::new((i as f32 + 0.5) / 4.0, 0.3)).r, i as f32);
    }
    assert!((b.eval(Vec2::new(0.5, 0.5)).r - 1.5).abs() < 1e-6);
    assert!((b.eval(Vec2::new(0.0, 0.5)).r - 1.5).abs() < 1e-6, "the seam joins texels 3 and 0");
}

#[test]
fn wrapping_works_far_outside_and_for_nan() {
    let read = |wrap, u: f32| ramp(wrap, Lookup::Nearest).eval(Vec2::new(u, 0.0)).r;
    assert_eq!([-0.1, 1.1, 5.3].map(|u| read(Wrap::Repeat, u)), [3.0, 0.0, 1.0]);
    assert_eq!([-0.1, 1.1, 5.3].map(|u| read(Wrap::Mirror, u)), [0.0, 3.0, 2.0]);
    assert_eq!([-0.1, 1.1, 5.3].map(|u| read(Wrap::Clamp, u)), [0.0, 3.0, 3.0]);
    // A float this large is a whole number of pictures, and of pairs of pictures.
    for u in [1e10, -1e10, 1e30, 3e38] {
        let near = read(Wrap::Repeat, 0.0);
        assert_eq!(read(Wrap::Repeat, u), near, "{u}");
        assert_eq!(read(Wrap::Mirror, u), near, "{u}");
        assert_eq!(read(Wrap::Clamp, u), if u > 0.0 { 3.0 } else { 0.0 }, "{u}");
        let smooth = |u: f32| ramp(Wrap::Repeat, Lookup::Bilinear).eval(Vec2::new(u, 0.5)).r;
        assert_eq!(smooth(u), smooth(0.0), "{u}");
    }
    for u in [f32::NAN, f32::INFINITY, -1e30, 3e38] {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for lookup in [Lookup::Nearest, Lookup::Bilinear] {
                for uv in [Vec2::new(u, u), Vec2::new(u, 0.2), Vec2::new(0.2, u)] {
                    let value = ramp(wrap, lookup).eval(uv).r;
                    assert!((0.0..=3.0).contains(&value), "{uv} {wrap:?} {lookup:?}: {value}");
                }
            }
        }
    }
}

/// In each cell, differences of the bilinear interpolation have no error but rounding. Near a texel's centre the slope changes.
#[test]
fn the_gradient_is_the_slope_of_the_cell() {
    let texels = (0..15).map(|i| Rgb::grey((i * i % 7) as f32)).collect();
    let bitmap = Bitmap::new(5, 3, Texels::Float(texels), Wrap::Repeat, Lookup::Bilinear);
    for k in 0..200 {
        let uv = Vec2::new((k as f32 * 0.618_034).fract(), (k as f32 + 0.5) / 200.0);
        let within = uv * Vec2::new(5.0, 3.0) - 0.5;
        if (within - within.round()).abs().min_element() < 0.02 {
            continue;
        }
        let slope = |step: Vec2| {
            (bitmap.eval(uv + step).r - bitmap.eval(uv - step).r) / (2.0 * step.length())
        };
        let [du, dv] = bitmap.gradient(uv).map(|slope| slope.r);
        let expected = [slope(Vec2::X * 2e-3), slope(Vec2::Y * 2e-3)];
        assert!((du - expected[0]).abs() < 0.01 && (dv - expected[1]).abs() < 0.01, "{uv}");
    }
    assert_eq!(ramp(Wrap::Clamp, Lookup::Nearest).gradient(Vec2::ONE * 0.5), [Rgb::BLACK; 2]);
}
