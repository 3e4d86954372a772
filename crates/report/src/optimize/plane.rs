//! The display-render plane: models of equal quality, the curve through them, lines of equal total
//! power.

use super::{Area, Story, around, clear, colour, dashed, label, labels};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::{significant, watt_unit};
use crate::plot::{
    Align, Canvas, Drawn, GREY, GRID, INK, Panel, Scale, legend, palette, text_width,
};
use powergs_optimize::plan::{Outcome, Role};

const NAME: &str = "plane";
const TITLE: &str = "Display against rendering power";
/// Lines of equal total power.
const ISO_LINES: usize = 6;
/// Points of the curve.
const STEPS: u32 = 100;

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let shown: Vec<&Outcome> = story
        .done
        .iter()
        .filter(|o| matches!(o.role, Role::Sample | Role::Final | Role::Dense))
        .collect();
    if story.samples().next().is_none() {
        return Ok(None);
    }
    let target = story
        .target
        .map_or(String::new(), |t| format!("target {:.2} dB, SSIM {:.4}", t.psnr_db, t.ssim));
    let drawing = story.page(NAME, TITLE, &target).draw(|canvas| draw(canvas, story, &shown))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn draw(canvas: &Canvas, story: &Story<'_>, shown: &[&Outcome]) -> Drawn {
    let panel = Panel { left: 150.0, top: 150.0, right: 1240.0, bottom: 630.0 };
    let most = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let (display, render) =
        (|o: &&Outcome| per_watt * o.watts.display_w, |o: &&Outcome| per_watt * o.watts.render_w);
    let x = around(shown.iter().map(display), 0.12, panel.horizontal());
    let y = around(shown.iter().map(render), 0.12, panel.vertical());
    panel.vertical_axis(canvas, &y, &format!("rendering power, {unit}"))?;
    for tick in x.ticks(8) {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &x, &x.ticks(8), &format!("display power, {unit}"))?;
    let mut taken = iso_power(canvas, (&x, &y), panel, &unit)?;
    if let Ok(fit) = &story.conclusion.fit {
        let curve: Vec<(f64, f64)> = (0..=STEPS)
            .map(|i| {
                let t = f64::from(i) / f64::from(STEPS);
                let rho = fit.rho_min() + t * (fit.rho_max() - fit.rho_min());
                (x.at(per_watt * fit.display_w(rho)), y.at(per_watt * fit.render_w(rho)))
            })
            .collect();
        canvas.line(&curve, palette::BLUE, 3)?;
        taken.extend(curve.iter().map(|(x, y)| [x - 3.0, y - 3.0, x + 3.0, y + 3.0]));
    }
    let mut points = Vec::new();
    for outcome in shown {
        let at = (x.at(display(outcome)), y.at(render(outcome)));
        let missed = outcome.role == Role::Sample && !outcome.passed;
        let ink = if missed { palette::GREY } else { colour(outcome.role) };
        canvas.dot(at, if outcome.role == Role::Final { 9 } else { 7 }, ink)?;
        let text = label(outcome);
        points.push((at, if missed { format!("{text} (missed)") } else { text }, INK));
    }
    labels(canvas, &points, (panel.left, panel.right), taken)?;
    let entries = [
        ("dense", INK),
        ("samples", palette::SKY),
        ("iso-quality curve (fit)", palette::BLUE),
        ("ours", palette::VERMILION),
        ("equal total power", palette::PALE),
    ];
    legend(canvas, 40.0, 112.0, &entries)
}

/// Lines on which display and rendering power add up to the same, with the sum. Where the sums
/// stand.
fn iso_power(
    canvas: &Canvas,
    (x, y): (&Scale, &Scale),
    panel: Panel,
    unit: &str,
) -> Result<Vec<Area>, String> {
    let mut taken = Vec::new();
    let (low, high) = (x.low() + y.low(), x.high() + y.high());
    for i in 1..=ISO_LINES {
        let total = low + (high - low) * i as f64 / (ISO_LINES + 1) as f64;
        // From the left or the top edge to the bottom or the right one.
        let x0 = x.low().max(total - y.high());
        let x1 = x.high().min(total - y.low());
        let (from, to) = ((x.at(x0), y.at(total - x0)), (x.at(x1), y.at(total - x1)));
        dashed(canvas, from, to, palette::PALE)?;
        let text = format!("{} {unit}", significant(total));
        let at = (to.0 - 8.0, (to.1 - 12.0).min(panel.bottom - 12.0));
        let area = [at.0 - text_width(&text), at.1 - 10.0, at.0, at.1 + 10.0];
        clear(canvas, area)?;
        canvas.text(&text, at, Align::Right, GREY)?;
        taken.push(area);
    }
    Ok(taken)
}
