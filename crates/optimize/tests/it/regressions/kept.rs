//! Models that a run threw away and that its user wanted.

use powergs_core::run::MemoryStore;
use powergs_optimize::campaign::Finished;
use powergs_optimize::request::{Goals, Request};
use powergs_optimize::role::Baseline;

use super::super::campaign::{open, request};

/// The short campaign with all comparisons and a model of the user, on a panel.
fn compared(display_ratio: f64) -> Request {
    let asked = request();
    let goals = Goals { baselines: Baseline::ALL.to_vec(), ..asked.goals };
    let externals = vec![("mini".to_owned(), asked.dense.clone())];
    Request { goals, externals, display_ratio: Some(display_ratio), ..asked }
}

#[test]
fn comparisons_of_a_run_could_not_be_priced_anew() {
    let store = MemoryStore::new();
    let first = open(compared(0.5)).run(&store, &()).unwrap().unwrap();
    let mut other = open(compared(3.0));
    let to = MemoryStore::new();
    let again = other.reprice(&store, &to, false, &()).unwrap().unwrap().priced().unwrap();
    let names = |finished: &Finished| {
        let name = |o: &powergs_optimize::outcome::Outcome| o.name.replace("former-", "");
        finished.outcomes.iter().map(name).collect::<Vec<String>>()
    };
    assert_eq!(names(&first), names(&again));
    for baseline in Baseline::ALL {
        assert!(names(&again).contains(&baseline.name()), "{baseline}");
    }
    assert!(names(&again).contains(&"mini".to_owned()));
    for (now, then) in again.outcomes.iter().zip(&first.outcomes) {
        assert_eq!(now.gate.quality, then.gate.quality, "{}", then.name);
        assert!((now.watts.display_w / then.watts.display_w - 6.0).abs() < 1e-9, "{}", then.name);
    }
}
