//! From `results.csv` to columns: what is kept, and what a wrong text says.

use powergs_study::analysis::Table;
use powergs_study::analysis::table::Over;
use powergs_study::sweep::expr::Expr;

use super::support::Sweep;

fn read(text: &str) -> Result<Table, String> {
    Table::read(text.as_bytes(), |_| true).map_err(|e| e.to_string())
}

const HEAD: &str =
    "point,is_baseline,id,status,reason,energy_table,trace,scope,a.b,frames,fps.mean\n";

#[test]
fn columns_and_counts() {
    let table = Sweep::default().table();
    assert_eq!((table.counts.ok, table.counts.failed, table.counts.excluded), (50, 1, 1));
    assert_eq!(table.len(), 51 * 2 * 4, "two tables; two traces, mean and worst");
    assert_eq!(table.over[..4], [Over::Trace, Over::Trace, Over::Mean, Over::Worst]);
    let names: Vec<&str> = table.axes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["vru.cores", "buffers.feature.capacity", "geometry.test"]);
    let capacity = table.axis("buffers.feature.capacity").expect("an axis");
    assert_eq!(capacity.number(0), Some(512.0 * 1024.0), "in bytes");
    assert!(capacity.is_numeric() && !table.axis("geometry.test").expect("an axis").is_numeric());
    assert_eq!(table.label(0), "baseline");
    assert!(table.numbers("bottleneck").is_none(), "words");
    assert_eq!(table.reasons[0], ("failed: buffer, too small".to_owned(), 1));
}

/// A size in SI units and a derived key are columns to ask for, but nothing that is varied.
#[test]
fn what_follows_from_axes_is_no_axis() {
    let text = "point,is_baseline,id,status,reason,energy_table,trace,scope,a,buffer,buffer.si,\
                b,frames,fps.mean\n\
                0,false,a,ok,,t,,mean,1,1 KiB,1024,2,4,60\n\
                1,false,b,ok,,t,,mean,2,2 KiB,2048,4,4,70\n";
    let mut table = read(text).expect("a table");
    table.follow(&["b".to_owned()].into());
    let names: Vec<&str> = table.axes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["a", "buffer"]);
    assert_eq!(table.axis("b").map(|b| b.number(1)), Some(Some(4.0)));
    assert_eq!(table.number("buffer.si", 0), Some(1024.0));
    assert_eq!(table.settings(1), [("a", "2"), ("buffer", "2 KiB")]);
}

#[test]
fn an_axis_counts_where_its_condition_holds() {
    let text = "point,is_baseline,id,status,reason,energy_table,trace,scope,cache.capacity,\
                cache.ways,frames,fps.mean\n\
                0,false,a,ok,,t,,mean,0 B,4,4,60\n\
                1,false,b,ok,,t,,mean,32 KiB,4,4,70\n";
    let mut table = read(text).expect("a table");
    let condition = |text: &str| ("cache.ways".to_owned(), Expr::parse(text).expect("a condition"));
    table.restrict(&[condition("cache.capacity > 0")]);
    assert_eq!([0, 1].map(|row| table.counts("cache.ways", row)), [false, true]);
    assert_eq!(table.settings(0), [("cache.capacity", "0 B")]);
    assert_eq!(table.settings(1), [("cache.capacity", "32 KiB"), ("cache.ways", "4")]);
    table.restrict(&[condition("vru.cores > 2")]);
    assert!(table.counts("cache.ways", 0), "nobody knows");
}

#[test]
fn only_wanted_metrics_are_kept() {
    let text = Sweep::default().csv();
    let table = Table::read(text.as_bytes(), |name| name == "fps.mean").expect("a table");
    assert_eq!(table.metrics.len(), 1);
    assert!(table.metric_names.contains(&"energy_pj.mean".to_owned()));
}

#[test]
fn empty_cells_are_not_zero() {
    let table = read(&format!("{HEAD}0,false,a,ok,,t,,mean,1,4,\n1,false,b,ok,,t,,mean,1,4,60\n"))
        .expect("ok");
    let fps = table.numbers("fps.mean").expect("numbers");
    assert!(fps[0].is_nan() && fps[1] == 60.0);
    assert_eq!(table.number("fps.mean", 0), None);
}

#[test]
fn wrong_texts_say_where() {
    let cases = [
        ("", "no column `point`"),
        ("point,is_baseline,id\n", "no column `status`"),
        ("a,a\n", "column `a` appears twice"),
        (&HEAD.replace("frames", "frame"), "no column `frames`"),
        (
            &format!("{HEAD}x,false,a,ok,,t,,mean,1,4,60\n"),
            "line 2, column `point`: `x` is not the number of a point",
        ),
        (&format!("{HEAD}0,false,a,done,,t,,mean,1,4,60\n"), "line 2, column `status`: `done`"),
        (&format!("{HEAD}0,false,xyz,ok,,t,,mean,1,4,60\n"), "column `id`: `xyz` is not a hash"),
        (&format!("{HEAD}0,false,a,ok,,t,,median,1,4,60\n"), "`median` is not `trace`, `mean`"),
        (
            &format!("{HEAD}0,false,a,ok,,t,,mean,1,4,60\n1,false,b,ok,,t,,mean,1,4,fast\n"),
            "line 3, column `fps.mean`: `fast` is not a number",
        ),
        (&format!("{HEAD}0,false,a,ok\n"), "line: 2"),
        (
            &format!("{HEAD}18446744073709551615,false,a,ok,,t,,mean,1,4,60\n"),
            "is not the number of a point",
        ),
    ];
    for (text, expected) in cases {
        let error = read(text).expect_err(expected);
        assert!(error.contains(expected), "{error}\nnot: {expected}");
    }
    let bytes = [HEAD.as_bytes(), b"0,false,\xff,ok,,t,,mean,1,4,60\n"].concat();
    assert!(Table::read(&bytes[..], |_| true).is_err());
}

/// Every cut of a table is read or refused.
#[test]
fn cut_tables() {
    let small = Sweep { cores: vec![1], kib: vec![16], ..Sweep::default() };
    let text = small.csv();
    for end in (0..text.len()).step_by(7) {
        let _ = read(&text[..end]);
    }
}
