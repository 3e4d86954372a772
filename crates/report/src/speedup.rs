//! Several machines over several traces: the chart of speed-ups that papers have, its table, its
//! files.

use serde_json::{Value, json};

use crate::document::{Cell, Column, Table};
use crate::format::shortened;
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Rule, Scale, Words};
use powergs_study::speedup::{Gain, SpeedUp};

/// Name of the chart.
const NAME: &str = "speedup";
/// Traces in the chart; tables have all.
const MOST: usize = 14;
/// Colours of the machines behind the first.
const COLOURS: [Colour; 8] = Colour::SERIES;
/// What the mean is called: the geometric one.
const MEAN: &str = "geomean";

/// The chart: a bar a trace and machine, or with many machines their means alone.
pub fn chart(all: &SpeedUp, subtitle: impl Into<String>) -> Chart {
    let first = &all.machines[0].label;
    let title = format!("Speed-up over {first}");
    if all.machines.len() - 1 > MOST_BARS {
        let gains = gains(all);
        let subtitle = format!("{}; geometric means, from least to largest", subtitle.into());
        let mut chart = Chart::new(NAME, title, subtitle).columns(gains.len());
        for (i, &gain) in gains.iter().enumerate() {
            let mut panel = means(all, gain);
            if i > 0 {
                panel.y = panel.y.hidden();
            }
            chart = chart.panel(panel);
        }
        return chart;
    }
    let machines = 1..all.machines.len().min(COLOURS.len() + 1);
    let entries = machines.map(|m| Entry::fill(all.machines[m].label.as_str(), COLOURS[m - 1]));
    let left = panel(all, Gain::Speed, &format!("speed-up over {first} (frame rate)"));
    let chart = Chart::new(NAME, title, subtitle).legend(entries);
    if !gains(all).contains(&Gain::Energy) {
        return chart.panel(left);
    }
    let mut right =
        panel(all, Gain::Energy, &format!("energy gain over {first} (energy per frame)"));
    right.y = right.y.hidden();
    chart.columns(2).panel(left).panel(right)
}

/// Machines beside the first of which every trace has a bar.
const MOST_BARS: usize = 5;

/// The gains that another machine than the first has: joules of other technologies are none.
fn gains(all: &SpeedUp) -> Vec<Gain> {
    let has = |gain: &Gain| (1..all.machines.len()).any(|m| all.mean(*gain, m).is_some());
    Gain::ALL.into_iter().filter(|gain| *gain == Gain::Speed || has(gain)).collect()
}

/// What a gain is called.
fn name(gain: Gain) -> &'static str {
    match gain {
        Gain::Speed => "speed-up",
        Gain::Energy => "energy gain",
    }
}

/// Why a machine has no bar, where that is no lack of numbers.
fn withheld(all: &SpeedUp, gain: Gain, machine: usize) -> Option<&'static str> {
    let [speed, energy] = all.machines[machine].is_comparable;
    match (speed, energy, gain) {
        (false, ..) => Some("another task"),
        (true, false, Gain::Energy) => Some("another node"),
        _ => None,
    }
}

/// A bar a machine: its geometric mean over the traces.
fn means(all: &SpeedUp, gain: Gain) -> Panel {
    let machines = 1..all.machines.len();
    let mut highest = 1.0f64;
    let mut bars = Vec::new();
    for m in machines.clone() {
        let Some(mean) = all.mean(gain, m) else {
            bars.extend(withheld(all, gain, m).map(|why| Bar::new(m - 1, Vec::new()).end(why)));
            continue;
        };
        highest = highest.max(mean);
        let interval = all.spread(gain, m).map(|[least, most]| (least, most));
        highest = highest.max(interval.map_or(mean, |(_, most)| most));
        let bar = Bar { interval, ..Bar::new(m - 1, vec![Part::new(mean, COLOURS[0])]) };
        bars.push(bar.end(format!("{mean:.2}")));
    }
    let names = machines.map(|m| shortened(&all.machines[m].label, 24));
    let x = Axis::new(name(gain), Scale::from_zero(1.15 * highest));
    Panel::new(x, Axis::names(names)).dashed(Rule::X(1.0), Colour::NOTE).mark(Mark::Bars(bars))
}

fn panel(all: &SpeedUp, gain: Gain, title: &str) -> Panel {
    let traces = all.traces.len().min(MOST);
    let machines = all.machines.len().min(COLOURS.len() + 1);
    let value = |m: usize, row: usize| match row {
        row if row < traces => all.gain(gain, m, row),
        _ => all.mean(gain, m),
    };
    let mut bars = Vec::new();
    let mut highest = 1.0f64;
    for row in 0..=traces {
        for m in 1..machines {
            let lane = (m - 1, machines - 1);
            let Some(v) = value(m, row) else {
                let empty = |why: &str| Bar { lane, ..Bar::new(row, Vec::new()).end(why) };
                bars.extend(withheld(all, gain, m).map(empty));
                continue;
            };
            highest = highest.max(v);
            let (number, colour) = (format!("{v:.2}"), COLOURS[m - 1]);
            // Behind the end of a bar just below 1 the line would go through it.
            let bar = match (0.8..1.0).contains(&v) && machines < 5 {
                true => Bar::new(row, vec![Part { label: number, ..Part::new(v, colour) }]),
                false => Bar::new(row, vec![Part::new(v, colour)]).end(number),
            };
            // From the least to the largest of the traces.
            let spread = all.spread(gain, m).filter(|_| row == traces);
            let interval = spread.map(|[least, most]| (least, most));
            bars.push(Bar { lane, interval, ..bar });
        }
    }
    let names = all.traces[..traces].iter().map(|t| Words::from(shortened(t, 24)));
    let y = Axis::names(names.chain([Words::bold(MEAN)]));
    let x = Axis::new(title, Scale::from_zero(1.08 * highest));
    Panel::new(x, y).dashed(Rule::X(1.0), Colour::NOTE).mark(Mark::Bars(bars))
}

/// The means alone.
pub fn means_table(all: &SpeedUp) -> Table {
    let (first, gains) = (&all.machines[0].label, gains(all));
    let column = |gain: &Gain| {
        let group = format!("{} over {first}", name(*gain));
        [MEAN, "least", "largest"].map(|head| Column::fixed(head, 3).group(group.clone()))
    };
    let columns = [Column::text("machine")].into_iter().chain(gains.iter().flat_map(column));
    let row = |m: usize| {
        let label = Cell::from(all.machines[m].label.as_str());
        let of = |gain: &Gain| {
            let spread = all.spread(*gain, m);
            let ends = [0, 1].map(|end| Cell::from(spread.map(|both| both[end])));
            [all.mean(*gain, m).into()].into_iter().chain(ends)
        };
        [label].into_iter().chain(gains.iter().flat_map(of)).collect::<Vec<_>>()
    };
    Table::new(columns).rows((1..all.machines.len()).map(row))
}

/// Speed-ups and energy gains: a row a trace and machine, then the means.
pub fn table(all: &SpeedUp) -> Table {
    let first = &all.machines[0].label;
    let machines = all.machines.len();
    let gains = gains(all);
    let mut columns = vec![
        Column::text("trace"),
        Column::text("machine"),
        Column::fixed("per second", 1),
        Column::fixed("mJ each", 3),
    ];
    let column = |gain: &Gain| Column::fixed(format!("{} over {first}", name(*gain)), 3);
    columns.extend(gains.iter().map(column));
    let row = |t: usize, m: usize| -> Vec<Cell> {
        let machine = &all.machines[m];
        let speed = machine.speeds[t];
        let first = [
            all.traces[t].as_str().into(),
            machine.label.as_str().into(),
            speed.map(|s| s.fps).into(),
            speed.map(|s| s.energy_j * 1e3).into(),
        ];
        first.into_iter().chain(gains.iter().map(|g| all.gain(*g, m, t).into())).collect()
    };
    let mean = |m: usize| -> Vec<Cell> {
        let none = || Cell::from(None::<f64>);
        let first = [MEAN.into(), all.machines[m].label.as_str().into(), none(), none()];
        first.into_iter().chain(gains.iter().map(|g| all.mean(*g, m).into())).collect()
    };
    let of_traces = (0..all.traces.len()).flat_map(|t| (0..machines).map(move |m| row(t, m)));
    Table::new(columns).rows(of_traces.chain((0..machines).map(mean)))
}

/// `speedup.csv`: the table with exact numbers.
pub fn csv(all: &SpeedUp) -> Vec<u8> {
    let mut table = Table::record(
        "trace machine fps energy_pj speedup energy_gain speedup_least speedup_largest \
         speedup_deviation energy_gain_least energy_gain_largest energy_gain_deviation",
    );
    let none = || Cell::from(None::<f64>);
    for m in 0..all.machines.len() {
        let label = all.machines[m].label.as_str();
        let end =
            |gain, end: usize| Cell::from(all.spread(gain, m).map(|both: [f64; 2]| both[end]));
        for (t, trace) in all.traces.iter().enumerate() {
            let speed = all.machines[m].speeds[t];
            table.row([
                trace.as_str().into(),
                label.into(),
                speed.map(|s| s.fps).into(),
                speed.map(|s| s.energy_j * 1e12).into(),
                all.gain(Gain::Speed, m, t).into(),
                all.gain(Gain::Energy, m, t).into(),
                none(),
                none(),
                none(),
                none(),
                none(),
                none(),
            ]);
        }
        table.row([
            MEAN.into(),
            label.into(),
            Cell::from(None::<f64>),
            Cell::from(None::<f64>),
            all.mean(Gain::Speed, m).into(),
            all.mean(Gain::Energy, m).into(),
            end(Gain::Speed, 0),
            end(Gain::Speed, 1),
            all.deviation(Gain::Speed, m).into(),
            end(Gain::Energy, 0),
            end(Gain::Energy, 1),
            all.deviation(Gain::Energy, m).into(),
        ]);
    }
    table.csv()
}

/// The same as JSON.
pub fn json(all: &SpeedUp) -> Value {
    let traces = 0..all.traces.len();
    let machine = |m: usize| {
        let of = |gain| traces.clone().map(|t| all.gain(gain, m, t)).collect::<Vec<_>>();
        let fps = all.machines[m].speeds.iter().map(|s| s.map(|s| s.fps));
        json!({
            "label": all.machines[m].label,
            "fps": fps.collect::<Vec<_>>(),
            "speedup": of(Gain::Speed),
            "speedup_geomean": all.mean(Gain::Speed, m),
            "energy_gain": of(Gain::Energy),
            "energy_gain_geomean": all.mean(Gain::Energy, m),
            "speedup_spread": all.spread(Gain::Speed, m),
            "speedup_deviation": all.deviation(Gain::Speed, m),
            "energy_gain_spread": all.spread(Gain::Energy, m),
            "energy_gain_deviation": all.deviation(Gain::Energy, m),
        })
    };
    json!({
        "baseline": all.machines[0].label,
        "traces": all.traces,
        "machines": (0..all.machines.len()).map(machine).collect::<Vec<_>>(),
    })
}
