//! The quality that is promised is the one that a user sees, who looks from everywhere.

use powergs_core::run::MemoryStore;
use powergs_optimize::campaign::Finished;
use powergs_optimize::oracle::PaperOracle;
use powergs_optimize::references::{Reference, ReferenceImages};
use powergs_optimize::request::{Goal, Goals, LEAST_GATE, Request};
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{Gate, Settings};
use powergs_quality::likeness;
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::orbit::Orbit;
use powergs_scene::{Camera, Gaussians};

use super::campaign::open;
use super::scenes::tiny;

/// Views around the scene that stand for looking from everywhere.
const AROUND: usize = 64;

/// A circle of views, turned by a share of the step between two.
fn circle(views: usize) -> Vec<Camera> {
    Orbit {
        views,
        centre: glam::DVec3::new(0.0, 0.0, 0.4),
        radius: 4.0,
        elevation: 0.35,
        up: glam::DVec3::Z,
        vertical_fov: 0.7,
        size: (48, 36),
    }
    .cameras()
}

/// Eight views of a circle, beginning with the `first` of so many as there are around, at 26 dB.
fn asked(dense: &Gaussians, first: usize, least_gate: usize) -> Request {
    let base = tiny(10, 8, (8, 8));
    let step = AROUND / 8;
    let cameras = circle(AROUND).into_iter().skip(first).step_by(step).collect();
    let oracle = PaperOracle::published(60.0).unwrap();
    let settings =
        Settings { iterations: 40, final_iterations: 20, interval: 5, ..Settings::DEFAULT };
    let goals = Goals {
        goal: Some(Goal::Absolute { psnr_db: 26.0, ssim: 0.0 }),
        schedule: Schedule::listed(&[0.5]).unwrap(),
        ..Goals::default()
    };
    let asked = Request::new("circle", dense.clone(), cameras, oracle, base.display);
    Request { settings, goals, least_gate, ..asked }
}

/// What the gate views promise, and what is seen from everywhere, decibels.
fn promised_and_seen(dense: &Gaussians, first: usize, least_gate: usize) -> (f64, f64) {
    let campaign = open(asked(dense, first, least_gate));
    let found: Finished = campaign.run(&MemoryStore::new(), &()).unwrap().unwrap();
    let name = found.result.clone().expect("it is reached");
    let promised = found.results.model(&name).unwrap().gate.psnr_db.unwrap();
    let model = found.model.unwrap();
    let options = Options::reference(Detail::Image);
    let psnr = |camera: &Camera| {
        let shown = |scene: &Gaussians| render(scene, camera, &options).picture;
        likeness(&shown(&model), &shown(dense)).psnr_db
    };
    let seen = circle(AROUND).iter().map(psnr).sum::<f64>() / AROUND as f64;
    (promised, seen)
}

#[test]
fn with_views_between_the_others_the_promise_is_what_is_seen_from_everywhere() {
    let dense = tiny(300, 8, (8, 8)).dense;
    let off = |first: usize, least_gate: usize| {
        let (promised, seen) = promised_and_seen(&dense, first, least_gate);
        seen - promised
    };
    // One or two views promise decibels too much on this circle, and too little on that one.
    let (too_much, too_little) = (off(3, 0), off(7, 0));
    assert!(too_much < -2.0 && too_little > 1.0, "{too_much}, {too_little}");
    let (less, more) = (off(3, LEAST_GATE), off(7, LEAST_GATE));
    assert!(less.abs() < 0.5 * too_much.abs() && more.abs() < too_little, "{less}, {more}");
}

#[test]
fn views_are_made_only_where_one_more_costs_a_render_and_they_never_train() {
    let dense = tiny(300, 8, (8, 8)).dense;
    let opened = |change: &dyn Fn(&mut Request)| {
        let mut asked = asked(&dense, 0, 12);
        change(&mut asked);
        open(asked)
    };
    let campaign = opened(&|_| ());
    let split = &campaign.split;
    assert_eq!(campaign.gate_views(), 12);
    assert_eq!(campaign.cameras.len(), 8 + split.made);
    assert!(split.made >= 10 && split.train.iter().chain(&split.test).all(|view| *view < 8));
    assert_eq!(campaign.priced.to_string(), "8 views of 48x36");
    // Half way between two views of the circle first, each pair once.
    let mut names: Vec<&str> = campaign.cameras.iter().map(|c| c.name.as_str()).collect();
    assert!(names[8..16].iter().all(|name| name.starts_with("between_0.5_orbit_")), "{names:?}");
    let all = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all);
    let made = |change: &dyn Fn(&mut Request)| opened(change).split.made;
    assert_eq!(made(&|r| r.least_gate = 0), 0);
    assert_eq!(made(&|r| r.settings.gate = Gate::Test), 0);
    let photos = |r: &mut Request| {
        let options = Options::reference(Detail::Image);
        let photo = |c: &Camera| Reference::new(&render(&r.dense, c, &options).picture);
        let photos: Vec<Reference> = r.cameras.iter().map(photo).collect();
        r.references = ReferenceImages::Photos(Box::new(photos));
    };
    assert_eq!(made(&photos), 0);
    // Inside of things nothing is like what is seen from outside.
    let across = |r: &mut Request| r.cameras = circle(3);
    assert_eq!(made(&across), 0);
}
