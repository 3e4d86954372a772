//! The display rate on axes of frame rates and frame times, and a budget on axes of power.

use super::axis::Axis;
use crate::format::{rate, significant};
use powergs_chart::{Colour, Entry, Symbol};
use powergs_study::analysis::Analysis;

/// The colour of its line.
pub const COLOUR: Colour = Colour::PURPLE;

/// The display rate or the budget in the unit of objective `j`; `None` where that is neither a rate
/// nor a time nor a power.
fn value(analysis: &Analysis, j: usize) -> Option<f64> {
    let question = &analysis.question;
    match question.objectives[j].name.split('.').next()? {
        "fps" => question.display_fps,
        "frame_time_ms" => Some(1e3 / question.display_fps?),
        "power_w" => question.budget_w,
        _ => None,
    }
}

/// What the line of objective `j` is called.
fn words(analysis: &Analysis, j: usize) -> Option<String> {
    let question = &analysis.question;
    match question.objectives[j].name.split('.').next()? {
        "power_w" => Some(format!("budget, {} W", significant(question.budget_w?))),
        _ => Some(format!("display rate, {} FPS", rate(question.display_fps?))),
    }
}

/// Values of objective `j` with the display rate, if that is not far from them.
pub fn with(analysis: &Analysis, j: usize, values: Vec<f64>) -> Vec<f64> {
    let (low, high) = powergs_chart::ends(values.iter().copied());
    let near = value(analysis, j).filter(|v| (low / 2.0..=high * 2.0).contains(v));
    values.into_iter().chain(near).collect()
}

/// Where the line is on an axis of objective `j`, if it is there.
pub fn line(analysis: &Analysis, j: usize, axis: &Axis) -> Option<f64> {
    let at = value(analysis, j)? * axis.factor;
    let scale = &axis.axis.scale;
    (scale.low()..=scale.high()).contains(&at).then_some(at)
}

/// What explains the lines, or says where they would be.
pub fn entries(analysis: &Analysis, axes: &[(usize, &Axis)]) -> Vec<Entry> {
    let entry = |(j, axis): &(usize, &Axis)| {
        let at = value(analysis, *j)? * axis.factor;
        let words = words(analysis, *j)?;
        let scale = &axis.axis.scale;
        Some(if at < scale.low() {
            Entry::note(format!("{words}: below this chart"))
        } else if at > scale.high() {
            Entry::note(format!("{words}: above this chart"))
        } else {
            Entry::new(words, Symbol::Dashed(COLOUR))
        })
    };
    let mut all: Vec<Entry> = axes.iter().filter_map(entry).collect();
    all.dedup();
    all
}
