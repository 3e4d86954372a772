//! Whole answers on a table whose answer is known.

use powergs_study::analysis::marginal::Price;
use powergs_study::analysis::{Analysis, AnalysisError, Named, Objective, Question, Scope, Table};
use powergs_study::sweep::expr::Expr;

use super::support::Sweep;

fn two() -> Question {
    Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("fps.mean")])
}

fn condition(question: Question, text: &str) -> Question {
    Question { condition: Some(Expr::parse(text).expect("an expression")), ..question }
}

/// Exactly the rows that nobody beats, by the definition on the raw columns.
#[test]
fn the_front_is_that_of_the_rows_looked_at() {
    let table = Sweep::default().table();
    let question = condition(two(), "frame_time_ms.p99 <= 30 && vru.cores >= 2");
    let analysis = Analysis::of(&table, &question).expect("an answer");
    let column = |name: &str, row: u32| table.number(name, row).expect("measured");
    let rows = &analysis.rows;
    assert!(rows.len() < 50 && !rows.is_empty());
    for &row in rows {
        assert!(column("frame_time_ms.p99", row) <= 30.0 && !table.is_baseline(row));
        let (area, fps) = (column("area_mm2", row), column("fps.mean", row));
        let beaten = rows.iter().any(|&other| {
            let (a, f) = (column("area_mm2", other), column("fps.mean", other));
            a <= area && f >= fps && (a < area || f > fps)
        });
        assert_eq!(analysis.front.contains(&row), !beaten, "{}", table.label(row));
    }
    let areas: Vec<f64> = analysis.front.iter().map(|&r| column("area_mm2", r)).collect();
    assert!(areas.is_sorted(), "the best in the first objective first");
    assert!(analysis.front.contains(&analysis.knee));
}

#[test]
fn the_first_of_the_ranking_is_the_knee() {
    let table = Sweep::default().table();
    for scope in [Scope::Mean, Scope::Worst, Scope::Trace("room".into())] {
        let question = Question { scope, ..two() };
        let analysis = Analysis::of(&table, &question).expect("an answer");
        assert_eq!(analysis.stability.top[0], analysis.knee);
    }
}

#[test]
fn the_baseline_is_measured_but_is_no_candidate() {
    let table = Sweep::default().table();
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    let named = analysis.named.as_ref().expect("the base machine");
    assert_eq!(Some(named.row), analysis.baseline);
    assert!(!named.on_front && !analysis.rows.contains(&named.row));
    let nearest = named.distance.nearest.as_ref().expect("beaten");
    assert!(nearest.gains.iter().all(|g| *g >= 0.0) && nearest.gains.iter().any(|g| *g > 0.0));
    let better = analysis.rows[nearest.design];
    let gain = analysis.value(1, better) - analysis.value(1, named.row);
    assert_eq!(gain, nearest.gains[1], "gains are in the unit of the column");
    assert_eq!(named.distance.best.len(), 2);
}

#[test]
fn a_table_without_a_baseline() {
    let table = Sweep { baseline: false, ..Sweep::default() }.table();
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    assert!(analysis.named.is_none() && analysis.around_baseline.is_empty());
}

#[test]
fn marginal_values_fall_along_the_front() {
    let table = Sweep::default().table();
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    let prices: Vec<Price> = analysis.marginals.iter().map(|m| m.price).collect();
    assert!(prices.contains(&Price::Area));
    for marginal in &analysis.marginals {
        let values: Vec<f64> = marginal.steps.iter().map(|s| s.value()).collect();
        assert!(values.windows(2).all(|w| w[0] > w[1]), "{values:?}");
        assert!(marginal.steps.iter().all(|s| s.gain > 0.0 && s.price > 0.0));
        assert!(marginal.steps.windows(2).all(|w| w[0].to == w[1].from));
    }
}

/// One more core, and one fewer, around the knee: only that axis differs.
#[test]
fn neighbours_differ_in_one_axis() {
    let table = Sweep::default().table();
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    assert!(!analysis.around_knee.is_empty());
    for neighbour in &analysis.around_knee {
        for (axis, (_, words)) in table.axes.iter().enumerate() {
            let differs = words.code(neighbour.row) != words.code(analysis.knee);
            assert_eq!(differs, axis == neighbour.axis);
        }
    }
    assert!(analysis.around_baseline.is_empty(), "no point shares two axes with 3 cores, 512 KiB");
}

#[test]
fn axes_by_effect_and_dead_ones() {
    let text = Sweep::default().csv().replace(",geometry.test,", ",geometry.test,dead.key,");
    let mut n = 0;
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            n += 1;
            if n == 1 {
                return line.to_owned();
            }
            // The tests make no difference here; a key that follows nothing is dead.
            let fields: Vec<&str> = line.splitn(12, ',').collect();
            match fields.len() {
                12 if !fields[10].is_empty() => {
                    format!("{},{},{}", fields[..11].join(","), n % 2, fields[11])
                }
                _ => format!("{line},"),
            }
        })
        .collect();
    let table = Table::read(lines.join("\n").as_bytes(), |_| true).expect("a table");
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    let names: Vec<&str> = analysis.axes.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names[0], "vru.cores");
    assert!(analysis.axes.iter().all(|a| !a.is_dead()), "no pair differs in the dead key only");
    let cores = &analysis.axes[0];
    assert_eq!(cores.values, 5);
    assert!(cores.effects[1].alone.is_some_and(|a| a > 0.5));
}

#[test]
fn an_axis_without_effect_is_dead() {
    let sweep = Sweep { tests: vec!["obb", "exact"], ..Sweep::default() };
    let text = sweep.csv();
    // `exact` gets the area of `obb`: then the axis moves neither area nor time.
    let table = Table::read(text.as_bytes(), |_| true).expect("a table");
    let question = Question::of(vec![Objective::maximize("fps.mean")]);
    let analysis = Analysis::of(&table, &question).expect("an answer");
    let test = analysis.axes.iter().find(|a| a.name == "geometry.test").expect("an axis");
    assert!(test.is_dead());
    assert!(analysis.axes.iter().filter(|a| a.is_dead()).count() == 1);
}

fn error(question: &Question) -> AnalysisError {
    let table = Sweep::default().table();
    Analysis::of(&table, question).expect_err("an error")
}

#[test]
fn wrong_questions_say_what_to_do() {
    let of = |name: &str| Question::of(vec![Objective::minimize(name)]);
    let cases = [
        (of("areamm2"), "no column `areamm2`: did you mean `area_mm2`?"),
        (of("bottleneck"), "column `bottleneck` has words"),
        (Question::of(Vec::new()), "name columns with --minimize"),
        (
            Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("area_mm2")]),
            "`area_mm2` is there twice",
        ),
        (condition(two(), "area_mm <= 4"), "no column `area_mm`: did you mean `area_mm2`?"),
        (condition(two(), "area_mm2"), "the condition:"),
        (condition(two(), "geometry.test > 3"), "the condition:"),
        (
            Question { energy_table: Some("hbm3".into()), ..two() },
            "no energy table `hbm3` in the results: there are lpddr4, hbm2",
        ),
        (Question { scope: Scope::Trace("attic".into()), ..two() }, "there are garden, room"),
        (Question { design: Named::Point(99), ..two() }, "no design `99`"),
        (Question { design: Named::Id("f".into()), ..two() }, "f`"),
        (Question { colour: Some("vru.core".into()), ..two() }, "did you mean `vru.cores`?"),
    ];
    for (question, expected) in cases {
        let text = error(&question).to_string();
        assert!(text.contains(expected), "{text}\nnot: {expected}");
    }
}

#[test]
fn an_unmet_condition_says_which_part() {
    let question = condition(two(), "fps.mean >= 1e6 && area_mm2 <= 4");
    let text = error(&question).to_string();
    assert_eq!(
        text,
        "none of 50 designs meets the condition; `fps.mean >= 1e6` alone: 0, \
         `area_mm2 <= 4` alone: 50"
    );
}

#[test]
fn rows_without_a_value_are_left_out() {
    let text = "point,is_baseline,id,status,reason,energy_table,trace,scope,a,frames,\
                fps.mean,area_mm2\n\
                0,false,a,ok,,t,,mean,1,4,NaN,1\n\
                1,false,b,ok,,t,,mean,2,4,60,2\n\
                2,false,c,ok,,t,,mean,3,4,inf,1\n";
    let table = Table::read(text.as_bytes(), |_| true).expect("a table");
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    assert_eq!((analysis.simulated, analysis.front.as_slice()), (1, &[1][..]));
    let question = Question::of(vec![Objective::maximize("frames")]);
    let same = Analysis::of(&table, &question).expect("an answer");
    assert_eq!(same.front.len(), 3, "equal designs are all on the front");
}
