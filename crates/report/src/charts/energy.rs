//! Energy per frame and power at the display rate: a bar per stage, stacked by component.

use super::{frames, subtitle};
use crate::format::{engineering, prefix_of, rate, significant};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_energy::Component;
use powergs_energy::action::Phase;
use powergs_study::findings::breakdown::Breakdown;
use powergs_study::findings::{Key, Record};
use powergs_study::run_record::Run;

const NAME: &str = "energy";
const TITLE: &str = "Where the energy goes";
const DISPLAY: Colour = Colour::GREEN;

pub(crate) fn colour(component: Component) -> Colour {
    match component {
        Component::Dram => Colour::BLUE,
        Component::Sram => Colour::SKY,
        Component::Flop => Colour::ORANGE,
        Component::Leakage => Colour::GREY,
        Component::Background => Colour::PURPLE,
        Component::Refresh => Colour::YELLOW,
    }
}

/// The legend of the components.
pub(crate) fn entries() -> impl Iterator<Item = Entry> {
    Component::ALL.into_iter().map(|c| Entry::fill(c.name(), colour(c)))
}

pub(super) fn chart(run: &Run, record: &Record) -> Option<Chart> {
    let fps = run.facts.display_fps;
    let (energy, power) = (Breakdown::energy_j(record), Breakdown::power_w(record));
    let display = record.mean(Key::DisplayPower);
    let stages = power.shown();
    let names: Vec<&str> = stages.iter().map(|s| s.name()).collect();
    let left = panel(&names, &stages, &energy, None, "J");
    let task = run.facts.machine.task;
    let heading = format!("{} a {} at full rate", engineering(energy.total(), "J"), task.noun());
    let left = left.heading(Words::bold(heading));
    let all: Vec<&str> = names.iter().copied().chain(display.map(|_| "display")).collect();
    let right = panel(&all, &stages, &power, display, "W");
    let beside = display.map_or(String::new(), |w| format!(" + display {}", engineering(w, "W")));
    let reached = format!("{} {}", significant(record.displayed_fps()), task.per_second());
    let at = match (task.is_shown(), record.misses()) {
        (false, _) => reached,
        (true, true) => format!("{reached} (misses {})", rate(fps)),
        (true, false) => format!("{} FPS", rate(fps)),
    };
    let heading = format!("{} at {at}{beside}", engineering(power.total(), "W"));
    let mut right = right.heading(Words::bold(heading));
    // Without a display both panels have the same names.
    if display.is_none() {
        right.y = right.y.hidden();
    }
    let extra = display.map(|_| Entry::fill("display", DISPLAY));
    let chart = Chart::new(NAME, TITLE, subtitle(run, &frames(run))).columns(2);
    Some(chart.legend(entries().chain(extra)).panel(left).panel(right))
}

/// One panel: a bar per stage, and one for the display where it is known.
fn panel(
    names: &[&str],
    stages: &[Phase],
    values: &Breakdown,
    display: Option<f64>,
    unit: &str,
) -> Panel {
    let highest = stages.iter().map(|&s| values.stage(s)).chain(display).fold(0.0, f64::max);
    let (factor, prefix) = prefix_of(highest);
    let bar = |(i, &stage): (usize, &Phase)| {
        let part = |c| Part::new(values.part(stage, c) / factor, colour(c));
        let bar = Bar::new(i, Component::ALL.map(part).into());
        bar.end(significant(values.stage(stage) / factor))
    };
    let mut bars: Vec<Bar> = stages.iter().enumerate().map(bar).collect();
    bars.extend(display.map(|watts| {
        let bar = Bar::new(stages.len(), vec![Part::new(watts / factor, DISPLAY)]);
        bar.end(significant(watts / factor))
    }));
    let x = Axis::new(format!("{prefix}{unit}"), Scale::from_zero(highest / factor)).ticks(5);
    Panel::new(x, Axis::names(names.iter().copied())).mark(Mark::Bars(bars))
}
