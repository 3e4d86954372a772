//! Power at the size at which a model is shown, and not at that at which it trains.

use std::num::NonZeroUsize;

use powergs_core::run::MemoryStore;
use powergs_frame::scene::Eye;
use powergs_optimize::campaign::{Campaign, CampaignError};
use powergs_optimize::invalid::Invalid;
use powergs_optimize::request::Request;
use powergs_optimize::settings::{GateSize, Settings};
use powergs_optimize::views::{PowerCameras, PowerViews, Priced};
use powergs_scene::Camera;
use powergs_scene::camera::edit::resized;

use super::campaign::{foveated, open, request};
use super::scenes::tiny;

/// The views of the short campaign at another size.
fn shown(size: (u32, u32)) -> PowerCameras {
    let larger = |c: &Camera| resized(c, size.0, size.1);
    PowerCameras::Shown(request().cameras.iter().map(larger).collect())
}

fn priced(change: impl FnOnce(&mut Request)) -> Priced {
    let mut asked = request();
    change(&mut asked);
    open(asked).priced
}

#[test]
fn what_power_is_counted_over_is_said_in_words() {
    let at = |size| move |r: &mut Request| r.power_cameras = shown(size);
    assert_eq!(priced(|_| ()).to_string(), "8 views of 48x36");
    assert_eq!(priced(at((96, 72))).to_string(), "8 views of 96x72");
    let few = |r: &mut Request| r.power_views = PowerViews::Spread(NonZeroUsize::new(3).unwrap());
    assert_eq!(priced(few).to_string(), "3 of 8 views of 48x36");
    assert_eq!(priced(|r| r.power_views = PowerViews::Test).to_string(), "1 of 8 views of 48x36");
    let path = |r: &mut Request| r.power_views = PowerViews::Path(5);
    assert_eq!(priced(path).to_string(), "5 frames of a path of 48x36");
    let others = |r: &mut Request| r.power_cameras = PowerCameras::Others(r.cameras[..2].to_vec());
    assert_eq!(priced(others).to_string(), "2 other views of 48x36");
    let mixed = |r: &mut Request| {
        let mut cameras = r.cameras.clone();
        cameras[1] = resized(&cameras[1], 24, 18);
        r.power_cameras = PowerCameras::Shown(cameras);
    };
    assert_eq!(priced(mixed).to_string(), "8 views of up to 48x36");
}

#[test]
fn a_price_below_the_size_of_the_photos_is_told() {
    let at = |full: [u32; 2]| priced(|r| r.full_size = Some(full)).note();
    assert_eq!(at([48, 36]), None);
    assert_eq!(at([24, 18]), None);
    let note = at([540, 960]).unwrap();
    assert!(note.contains("at 48x36, below the 540x960 of the cameras"), "{note}");
}

#[test]
fn larger_views_than_those_that_train_are_sixteen_at_most_where_nobody_says_otherwise() {
    let many = tiny(100, 1, (24, 18));
    let n = many.cameras.len();
    assert!(n > 16, "{n}");
    let asked = |size: (u32, u32), which| {
        let larger = many.cameras.iter().map(|c| resized(c, size.0, size.1)).collect();
        let asked = request();
        Request {
            cameras: many.cameras.clone(),
            power_cameras: PowerCameras::Shown(larger),
            power_views: which,
            ..asked
        }
    };
    let count = |size, which| open(asked(size, which)).priced.views;
    assert_eq!(count((48, 36), PowerViews::Usual), 16);
    assert_eq!(count((24, 18), PowerViews::Usual), n);
    assert_eq!(count((48, 36), PowerViews::All), n);
    // Evenly spaced, so that no side of the scene counts alone.
    let views = open(asked((48, 36), PowerViews::Usual)).power_views;
    let position = |c: &Camera| many.cameras.iter().position(|o| o.name == c.name).unwrap();
    let gaps: Vec<usize> = views.windows(2).map(|w| position(&w[1]) - position(&w[0])).collect();
    let (least, most) = (gaps.iter().min().unwrap(), gaps.iter().max().unwrap());
    assert!(most - least <= 1, "{gaps:?}");
}

#[test]
fn where_models_are_judged_as_they_train_the_size_of_the_price_changes_watts_alone() {
    let store = MemoryStore::new();
    let trained = |asked: Request| {
        let settings = Settings { gate_size: GateSize::Trained, ..asked.settings };
        open(Request { settings, ..asked })
    };
    let small = trained(request());
    let first = small.run(&store, &()).unwrap().unwrap();
    let large = || trained(Request { power_cameras: shown((192, 144)), ..request() });
    assert_ne!(small.fingerprint(), large().fingerprint());
    assert_eq!(small.inputs(), large().inputs(), "models do not depend on it");
    let (mut campaign, to) = (large(), MemoryStore::new());
    let again = campaign.reprice(&store, &to, false, &()).unwrap().unwrap().priced().unwrap();
    assert_eq!(again.results.priced.as_ref().unwrap().size, [192, 144]);
    for (a, b) in again.outcomes.iter().zip(&first.outcomes) {
        assert_eq!((a.gate.quality, a.passed), (b.gate.quality, b.passed), "{}", b.name);
        // Sixteen times the pixels; the panel is scaled to the dense model's rendering.
        assert!(a.watts.render_w > 4.0 * b.watts.render_w, "{}: {:?}", b.name, a.watts);
    }
}

#[test]
fn levels_of_the_periphery_are_priced_as_they_are_trained() {
    let asked = Request { power_cameras: shown((96, 72)), ..foveated() };
    let error = Campaign::open(asked, &()).err().unwrap();
    assert!(matches!(error, CampaignError::Invalid(Invalid::LevelsAtOtherSize)), "{error}");
    let none = |r: &mut Request| {
        r.power_cameras = PowerCameras::Others(r.cameras.clone());
        r.power_views = PowerViews::Test;
    };
    let mut asked = request();
    asked.cameras.iter_mut().for_each(|c| c.split = None);
    none(&mut asked);
    let error = Campaign::open(asked, &()).err().unwrap();
    assert!(matches!(error, CampaignError::Invalid(Invalid::NoTestViews)), "{error}");
}

/// The same view for both eyes: a frame of the display takes twice the time, tiles and light.
#[test]
fn foveated_pairs_are_frames_of_the_display() {
    let eye = |camera: &Camera, eye| Camera { eye: Some(eye), ..camera.clone() };
    let pair = |camera: &Camera| [eye(camera, Eye::Left), eye(camera, Eye::Right)];
    let asked = foveated();
    let pairs = PowerCameras::Others(asked.cameras.iter().flat_map(pair).collect());
    // Pixels and watts of the panel as they are: nothing is scaled to the dense model.
    let single = Request { display_ratio: None, ..foveated() };
    let paired = Request { display_ratio: None, power_cameras: pairs, ..foveated() };
    let single = open(single).run(&MemoryStore::new(), &()).unwrap().unwrap();
    let paired = open(paired).run(&MemoryStore::new(), &()).unwrap().unwrap();
    assert_eq!(paired.results.priced.as_ref().unwrap().eyes, 2);
    let [single, paired] = [single, paired].map(|f| f.foveated.expect("levels were made"));
    assert!((2.0 * paired.dense_fps / single.dense_fps - 1.0).abs() < 1e-9);
    assert!(!single.measured.is_empty());
    for (one, two) in single.measured.iter().zip(&paired.measured) {
        assert_eq!(one.levels.jobs, two.levels.jobs, "models do not depend on it");
        let twice = |name: &str, one: f64, two: f64| {
            assert!((two / one - 2.0).abs() < 1e-9, "{name}: {one}, {two}");
        };
        twice("time", 1.0 / one.fps, 1.0 / two.fps);
        twice("light", one.watts.display_w, two.watts.display_w);
        for region in 0..one.tiles.len() {
            if one.tiles[region] > 0.0 {
                twice("tiles", one.tiles[region], two.tiles[region]);
                twice("joules", one.region_j[region], two.region_j[region]);
            }
        }
        assert_eq!(one.hvsq, two.hvsq);
    }
}
