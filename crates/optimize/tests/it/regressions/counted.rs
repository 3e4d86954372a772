//! Watts that did not say how they were counted.

use powergs_base::budget::Budget;
use powergs_core::run::{MemoryStore, System};
use powergs_optimize::counted::PowerCounts;
use powergs_optimize::oracle::CycleOracle;
use powergs_optimize::request::Request;
use powergs_optimize::results::Results;

use super::super::campaign::{open, request};

#[test]
fn results_did_not_say_whether_a_machine_stands_by_in_them_and_how_the_panel_was_scaled() {
    let campaign = open(request());
    let finished = campaign.run(&MemoryStore::new(), &()).unwrap().unwrap();
    let read = Results::parse(&finished.results.to_json()).unwrap();
    let counted = read.counted.expect("it says so");
    assert_eq!((counted.counts, counted.has_standby), (PowerCounts::ClosedForm, false));
    assert_eq!(counted.display_ratio, Some(0.5));
    let own = request().display.scale;
    assert!((counted.display_factor * own / read.display_scale - 1.0).abs() < 1e-12);
    assert_eq!(counted.by_what("paper"), "the published closed form, without standby");
    let standby = finished.outcomes[0].watts.parts.stage_w(powergs_energy::action::Phase::Standby);
    assert_eq!(standby, 0.0);

    let system = System::named("gscore").unwrap();
    let oracle = CycleOracle { system, fps: 60.0, memory: Budget::DEFAULT };
    let asked = Request { oracle: Box::new(oracle), display_ratio: None, ..request() };
    let counted = open(asked).counted;
    assert_eq!((counted.counts, counted.has_standby), (PowerCounts::Machine, true));
    assert_eq!((counted.display_ratio, counted.display_factor), (None, 1.0));
    assert_eq!(counted.by_what("gscore"), "the machine gscore, with its standby");
    assert_eq!(counted.panel("oled-powergs"), "panel oled-powergs as it is");
}
