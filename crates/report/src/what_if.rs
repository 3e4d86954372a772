//! What one step would buy, in words.

use std::fmt::Write;

use super::format::significant;
use powergs_study::findings::what_if::{Step, WhatIf, change};

/// Lines of a table for the terminal: the `most` best steps that change the time at all.
pub fn lines(what_if: &WhatIf, most: usize) -> String {
    let frames = match what_if.frames.len() {
        1 => "1 frame".into(),
        n => format!("{n} frames"),
    };
    let head = format!("doubling ({frames})");
    let mut text = format!("{head:<28}{:>26}{:>26}\n", "ms per frame", "mJ per frame");
    let moves = |s: &&Step| what_if.time_change(s).abs() >= 0.005;
    let shown: Vec<&Step> = what_if.steps.iter().filter(moves).take(most).collect();
    for step in &shown {
        let time = pair(what_if.base.frame_time_ms, step.cost.frame_time_ms);
        let energy = pair(what_if.base.energy_pj * 1e-9, step.cost.energy_pj * 1e-9);
        let _ = writeln!(text, "{:<28}{time:>26}{energy:>26}", step.resource);
    }
    let others = what_if.steps.len() - shown.len();
    if others > 0 {
        let all = if shown.is_empty() { "all" } else { "the other" };
        let _ = writeln!(text, "{all} {others}: see summary.md");
    }
    text
}

/// `2.77 -> 2.10  -24 %`.
fn pair(from: f64, to: f64) -> String {
    format!("{} -> {} {}", significant(from), significant(to), signed_percent(change(from, to)))
}

/// A relative change with its sign, padded: ` -24 %`.
pub fn signed_percent(change: f64) -> String {
    let p = change * 100.0;
    let text = if p.abs() < 0.05 {
        "0 %".to_owned()
    } else if p.abs() < 9.95 {
        format!("{p:+.1} %")
    } else {
        format!("{p:+.0} %")
    };
    format!("{text:>7}")
}
