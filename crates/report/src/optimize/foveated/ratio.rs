//! What our foveated model saves as the panel draws more against the accelerator.

use super::{Show, colour};
use powergs_chart::{Axis, Chart, Colour, Entry, Line, Panel, Place, Rule, Scale, Side, Words};
use powergs_optimize::foveated::Method;
use powergs_optimize::ratio_study::RATIOS;
use powergs_optimize::results::saving_at;

const NAME: &str = "foveated_ratio";
const TITLE: &str = "Foveated saving against the display-to-render ratio";
/// Places in the range, evenly spaced.
const PLACES: usize = 25;

struct Series {
    name: String,
    colour: Colour,
    /// Ratio and saving.
    points: Vec<Place>,
}

pub(super) fn chart(show: &Show<'_>) -> Option<Chart> {
    let series = series(show).unwrap_or_default();
    if series.len() < 2 {
        return None;
    }
    let what = format!("variant {}, models held fixed while the panel is scaled", show.variant());
    let own = show.results.display_to_render;
    let entries = series.iter().map(|s| Entry::fill(s.name.as_str(), s.colour));
    Some(
        show.chart(NAME, TITLE, &what)
            .legend(entries)
            .panel(panel(&series, own))
            .note("A model that is optimised at a ratio saves at least as much there."),
    )
}

fn series(show: &Show<'_>) -> Option<Vec<Series>> {
    let (r, variant) = (show.results, show.variant());
    let dense = r.dense()?;
    let ours = r.foveal(Method::PowerGs, variant)?;
    let ours = (ours.display_w, ours.render_w);
    let ratio = |i: usize| RATIOS.0 + (RATIOS.1 - RATIOS.0) * i as f64 / (PLACES - 1) as f64;
    let of = |name: &str, colour: Colour, other: (f64, f64)| {
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
    all.push(of("the dense model", Colour::INK, (dense.display_w, dense.render_w)));
    Some(all)
}

fn panel(series: &[Series], own: Option<f64>) -> Panel {
    let values = series.iter().flat_map(|s| s.points.iter().map(|p| 100.0 * p.1));
    let y = Axis::new("power saved, %", Scale::around(values.chain([0.0]), 0.06));
    let bottom = y.scale.low();
    let name = "display power over accelerator power, dense model";
    let x = Axis::new(name, Scale::linear(RATIOS.0, RATIOS.1)).ticks(10);
    let mut panel = Panel::new(x, y);
    if let Some(own) = own.filter(|own| (RATIOS.0..=RATIOS.1).contains(own)) {
        panel = panel.dashed(Rule::X(own), Colour::NOTE).label(
            Words::note("this run"),
            (own, bottom),
            Side::AboveRight,
        );
    }
    series.iter().fold(panel, |panel, s| {
        let points: Vec<Place> = s.points.iter().map(|p| (p.0, 100.0 * p.1)).collect();
        panel.line(Line::curve(points, s.colour))
    })
}
