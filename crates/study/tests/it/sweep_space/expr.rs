//! The expression language.

use powergs_study::sweep::expr::{Expr, Value};
use proptest::prelude::*;

fn lookup(name: &str) -> Option<Value> {
    Some(match name {
        "vru.cores" => Value::Number(4.0),
        "dram.controller-latency" => Value::Number(40e-9),
        "dram:timing.burst" => Value::Number(8.0),
        "buffers.sorting.capacity" => Value::Number(65536.0),
        "geometry.test" => Value::Text("obb".into()),
        "vru.tile-overlap" => Value::Truth(false),
        "frame_time_ms.p99" => Value::Number(12.5),
        "energy_pj.mean" => Value::Number(3e9),
        "area_mm2" => Value::Number(3.95),
        "a" => Value::Number(7.0),
        "b" => Value::Number(2.0),
        "odd name" => Value::Number(1.0),
        _ => return None,
    })
}

#[track_caller]
fn check(text: &str, expected: Value) {
    let value = Expr::parse(text).and_then(|e| e.eval(&lookup));
    assert_eq!(value, Ok(expected), "{text}");
}

#[track_caller]
fn number(text: &str, expected: f64) {
    check(text, Value::Number(expected));
}

#[track_caller]
fn truth(text: &str, expected: bool) {
    check(text, Value::Truth(expected));
}

/// The whole error, as a user sees it.
#[track_caller]
fn wrong(text: &str, expected: &str) {
    let error = Expr::parse(text).and_then(|e| e.eval(&lookup)).expect_err(text).to_string();
    assert!(error.contains(expected), "{text}: {error}");
}

#[test]
fn arithmetic_binds_as_on_paper() {
    number("1 + 2 * 3", 7.0);
    number("(1 + 2) * 3", 9.0);
    number("10 - 4 - 3", 3.0);
    number("2 ^ 3 ^ 2", 512.0);
    number("-2 ^ 2", -4.0);
    number("2 ^ -1", 0.5);
    number("7 % 4 * 2", 6.0);
    number("12 / 4 / 3", 1.0);
    number("--3", 3.0);
    number("1.5e3 + .5", 1500.5);
    number("3 * -a", -21.0);
}

#[test]
fn names_may_have_dots_dashes_and_a_file() {
    number("2 * vru.cores", 8.0);
    number("dram.controller-latency", 40e-9);
    number("dram:timing.burst * 2", 16.0);
    number("a - b", 5.0);
    number("a-1", 6.0);
    number("a -b", 5.0);
    number("`odd name` + 1", 2.0);
    wrong("a-b", "nothing is called `a-b`");
    let expr = Expr::parse("a + b * a > vru.cores").expect("an expression");
    assert_eq!(expr.names().into_iter().collect::<Vec<_>>(), ["a", "b", "vru.cores"]);
}

#[test]
fn numbers_with_units_are_si() {
    number("64 KiB", 65536.0);
    number("64KiB / 1 KiB", 64.0);
    number("2 GHz * 1 ns", 2.0);
    number("51.2 GB/s", 51.2e9);
    number("1 B/b", 0.5);
    number("0.5 pJ/B", 0.5 / 1e12);
    number("28 nm", 28.0);
    truth("buffers.sorting.capacity == 64 KiB", true);
    truth("dram.controller-latency == 40 ns", true);
    wrong("64 KiBs", "is not a unit");
    wrong("fps.mean > 60 FPS", "leave `FPS` out");
    wrong("64 kib", "did you mean `KiB`?");
    wrong("1.5 B", "whole number of bytes");
    wrong("3 cores", "write `*`");
}

#[test]
fn truths_and_texts() {
    truth("geometry.test == 'obb'", true);
    truth("geometry.test != \"obb\" || area_mm2 <= 4", true);
    truth("!vru.tile-overlap && a > b", true);
    truth("(1 < 2) == true", true);
    wrong("1 < 2 == true", "do not chain");
    truth("true || missing > 1", true);
    truth("false && missing > 1", false);
    wrong("geometry.test == 4", "never equal");
    wrong("geometry.test < 4", "where a number is wanted");
    wrong("a && true", "where true or false is wanted");
    wrong("1 < a < 9", "do not chain");
    wrong("a = 3", "write `==`");
}

#[test]
fn functions() {
    number("min(a, b, 9) + max(1, 3)", 5.0);
    number("ceil(1.2) + floor(1.8) + round(2.5) + abs(-1)", 7.0);
    number("log2(8) + sqrt(9)", 6.0);
    number("ceil_pow2(5) + floor_pow2(5)", 12.0);
    number("ceil_pow2(64) + floor_pow2(64)", 128.0);
    number("ceil_pow2(0.3)", 0.5);
    number("if(a > b, 1, missing)", 1.0);
    wrong("ceil_pow(3)", "did you mean `ceil_pow2`?");
    wrong("if(a, b)", "takes 3 values, not 2");
    wrong("min()", "at least 1");
    wrong("log2(0)", "not a finite number");
    wrong("a / 0", "not a finite number");
    wrong("ceil_pow2(0)", "not a finite number");
}

#[test]
fn a_unit_beside_a_statistic_becomes_that_of_its_name() {
    truth("frame_time_ms.p99 <= 16.67 && area_mm2 <= 4", true);
    truth("frame_time_ms.p99 <= 12.4 ms", false);
    truth("12.6 ms >= frame_time_ms.p99", true);
    truth("energy_pj.mean <= 3 mJ", true);
    truth("energy_pj.mean < 2.9 mJ", false);
    truth("area_mm2 <= 4 mm2", true);
    wrong("energy_pj.mean <= 3 ms", "is an energy, and this is a time");
    wrong("energy_pj.mean * 2 <= 3 mJ", "has its unit in its name");
    truth("area_mm2 * 2 < 8 && buffers.sorting.capacity > 1 KiB", true);
}

#[test]
fn errors_show_the_place() {
    let error = Expr::parse("area_mm2 <= (4").expect_err("no closing parenthesis").to_string();
    assert_eq!(error, "column 13: this `(` is never closed\n  | area_mm2 <= (4\n  |             ^");
    wrong("", "column 1: a value is missing at the end");
    wrong("1 +", "column 4: a value is missing at the end");
    wrong("1 2", "column 3: an operator is missing");
    wrong("1)", "a `)` without its `(`");
    wrong("'abc", "no closing '");
    wrong("a @ b", "`@` means nothing here");
    wrong("ä", "means nothing here");
    let unknown = Expr::parse("2 * vru.core").expect("an expression").eval(&lookup);
    assert_eq!(unknown.expect_err("no such key").unknown.as_deref(), Some("vru.core"));
}

#[test]
fn hostile_texts_end() {
    for text in ["(".repeat(4096), "-".repeat(4096), "!".repeat(3000), "if(".repeat(1000)] {
        wrong(&text, "levels deep");
    }
    wrong(&"1+".repeat(4000), "longer than");
    let wide = format!("{}1", "1+".repeat(2000));
    number(&wide, 2001.0);
}

proptest! {
    #[test]
    fn nothing_panics(text in "\\PC{0,60}") {
        let _ = Expr::parse(&text).map(|e| e.eval(&lookup)).map_err(|e| e.to_string());
    }

    #[test]
    fn words_in_any_order_do_not_panic(words in proptest::collection::vec(
        proptest::sample::select(vec![
            "a", "b", "1", "2.5", "64 KiB", "'x'", "(", ")", ",", "+", "-", "*", "/", "%", "^", "!",
            "==", "<", "<=", "&&", "||", "min(", "if(", "true", "energy_pj", "3 mJ", "`", "é",
        ]), 0..30)
    ) {
        let text = words.join(" ");
        let _ = Expr::parse(&text).map(|e| e.eval(&lookup)).map_err(|e| e.to_string());
    }

    #[test]
    fn sums_and_products_are_those_of_rust(a in -1e6..1e6f64, b in -1e6..1e6f64, c in 0.1..1e6f64) {
        let text = format!("{a:?} + {b:?} * {c:?} - {b:?} / {c:?}");
        let value = Expr::parse(&text).and_then(|e| e.eval(&|_| None)).expect("a number");
        prop_assert_eq!(value, Value::Number(a + b * c - b / c));
    }
}

#[test]
fn a_condition_is_missed_by_the_side_that_counts() {
    let missed = |text: &str| {
        Expr::parse(text).and_then(|e| e.missed_by(&lookup, &lookup)).map_err(|e| e.to_string())
    };
    // In shares of the limit, on whatever side that stands.
    assert_eq!(missed("a <= 3.5"), Ok(1.0));
    assert_eq!(missed("3.5 >= a"), Ok(1.0));
    assert_eq!(missed("a >= 14"), Ok(0.5));
    // A limit of 0 is no measure.
    assert_eq!(missed("a <= 0"), Ok(1.0));
    assert!(missed("a <= 7").is_ok_and(|by| by <= 0.0));
    // Equal sides miss a strict bound.
    assert!(missed("a < 7").is_ok_and(|by| by > 0.0 && by < 1e-300));
    // A side that has no value counts only where the other one does not decide.
    assert!(missed("b > 4 && a / (b - 2) < 3").is_ok_and(|by| by == 0.5));
    assert!(missed("b < 4 || a / (b - 2) < 3").is_ok_and(|by| by <= 0.0));
    assert!(missed("b < 4 && a / (b - 2) < 3").is_err());
    assert!(missed("b > 4 || a / (b - 2) < 3").is_err());
}
