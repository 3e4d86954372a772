//! Quality against total power, all models of the run.

use super::{Story, around, colour, dashed, label, labels};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::watt_unit;
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Panel, palette};
use powergs_optimize::plan::{Outcome, Role};

const NAME: &str = "quality";
const TITLE: &str = "Quality against total power";

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let shown: Vec<&Outcome> =
        story.done.iter().filter(|o| !matches!(o.role, Role::Sweep(_))).collect();
    if shown.len() < 2 {
        return Ok(None);
    }
    let what = "test views; dashed: the target of the gate views";
    let drawing = story.page(NAME, TITLE, what).draw(|canvas| {
        let left = Panel { left: 120.0, top: 130.0, right: 630.0, bottom: 630.0 };
        let right = Panel { left: 750.0, right: 1250.0, ..left };
        let target = story.target;
        panel(canvas, left, &shown, "PSNR, dB", |o| o.test.quality.psnr_db, {
            target.map(|t| t.psnr_db)
        })?;
        panel(canvas, right, &shown, "SSIM", |o| o.test.quality.ssim, target.map(|t| t.ssim))
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn panel(
    canvas: &Canvas,
    panel: Panel,
    shown: &[&Outcome],
    name: &str,
    of: impl Fn(&Outcome) -> f64,
    target: Option<f64>,
) -> Drawn {
    // Against its own renders the dense model is far above everything: it is not on this scale.
    let highest = |o: &&&Outcome| o.role != Role::Dense || of(o) < 70.0;
    let (on, off): (Vec<&&Outcome>, Vec<&&Outcome>) = shown.iter().partition(highest);
    let most = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let power = |o: &Outcome| per_watt * o.watts.total_w();
    let x = around(shown.iter().map(|o| power(o)), 0.12, panel.horizontal());
    let y = around(on.iter().map(|o| of(o)).chain(target), 0.10, panel.vertical());
    panel.vertical_axis(canvas, &y, name)?;
    for tick in x.ticks(5) {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &x, &x.ticks(5), &format!("total power, {unit}"))?;
    if let Some(target) = target.filter(|t| *t > 0.0) {
        let height = y.at(target);
        dashed(canvas, (panel.left, height), (panel.right, height), palette::GREY)?;
    }
    let mut points = Vec::new();
    for outcome in &on {
        let at = (x.at(power(outcome)), y.at(of(outcome)));
        canvas.dot(at, if outcome.role == Role::Final { 9 } else { 7 }, colour(outcome.role))?;
        points.push((at, label(outcome), INK));
    }
    // Those that matter get their labels first.
    points.sort_by_key(|(_, text, _)| text.starts_with('ρ'));
    labels(canvas, &points, (panel.left, panel.right), Vec::new())?;
    for outcome in off {
        let at = x.at(power(outcome));
        let text = format!("{}: {:.0} dB, above", label(outcome), of(outcome));
        canvas.line(&[(at, panel.top), (at, panel.top + 22.0)], INK, 3)?;
        canvas.text(&text, (at - 10.0, panel.top + 10.0), Align::Right, GREY)?;
    }
    Ok(())
}
