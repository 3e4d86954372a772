//! A front on one model of the DRAM against the same designs on another.

use powergs_study::analysis::{
    Analysis, Confirmation, Misses, Objective, Question, Standing, Table,
};
use powergs_study::sweep::expr::Expr;

use super::whole::small;

fn question() -> Question {
    Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("fps.mean")])
}

/// Area and frame rate of four designs with either model: the front of the first has all of them,
/// and its knee is #2.
fn tables() -> [Table; 2] {
    let of = |fps: [f64; 4]| {
        let areas = [1.0, 2.0, 3.0, 6.0];
        let rows: Vec<_> = (0..4).map(|i| (["1", "2", "4", "8"][i], areas[i], fps[i])).collect();
        small(&rows)
    };
    [of([61.0, 80.0, 95.0, 100.0]), of([59.0, 90.0, 88.0, 100.0])]
}

fn standings(confirmation: &Confirmation) -> Vec<(u64, Standing)> {
    confirmation.designs.iter().map(|d| (d.point, d.standing)).collect()
}

#[test]
fn the_knee_comes_first_then_its_neighbours() {
    let [table, _] = tables();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    assert_eq!((analysis.front.as_slice(), analysis.knee), (&[0, 1, 2, 3][..], 2));
    assert_eq!(analysis.from_knee(20), [2, 1, 3, 0]);
    assert_eq!(analysis.from_knee(2), [2, 1]);
    assert!(analysis.from_knee(0).is_empty());
}

#[test]
fn what_leaves_the_front_is_named_and_the_order_counted() {
    let [table, banked] = tables();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    let points = analysis.from_knee(4);
    let all = Confirmation::of(&analysis, &points, &banked).expect("an answer");
    use Standing::{Beaten, Front, Late, Unmet};
    assert_eq!(standings(&all), [(2, Beaten), (1, Front), (3, Front), (0, Late)]);
    assert_eq!((all.knee_before(), all.knee, all.front), (Some(2), Some(1), 4));
    let orders: Vec<_> = all.orders.iter().map(|o| (o.pairs, o.swapped)).collect();
    assert_eq!(orders, [(6, 0), (6, 1)]);
    assert_eq!((all.orders[0].best, all.orders[0].best_banked), (Some(0), Some(0)));
    let fps = all.designs[1].values.iter().find(|v| v.column == "fps.mean").expect("compared");
    assert_eq!((fps.calibrated, fps.banked), (Some(80.0), Some(90.0)));
    assert_eq!(fps.difference(), Some(-10.0 / 90.0));

    // The display rate counts only where the question says so; so does a condition.
    let question = Question { misses: Misses::Included, ..question() };
    let including = Analysis::of(&table, &question).expect("an answer");
    let all = Confirmation::of(&including, &points, &banked).expect("an answer");
    assert_eq!(standings(&all)[3], (0, Front));
    let condition = Some(Expr::parse("fps.mean >= 60 && area_mm2 <= 2").expect("an expression"));
    let question = Question { condition, ..question };
    let small = Analysis::of(&table, &question).expect("an answer");
    let all = Confirmation::of(&small, &small.from_knee(4), &banked).expect("an answer");
    assert_eq!(standings(&all), [(0, Unmet), (1, Front)]);
    assert_eq!(all.knee, Some(1));
}

#[test]
fn designs_without_results_failed_and_equal_ones_keep_the_knee() {
    let [table, _] = tables();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    // #2 has no results.
    let banked = small(&[("1", 1.0, 61.0), ("2", 2.0, 80.0)]);
    let all = Confirmation::of(&analysis, &[2, 1, 0], &banked).expect("an answer");
    assert_eq!(standings(&all)[0], (2, Standing::Failed));
    assert_eq!(all.designs[0].values[0].difference(), None);
    let none = Confirmation::of(&analysis, &[2], &small(&[])).expect("an answer");
    assert_eq!((none.knee, standings(&none)), (None, vec![(2, Standing::Failed)]));
    let alike = small(&[("1", 1.0, 61.0), ("2", 3.0, 95.01), ("4", 3.0, 95.0), ("8", 6.0, 100.0)]);
    let all = Confirmation::of(&analysis, &[2, 1, 3, 0], &alike).expect("an answer");
    assert_eq!(all.knee, Some(2), "#1 is alike");
    assert_eq!(standings(&all)[..2], [(2, Standing::Front), (1, Standing::Front)]);
}

#[test]
fn a_confirmation_is_of_one_question() {
    let [table, banked] = tables();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    let all = Confirmation::of(&analysis, &analysis.from_knee(2), &banked).expect("an answer");
    let text = serde_json::to_string(&all).expect("JSON");
    assert_eq!(serde_json::from_str::<Confirmation>(&text).expect("JSON"), all);
    assert!(all.fits(&analysis));
    let other = Question::of(vec![Objective::minimize("area_mm2")]);
    assert!(!all.fits(&Analysis::of(&table, &other).expect("an answer")));
}
