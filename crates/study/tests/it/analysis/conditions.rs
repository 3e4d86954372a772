//! A condition holds on every trace, unless it says `mean(...)`.

use powergs_study::analysis::{Analysis, AnalysisError, Objective, Question, Scope, Table};
use powergs_study::sweep::expr::Expr;

/// Two designs on two traces: watts of each, and their mean. #0 takes 1.4 W on average and 1.6 W on
/// `fox`; #1 never more than 1.45 W.
fn table() -> Table {
    let mut text = String::from(
        "point,is_baseline,id,status,reason,energy_table,trace,dram_model,scope,vru.cores,frames,\
         frame_time_ms.mean,fps.mean,power_w.mean,area_mm2\n",
    );
    for (table, scale) in [("28nm", 1.0), ("7nm", 0.5)] {
        for (point, [bot, fox]) in [[1.2, 1.6], [1.4, 1.45]].iter().enumerate() {
            let mut row = |trace: &str, scope: &str, watts: f64| {
                let (cores, area) = (point + 1, 5.0 - point as f64);
                text += &format!(
                    "{point},false,{point:x},ok,,{table},{trace},banked,{scope},{cores},4,10,100,\
                     {},{area}\n",
                    watts * scale
                );
            };
            row("bot", "trace", *bot);
            row("fox", "trace", *fox);
            row("", "mean", (bot + fox) / 2.0);
            row("bot", "worst", bot.max(*fox));
        }
    }
    Table::read(text.as_bytes(), |_| true).expect("a table")
}

fn asked(condition: &str, scope: Scope) -> Result<Vec<u64>, AnalysisError> {
    let table = table();
    let condition = Some(Expr::parse(condition).expect("an expression"));
    let objectives = vec![Objective::minimize("power_w.mean"), Objective::minimize("area_mm2")];
    let question = Question { condition, scope, ..Question::of(objectives) };
    let analysis = Analysis::of(&table, &question)?;
    Ok(analysis.rows.iter().map(|row| table.points[*row as usize]).collect())
}

#[test]
fn a_budget_holds_on_every_trace() {
    assert_eq!(asked("power_w.mean <= 1.5", Scope::Mean).expect("an answer"), [1]);
    assert_eq!(asked("power_w.mean <= 1.5 W", Scope::Worst).expect("an answer"), [1]);
    assert_eq!(asked("power_w.mean <= 1.7", Scope::Mean).expect("an answer"), [0, 1]);
    // The mean is asked for by name, and a trace as a scope.
    assert_eq!(asked("mean(power_w.mean) <= 1.5", Scope::Mean).expect("an answer"), [0, 1]);
    assert_eq!(asked("mean(power_w.mean) <= 1.41 W", Scope::Mean).expect("an answer"), [0]);
    let bot = Scope::Trace("bot".into());
    assert_eq!(asked("power_w.mean <= 1.3", bot).expect("an answer"), [0]);
}

#[test]
fn where_none_meets_it_the_nearest_and_what_binds_are_named() {
    let error = asked("power_w.mean <= 1.3 && area_mm2 <= 6", Scope::Mean).expect_err("none");
    let text = error.to_string();
    // #1 misses by (1.45 - 1.3) / 1.3 on fox, #0 by more.
    assert!(text.contains("nearest: #1 misses `power_w.mean <= 1.3` by 11.5 % on fox"), "{text}");
    assert!(text.contains("power_w.mean 1.45"), "{text}");
    assert!(text.contains("under `7nm` 2 meet it"), "{text}");
    let text = asked("area_mm2 <= 1", Scope::Mean).expect_err("none").to_string();
    assert!(text.contains("#1 misses `area_mm2 <= 1`"), "{text}");
    assert!(!text.contains("under `7nm`"), "areas are the same there: {text}");
}
