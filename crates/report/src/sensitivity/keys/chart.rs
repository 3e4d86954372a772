//! A tornado for each measure: elasticities at the left, and at the right what half and double of a
//! key, or another name, do.

use crate::format::{rate, shortened, significant};
use crate::sensitivity::chart::both_ways;
use powergs_chart::{Axis, Chart, Colour, Entry, Mark, Panel};
use powergs_study::findings::cost::Cost;
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, Reach, Shape};

/// The measures that have a chart, with its file name and title.
const CHARTS: [(Measure, &str, &str); 3] = [
    (Measure::Fps, "tornado_fps", "What every key moves: frames per second"),
    (Measure::Energy, "tornado_energy", "What every key moves: energy per frame"),
    (Measure::Area, "tornado_area", "What every key moves: area"),
];
/// Bars that a slide has room for.
const MOST: usize = 18;
/// Elasticity; half, double or another name.
const COLOURS: [Colour; 3] = [Colour::GREEN, Colour::BLUE, Colour::ORANGE];
/// An elasticity that holds on one side only.
const KINKED: Colour = Colour::GREY;
/// A scale ends here at the latest, percent.
const WIDEST: f64 = 150.0;

/// One bar of the chart.
struct ChartBar {
    label: String,
    elasticity: Option<f64>,
    /// Whether it is the same on both sides.
    smooth: bool,
    /// Percent, down and up.
    change: [Option<f64>; 2],
    effect: f64,
}

/// The charts; without one for a measure that nothing moves.
pub fn charts(all: &Keys) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (measure, name, title) in CHARTS {
        let mut bars: Vec<ChartBar> = all.rows.iter().filter_map(|row| bar(row, measure)).collect();
        bars.sort_by(|a, b| b.effect.total_cmp(&a.effect));
        bars.truncate(MOST);
        if !bars.is_empty() {
            charts.push(chart(all, measure, name, title, &bars));
        }
    }
    charts
}

/// The bar of a key; of names the one that moves most. `None` if nothing is to be seen.
fn bar(row: &KeyRow, measure: Measure) -> Option<ChartBar> {
    let elasticity = row.elasticity(measure).map(|e| e.value);
    let smooth = row.shape(measure) == Shape::Smooth;
    let percent = |change: Option<f64>| change.map(|c| c * 100.0);
    let (label, change) = if row.is_number() {
        (row.key.clone(), row.far(measure).map(percent))
    } else {
        let base = Cost::mean(&row.base);
        let names = row.reached(Reach::Name);
        let changes = names.filter_map(|(t, o)| Some((t, measure.change(&o, &base)?)));
        let (step, change) = changes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        (format!("{}={}", row.key, step.value), [None, percent(Some(change))])
    };
    let effect = change.into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
    (effect >= 0.05).then_some(ChartBar { label, elasticity, smooth, change, effect })
}

fn chart(
    all: &Keys,
    measure: Measure,
    name: &'static str,
    title: &'static str,
    bars: &[ChartBar],
) -> Chart {
    let what = measure.title();
    let names = Axis::names(bars.iter().map(|b| b.label.as_str()));
    let slopes = |b: &ChartBar| if b.smooth { [b.elasticity, None] } else { [None, b.elasticity] };
    let elasticities: Vec<[Option<f64>; 2]> = bars.iter().map(slopes).collect();
    let changes: Vec<[Option<f64>; 2]> = bars.iter().map(|b| b.change).collect();
    let x = both_ways(&format!("elasticity of {what}"), &elasticities, 0.1, WIDEST);
    let colours = [COLOURS[0], KINKED];
    let left = Panel::new(x, names.clone()).mark(Mark::Tornado { rows: elasticities, colours });
    let x = both_ways(&format!("change of {what}, %"), &changes, 1.0, WIDEST);
    let colours = [COLOURS[1], COLOURS[2]];
    let right = Panel::new(x, names.hidden()).mark(Mark::Tornado { rows: changes, colours });
    let names = ["elasticity", "key at half", "key doubled, or another name"];
    let kinked = bars.iter().any(|b| !b.smooth && b.elasticity.is_some());
    let kinked = kinked.then(|| Entry::fill("elasticity, kinked or one-sided", KINKED));
    let entries = names.into_iter().zip(COLOURS).map(|(name, colour)| Entry::fill(name, colour));
    Chart::new(name, title, subtitle(all))
        .legend(entries.chain(kinked))
        .columns(2)
        .panel(left)
        .panel(right)
}

fn subtitle(all: &Keys) -> String {
    let note = all.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let names: Vec<&str> = all.traces.iter().map(|t| t.name.as_str()).collect();
    let outcomes: Vec<Cost> = all.traces.iter().map(|t| t.base).collect();
    let base = Cost::mean(&outcomes);
    let area = base.area_mm2.map_or(String::new(), |a| format!(", {} mm²", significant(a)));
    format!(
        "{note}{} on {}: {} FPS, {} mJ a frame, {} mW at {} FPS{area}",
        shortened(&names.join(", "), 34),
        shortened(&all.machine, 20),
        significant(base.fps()),
        significant(base.energy_mj()),
        significant(base.power_w * 1e3),
        rate(all.display_fps),
    )
}
