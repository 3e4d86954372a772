//! The display rate on axes of frame rates and frame times.

use super::axis::Axis;
use crate::format::rate;
use powergs_chart::{Colour, Entry, Symbol};
use powergs_study::analysis::Analysis;

/// The colour of its line.
pub const COLOUR: Colour = Colour::PURPLE;

/// The display rate in the unit of objective `j`; `None` where that is neither a rate nor a time.
fn value(analysis: &Analysis, j: usize) -> Option<f64> {
    let fps = analysis.question.display_fps?;
    match analysis.question.objectives[j].name.split('.').next()? {
        "fps" => Some(fps),
        "frame_time_ms" => Some(1e3 / fps),
        _ => None,
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

/// What explains the line, or says where it would be; `None` without rates and times.
pub fn entry(analysis: &Analysis, axes: &[(usize, &Axis)]) -> Option<Entry> {
    let fps = rate(analysis.question.display_fps?);
    let (j, axis) = axes.iter().find(|(j, _)| value(analysis, *j).is_some())?;
    let at = value(analysis, *j)? * axis.factor;
    let scale = &axis.axis.scale;
    Some(if at < scale.low() {
        Entry::note(format!("{fps} FPS is below this chart"))
    } else if at > scale.high() {
        Entry::note(format!("{fps} FPS is above this chart"))
    } else {
        Entry::new(format!("display rate, {fps} FPS"), Symbol::Dashed(COLOUR))
    })
}
