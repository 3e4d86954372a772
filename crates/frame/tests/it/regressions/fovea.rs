//! Screens and levels.

use glam::DVec3;
use powergs_frame::fovea::{EccentricityMap, Screen, ScreenRule, ScreenWidth, TileLevels};
use powergs_frame::scene::Camera;
use powergs_frame::splat::TileGrid;

/// A camera with this horizontal field of view, degrees, in an image of 1280x1024.
fn camera(degrees: f64) -> Camera {
    let own = Camera::looking_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.6, (1280, 1024));
    let focal = 640.0 / (degrees.to_radians() / 2.0).tan();
    Camera { fx: focal, fy: focal, ..own }
}

fn of_camera() -> ScreenRule {
    ScreenRule { width: ScreenWidth::OfCamera, ..Screen::PUBLISHED.into() }
}

/// Tiles of R1 to R4 with the gaze in the middle.
fn tiles(screen: Screen) -> [usize; 4] {
    let map = EccentricityMap::on(screen, [0.5, 0.5], [1280, 1024]).expect("a gaze");
    let tiles = TileLevels::new(&map, TileGrid::new(1280, 1024, 16)).tiles;
    [0, 1, 2, 3].map(|region| tiles.iter().filter(|tile| tile.region() == region).count())
}

#[test]
fn a_camera_of_40_degrees_was_shown_on_a_screen_of_90() {
    let screen = of_camera().of(&camera(40.0));
    assert!((screen.fov_deg - 40.0).abs() < 1e-9, "{}", screen.fov_deg);
    assert_eq!(screen.pooling_rate, Screen::PUBLISHED.pooling_rate);
    assert_eq!(tiles(screen), [1600, 1764, 1444, 312]);
    assert_eq!(tiles(Screen::PUBLISHED), [584, 640, 856, 3040]);
    // One that is given holds for all cameras.
    let given = ScreenRule::from(Screen::PUBLISHED);
    assert_eq!(given.of(&camera(40.0)), Screen::PUBLISHED);
}

#[test]
fn a_screen_unlike_the_camera_was_taken_silently() {
    let given = ScreenRule::from(Screen::PUBLISHED);
    let cameras = [camera(88.0), camera(40.0), camera(40.0)];
    let most = given.most_unlike(&cameras).expect("40 are not 90");
    assert!(std::ptr::eq(most, &cameras[1]), "the first of those that differ most");
    assert_eq!(given.most_unlike(&cameras[..1]), None, "88 are 90 to 3 %");
    assert_eq!(of_camera().most_unlike(&cameras), None);
    assert_eq!(given.most_unlike(&[]), None);
}

#[test]
fn every_camera_has_a_screen_that_can_be() {
    for fx in [1e-300, 1e-14, 1e14, 1e300] {
        let screen = of_camera().of(&Camera { fx, ..camera(40.0) });
        assert_eq!(screen.check(), Ok(()), "{fx}");
    }
}

#[test]
fn the_screen_of_a_camera_has_a_name() {
    assert_eq!(ScreenWidth::parse(" camera "), Ok(ScreenWidth::OfCamera));
    assert_eq!(ScreenWidth::parse("powergs"), Ok(ScreenWidth::Degrees(90.0)));
    assert_eq!(ScreenWidth::parse("40"), Ok(ScreenWidth::Degrees(40.0)));
    let refused = ScreenWidth::parse("narrow").unwrap_err();
    assert!(refused.contains("wide-100") && refused.contains("`camera`"), "{refused}");
    for bad in ["0", "180", "nan"] {
        assert!(ScreenWidth::parse(bad).is_err(), "{bad}");
    }
    let rate = ScreenRule { pooling_rate: f64::NAN, ..of_camera() };
    assert!(rate.check().is_err() && of_camera().check().is_ok());
}
