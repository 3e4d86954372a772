//! The level of every tile.

use powergs_frame::fovea::{
    EccentricityMap, GAZE_CYCLE, GazeError, Screen, ScreenGaze, TileLevels,
};
use powergs_frame::splat::TileGrid;
use powergs_frame::splat::cover::TileRect;
use powergs_testkit::scenes::load;
use serde_json::Value;

fn rows(value: &Value) -> Vec<f64> {
    let rows = value.as_array().expect("rows").iter();
    rows.flat_map(|row| row.as_array().expect("a row")).map(|v| v.as_f64().expect("x")).collect()
}

/// All tiles of two screens; the reference is rounded to six decimals.
#[test]
fn published_levels_and_slopes_of_tiles() {
    for case in load("foveation_levels.json")["cases"].as_array().expect("cases") {
        let n = |key: &str| case[key].as_u64().expect("a number") as u32;
        let gaze = [0, 1].map(|i| case["gaze"][i].as_f64().expect("a gaze"));
        let (width, height) = (n("W"), n("H"));
        let map = EccentricityMap::on(Screen::PUBLISHED, gaze, [width, height]).expect("a gaze");
        let grid = TileGrid::new(width, height, 16);
        assert_eq!((grid.nx, grid.ny), (n("tiles_x"), n("tiles_y")));
        let tiles = TileLevels::new(&map, grid).tiles;
        for (key, of) in [
            ("level", &(|i: usize| tiles[i].level) as &dyn Fn(usize) -> f64),
            ("grad_x", &|i| tiles[i].slope[0]),
            ("grad_y", &|i| tiles[i].slope[1]),
        ] {
            for (i, want) in rows(&case[key]).into_iter().enumerate() {
                assert!((of(i) - want).abs() < 2e-6, "{key} of tile {i}: {} for {want}", of(i));
            }
        }
        // The published least level decides the first one. Its own rule of blending is another
        // (it leaves out tiles that only end beyond the middle): whoever blends there blends here.
        let published = rows(&case["level_min"]).into_iter().zip(case["blend"].as_array().unwrap());
        let blends = published.zip(&tiles).filter(|((least, row), tile)| {
            let _ = row;
            assert_eq!(f64::from(tile.first), least.max(0.0).trunc().min(3.0));
            least.max(0.0).fract() > 0.5 && *least < 3.0 && !tile.blends
        });
        assert_eq!(blends.count(), 0);
    }
}

/// Seen from the middle, left and right and top and bottom are alike: the seams are symmetric,
/// which the published ones are not (B10).
#[test]
fn seams_are_symmetric() {
    let map = EccentricityMap::new([0.5, 0.5], 90.0, [640, 480]).expect("a gaze");
    let levels = TileLevels::new(&map, TileGrid::new(640, 480, 16));
    let mut mixed = 0;
    for (x, y) in (0..320).flat_map(|x| (0..240).map(move |y| (x, y))) {
        // Pixel centres are at whole numbers and tiles begin at them: the mirror of x is 640 - x.
        let share = levels.share(x, y);
        mixed += u32::from(share > 0.0 && share < 1.0);
        for (x, y) in [(640 - x, y), (x, 480 - y)].into_iter().filter(|&(x, y)| x < 640 && y < 480)
        {
            let (tx, ty) = (x % 16, y % 16);
            // The first column of a tile mirrors to that of the next one: another linear piece.
            if tx != 0 && ty != 0 {
                assert!((levels.share(x, y) - share).abs() < 1e-9, "{x} {y}");
            }
        }
    }
    assert!(mixed > 1000, "{mixed}");
}

/// Within a tile the share never falls away from the gaze, and it is 0 at its least level.
#[test]
fn shares_grow_with_the_level() {
    let map = EccentricityMap::new([0.1, 0.8], 110.0, [500, 300]).expect("a gaze");
    let levels = TileLevels::new(&map, TileGrid::new(500, 300, 16));
    for tile in &levels.tiles {
        assert!(tile.first <= 3 && !(tile.first == 3 && tile.blends));
        let [gx, gy] = tile.slope.map(|g| 0.5 * g.signum());
        if tile.level - f64::from(tile.first) < 1.5 {
            assert!(tile.share([-gx, -gy]) <= tile.share([gx, gy]));
        }
        assert!(tile.blends || tile.share([gx, gy]) == 0.0);
        assert_eq!(tile.blends, tile.share([gx, gy]) > 0.0, "{tile:?}");
    }
}

#[test]
fn filters_count_what_they_keep() {
    let map = EccentricityMap::new([0.3, 0.6], 90.0, [640, 480]).expect("a gaze");
    let grid = TileGrid::new(640, 480, 16);
    let filter = TileLevels::new(&map, grid).filter();
    for (highest, rect) in (0..4u8).flat_map(|h| {
        [(0, 0, 40, 30), (3, 2, 17, 25), (5, 5, 5, 9), (39, 29, 40, 30)].map(|r| (h, r))
    }) {
        let (x0, y0, x1, y1) = rect;
        let tiles = (y0..y1).flat_map(|y| (x0..x1).map(move |x| grid.index(x, y)));
        let want = tiles.filter(|&t| filter.keeps(t, highest)).count() as u64;
        assert_eq!(filter.count(&TileRect { x0, y0, x1, y1 }, highest), want);
    }
}

/// Which levels a picture has: the published widths (R4 needs about 520 pixels at 90 degrees).
#[test]
fn small_pictures_lack_regions() {
    let missing = |width: u32, screen: Screen| {
        let map = EccentricityMap::on(screen, [0.5, 0.5], [width, width * 3 / 4]).expect("a gaze");
        map.missing_regions()
    };
    assert_eq!(missing(64, Screen::PUBLISHED), [1, 2, 3]);
    assert_eq!(missing(256, Screen::PUBLISHED), [3]);
    assert_eq!(missing(800, Screen::PUBLISHED), [0u8; 0]);
    let wider = Screen { fov_deg: 110.0, ..Screen::PUBLISHED };
    let eager = Screen { pooling_rate: 0.4, ..Screen::PUBLISHED };
    assert!(missing(256, wider).len() <= missing(256, Screen::PUBLISHED).len());
    assert_eq!(missing(256, eager), [0u8; 0]);
}

#[test]
fn screens_and_gazes_that_cannot_be() {
    assert_eq!(Screen::parse("wide-110").expect("a preset").fov_deg, 110.0);
    assert_eq!(Screen::parse(" 97.5 ").expect("degrees").fov_deg, 97.5);
    for bad in ["0", "180", "-3", "NaN", "inf", "wide", ""] {
        assert!(Screen::parse(bad).is_err(), "{bad}");
    }
    assert!(Screen::parse("narrow").unwrap_err().contains("wide-100"));
    for rate in [0.0, -1.0, f64::NAN, 11.0] {
        let screen = Screen { pooling_rate: rate, ..Screen::PUBLISHED };
        assert!(matches!(screen.check(), Err(GazeError::PoolingRate { .. })), "{rate}");
    }
    let gaze_at =
        |x, y| ScreenGaze { point: [x, y], screen: Screen::PUBLISHED }.eccentricity_map([64, 48]);
    // Just outside is outside.
    for gaze in [(1.000_000_1, 0.5), (-1e-9, 0.5), (0.5, f32::NAN)] {
        assert!(matches!(gaze_at(gaze.0, gaze.1), Err(GazeError::Gaze { .. })), "{gaze:?}");
    }
    assert!(GAZE_CYCLE.iter().all(|&[x, y]| gaze_at(x, y).is_ok()));
    assert_eq!(GAZE_CYCLE[1], [0.25, 0.5], "the first number is the outer loop");
}
