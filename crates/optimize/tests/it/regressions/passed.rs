//! Models that passed what they miss.

use powergs_core::run::MemoryStore;
use powergs_optimize::references::{Reference, ReferenceImages};
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::role::RoleKind;
use powergs_raster::{Detail, Options, render};
use powergs_scene::Camera;

use super::super::campaign::{open, request};

#[test]
fn the_dense_model_passed_by_a_share_of_its_own_and_missed_that_of_the_held_out_one() {
    let asked = request();
    // Photos that are darker than the model, so that training brings it nearer to them.
    let mut darker = asked.dense.clone();
    darker.sh.iter_mut().for_each(|value| *value -= 0.05);
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
    assert!(dense.gate.psnr_db < held_out.gate.psnr_db, "training does nothing");
    assert!(!dense.passed && held_out.passed);
    for model in &results.models {
        let margin_db = model.margin_db.expect("there is a target");
        assert_eq!(model.passed, margin_db >= 0.0, "{}: {margin_db} dB", model.name);
    }
}
