//! Whole answers on a table whose answer is known.

use powergs_study::analysis::front::is_alike;
use powergs_study::analysis::marginal::Price;
use powergs_study::analysis::{
    Analysis, AnalysisError, Misses, Named, Objective, Question, Scope, Table,
};
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
        (of("areamm2"), "no column `areamm2`; did you mean `area_mm2`?"),
        (of("bottleneck"), "column `bottleneck` has words"),
        (Question::of(Vec::new()), "name columns with --minimize"),
        (
            Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("area_mm2")]),
            "`area_mm2` appears twice",
        ),
        (condition(two(), "area_mm <= 4"), "no column `area_mm`; did you mean `area_mm2`?"),
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

/// Axes of numbers, expressions, and metrics of another energy table.
#[test]
fn any_number_is_an_objective() {
    let mut table = Sweep::default().table();
    let objectives = vec![
        Objective::minimize("buffers.feature.capacity"),
        Objective::minimize("area_mm2 * frame_time_ms.p99"),
        Objective::minimize("hbm2:energy_pj.mean"),
        Objective::maximize("fps.mean / vru.cores"),
    ];
    table.compute(&objectives).expect("columns");
    let analysis = Analysis::of(&table, &Question::of(objectives)).expect("an answer");
    let row = analysis.knee;
    let number = |name: &str| table.number(name, row).expect("a number");
    assert!([16.0, 32.0, 64.0, 128.0, 256.0].contains(&(analysis.value(0, row) / 1024.0)));
    assert_eq!(analysis.value(1, row), number("area_mm2") * number("frame_time_ms.p99"));
    assert!(analysis.value(2, row) > number("energy_pj.mean"), "a byte costs more there");
    let ends: Vec<f64> = (0..4).map(|j| analysis.value(j, analysis.ends[j])).collect();
    assert_eq!(ends[0], 16.0 * 1024.0);
}

#[test]
fn objectives_that_are_none_say_what_to_write() {
    let cases = [
        ("energy", "no column `energy`; did you mean `energy_pj.mean`?"),
        ("qqqqqqqq", "there are `power_w.mean`"),
        ("qqqqqqqq", "`vru.cores`, `buffers.feature.capacity`"),
        ("clock", "`clock` is the same for all designs of this sweep"),
        ("geometry.test", "column `geometry.test` has words"),
        ("area_mm2 *", "the objective `area_mm2 *`: column"),
        ("1 + 2", "no column in it"),
    ];
    for (name, expected) in cases {
        let error = Sweep::default().table().compute(&[Objective::minimize(name)]);
        let text = error.expect_err("no objective").to_string();
        assert!(text.contains(expected), "{text}\nnot: {expected}");
    }
}

#[test]
fn an_unmet_condition_says_which_part() {
    let question = condition(two(), "fps.mean >= 1e6 && area_mm2 <= 4");
    let text = error(&question).to_string();
    assert_eq!(
        text,
        "none of 50 designs meets the condition on every trace; `fps.mean >= 1e6` alone: 0, \
         `area_mm2 <= 4` alone: 50; nearest: #48 misses `fps.mean >= 1e6` by 100 % on room \
         (fps.mean 258)"
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
    assert_eq!((same.front.as_slice(), same.twins[0].as_slice()), (&[0][..], &[1, 2][..]));
}

/// A table of single traces: key, area, frame rate; the display shows 60.
pub fn small(rows: &[(&str, f64, f64)]) -> Table {
    small_of("banked", rows)
}

/// The same with a model of the DRAM.
pub fn small_of(model: &str, rows: &[(&str, f64, f64)]) -> Table {
    let mut text = String::from(
        "point,is_baseline,id,status,reason,energy_table,trace,dram_model,scope,vru.cores,frames,\
         frame_time_ms.mean,frame_time_ms.max,fps.mean,fps.min,deadline_missed_frac,area_mm2\n",
    );
    for (point, (key, area, fps)) in rows.iter().enumerate() {
        let (ms, late) = (1e3 / fps, u8::from(*fps < 60.0));
        text += &format!(
            "{point},false,{point:x},ok,,t,,{model},mean,{key},4,{ms},{ms},{fps},{fps},{late},\
             {area}\n"
        );
    }
    Table::read(text.as_bytes(), |_| true).expect("a table")
}

#[test]
fn designs_that_miss_the_display_rate_rank_behind() {
    let table = small(&[("1", 1.0, 31.0), ("2", 2.0, 59.0), ("4", 3.0, 61.0), ("8", 5.0, 90.0)]);
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    assert_eq!((analysis.front.as_slice(), analysis.behind.as_slice()), (&[2, 3][..], &[0, 1][..]));
    assert!(analysis.is_late(0) && !analysis.is_late(2) && analysis.unreached().is_none());
    assert_eq!(analysis.stability.top, [2, 3]);
    let all = Question { misses: Misses::Included, ..two() };
    let all = Analysis::of(&table, &all).expect("an answer");
    assert_eq!((all.front.len(), all.behind.len()), (4, 0));
    assert!(all.is_late(0), "they are marked all the same");
}

#[test]
fn where_no_design_meets_the_rate_the_least_miss_comes_first() {
    let table = small(&[("1", 1.0, 31.0), ("2", 3.0, 59.0), ("4", 2.0, 58.99), ("8", 5.0, 40.0)]);
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    assert_eq!(analysis.front, [2], "of those that miss it least the smallest");
    assert_eq!(analysis.behind, [0, 3]);
    let (row, fps) = analysis.unreached().expect("none meets it");
    assert_eq!(row, 1);
    assert!((fps - 59.0).abs() < 1e-9);
}

#[test]
fn noise_is_no_trade() {
    // #1 and #2 are #0 but for 0.05 %; #3 gains 0.2 %.
    let table =
        small(&[("1", 2.0, 100.0), ("2", 2.0, 100.05), ("4", 2.001, 100.04), ("8", 2.0, 100.2)]);
    let of = |epsilon| {
        let analysis = Analysis::of(&table, &Question { epsilon, ..two() }).expect("an answer");
        (analysis.front.clone(), analysis.twins.clone(), analysis.knee)
    };
    assert_eq!(of(1e-3), (vec![3], vec![vec![]], 3));
    assert_eq!(of(0.0), (vec![3], vec![vec![]], 3));
    let table = small(&[("1", 2.0, 100.0), ("2", 2.0, 100.05), ("4", 2.001, 100.09)]);
    let question = two();
    let analysis = Analysis::of(&table, &question).expect("an answer");
    assert_eq!((analysis.front.len(), analysis.twins[0].len()), (1, 2), "one entry, two equal");
    assert!(analysis.marginals.is_empty() && analysis.around_knee.len() >= 2);
    let exact = Analysis::of(&table, &Question { epsilon: 0.0, ..question }).expect("an answer");
    assert_eq!(exact.front, [1, 2]);
}

/// Whatever is left out is covered by an entry of the front, and no entry by another.
#[test]
fn a_thinned_front_covers_all_designs() {
    let table = Sweep::default().table();
    for epsilon in [0.0, 1e-3, 0.05, 0.3] {
        let question = Question { epsilon, ..two() };
        let analysis = Analysis::of(&table, &question).expect("an answer");
        let covers = |a: u32, b: u32| {
            (0..2).all(|j| {
                let goal = analysis.question.objectives[j].goal;
                let (x, y) = (analysis.value(j, a), analysis.value(j, b));
                goal.gain(y, x) >= 0.0 || is_alike(x, y, 2.0 * epsilon)
            })
        };
        for &row in &analysis.rows {
            assert!(analysis.front.iter().any(|&m| covers(m, row)), "{epsilon} {row}");
        }
        for &a in &analysis.front {
            let alike = |b: u32| (0..2).all(|j| analysis.alike(j, a, b));
            assert!(!analysis.front.iter().any(|&b| a != b && alike(b)));
        }
        assert_eq!(analysis.stability.top[0], analysis.knee);
    }
}

#[test]
fn a_front_at_the_end_of_an_axis_is_noticed() {
    let table = small(&[("1", 2.0, 70.0), ("2", 2.0, 80.0), ("4", 2.0, 90.0)]);
    let analysis = Analysis::of(&table, &two()).expect("an answer");
    let [end] = analysis.at_ends.as_slice() else { panic!("{:?}", analysis.at_ends) };
    assert_eq!((end.axis.as_str(), end.value.as_str(), end.is_largest), ("vru.cores", "4", true));
    // Nothing is below one core, and an equal design elsewhere is not bound by the end.
    let least = small(&[("1", 1.0, 90.0), ("2", 2.0, 90.0)]);
    assert!(Analysis::of(&least, &two()).expect("an answer").at_ends.is_empty());
    let equal = small(&[("2", 2.0, 80.0), ("3", 2.0, 90.0), ("4", 2.0, 90.0)]);
    assert!(Analysis::of(&equal, &two()).expect("an answer").at_ends.is_empty());
}
