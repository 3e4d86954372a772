//! The joint machine gives the next ratio, until one is there.

use powergs_codesign::alternate::next;
use powergs_codesign::compare::{CompareBudget, Market};
use powergs_codesign::fit::{Fitted, ModelFacts};
use powergs_codesign::model::ModelPoint;
use powergs_codesign::pricing::{Fate, Price, Row, SCOPES};
use powergs_optimize::record::RecordFormats;
use powergs_optimize::setup::Seen;
use powergs_optimize::target::Quality;

fn model(rho: f64, format: &str) -> Fitted {
    let seen = Seen { quality: Quality::likeness(37.1, 0.97), display_w: 1.0 };
    let point = ModelPoint {
        rho,
        sh_degree: 3,
        format: format.into(),
        formats: RecordFormats::default(),
        is_dense: false,
    };
    let facts = ModelFacts {
        points: 100,
        iterations: 10,
        lambda: None,
        gate: seen,
        test: seen,
        passed: true,
        margin_db: 0.1,
    };
    Fitted { point, id: 0, facts }
}

/// Display power rises steeply at the end of pruning, rendering power falls from its beginning.
fn row(rho: f64) -> Row {
    let display_w = 1.0 + 0.4 * rho / (1.3 - rho);
    let render_w = 0.8 - 0.7 * rho / (0.3 + rho);
    let price = Price {
        total_w: display_w + render_w,
        display_w,
        stages_w: [0.0, 0.0, render_w, 0.0],
        area_mm2: Some(1.0),
        frame_ms: 1.0,
        dram_bytes: 1.0,
    };
    Row { pairs: [(Some(4), Fate::Priced(vec![[price; SCOPES]]))].into(), ..Row::default() }
}

#[test]
fn a_fit_of_ratios_gives_the_next_until_it_is_there() {
    let mut models: Vec<Fitted> = [0.0, 0.45, 0.9].map(|rho| model(rho, "short")).into();
    let mut rows: Vec<Row> = [0.0, 0.45, 0.9].map(row).into();
    let budget = CompareBudget { area_mm2: 2.0, frame_ms: 2.0 };
    let mut tried = Vec::new();
    loop {
        let passed = vec![true; models.len()];
        let market = Market { rows: &rows, passed: &passed, budget, table: 0, scope: 0 };
        let (best, _) = market.ranked(market.pairs()).unwrap()[0];
        let Some(point) = next(&models, &market, best) else { break };
        assert!(models.iter().all(|m| (m.point.rho - point.rho).abs() >= 0.01));
        assert_eq!((point.sh_degree, point.format.as_str()), (3, "short"));
        tried.push(point.rho);
        rows.push(row(point.rho));
        models.push(Fitted { point: point.clone(), ..model(point.rho, "short") });
        assert!(tried.len() < 10, "{tried:?}");
    }
    assert!(!tried.is_empty());
    // By exhaustion the sum is least at 0.322.
    let nearest = tried.iter().map(|rho| (rho - 0.322_f64).abs()).fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.1, "{tried:?}");
}

#[test]
fn other_formats_and_too_few_ratios_are_no_samples() {
    let models = [model(0.0, "short"), model(0.3, "short"), model(0.9, "fp16")];
    let rows: Vec<Row> = [0.0, 0.3, 0.9].map(row).into();
    let budget = CompareBudget { area_mm2: 2.0, frame_ms: 2.0 };
    let passed = [true; 3];
    let market = Market { rows: &rows, passed: &passed, budget, table: 0, scope: 0 };
    assert_eq!(next(&models, &market, (1, Some(4))), None);
}
