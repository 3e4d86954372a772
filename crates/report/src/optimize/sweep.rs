//! Fixed λ without pruning: what quality and display power become.

use super::Story;
use crate::format::watt_unit;
use powergs_chart::{Axis, Chart, Colour, Line, Panel, Place, Points, Scale, Size};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;

const NAME: &str = "sweep";
const TITLE: &str = "λ without pruning";

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
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
        return None;
    }
    let most = rows.iter().map(|(_, o)| o.test.display_w).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let name = format!("display power, {unit}");
    let psnr = panel(&rows, "PSNR, dB", |o| o.test.quality.psnr_db, Colour::BLUE);
    let power = panel(&rows, &name, |o| per_watt * o.test.display_w, Colour::ORANGE);
    Some(story.chart(NAME, TITLE, "test views").columns(2).panel(psnr).panel(power))
}

fn panel(
    rows: &[(f64, &Outcome)],
    name: &str,
    of: impl Fn(&Outcome) -> f64,
    colour: Colour,
) -> Panel {
    let low = rows.iter().map(|r| r.0).fold(f64::INFINITY, f64::min);
    let high = rows.iter().map(|r| r.0).fold(0.0, f64::max);
    let x = Axis::new("λ, 1/W", Scale::logarithmic(low, high)).ticks(5);
    let y = Axis::new(name, Scale::around(rows.iter().map(|r| of(r.1)), 0.1));
    let points: Vec<Place> = rows.iter().map(|r| (r.0, of(r.1))).collect();
    Panel::new(x, y).line(Line::curve(points.clone(), colour)).points(Points::dots(
        points,
        colour,
        Size::Large,
    ))
}
