//! A front on one model of the DRAM against the same designs on another.

use powergs_study::analysis::{
    Analysis, Confirmation, Misses, Objective, Question, Standing, Table,
};
use powergs_study::sweep::expr::Expr;

use super::whole::{small, small_of};

fn question() -> Question {
    Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("fps.mean")])
}

/// Area and frame rate of four designs with `calibrated`: its front has all of them, and its knee
/// is #2.
const CALIBRATED: [f64; 4] = [61.0, 80.0, 95.0, 100.0];
const AREAS: [f64; 4] = [1.0, 2.0, 3.0, 6.0];

fn designs(fps: [f64; 4]) -> Vec<(&'static str, f64, f64)> {
    (0..4).map(|i| (["1", "2", "4", "8"][i], AREAS[i], fps[i])).collect()
}

fn calibrated() -> Table {
    small_of("calibrated", &designs(CALIBRATED))
}

/// The table in which some designs have the results of `banked`.
fn confirmed(banked: &[(&str, f64, f64)]) -> Table {
    let mut table = calibrated();
    table.replace(&small(banked));
    table
}

fn compared(question: &Question, points: &[u64], table: &Table) -> Confirmation {
    let calibrated = calibrated();
    let before = Analysis::of(&calibrated, question).expect("an answer");
    let after = Analysis::of(table, question).expect("an answer");
    Confirmation::of(&before, &after, points)
}

fn standings(confirmation: &Confirmation) -> Vec<(u64, Standing)> {
    confirmation.designs.iter().map(|d| (d.point, d.standing)).collect()
}

#[test]
fn the_knee_comes_first_then_its_neighbours() {
    let table = calibrated();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    assert_eq!((analysis.front.as_slice(), analysis.knee), (&[0, 1, 2, 3][..], 2));
    assert_eq!(analysis.from_knee(20), [2, 1, 3, 0]);
    assert_eq!(analysis.from_knee(2), [2, 1]);
    assert!(analysis.from_knee(0).is_empty());
}

#[test]
fn what_leaves_the_front_is_named_and_the_order_counted() {
    let banked = designs([59.0, 90.0, 88.0, 100.0]);
    let table = confirmed(&banked);
    let all = compared(&question(), &[2, 1, 3, 0], &table);
    use Standing::{Beaten, Front, Late, Unmet};
    assert_eq!(standings(&all), [(2, Beaten), (1, Front), (3, Front), (0, Late)]);
    assert_eq!((all.knee_before, all.front), (2, 2));
    assert_ne!(all.knee, 2, "it is beaten");
    let orders: Vec<_> = all.orders.iter().map(|o| (o.pairs, o.swapped)).collect();
    assert_eq!(orders, [(6, 0), (6, 1)]);
    assert_eq!((all.orders[0].best, all.orders[0].best_banked), (Some(0), Some(0)));
    let fps = all.designs[1].values.iter().find(|v| v.column == "fps.mean").expect("compared");
    assert_eq!((fps.calibrated, fps.banked), (Some(80.0), Some(90.0)));
    assert_eq!(fps.difference(), Some(-10.0 / 90.0));
    // 80 for 90 FPS is the largest: 12.5 % too much time.
    assert!((all.error() - 0.125).abs() < 1e-12, "{}", all.error());

    // The display rate counts only where the question says so; so does a condition.
    let including = Question { misses: Misses::Included, ..question() };
    let all = compared(&including, &[2, 1, 3, 0], &table);
    assert_eq!(standings(&all)[3], (0, Front));
    let condition = Some(Expr::parse("fps.mean >= 60 && area_mm2 <= 2").expect("an expression"));
    let all = compared(&Question { condition, ..including }, &[0, 1], &table);
    assert_eq!(standings(&all), [(0, Unmet), (1, Front)]);
    assert_eq!(all.knee, 1);
}

/// Every conclusion about a confirmed design is drawn from its results with `banked`.
#[test]
fn what_a_square_millimetre_buys_is_that_of_confirmed_rows() {
    let value = |table: &Table| {
        let analysis = Analysis::of(table, &question()).expect("an answer");
        let step = analysis.marginals[0].steps[0];
        (step.from, step.to, step.value())
    };
    assert_eq!(value(&calibrated()), (0, 1, 19.0));
    // #0 61 -> 70 and #1 80 -> 78: a third of it.
    let table = confirmed(&designs([70.0, 78.0, 95.0, 100.0]));
    let (from, _, worth) = value(&table);
    assert_eq!(from, 0);
    assert!(worth < 13.0, "{worth}");
    // Steps from one model to the other are no steps.
    let table = confirmed(&designs(CALIBRATED)[..2]);
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    let models: Vec<&str> = (0..4).map(|row| table.models.word(row)).collect();
    assert_eq!(models, ["banked", "banked", "calibrated", "calibrated"]);
    for step in &analysis.around_knee {
        let knee = table.models.word(analysis.knee);
        assert_eq!(table.models.word(step.row), knee, "{step:?}");
    }
}

/// A design that misses the rate by less than the models differ could meet it.
#[test]
fn what_nearly_meets_the_rate_is_looked_at() {
    let near = |fps: [f64; 4], error| {
        let table = small_of("calibrated", &designs(fps));
        let question = Question { display_fps: Some(60.0), ..question() };
        Analysis::of(&table, &question).expect("an answer").nearly_met(error, 20)
    };
    // #0 misses by 1.7 %, #1 by 9 %.
    assert_eq!(near([59.0, 55.0, 95.0, 100.0], 0.02), [0]);
    assert_eq!(near([59.0, 55.0, 95.0, 100.0], 0.10), [0, 1]);
    assert!(near([59.0, 55.0, 95.0, 100.0], 0.01).is_empty());
    // Larger than one that meets the rate, and slower: whatever it does, nobody takes it.
    assert!(near([90.0, 59.0, 95.0, 100.0], 0.10).is_empty());
}

#[test]
fn designs_without_results_failed() {
    // #2 has no results.
    let table = confirmed(&[("1", 1.0, 61.0), ("2", 2.0, 80.0)]);
    let all = compared(&question(), &[2, 1, 0], &table);
    assert_eq!(standings(&all)[0], (2, Standing::Failed));
    assert_eq!(standings(&all)[1], (1, Standing::Front));
}

#[test]
fn a_confirmation_is_of_one_question() {
    let table = confirmed(&designs([59.0, 90.0, 88.0, 100.0]));
    let all = compared(&question(), &[2, 1], &table);
    let text = serde_json::to_string(&all).expect("JSON");
    assert_eq!(serde_json::from_str::<Confirmation>(&text).expect("JSON"), all);
    assert!(all.fits(&Analysis::of(&table, &question()).expect("an answer")));
    let other = Question::of(vec![Objective::minimize("area_mm2")]);
    assert!(!all.fits(&Analysis::of(&table, &other).expect("an answer")));
}
