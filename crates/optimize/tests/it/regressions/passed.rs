//! Models that passed what they miss.

use powergs_core::run::MemoryStore;
use powergs_optimize::references::{Reference, ReferenceImages};
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::results::ModelRecord;
use powergs_optimize::role::RoleKind;
use powergs_raster::{Detail, Options, render};
use powergs_scene::Camera;

use super::super::campaign::{open, request};

#[test]
fn the_dense_model_passed_by_a_share_of_its_own_and_missed_that_of_the_held_out_one() {
    let asked = request();
    // Photos that are darker than the model, so that training brings it nearer to them.
    let mut darker = asked.dense.clone();
    darker.sh.iter_mut().for_each(|value| *value -= 0.5);
    let options = Options::reference(Detail::Image);
    let photo = |camera: &Camera| Reference::new(&render(&darker, camera, &options).picture);
    let photos: Vec<Reference> = asked.cameras.iter().map(photo).collect();
    let goals = Goals { goal: Some(Goal::Share(1.0)), ..asked.goals };
    let references = ReferenceImages::Photos(Box::new(photos));
    let finished =
        open(Request { goals, references, ..asked }).run(&MemoryStore::new(), &()).unwrap();
    let results = finished.expect("nobody cancels").results;
    let of = |role: RoleKind| results.models.iter().find(move |m| m.role == role).unwrap();
    let (dense, held_out) = (of(RoleKind::Dense), of(RoleKind::HeldOut));
    // Few steps from few views lose what they should gain: the target is that of the run all
    // the same, and the dense model is not held to a share of itself.
    let margin_db = |model: &ModelRecord| model.margin_db.expect("there is a target");
    assert!(margin_db(dense) > 0.1 && margin_db(held_out).abs() < 1e-9);
    for model in &results.models {
        let margin_db = model.margin_db.expect("there is a target");
        assert_eq!(model.passed, margin_db >= 0.0, "{}: {margin_db} dB", model.name);
    }
}
