//! Models against the axis of the machine that matters most: the least watts of each cell.

use std::collections::BTreeMap;

use super::words;
use crate::format::{engineering, shortened, significant, watt_unit};
use powergs_chart::{Axis, Cell, Chart, Colour, Entry, Mark, Panel, Symbol, Words, ends};
use powergs_codesign::Finished;
use powergs_codesign::compare::Way;
use powergs_codesign::pricing::Fate;

const NAME: &str = "map";
const TITLE: &str = "Models against machines";
const RIDGE: Colour = Colour::ORANGE;
const JOINT: Colour = Colour::VERMILION;
/// Models that a chart has room for: those with the least watts.
const MOST: usize = 16;

/// The least watts of a model at each value of an axis, within the budget.
type MapLane = BTreeMap<String, f64>;

/// The map; `None` where no axis of the machine has two values.
pub(super) fn chart(finished: &Finished) -> Option<Chart> {
    let lanes = |axis: usize| -> Vec<MapLane> {
        let lane = |row: &powergs_codesign::pricing::Row| {
            let mut lane = MapLane::new();
            for (point, fate) in &row.pairs {
                // The base machine is on no axis.
                let on_axes = row.settings.get(point).filter(|_| point.is_some());
                let (Fate::Priced(prices), Some(settings)) = (fate, on_axes) else {
                    continue;
                };
                // Models without a codebook are on no axis of one.
                if settings[axis].is_empty() {
                    continue;
                }
                let price = &prices[0][0];
                if finished.budget.limit(price).is_some() {
                    continue;
                }
                let least = lane.entry(settings[axis].clone()).or_insert(f64::INFINITY);
                *least = least.min(price.total_w);
            }
            lane
        };
        finished.rows.iter().map(lane).collect()
    };
    // The axis along which the best of a model changes most.
    let spread = |lanes: &[MapLane]| -> f64 {
        let of = |lane: &MapLane| {
            let (low, high) = ends(lane.values().copied());
            if lane.len() > 1 { high - low } else { 0.0 }
        };
        lanes.iter().map(of).fold(0.0, f64::max)
    };
    let axes = words::axes(finished);
    let all = axes.into_iter().map(|(i, name)| (name, lanes(i)));
    let (name, lanes) = all
        .filter(|(_, lanes)| lanes.iter().any(|lane| lane.len() > 1))
        .max_by(|a, b| spread(&a.1).total_cmp(&spread(&b.1)))?;
    Some(drawn(finished, name, &lanes))
}

fn drawn(finished: &Finished, name: &str, lanes: &[MapLane]) -> Chart {
    let best = |place: usize| lanes[place].values().copied().fold(f64::INFINITY, f64::min);
    let mut order: Vec<usize> = (0..lanes.len()).filter(|p| !lanes[*p].is_empty()).collect();
    order.sort_by(|a, b| best(*a).total_cmp(&best(*b)));
    order.truncate(MOST);
    let mut values: Vec<&String> = order.iter().flat_map(|p| lanes[*p].keys()).collect();
    values.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
    values.dedup();
    let (low, high) = ends(order.iter().flat_map(|p| lanes[*p].values().copied()));
    let (per_watt, unit) = watt_unit(high);
    let joint = finished.of(Way::Joint).and_then(|c| c.found.as_ref().ok()).map(|f| f.pair);
    let mut cells = Vec::new();
    for (up, place) in order.iter().rev().enumerate() {
        for (column, value) in values.iter().enumerate() {
            let Some(&watts) = lanes[*place].get(*value) else { continue };
            let is_best = watts == best(*place);
            let is_joint = is_best && joint.is_some_and(|(model, _)| model == *place);
            cells.push(Cell {
                column,
                row: up,
                colour: Colour::at(if high > low { (watts - low) / (high - low) } else { 0.5 }),
                label: significant(per_watt * watts),
                dot: match (is_joint, is_best) {
                    (true, _) => Some((JOINT, true)),
                    (false, true) => Some((RIDGE, false)),
                    (false, false) => None,
                },
            });
        }
    }
    let mut across = Axis::names(values.iter().map(|v| Words::note(shortened(v, 14))));
    across.title = name.to_owned();
    let model = |place: &usize| Words::note(shortened(&words::model(finished, *place), 30));
    let mut up = Axis::names(order.iter().rev().map(model));
    up.title = "model".into();
    let mut panel = Panel::new(across, up).mark(Mark::Heat(cells));
    panel.colours = Some((engineering(low, "W"), engineering(high, "W")));
    let about = format!(
        "least {unit} within the budget at every value of {name}, other axes at their best"
    );
    Chart::new(NAME, TITLE, about)
        .legend([
            Entry::new("best value for the model", Symbol::Dot(RIDGE)),
            Entry::new("joint model", Symbol::Dot(JOINT)),
        ])
        .panel(panel)
}

/// The number that a value begins with, so that 8 comes before 16.
fn number(value: &str) -> f64 {
    let head = value.split(' ').next().unwrap_or_default();
    let unit = match value.split(' ').nth(1) {
        Some("KiB") => 1024.0,
        Some("MiB") => 1024.0 * 1024.0,
        Some("MHz") => 1e6,
        Some("GHz") => 1e9,
        _ => 1.0,
    };
    head.parse::<f64>().map_or(f64::INFINITY, |x| unit * x)
}
