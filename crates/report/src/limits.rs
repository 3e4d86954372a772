//! What is not modelled, and which assumptions mattered most, in words.

use super::format::percent;
use super::what_if::signed_percent;
use powergs_core::energy::Component;
use powergs_study::findings::limits::{Mattered, NOT_MODELLED, Why};

/// Why an assumption mattered, in a few words.
pub fn why(why: &Why) -> String {
    match why {
        Why::Doubled { resource, change } => {
            format!("doubling {resource}: frame time {}", signed_percent(*change).trim())
        }
        Why::Bottleneck => "behind the bottleneck of this run".into(),
        Why::Energy { part, share } => {
            format!("{}: {} % of the energy", part_words(*part), percent(*share))
        }
    }
}

fn part_words(part: Component) -> &'static str {
    match part {
        Component::Dram => "DRAM accesses",
        Component::Sram => "buffer accesses",
        Component::Flop => "arithmetic",
        Component::Leakage => "leakage",
        Component::Background => "DRAM background",
        Component::Refresh => "DRAM refresh",
    }
}

/// The line on the terminal that points to the list.
pub fn line(left_out: usize, mattered: &[Mattered]) -> String {
    let numbers: Vec<&str> = mattered.iter().map(|m| m.assumption).take(6).collect();
    let mattered = if numbers.is_empty() {
        String::new()
    } else {
        format!("; mattered most: {}", numbers.join(" "))
    };
    format!("limits  {left_out} effects left out{mattered}\n")
}

/// The table of [`NOT_MODELLED`] for `docs/limits.md`.
pub fn page() -> String {
    let mut text = String::from(PAGE);
    for effect in NOT_MODELLED {
        let which =
            effect.dram.map_or("all".to_owned(), |m| format!("`dram.model = \"{}\"`", m.name()));
        let see = if effect.assumption.is_empty() { "-" } else { effect.assumption };
        let (what, bias) = (effect.what, effect.bias.name());
        text += &format!("| {what} | {bias} | {see} | {which} |\n");
    }
    text
}

const PAGE: &str = "\
# What is not modelled

<!-- Written from crates/study/src/findings/limits.rs: change that, then
     UPDATE_EXPECT=1 cargo test report:: -->

Every report of the `cycle` model ends with this list (`summary.md`, `not_modelled` in `--json`). \
*Optimistic*: real frames take longer than simulated ones; *pessimistic*: real frames take less \
time. The A-numbers are explained in [model-accel.md](model-accel.md) and [model.md](model.md). \
Beside it a report names the assumptions that mattered most in that run: those behind the \
resources that move the frame time by 3 % or more when they are doubled (`--what-if`), and those \
behind every part of 15 % or more of the energy.

| effect | simulated time is | see | machines |
|---|---|---|---|
";
