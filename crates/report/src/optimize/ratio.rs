//! What is saved as the panel draws more against the accelerator.

use super::{Story, around};
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Canvas, Drawn, GRID, INK, Panel, Scale, legend, palette};
use powergs_optimize::study::{RATIOS, RatioRow};

const NAME: &str = "ratio";
const TITLE: &str = "Saving against the display-to-render ratio";

type Series = (&'static str, plotters::style::RGBColor, fn(&RatioRow) -> Option<f64>);
/// What is compared with.
const SERIES: [Series; 3] = [
    ("over render-only", palette::ORANGE, |r| r.over_render_only),
    ("over display-only", palette::BLUE, |r| r.over_display_only),
    ("over the dense model", INK, |r| Some(r.over_dense)),
];

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    if story.ratios.is_empty() {
        return Ok(None);
    }
    let what = "the fitted optimum of each ratio";
    let drawing = story.page(NAME, TITLE, what).draw(|canvas| draw(canvas, &story.ratios))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn draw(canvas: &Canvas, rows: &[RatioRow]) -> Drawn {
    let panel = Panel { left: 150.0, top: 150.0, right: 1240.0, bottom: 630.0 };
    let values = rows.iter().flat_map(|r| SERIES.iter().filter_map(move |s| (s.2)(r)));
    let y = around(values.map(|v| 100.0 * v).chain([0.0]), 0.06, panel.vertical());
    let x = Scale::exact(RATIOS.0, RATIOS.1, panel.horizontal());
    panel.vertical_axis(canvas, &y, "power saved, %")?;
    for tick in x.ticks(10) {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    let name = "display power over rendering power, dense model";
    panel.horizontal_axis(canvas, &x, &x.ticks(10), name)?;
    let entries: Vec<_> = SERIES.iter().map(|s| (s.0, s.1)).collect();
    legend(canvas, 40.0, 112.0, &entries)?;
    for (_, colour, of) in SERIES {
        let point = |r: &RatioRow| Some((x.at(r.ratio), y.at(100.0 * of(r)?)));
        let points: Vec<(f64, f64)> = rows.iter().filter_map(point).collect();
        if points.len() > 1 {
            canvas.line(&points, colour, 3)?;
        }
        points.into_iter().try_for_each(|p| canvas.dot(p, 5, colour))?;
    }
    Ok(())
}
