//! What is said of conditions that no design meets.

use powergs_study::analysis::{Analysis, Objective, Question, Table};
use powergs_study::sweep::expr::Expr;

/// Two designs on a trace: milliseconds and watts.
fn unmet(condition: &str) -> String {
    let text = "point,is_baseline,id,status,reason,energy_table,trace,scope,a,frames,\
                frame_time_ms.p99,power_w.mean\n\
                0,false,a,ok,,t,,mean,1,4,8.4,0.566\n\
                1,false,b,ok,,t,,mean,2,4,6.1,0.9\n";
    let table = Table::read(text.as_bytes(), |_| true).expect("a table");
    let condition = Some(Expr::parse(condition).expect("an expression"));
    let objectives =
        vec![Objective::minimize("frame_time_ms.p99"), Objective::minimize("power_w.mean")];
    let question = Question { condition, ..Question::of(objectives) };
    Analysis::of(&table, &question).expect_err("none meets it").to_string()
}

#[test]
fn a_limit_was_missed_by_a_share_of_the_value_and_one_of_two_was_named() {
    let said = unmet("frame_time_ms.p99 <= 8 && power_w.mean <= 0.5");
    let nearest = "nearest: #0 misses `power_w.mean <= 0.5` by 13.2 % (power_w.mean 0.566) and \
                   `frame_time_ms.p99 <= 8` by 5.00 % (frame_time_ms.p99 8.40)";
    assert!(said.contains(nearest), "{said}");
    // What is met is not named.
    let said = unmet("frame_time_ms.p99 <= 8.5 && power_w.mean <= 0.5");
    let nearest = "misses `power_w.mean <= 0.5` by 13.2 % (power_w.mean 0.566)";
    assert!(said.ends_with(nearest), "{said}");
}

#[test]
fn a_limit_that_is_met_exactly_was_missed_by_304_zeros() {
    let said = unmet("frame_time_ms.p99 < 6.1");
    assert!(said.contains("#1 misses `frame_time_ms.p99 < 6.1` by less than 0.001 %"), "{said}");
}
