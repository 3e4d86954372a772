//! Where the power goes before and after: a bar per model, rendering by stage, and the display.

use plotters::style::RGBColor;

use super::{Story, label};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::{engineering, watt_unit};
use crate::plot::{Align, Canvas, Drawn, GRID, INK, Panel, Scale, legend, palette};
use powergs_core::action::Stage;
use powergs_optimize::plan::{Outcome, Role};

const NAME: &str = "breakdown";
const TITLE: &str = "Where the power goes";

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let ours = story.best().map(|o| o.name.clone());
    let is_shown = |o: &&Outcome| {
        let other = matches!(o.role, Role::Dense | Role::Baseline(_) | Role::External(_));
        other || Some(&o.name) == ours.as_ref()
    };
    let shown: Vec<&Outcome> = story.done.iter().filter(is_shown).collect();
    if shown.len() < 2 {
        return Ok(None);
    }
    let what = format!("display {}", story.display);
    let drawing = story.page(NAME, TITLE, &what).draw(|canvas| draw(canvas, &shown))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn stage_colour(stage: Stage) -> RGBColor {
    match stage {
        Stage::Preprocessing => palette::GREEN,
        Stage::Sorting => palette::ORANGE,
        Stage::Rendering => palette::VERMILION,
        Stage::Standby => palette::GREY,
    }
}

fn draw(canvas: &Canvas, shown: &[&Outcome]) -> Drawn {
    let panel = Panel { left: 210.0, top: 150.0, right: 1100.0, bottom: 630.0 };
    let highest = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(highest);
    let x = Scale::from_zero(per_watt * highest, panel.horizontal());
    let stages = Stage::ALL.map(|s| (s.name(), stage_colour(s)));
    let entries: Vec<_> = stages.into_iter().chain([("display", palette::SKY)]).collect();
    legend(canvas, 40.0, 112.0, &entries)?;
    for tick in x.ticks(8) {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &x, &x.ticks(8), &format!("power, {unit}"))?;
    let slot = (panel.bottom - panel.top) / shown.len() as f64;
    let half = (0.32 * slot).min(36.0);
    for (i, outcome) in shown.iter().enumerate() {
        let middle = panel.top + (i as f64 + 0.5) * slot;
        let name = if outcome.role == Role::Sample { "ours".into() } else { label(outcome) };
        canvas.text(&name, (panel.left - 14.0, middle), Align::Right, INK)?;
        let parts = Stage::ALL.map(|s| (outcome.watts.parts.stage_w(s), stage_colour(s)));
        let mut from = 0.0;
        for (watts, ink) in parts.into_iter().chain([(outcome.watts.display_w, palette::SKY)]) {
            let (a, b) = (x.at(per_watt * from), x.at(per_watt * (from + watts)));
            if b - a >= 0.5 {
                canvas.fill((a, middle - half), (b, middle + half), ink)?;
            }
            from += watts;
        }
        let total = engineering(from, "W");
        canvas.text(&total, (x.at(per_watt * from) + 10.0, middle), Align::Left, INK)?;
    }
    Ok(())
}
