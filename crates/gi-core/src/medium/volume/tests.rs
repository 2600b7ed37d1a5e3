use super::*;

fn row(values: &[f32], outside: Outside, between: Between) -> Grid {
    let cells = Cells::Grey(values.into());
    Grid::new([values.len(), 1, 1], cells, outside, between).expect("a valid grid")
}

#[test]
fn values_are_interpolated_between_the_centres_of_cells() {
    let grid = row(&[1.0, 3.0], Outside::Clamp, Between::Trilinear);
    let expected = [(0.25, 1.0), (0.5, 2.0), (0.75, 3.0), (0.0, 1.0), (1.0, 3.0), (2.0, 3.0)];
    for (x, value) in expected {
        assert_eq!(grid.at(Vec3::new(x, 0.3, 0.9)).g, value, "{x}");
    }
    let grid = row(&[1.0, 3.0], Outside::Clamp, Between::Nearest);
    assert_eq!([0.1, 0.49, 0.51].map(|x| grid.at(Vec3::splat(x)).r), [1.0, 1.0, 3.0]);
}

#[test]
fn outside_the_cube_a_grid_is_clamped_repeated_mirrored_or_zero() {
    let at = |outside, x: f32| {
        row(&[1.0, 2.0, 3.0], outside, Between::Nearest).at(Vec3::new(x, 0.5, 0.5)).b
    };
    let places = [-0.5, -0.1, 1.1, 1.5, 2.1];
    assert_eq!(places.map(|x| at(Outside::Clamp, x)), [1.0, 1.0, 3.0, 3.0, 3.0]);
    assert_eq!(places.map(|x| at(Outside::Repeat, x)), [2.0, 3.0, 1.0, 2.0, 1.0]);
    assert_eq!(places.map(|x| at(Outside::Mirror, x)), [2.0, 1.0, 3.0, 2.0, 1.0]);
    assert_eq!(places.map(|x| at(Outside::Zero, x)), [0.0; 5]);
}

#[test]
fn grids_without_cells_or_with_too_few_values_are_refused() {
    let new =
        |size| Grid::new(size, Cells::Grey([1.0; 8].into()), Outside::Clamp, Between::Nearest);
    assert!(new([2, 2, 2]).is_some());
    assert!([[2, 2, 3], [0, 2, 2], [usize::MAX, 2, 1]].iter().all(|s| new(*s).is_none()));
}
