//! The bottleneck in words.

use super::format::percent;
use powergs_core::accel::Stall;
use powergs_study::findings::bottleneck::{Bottleneck, Limit, Wait};

fn words(cause: Stall) -> &'static str {
    match cause {
        Stall::Records => "records of Gaussians",
        Stall::List => "tile lists",
        Stall::Spill => "spilled keys",
        Stall::Features => "feature loads",
        Stall::Input => "the unit before",
        Stall::Output => "room in the output",
        Stall::Bank => "busy banks",
    }
}

/// One sentence: which unit bounds what share of the frame, and what the rest waits for.
pub fn sentence(found: &Bottleneck) -> String {
    let dram = found.dram_wait;
    let cause = |w: &Wait| {
        let row = w.row_miss.map_or(String::new(), |m| format!(" (row-miss {} %)", percent(m)));
        format!("{} {} %{row}", words(w.cause), percent(w.share))
    };
    let shown = |w: &&Wait| w.share >= 0.005;
    let mut heads: Vec<String> = found
        .bounds
        .iter()
        .filter(|b| b.share >= 0.005)
        .map(|b| format!("{}-bound {} %", b.unit.name().to_uppercase(), percent(b.share)))
        .collect();
    let mut waits = Vec::new();
    if found.limit == Limit::Dram && dram >= 0.005 {
        let causes: Vec<String> =
            found.waits.iter().filter(|w| w.cause.is_dram()).filter(shown).map(cause).collect();
        heads.insert(0, format!("DRAM-bound {} %: {}", percent(dram), causes.join(", ")));
        waits.extend(found.waits.iter().filter(|w| !w.cause.is_dram()).filter(shown).map(cause));
    } else {
        waits.extend(found.waits.iter().filter(shown).map(cause));
    }
    let full = if found.is_bus_full() {
        format!("The DRAM bus is full, it moves data {} % of the time. ", percent(found.bus_busy))
    } else {
        String::new()
    };
    if let Some(first) = heads.first_mut() {
        *first = first.replacen(" %", " % of the frame", 1);
    }
    if heads.len() > 1 && heads[0].contains(':') {
        let first = heads.remove(0);
        heads[0] = format!("{first}; {}", heads[0]);
    }
    let mut text = format!("{full}{}", heads.join(", "));
    if !waits.is_empty() {
        text += &format!("; the rest waits for {}", waits.join(", "));
    }
    if found.without_work >= 0.005 {
        text += &format!("; {} % without work", percent(found.without_work));
    }
    text + "."
}
