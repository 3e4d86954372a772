//! Charts of sensitivity: no label covers a mark or another label.

use std::path::Path;

use powergs_chart::Chart;
use powergs_sim::report::sensitivity::{self, interactions, keys};
use powergs_sim::run::{System, TraceFile};
use powergs_study::sensitivity::{
    AssumptionStudy, InteractionStudy, KeySelection, KeyStudy, Method,
};
use powergs_testkit::charts::covered;

/// The first frame of the demo trace.
fn frame() -> TraceFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/demo.bin");
    let mut trace = TraceFile::open(&path).expect("the demo trace");
    trace.select(0, Some(1)).expect("a frame");
    trace
}

#[test]
fn labels_cover_nothing() {
    let system = System::named("gscore").expect("a machine");
    let study = AssumptionStudy { system: &system, only: &[1, 4, 14, 26, 27], display_fps: 60.0 };
    let assumptions = study.run(&mut [frame()], &()).expect("no error").expect("frames");
    let mut charts: Vec<Chart> = sensitivity::charts(&assumptions);
    let chosen = ["vru.cores=2..8", "gsu.bsu-per-core=1|2", "clock", "geometry.test=aabb|obb"];
    let chosen = chosen.map(|text| text.parse::<KeySelection>().expect("a selection"));
    for method in [Method::Morris, Method::Sobol] {
        let interactions = Some(InteractionStudy { method, samples: Some(4), seed: 7 });
        let study =
            KeyStudy { system: &system, keys: &chosen, step: 0.1, display_fps: 60.0, interactions };
        let found = study.run(&mut [frame()], &()).expect("no error").expect("frames");
        charts.extend(keys::charts(&found.keys));
        charts.extend(interactions::charts(&found.interactions.expect("keys together")));
    }
    assert!(charts.len() > 5, "{} charts", charts.len());
    for chart in &charts {
        assert_eq!(covered(chart), Vec::<String>::new());
    }
}
