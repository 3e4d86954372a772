//! Orders of tiles.

use powergs_core::workload::order::{TileOrder, tiles};

#[test]
fn every_tile_comes_once() {
    for (nx, ny) in [(0, 0), (1, 1), (7, 1), (1, 9), (5, 3), (16, 16), (120, 68), (3, 40)] {
        for order in [TileOrder::Raster, TileOrder::Morton, TileOrder::Hilbert] {
            let mut all = tiles(nx, ny, order);
            assert_eq!(all.first(), (nx * ny > 0).then_some(&0), "{nx}x{ny} {order:?} starts at 0");
            all.sort_unstable();
            assert!(all.into_iter().eq(0..nx * ny), "{nx}x{ny} {order:?}");
        }
    }
}

#[test]
fn small_grids_are_as_drawn() {
    assert_eq!(tiles(3, 2, TileOrder::Raster), [0, 1, 2, 3, 4, 5]);
    assert_eq!(tiles(4, 2, TileOrder::Morton), [0, 1, 4, 5, 2, 3, 6, 7]);
    assert_eq!(tiles(2, 2, TileOrder::Hilbert), [0, 2, 3, 1]);
}

#[test]
fn the_hilbert_curve_goes_from_neighbour_to_neighbour() {
    for side in [2, 4, 8, 32] {
        let all = tiles(side, side, TileOrder::Hilbert);
        for pair in all.windows(2) {
            let at = |i: u32| (i % side, i / side);
            let ((ax, ay), (bx, by)) = (at(pair[0]), at(pair[1]));
            assert_eq!(ax.abs_diff(bx) + ay.abs_diff(by), 1, "{pair:?} of {side}");
        }
    }
}
