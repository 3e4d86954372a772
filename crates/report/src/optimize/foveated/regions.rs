//! Power and HVSQ of the regions of the screen: FR-Render with the colour filter against ours.

use super::{Show, colour};
use crate::format::{significant, watt_unit};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Side, Words};
use powergs_frame::fovea::{LEVELS, REGIONS};
use powergs_optimize::foveated::Method;
use powergs_optimize::results::FovealRecord;

const NAME: &str = "foveated_regions";
const TITLE: &str = "Power and quality of the regions";

pub(super) fn chart(show: &Show<'_>) -> Option<Chart> {
    let (r, variant) = (show.results, show.variant());
    let methods = [Method::RtgsD22, Method::PowerGs];
    let shown: Vec<&FovealRecord> =
        methods.into_iter().filter_map(|m| r.foveal(m, variant)).collect();
    if shown.is_empty() {
        return None;
    }
    let watts = |f: &FovealRecord, i: usize| {
        (f.tiles[i] > 0.0).then_some(f.region_j[i] * r.fps).filter(|w| w.is_finite())
    };
    let most = shown.iter().flat_map(|f| (0..LEVELS).filter_map(move |i| watts(f, i)));
    let (per_watt, unit) = watt_unit(most.fold(0.0, f64::max));
    let power = |f: &FovealRecord, i: usize| watts(f, i).map(|w| per_watt * w);
    let quality = |f: &FovealRecord, i: usize| f.hvsq[i].map(|v| 1e5 * v);
    let power = panel(&shown, &power, &format!("power, {unit}"));
    let quality = panel(&shown, &quality, "HVSQ, 1e-5");
    let what = format!("variant {variant}, R1 where somebody looks to R4 far out");
    let entries = shown.iter().map(|f| Entry::fill(f.method.name(), colour(f.method)));
    let note = "Without what belongs to no region: preprocessing, standing power, the filter.";
    Some(
        show.chart(NAME, TITLE, &what)
            .legend(entries)
            .columns(2)
            .panel(power.heading(Words::note("sorting and rendering on the machine")))
            .panel(quality.heading(Words::note("HVSQ of the shown frames, less is better")))
            .note(note),
    )
}

type Value<'a> = &'a dyn Fn(&FovealRecord, usize) -> Option<f64>;

/// Upright bars, one for each method side by side in every region.
fn panel(shown: &[&FovealRecord], value: Value<'_>, name: &str) -> Panel {
    let all = shown.iter().flat_map(|f| (0..LEVELS).filter_map(|i| value(f, i)));
    let y = Axis::new(name, Scale::from_zero(1.05 * all.fold(0.0, f64::max)));
    let mut bars = Vec::new();
    let mut panel = Panel::new(Axis::names(REGIONS), y);
    for row in 0..LEVELS {
        let mut is_empty = true;
        for (j, f) in shown.iter().enumerate() {
            let Some(v) = value(f, row) else { continue };
            is_empty = false;
            let bar = Bar::new(row, vec![Part::new(v, colour(f.method))]).end(significant(v));
            bars.push(Bar { lane: (j, shown.len()), ..bar });
        }
        if is_empty {
            let at = (row as f64 + 0.5, 0.0);
            panel = panel.label(Words::new("none", Colour::GREY), at, Side::Above);
        }
    }
    panel.mark(Mark::Bars(bars))
}
