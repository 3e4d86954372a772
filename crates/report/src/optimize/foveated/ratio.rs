//! What our foveated model saves as the panel draws more against the accelerator.

use plotters::style::RGBColor;

use super::{Show, around, colour};
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Panel, Scale, legend};
use powergs_optimize::foveated::Method;
use powergs_optimize::results::saving_at;
use powergs_optimize::study::RATIOS;

const NAME: &str = "foveated_ratio";
const TITLE: &str = "Foveated saving against the display-to-render ratio";
/// Places in the range, evenly spaced.
const PLACES: usize = 25;

struct Series {
    name: String,
    colour: RGBColor,
    /// Ratio and saving.
    points: Vec<(f64, f64)>,
}

pub(super) fn chart(show: &Show<'_>) -> Result<Option<Chart>, ReportError> {
    let series = series(show).unwrap_or_default();
    if series.len() < 2 {
        return Ok(None);
    }
    let what = format!("variant {}, models held fixed while the panel is scaled", show.variant());
    let own = show.results.display_to_render;
    let drawing = show.page(NAME, TITLE, &what).draw(|canvas| draw(canvas, &series, own))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn series(show: &Show<'_>) -> Option<Vec<Series>> {
    let (r, variant) = (show.results, show.variant());
    let dense = r.dense()?;
    let ours = r.foveal(Method::PowerGs, variant)?;
    let ours = (ours.display_w, ours.render_w);
    let ratio = |i: usize| RATIOS.0 + (RATIOS.1 - RATIOS.0) * i as f64 / (PLACES - 1) as f64;
    let of = |name: &str, colour: RGBColor, other: (f64, f64)| {
        let at = |i: usize| Some((ratio(i), saving_at(dense, ours, other, ratio(i)).ok()?));
        Series {
            name: format!("over {name}"),
            colour,
            points: (0..PLACES).filter_map(at).collect(),
        }
    };
    let methods = [Method::FrRender, Method::FrDisplay, Method::RtgsD22].into_iter();
    let compared = methods.filter_map(|m| Some((m, r.foveal(m, variant)?)));
    let mut all: Vec<Series> =
        compared.map(|(m, f)| of(m.name(), colour(m), (f.display_w, f.render_w))).collect();
    all.push(of("the dense model", INK, (dense.display_w, dense.render_w)));
    Some(all)
}

fn draw(canvas: &Canvas, series: &[Series], own: Option<f64>) -> Drawn {
    let panel = Panel { left: 150.0, top: 150.0, right: 1240.0, bottom: 600.0 };
    let values = series.iter().flat_map(|s| s.points.iter().map(|p| 100.0 * p.1));
    let y = around(values.chain([0.0]), 0.06, panel.vertical());
    let x = Scale::exact(RATIOS.0, RATIOS.1, panel.horizontal());
    panel.vertical_axis(canvas, &y, "power saved, %")?;
    let ticks = x.ticks(10);
    for &tick in &ticks {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    let name = "display power over rendering power, dense model";
    panel.horizontal_axis(canvas, &x, &ticks, name)?;
    let entries: Vec<(&str, RGBColor)> =
        series.iter().map(|s| (s.name.as_str(), s.colour)).collect();
    legend(canvas, 40.0, 112.0, &entries)?;
    let note = "A model that is optimised at a ratio saves at least as much there.";
    canvas.text(note, (panel.left, 690.0), Align::Left, GREY)?;
    if let Some(own) = own.filter(|own| (RATIOS.0..=RATIOS.1).contains(own)) {
        let at = x.at(own);
        super::super::dashed(canvas, (at, panel.top), (at, panel.bottom), GREY)?;
        canvas.text("this run", (at + 8.0, panel.bottom - 14.0), Align::Left, GREY)?;
    }
    for Series { colour, points, .. } in series {
        let points: Vec<(f64, f64)> =
            points.iter().map(|p| (x.at(p.0), y.at(100.0 * p.1))).collect();
        if points.len() > 1 {
            canvas.line(&points, *colour, 3)?;
        }
    }
    Ok(())
}
