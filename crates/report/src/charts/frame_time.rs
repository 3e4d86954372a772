//! Frame time of every frame, with the deadline at the display rate. Few frames stand alone: they
//! may be views that have nothing to do with each other.

use super::subtitle;
use crate::format::{rate, significant};
use powergs_chart::{
    Axis, Bin, Chart, Colour, Entry, Line, Mark, Panel, Place, Points, Rule, Scale, Size, Symbol,
};
use powergs_study::findings::{Key, Record};
use powergs_study::run_record::Run;

const NAME: &str = "frame_time";
const TITLE: &str = "Frame time";
/// Up to this number of frames each is a bar.
const BARS: usize = 32;

/// Frames over the deadline.
const LATE: Colour = Colour::ORANGE;
/// A range wider than this is drawn logarithmically.
const WIDE: f64 = 50.0;
/// A deadline further above the data than this is told, not drawn: it would flatten the curve.
const FAR: f64 = 4.0;
/// Above this number of frames single frames get no dots.
const CROWDED: usize = 150;

pub(super) fn chart(run: &Run, record: &Record) -> Option<Chart> {
    let time_ms = record.aggregate(Key::FrameTime)?;
    let times: Vec<f64> =
        run.frames.iter().filter_map(|f| f.frame_time_s()).map(|s| s * 1e3).collect();
    // Nobody waits for steps.
    let deadline = Some(1e3 / run.facts.display_fps).filter(|_| run.facts.machine.task.is_shown());
    let missed = record
        .deadline_misses()
        .zip(deadline)
        .map(|(misses, ms)| format!("; {misses} of {} over {} ms", times.len(), significant(ms)));
    let numbers = format!(
        "mean {} ms, {} {} ms{}",
        significant(time_ms.mean),
        if (times.len() as u64) < crate::page::HUNDRED { "slowest" } else { "p99" },
        significant(time_ms.p99.as_f64()),
        missed.unwrap_or_default()
    );
    let frames: Vec<f64> = run.frames.iter().map(|f| f.frame as f64).collect();
    let points: Vec<Place> = frames.into_iter().zip(times).collect();
    let high = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let fps = rate(run.facts.display_fps);
    let line = deadline.map(|deadline| {
        let name = format!("deadline {} ms ({fps} FPS)", significant(deadline));
        match deadline <= FAR * high {
            true => Entry::new(name, Symbol::Dashed(Colour::VERMILION)),
            false => Entry::note(format!("{name}: above this chart")),
        }
    });
    let bars = points.len() <= BARS;
    let symbol = |c| if bars { Symbol::Fill(c) } else { Symbol::Curve(c) };
    let late = if bars { Symbol::Fill(LATE) } else { Symbol::Dot(LATE) };
    let chart = Chart::new(NAME, TITLE, subtitle(run, &numbers));
    let Some(line) = line else {
        return Some(chart.panel(panel(points, f64::INFINITY)));
    };
    let entries =
        [Entry::new("frame", symbol(Colour::BLUE)), Entry::new("over the deadline", late), line];
    Some(chart.legend(entries).panel(panel(points, deadline.unwrap_or(f64::INFINITY))))
}

fn panel(points: Vec<Place>, deadline: f64) -> Panel {
    let times = || points.iter().map(|p| p.1);
    let high = times().fold(0.0, f64::max);
    let low = times().filter(|t| *t > 0.0).fold(high, f64::min);
    let near = deadline <= FAR * high;
    let top = if near { high.max(deadline) } else { high };
    let y = if low > 0.0 && high > WIDE * low {
        Axis::new("frame time, ms", Scale::logarithmic(low, top))
    } else {
        Axis::new("frame time, ms", Scale::from_zero(top * 1.05))
    };
    let first = points.first().map_or(0.0, |p| p.0);
    let last = points.last().map_or(0.0, |p| p.0);
    let x = if first == last {
        let only = vec![(first, format!("{first}"))];
        Axis::new("frame", Scale::linear(first - 1.0, last + 1.0)).labelled(only)
    } else if points.len() <= BARS {
        Axis::new("frame", Scale::linear(first - 0.6, last + 0.6)).whole(10)
    } else {
        Axis::new("frame", Scale::linear(first, last)).whole(10)
    };
    let x = x.plain().positions();
    let line = Mark::Rule { at: Rule::Y(deadline), colour: Colour::VERMILION, dashed: true };
    if points.len() <= BARS {
        let late = |t: f64| if t > deadline { LATE } else { Colour::BLUE };
        let bin = |&(frame, t): &Place| Bin {
            from: frame - 0.3,
            to: frame + 0.3,
            height: t,
            colour: late(t),
            label: String::new(),
        };
        let bins = points.iter().map(bin).collect();
        let panel = Panel::new(x, y).mark(Mark::Histogram { bins, outlined: false });
        return if near { panel.mark(line) } else { panel };
    }
    let crowded = points.len() > CROWDED;
    let size = if crowded { Size::Small } else { Size::Medium };
    // Dots for frames while there is room, and for the missed ones in any case.
    let missed: Vec<Place> = points.iter().copied().filter(|p| p.1 > deadline).collect();
    let met: Vec<Place> = points.iter().copied().filter(|p| !crowded && p.1 <= deadline).collect();
    let panel = Panel::new(x, y)
        .line(Line::thin(points, Colour::BLUE))
        .points(Points::dots(met, Colour::BLUE, size))
        .points(Points::dots(missed, LATE, size));
    if near { panel.mark(line) } else { panel }
}
