//! Power and HVSQ of the regions of the screen: FR-Render with the colour filter against ours.

use super::{Show, colour};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::{significant, watt_unit};
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Panel, Scale, legend, palette};
use powergs_frame::fovea::{LEVELS, REGIONS};
use powergs_optimize::foveated::Method;
use powergs_optimize::results::FovealRecord;

const NAME: &str = "foveated_regions";
const TITLE: &str = "Power and quality of the regions";

pub(super) fn chart(show: &Show<'_>) -> Result<Option<Chart>, ReportError> {
    let (r, variant) = (show.results, show.variant());
    let methods = [Method::RtgsD22, Method::PowerGs];
    let shown: Vec<&FovealRecord> =
        methods.into_iter().filter_map(|m| r.foveal(m, variant)).collect();
    if shown.is_empty() {
        return Ok(None);
    }
    let what = format!("variant {variant}, R1 where somebody looks to R4 far out");
    let fps = r.fps;
    let drawing = show.page(NAME, TITLE, &what).draw(|canvas| draw(canvas, &shown, fps))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

type Value<'a> = &'a dyn Fn(&FovealRecord, usize) -> Option<f64>;

fn draw(canvas: &Canvas, shown: &[&FovealRecord], fps: f64) -> Drawn {
    let left = Panel { left: 120.0, top: 180.0, right: 620.0, bottom: 600.0 };
    let right = Panel { left: 760.0, right: 1240.0, ..left };
    let entries: Vec<_> = shown.iter().map(|f| (f.method.name(), colour(f.method))).collect();
    legend(canvas, 40.0, 112.0, &entries)?;
    let watts = |f: &FovealRecord, i: usize| {
        (f.tiles[i] > 0.0).then_some(f.region_j[i] * fps).filter(|w| w.is_finite())
    };
    let most = shown.iter().flat_map(|f| (0..LEVELS).filter_map(move |i| watts(f, i)));
    let (per_watt, unit) = watt_unit(most.fold(0.0, f64::max));
    let power = |f: &FovealRecord, i: usize| watts(f, i).map(|w| per_watt * w);
    let quality = |f: &FovealRecord, i: usize| f.hvsq[i].map(|v| 1e5 * v);
    let heads =
        ["sorting and rendering on the machine", "HVSQ of the shown frames, less is better"];
    for (panel, head) in [left, right].into_iter().zip(heads) {
        canvas.text(head, (panel.left, panel.top - 24.0), Align::Left, GREY)?;
    }
    bars(canvas, left, shown, (&power, &format!("power, {unit}")))?;
    bars(canvas, right, shown, (&quality, "HVSQ, 1e-5"))?;
    let note = "Without what belongs to no region: preprocessing, standing power, the filter.";
    canvas.text(note, (left.left, 680.0), Align::Left, GREY)
}

fn bars(
    canvas: &Canvas,
    panel: Panel,
    shown: &[&FovealRecord],
    (value, name): (Value<'_>, &str),
) -> Drawn {
    let most = shown.iter().flat_map(|f| (0..LEVELS).filter_map(|i| value(f, i)));
    let y = Scale::from_zero(1.05 * most.fold(0.0, f64::max), panel.vertical());
    panel.vertical_axis(canvas, &y, name)?;
    let slot = (panel.right - panel.left) / LEVELS as f64;
    let width = (0.94 * slot / shown.len() as f64).min(0.5 * slot);
    for (i, region) in REGIONS.iter().enumerate() {
        let middle = panel.left + (i as f64 + 0.5) * slot;
        canvas.text(region, (middle, panel.bottom + 22.0), Align::Centre, INK)?;
        let begin = middle - width * shown.len() as f64 / 2.0;
        let mut is_empty = true;
        for (j, f) in shown.iter().enumerate() {
            let Some(v) = value(f, i) else { continue };
            is_empty = false;
            let (x, top) = (begin + j as f64 * width, y.at(v));
            canvas.fill((x + 2.0, top), (x + width - 2.0, panel.bottom), colour(f.method))?;
            let at = (x + width / 2.0, top - 12.0);
            canvas.text(&significant(v), at, Align::Centre, INK)?;
        }
        if is_empty {
            let at = (middle, panel.bottom - 14.0);
            canvas.text("none", at, Align::Centre, palette::GREY)?;
        }
    }
    Ok(())
}
