//! How many cells a grid has.

use glam::DVec3;

/// Cells per triangle, the `lambda` of Wald et al. 2006, with their value. Ize et al. 2007 find the fastest grids at a number of
/// cells in proportion to that of the triangles.
pub const DENSITY: f64 = 5.0;

/// Most cells of a grid: 256 MiB, at 4 bytes each.
pub const MAX_CELLS: u32 = 1 << 26;

/// Most cells along an axis. Cells then stay 100 times as thick as rounding is uncertain for a ray from inside the scene.
pub const MAX_CELLS_PER_AXIS: u32 = 4096;

/// Cells along x, y and z for a scene's extents and number of triangles: `floor(extent * cbrt(DENSITY * triangles / volume))`, so
/// that cells are as cubic as can be and at most `DENSITY` per triangle (Cleary et al. 1983, Wald et al. 2006).
///
/// An axis too short for one such cell, as in a flat scene, has one cell, and the same rule holds in the remaining plane or
/// line. [`MAX_CELLS`] takes the place of `DENSITY * triangles` where that is larger.
pub(super) fn resolution(extent: DVec3, triangles: usize) -> [u32; 3] {
    let wanted = (DENSITY * triangles as f64).min(f64::from(MAX_CELLS));
    let mut cells = [1; 3];
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| extent[a].total_cmp(&extent[b]));
    for shortest in 0..3 {
        let axes = &axes[shortest..];
        let cells_per_volume = wanted / axes.iter().map(|&axis| extent[axis]).product::<f64>();
        let cells_per_length = match axes.len() {
            3 => cells_per_volume.cbrt(),
            2 => cells_per_volume.sqrt(),
            _ => cells_per_volume,
        };
        // Not so for a flat scene either: 0 * inf is no number.
        if extent[axes[0]] * cells_per_length >= 1.0 {
            for &axis in axes {
                cells[axis] = ((extent[axis] * cells_per_length) as u32).clamp(1, MAX_CELLS_PER_AXIS);
            }
            break;
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(x: f64, y: f64, z: f64, triangles: usize) -> [u32; 3] {
        resolution(DVec3::new(x, y, z), triangles)
    }

    fn total(cells: [u32; 3]) -> u64 {
        cells.map(u64::from).iter().product()
    }

    #[test]
    fn cells_are_cubes_and_as_many_as_the_density_says() {
        // 5 * 1600 = 8000 = 20^3; one triangle less asks for a little less, one more for a little more.
        assert_eq!(cells(7.0, 7.0, 7.0, 1599), [19, 19, 19]);
        assert_eq!(cells(7.0, 7.0, 7.0, 1601), [20, 20, 20]);
        // The volume is 8718; cells of edge 1.03.
        assert_eq!(cells(40.5, 20.5, 10.5, 1600), [39, 19, 10]);
        for triangles in [1, 2, 10, 1000, 262_267] {
            let count = total(cells(3.0, 1.1, 2.3, triangles)) as f64;
            assert!(count <= DENSITY * triangles as f64 && count >= 1.0);
            assert!(triangles < 1000 || count > 0.7 * DENSITY * triangles as f64, "{triangles}: {count}");
        }
    }

    #[test]
    fn scale_and_order_of_the_axes_do_not_matter() {
        for scale in [1e-30, 1.0, 1e30] {
            assert_eq!(cells(40.5 * scale, 20.5 * scale, 10.5 * scale, 1600), [39, 19, 10]);
            assert_eq!(cells(10.5 * scale, 40.5 * scale, 20.5 * scale, 1600), [10, 39, 19]);
        }
    }

    #[test]
    fn flat_scenes_are_cut_in_their_plane_and_points_not_at_all() {
        assert_eq!(cells(4.0, 0.0, 4.0, 2000), [100, 1, 100]);
        assert_eq!(cells(0.0, 3.0, 0.0, 200), [1, 1000, 1]);
        assert_eq!(cells(0.0, 0.0, 0.0, 1_000_000), [1, 1, 1]);
        // As thick as a 100th of a cell.
        assert_eq!(cells(4.0, 4e-4, 4.0, 2000), [100, 1, 100]);
        assert_eq!(cells(0.0, 0.0, 0.0, 0), [1, 1, 1]);
        assert_eq!(cells(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY, 0), [1, 1, 1]);
    }

    #[test]
    fn both_caps_hold_and_do_not_bind_below() {
        let most = MAX_CELLS_PER_AXIS;
        let line = |triangles| cells(1.0, 0.0, 0.0, triangles)[0];
        assert_eq!(line(819), 5 * 819);
        assert_eq!([line(820), line(1 << 27)], [most; 2]);
        // Their density asks for 2^24 and for 5 * 2^24 cells; 2^26 are allowed.
        let cube = |triangles| total(cells(1.0, 1.0, 1.0, triangles));
        assert_eq!(cube(3_355_443), 255_u64.pow(3));
        assert_eq!(cube(1 << 24), 406_u64.pow(3));
        assert_eq!(cube(1 << 27), 406_u64.pow(3));
        assert!(406_u64.pow(3) <= u64::from(MAX_CELLS) && 407_u64.pow(3) > u64::from(MAX_CELLS));
    }
}
