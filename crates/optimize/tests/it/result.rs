//! What a run ends with where a comparison takes fewer watts than its own models.

use powergs_core::run::MemoryStore;
use powergs_optimize::campaign::{Campaign, Finished};
use powergs_optimize::checkpoint::Checkpoints;
use powergs_optimize::lambda::LambdaRule;
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::role::Baseline;
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{Dimming, Settings};

use super::campaign::{open, request};

/// A search that prunes nothing, beside comparisons that have an easy game.
fn beaten(baselines: &[Baseline]) -> Request {
    let request = request();
    let goals = Goals {
        goal: Some(Goal::Absolute { psnr_db: 12.0, ssim: 0.0 }),
        schedule: Schedule::listed(&[0.0]).unwrap(),
        baselines: baselines.to_vec(),
        ratio_study: false,
        ..request.goals
    };
    // Gains would find less than these comparisons without training.
    let dimming = Dimming::Term(LambdaRule::Damped);
    let settings = Settings { final_iterations: 20, dimming, ..request.settings };
    Request { goals, settings, ..request }
}

fn run(campaign: &Campaign, store: &MemoryStore) -> Finished {
    campaign.run(store, &()).unwrap().expect("nobody cancels")
}

/// The result is `name` wherever it is told, and its model is the one that is given.
#[track_caller]
fn ends_with(campaign: &Campaign, store: &MemoryStore, finished: &Finished, name: &str) {
    assert_eq!(finished.result.as_deref(), Some(name));
    let results = &finished.results;
    let variant = results.variants[0].name.as_str();
    assert_eq!(results.result(variant).unwrap().name, name);
    let ours = results.ours(variant).unwrap().name.as_str();
    assert!(ours.starts_with("sample") || ours == "optimum", "{ours} is no model of the search");
    assert!(results.result(variant).unwrap().total_w() < results.ours(variant).unwrap().total_w());
    let kept = Checkpoints::new(store, campaign.fingerprint()).load_model(name).unwrap();
    assert!(finished.model.as_ref() == Some(&kept.scene));
    assert!(finished.pictures.as_ref().unwrap().name.contains(name));
}

#[test]
fn a_comparison_with_fewer_watts_is_the_result_under_its_own_name() {
    let store = MemoryStore::new();
    let campaign = open(beaten(&[Baseline::RenderOnly]));
    let finished = run(&campaign, &store);
    ends_with(&campaign, &store, &finished, "render-only");
    // One whose model is kept for nothing else.
    let store = MemoryStore::new();
    let campaign = open(beaten(&[Baseline::LightGaussian(50)]));
    ends_with(&campaign, &store, &run(&campaign, &store), "lightgs-50");
    // On another panel the same rule holds: where rendering is nearly free, pruning is no use.
    let repriced = |ratio: f64| {
        let to = MemoryStore::new();
        let beaten = beaten(&[Baseline::LightGaussian(50)]);
        let mut other = open(Request { display_ratio: Some(ratio), ..beaten });
        let finished = other.reprice(&store, &to, false, &()).unwrap().unwrap().priced().unwrap();
        assert_eq!(finished.results.variants[0].result, finished.result);
        finished.result.unwrap()
    };
    assert_eq!(repriced(0.2), "lightgs-50");
    let dimmed = repriced(1000.0);
    assert!(dimmed.starts_with("sample") || dimmed == "former-optimum", "{dimmed}");
}

#[test]
fn without_comparisons_it_is_the_best_of_the_search() {
    let finished = run(&open(beaten(&[])), &MemoryStore::new());
    assert!(finished.result.is_some() && finished.result == finished.conclusion.best);
}
