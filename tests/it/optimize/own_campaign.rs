//! The example of an optimisation of one's own: it runs in memory and saves power, and its charts
//! can be read.

use powergs_sim::optimize::campaign::Finished;
use powergs_sim::report::optimize::{Grade, Moment, Story, charts};
use powergs_testkit::charts::covered;

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
    assert!(finished.model.as_ref().is_some_and(|model| model.len() <= 600));
    labels_cover_nothing(&finished);
}

/// No label of its charts covers a mark or another label, on any page.
fn labels_cover_nothing(finished: &Finished) {
    let moments = finished.history.iter().filter_map(|row| {
        let job = finished.outcomes.get(row.job)?.name.clone();
        let check = row.iteration.check?;
        let (iteration, lambda) = (row.iteration.iteration, row.iteration.lambda);
        let psnr_db = check.seen.quality.psnr_db;
        Some(Moment { job, iteration, lambda, points: row.iteration.points, psnr_db })
    });
    let story = Story {
        name: "room".into(),
        oracle: "gscore".into(),
        counted: finished.results.counted.expect("it says so"),
        display: "oled-powergs".into(),
        fps: 60.0,
        priced: finished.results.priced.clone().expect("it says so"),
        judged: finished.results.judged.expect("it says so"),
        done: &finished.outcomes,
        all: &finished.outcomes,
        grades: vec![Grade {
            name: "own".into(),
            variant: 0,
            result: finished.result.clone(),
            target: None,
            next: None,
        }],
        target: None,
        test_target: None,
        asked: "35 dB".into(),
        views: (3, 3),
        made: 0,
        distance: None,
        lost: &finished.results.lost,
        iterations: 100,
        conclusion: &finished.conclusion,
        course: moments.collect(),
        ratios: finished.ratios.clone(),
        strip: finished.pictures.clone(),
    };
    let drawn = charts(&story);
    assert!(drawn.len() > 3, "{} charts", drawn.len());
    for chart in &drawn {
        assert_eq!(covered(chart), Vec::<String>::new());
        // Pictures have no watts.
        if chart.name == "strip" {
            continue;
        }
        let notes: Vec<&str> = chart.notes.iter().flatten().map(|note| &*note.text).collect();
        let says = "Power by the published closed form, without standby; the panel scaled to";
        assert!(notes.iter().any(|note| note.starts_with(says)), "{}: {notes:?}", chart.name);
    }
}
