//! What is saved as the panel draws more against the accelerator.

use super::Story;
use powergs_chart::{Axis, Chart, Colour, Entry, Line, Panel, Place, Points, Scale, Size};
use powergs_optimize::ratio_study::{RATIOS, RatioRow};

const NAME: &str = "ratio";
const TITLE: &str = "Saving against the display-to-render ratio";

type Series = (&'static str, Colour, fn(&RatioRow) -> Option<f64>);
/// What is compared with.
const SERIES: [Series; 3] = [
    ("over render-only", Colour::ORANGE, |r| r.over_render_only),
    ("over display-only", Colour::BLUE, |r| r.over_display_only),
    ("over the dense model", Colour::INK, |r| Some(r.over_dense)),
];

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let rows = &story.ratios;
    if rows.is_empty() {
        return None;
    }
    let values = rows.iter().flat_map(|r| SERIES.iter().filter_map(move |s| (s.2)(r)));
    let y = Scale::around(values.map(|v| 100.0 * v).chain([0.0]), 0.06);
    let name = "display power over accelerator power, dense model";
    let x = Axis::new(name, Scale::linear(RATIOS.0, RATIOS.1)).ticks(10);
    let panel = Panel::new(x, Axis::new("power saved, %", y));
    let panel = SERIES.into_iter().fold(panel, |panel, (_, colour, of)| {
        let point = |r: &RatioRow| Some((r.ratio, 100.0 * of(r)?));
        let points: Vec<Place> = rows.iter().filter_map(point).collect();
        panel.line(Line::curve(points.clone(), colour)).points(Points::dots(
            points,
            colour,
            Size::Medium,
        ))
    });
    let entries = SERIES.map(|(name, colour, _)| Entry::fill(name, colour));
    Some(story.chart(NAME, TITLE, "the fitted optimum of each ratio").legend(entries).panel(panel))
}
