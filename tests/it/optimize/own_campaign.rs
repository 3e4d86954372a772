//! The example of an optimisation of one's own: it runs in memory and saves power.

// Its `main` is not called here.
#[allow(dead_code)]
#[path = "../../../examples/own_campaign.rs"]
mod example;

#[test]
fn an_optimisation_of_ones_own_saves_power() {
    let finished = example::optimise().expect("it runs");
    let best = finished.conclusion.best.as_deref().expect("a model reaches the target");
    let watts = |name: &str| {
        let outcome = finished.outcomes.iter().find(|o| o.name == name).expect("a job");
        outcome.watts.total_w()
    };
    assert!(watts(best) < watts("dense"), "{} W of {} W", watts(best), watts("dense"));
    assert!(finished.model.is_some_and(|model| model.len() <= 600));
}
