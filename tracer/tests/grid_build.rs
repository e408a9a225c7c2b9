//! Is every triangle in the cells that it may be hit in, and in no others? Are the bounds on a grid's size kept?

mod kd_support;

use kd_support::*;
use proptest::prelude::*;
use scenes::{Triangle, Vec3};
use tracer::Aabb;
use tracer::grid::{DENSITY, Grid, MAX_CELLS_PER_AXIS};

/// Whether a box, widened by the grid's margin, meets a cell.
fn meets(grid: &Grid, bounds: &Aabb, cell: u32) -> bool {
    let [nx, ny, _] = grid.resolution();
    let place = [cell % nx, cell / nx % ny, cell / nx / ny];
    (0..3).all(|axis| {
        let at = |plane: u32| f64::from(grid.planes(axis)[plane as usize]);
        let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
        let margin = f64::from(grid.margin());
        at(place[axis]) <= high + margin && low - margin <= at(place[axis] + 1)
    })
}

/// What every grid must satisfy.
fn check(triangles: &[Triangle]) -> Grid {
    let grid = Grid::build(triangles).unwrap();
    let resolution = grid.resolution();
    assert_eq!(grid.cell_count(), resolution.iter().product::<u32>());
    for (axis, cells) in resolution.into_iter().enumerate() {
        let planes = grid.planes(axis);
        assert_eq!(planes.len(), cells as usize + 1);
        assert!(planes.is_sorted(), "{planes:?}");
        assert_eq!((planes[0], planes[cells as usize]), (f32::NEG_INFINITY, f32::INFINITY));
    }
    let mut end = 0;
    for cell in 0..grid.cell_count() {
        let references = grid.cell(cell);
        assert_eq!(references.start, end, "cells follow each other");
        end = references.end;
        let listed = &grid.references()[references.start as usize..end as usize];
        let expected: Vec<u32> = (0..)
            .zip(triangles)
            .filter(|(_, triangle)| meets(&grid, &Aabb::of_triangle(triangle), cell))
            .map(|(index, _)| index)
            .collect();
        assert_eq!(listed, expected, "cell {cell} of {resolution:?}");
    }
    assert_eq!(end as usize, grid.references().len());
    let counted = grid.statistics();
    assert_eq!((counted.cells, counted.references), (u64::from(grid.cell_count()), u64::from(end)));
    grid
}

#[test]
fn soups_quads_and_flat_scenes_list_each_triangle_where_its_box_is() {
    for seed in 0..4 {
        check(&soup(200, seed));
    }
    check(&quads(4));
    let mut flat = soup(100, 9);
    flat.iter_mut().flat_map(|t| &mut t.v).for_each(|corner| corner.y = 3.0);
    assert_eq!(check(&flat).resolution()[1], 1);
    let mut line = soup(100, 10);
    line.iter_mut().flat_map(|t| &mut t.v).for_each(|corner| *corner = Vec3::new(1.0, 3.0, corner.z));
    assert_eq!(check(&line).resolution(), [1, 1, 500]);
}

#[test]
fn scenes_far_from_the_origin_tiny_or_huge_list_each_triangle_where_its_box_is() {
    for (scale, offset) in
        [(1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)), (1e-30, Vec3::ZERO), (1e38, Vec3::ZERO)]
    {
        let mut triangles = soup(100, 7);
        triangles.iter_mut().flat_map(|t| &mut t.v).for_each(|p| *p = *p * scale + offset);
        check(&triangles);
    }
    // The planes of a scene as thin as the spacing of floats coincide.
    let thin = |y: f32| Triangle { v: [Vec3::new(0.0, 1e7, 0.0), Vec3::X + 1e7, Vec3::new(0.0, y, 1.0)] };
    check(&[thin(1e7), thin(1e7_f32.next_up())]);
}

#[test]
fn an_empty_scene_and_a_single_point_have_one_cell() {
    let empty = check(&[]);
    assert_eq!((empty.resolution(), empty.cell(0)), ([1; 3], 0..0));
    let point = check(&[Triangle { v: [Vec3::ONE; 3] }]);
    assert_eq!((point.resolution(), point.cell(0)), ([1; 3], 0..1));
}

#[test]
fn one_triangle_and_many_copies_of_it_are_listed_by_its_box() {
    let one = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, 1.0)] };
    assert_eq!(check(&[one]).resolution(), [1; 3]);
    let grid = check(&vec![one; 100]);
    assert!(grid.cell_count() > 1);
    assert!(grid.references().len() as u64 <= Grid::REFERENCES_PER_TRIANGLE * 100 + Grid::FREE_REFERENCES);
}

#[test]
fn a_grid_with_too_many_references_is_made_coarser_and_one_with_just_enough_is_not() {
    let bar = |length: f32| Triangle { v: [Vec3::ZERO, Vec3::X * length, Vec3::X * length] };
    // `long` bars cover all cells of a line; the others lie in its last cell, and tell their number.
    let line = |long: usize, short: usize| {
        let dot = Triangle { v: [Vec3::X * 99.999; 3] };
        let triangles = [vec![bar(100.0); long], vec![dot; short]].concat();
        Grid::build(&triangles).unwrap()
    };
    let (triangles, cells) = (200, 1000);
    let limit = Grid::REFERENCES_PER_TRIANGLE * triangles + Grid::FREE_REFERENCES;
    let fits = |long: u64| long * cells + (triangles - long) <= limit;
    assert!(fits(7) && !fits(8));
    assert_eq!(line(7, 193).resolution(), [1000, 1, 1]);
    assert_eq!(line(7, 193).references().len(), 7193);
    assert_eq!(line(8, 192).resolution(), [500, 1, 1]);
    assert_eq!(line(8, 192).references().len(), 8 * 500 + 192);
}

#[test]
fn cells_per_axis_are_capped() {
    let dot = |x: f32| Triangle { v: [Vec3::X * x; 3] };
    let line = |count: usize| Grid::build(&(0..count).map(|i| dot(i as f32)).collect::<Vec<_>>()).unwrap();
    assert_eq!(line(819).resolution(), [4095, 1, 1]);
    assert_eq!(line(820).resolution(), [MAX_CELLS_PER_AXIS, 1, 1]);
}

#[test]
fn corners_that_are_not_finite_are_refused_by_number() {
    let good = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
    for bad in [f32::NAN, f32::INFINITY] {
        let mut triangles = [good; 3];
        triangles[1].v[2].z = bad;
        let message = Grid::build(&triangles).unwrap_err().to_string();
        assert!(message.contains("triangle 1") && message.contains("remove it"), "{message}");
    }
    let far = Vec3::splat(f32::MAX);
    check(&[Triangle { v: [-far, far, Vec3::ZERO] }, good]);
}

#[test]
fn the_same_triangles_give_the_same_grid() {
    let triangles = soup(3000, 1);
    let (a, b) = (Grid::build(&triangles).unwrap(), Grid::build(&triangles).unwrap());
    assert_eq!((a.resolution(), a.references()), (b.resolution(), b.references()));
    assert!((0..a.cell_count()).all(|cell| a.cell(cell) == b.cell(cell)));
}

#[test]
fn the_expected_cost_is_that_of_a_sum_over_cells() {
    let triangles = soup(300, 2);
    let grid = Grid::build(&triangles).unwrap();
    let extent = grid.bounds().extent().as_dvec3();
    let cell = extent / glam::UVec3::from_array(grid.resolution()).as_dvec3();
    let area = |d: glam::DVec3| d.x * d.y + d.y * d.z + d.z * d.x;
    let expected: f64 = (0..grid.cell_count())
        .map(|index| (3.0 + 1.5 * f64::from(grid.cell(index).len() as u32)) * area(cell) / area(extent))
        .sum();
    let cost = grid.sah_cost(3.0, 1.5).unwrap();
    assert!((cost / expected - 1.0).abs() < 1e-12, "{cost}, {expected}");
    assert_eq!(Grid::build(&[]).unwrap().sah_cost(1.0, 1.0), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_soup_lists_each_triangle_where_its_box_is(seed in any::<u64>(), count in 1_usize..80, lattice: bool) {
        let mut triangles = soup(count, seed);
        if lattice {
            triangles.iter_mut().flat_map(|t| &mut t.v).for_each(|corner| *corner = (*corner * 3.0).round());
        }
        let grid = check(&triangles);
        prop_assert!(f64::from(grid.cell_count()) <= DENSITY * count as f64);
    }
}
