//! Fixed λ without pruning: what quality and display power become.

use super::{Story, around};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::watt_unit;
use crate::plot::{Canvas, Drawn, GRID, Panel, Scale, palette};
use powergs_optimize::plan::{Outcome, Role};

const NAME: &str = "sweep";
const TITLE: &str = "λ without pruning";

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let rows: Vec<(f64, &Outcome)> = story
        .done
        .iter()
        .filter_map(|o| match o.role {
            // Zero has no place on a logarithmic axis; the dense model stands for it.
            Role::Sweep(_) => o.lambda.filter(|l| *l > 0.0).map(|l| (l, o)),
            _ => None,
        })
        .collect();
    if rows.len() < 2 {
        return Ok(None);
    }
    let what = "test views";
    let drawing = story.page(NAME, TITLE, what).draw(|canvas| {
        let left = Panel { left: 130.0, top: 130.0, right: 620.0, bottom: 630.0 };
        let right = Panel { left: 760.0, right: 1240.0, ..left };
        let psnr = |o: &Outcome| o.test.quality.psnr_db;
        panel(canvas, left, &rows, "PSNR, dB", psnr, palette::BLUE)?;
        let most = rows.iter().map(|(_, o)| o.test.display_w).fold(0.0, f64::max);
        let (per_watt, unit) = watt_unit(most);
        let name = format!("display power, {unit}");
        let power = |o: &Outcome| per_watt * o.test.display_w;
        panel(canvas, right, &rows, &name, power, palette::ORANGE)
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn panel(
    canvas: &Canvas,
    panel: Panel,
    rows: &[(f64, &Outcome)],
    name: &str,
    of: impl Fn(&Outcome) -> f64,
    colour: plotters::style::RGBColor,
) -> Drawn {
    let low = rows.iter().map(|r| r.0).fold(f64::INFINITY, f64::min);
    let high = rows.iter().map(|r| r.0).fold(0.0, f64::max);
    let x = Scale::logarithmic(low, high, panel.horizontal());
    let y = around(rows.iter().map(|r| of(r.1)), 0.1, panel.vertical());
    panel.vertical_axis(canvas, &y, name)?;
    for tick in x.ticks(5) {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &x, &x.ticks(5), "λ, 1/W (logarithmic)")?;
    let points: Vec<(f64, f64)> = rows.iter().map(|r| (x.at(r.0), y.at(of(r.1)))).collect();
    canvas.line(&points, colour, 3)?;
    points.into_iter().try_for_each(|p| canvas.dot(p, 6, colour))
}
