//! Frame time along the path, with the deadline at the display rate.

use super::subtitle;
use crate::format::significant;
use powergs_chart::{
    Axis, Chart, Colour, Entry, Line, Mark, Panel, Place, Points, Rule, Scale, Size, Symbol,
};
use powergs_study::findings::RunSummary;
use powergs_study::run_record::Run;

const NAME: &str = "frame_time";
const TITLE: &str = "Frame time along the path";

/// A range wider than this is drawn logarithmically.
const WIDE: f64 = 50.0;
/// A deadline further above the data than this is told, not drawn: it would flatten the curve.
const FAR: f64 = 4.0;
/// Above this number of frames single frames get no dots.
const CROWDED: usize = 150;

pub(super) fn chart(run: &Run, summary: &RunSummary) -> Option<Chart> {
    let cycle = summary.cycle.as_ref()?;
    let times: Vec<f64> =
        run.frames.iter().filter_map(|f| f.frame_time_s()).map(|s| s * 1e3).collect();
    let deadline = 1e3 / run.facts.display_fps;
    let misses = cycle.deadline_misses;
    let numbers = format!(
        "mean {} ms, p99 {} ms; {misses} of {} over {} ms",
        significant(cycle.frame_time_ms),
        significant(cycle.frame_time_p99_ms),
        times.len(),
        significant(deadline)
    );
    let frames: Vec<f64> = run.frames.iter().map(|f| f.frame as f64).collect();
    let points: Vec<Place> = frames.into_iter().zip(times).collect();
    let high = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let far = if deadline <= FAR * high { "" } else { ": above this chart" };
    let name = format!("deadline {} ms{far}", significant(deadline));
    let chart = Chart::new(NAME, TITLE, subtitle(run, &numbers)).legend([
        Entry::new("frame", Symbol::Curve(Colour::BLUE)),
        Entry::new("over the deadline", Symbol::Dot(Colour::VERMILION)),
        Entry::new(name, Symbol::Dashed(Colour::VERMILION)),
    ]);
    Some(chart.panel(panel(points, deadline)))
}

fn panel(points: Vec<Place>, deadline: f64) -> Panel {
    let times = || points.iter().map(|p| p.1);
    let high = times().fold(0.0, f64::max);
    let low = times().filter(|t| *t > 0.0).fold(high, f64::min);
    let near = deadline <= FAR * high;
    let top = if near { high.max(deadline) } else { high };
    let y = if low > 0.0 && high > WIDE * low {
        Axis::new("frame time, ms (logarithmic)", Scale::logarithmic(low, top))
    } else {
        Axis::new("frame time, ms", Scale::from_zero(top * 1.05))
    };
    let first = points.first().map_or(0.0, |p| p.0);
    let last = points.last().map_or(0.0, |p| p.0);
    let x = if first == last {
        let only = vec![(first, format!("{first}"))];
        Axis::new("frame", Scale::linear(first - 1.0, last + 1.0)).labelled(only)
    } else {
        Axis::new("frame", Scale::linear(first, last)).whole(10)
    };
    let crowded = points.len() > CROWDED;
    let size = if crowded { Size::Small } else { Size::Medium };
    // Dots for frames while there is room, and for the missed ones in any case.
    let missed: Vec<Place> = points.iter().copied().filter(|p| p.1 > deadline).collect();
    let met: Vec<Place> = points.iter().copied().filter(|p| !crowded && p.1 <= deadline).collect();
    let panel = Panel::new(x.plain(), y)
        .line(Line::thin(points, Colour::BLUE))
        .points(Points::dots(met, Colour::BLUE, size))
        .points(Points::dots(missed, Colour::VERMILION, size));
    let line = Mark::Rule { at: Rule::Y(deadline), colour: Colour::VERMILION, dashed: true };
    if near { panel.mark(line) } else { panel }
}
