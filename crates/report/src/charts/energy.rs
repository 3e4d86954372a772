//! Energy per frame and power at the display rate: a bar per stage, stacked by component.

use plotters::style::RGBColor;

use super::{Chart, frames, subtitle};
use crate::ReportError;
use crate::format::{engineering, prefix_of, rate, significant};
use crate::plot::{Align, Canvas, Drawn, GRID, INK, Page, Panel, Scale, legend, palette};
use powergs_core::action::Stage;
use powergs_core::energy::Component;
use powergs_study::findings::RunSummary;
use powergs_study::findings::breakdown::Breakdown;
use powergs_study::run_record::Run;

const NAME: &str = "energy";
const TITLE: &str = "Where the energy goes";

pub(crate) fn colour(component: Component) -> RGBColor {
    match component {
        Component::Dram => palette::BLUE,
        Component::Sram => palette::SKY,
        Component::Flop => palette::ORANGE,
        Component::Leakage => palette::GREY,
        Component::Background => palette::PURPLE,
        Component::Refresh => palette::YELLOW,
    }
}

pub(super) fn chart(run: &Run, summary: &RunSummary) -> Result<Option<Chart>, ReportError> {
    let fps = run.facts.display_fps;
    let (energy, power) = (Breakdown::energy_j(summary), Breakdown::power_w(summary, fps));
    let display = summary.display_w;
    let page = Page {
        name: NAME,
        title: TITLE.into(),
        subtitle: subtitle(run, &frames(run)),
        underlay: None,
    };
    let left = Panel { left: 190.0, top: 190.0, right: 680.0, bottom: 640.0 };
    let right = Panel { left: 740.0, right: 1240.0, ..left };
    let stages = power.shown();
    let drawing = page.draw(|canvas| {
        let components = Component::ALL.map(|c| (c.name(), colour(c)));
        let extra = display.map(|_| ("display", palette::GREEN));
        let shown: Vec<_> = components.into_iter().chain(extra).collect();
        legend(canvas, 40.0, 112.0, &shown)?;
        let names = stages.iter().map(|s| s.name()).chain(display.map(|_| "display"));
        let names: Vec<_> = names.collect();
        for (i, name) in names.iter().enumerate() {
            let (middle, _) = row(left, names.len(), i);
            canvas.text(name, (left.left - 14.0, middle), Align::Right, INK)?;
        }
        let name = format!("accelerator power at {} FPS", rate(fps));
        bars(canvas, left, (&stages, names.len()), &energy, None, "energy per frame", "J")?;
        bars(canvas, right, (&stages, names.len()), &power, display, &name, "W")
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// Middle and half height of row `i` of `rows`.
fn row(panel: Panel, rows: usize, i: usize) -> (f64, f64) {
    let slot = (panel.bottom - panel.top) / rows as f64;
    (panel.top + (i as f64 + 0.5) * slot, (0.33 * slot).min(44.0))
}

/// One panel: a bar per stage, and one for the display where it is known.
fn bars(
    canvas: &Canvas,
    panel: Panel,
    (stages, rows): (&[Stage], usize),
    values: &Breakdown,
    display: Option<f64>,
    name: &str,
    unit: &str,
) -> Drawn {
    let highest = stages.iter().map(|&s| values.stage(s)).chain(display).fold(0.0, f64::max);
    let (factor, prefix) = prefix_of(highest);
    // The number behind the longest bar needs room too.
    let scale = Scale::from_zero(highest / factor, (panel.left, panel.right - 60.0));
    let total = format!("{name}: {}", engineering(values.total(), unit));
    canvas.bold(&total, (panel.left, panel.top - 32.0), Align::Left, INK)?;
    for tick in scale.ticks(5) {
        let x = scale.at(tick);
        canvas.line(&[(x, panel.top), (x, panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &scale, &scale.ticks(5), &format!("{prefix}{unit}"))?;
    let number = |middle: f64, value: f64| {
        let at = (scale.at(value) + 10.0, middle);
        canvas.text(&significant(value), at, Align::Left, INK)
    };
    for (i, &stage) in stages.iter().enumerate() {
        let place = row(panel, rows, i);
        stack(canvas, &scale, values, stage, factor, place)?;
        number(place.0, values.stage(stage) / factor)?;
    }
    if let Some(watts) = display {
        let (middle, half) = row(panel, rows, rows - 1);
        let end = (scale.at(watts / factor), middle + half);
        canvas.fill((panel.left, middle - half), end, palette::GREEN)?;
        number(middle, watts / factor)?;
    }
    Ok(())
}

fn stack(
    canvas: &Canvas,
    scale: &Scale,
    values: &Breakdown,
    stage: Stage,
    factor: f64,
    (middle, half): (f64, f64),
) -> Drawn {
    let mut before = 0.0;
    for component in Component::ALL {
        let after = before + values.part(stage, component) / factor;
        let (x0, x1) = (scale.at(before).round(), scale.at(after).round());
        if x1 > x0 {
            canvas.fill((x0, middle - half), (x1, middle + half), colour(component))?;
        }
        before = after;
    }
    Ok(())
}
