//! Where the cycles go: per kind of unit, busy, stalls by cause, idle.

use plotters::style::RGBColor;

use super::{Chart, frames, subtitle};
use crate::ReportError;
use crate::format::{percent, significant};
use crate::plot::{
    Align, Canvas, Drawn, GREY, INK, Page, Panel, Scale, legend, palette, text_width,
};
use powergs_study::findings::RunSummary;
use powergs_study::findings::summary::{DramSummary, UnitSummary};
use powergs_study::run_record::Run;

const NAME: &str = "cycles";
const TITLE: &str = "Where the cycles go";

/// Colours of [`UnitSummary::PARTS`], and of the text on them.
const COLOURS: [(RGBColor, RGBColor); UnitSummary::PARTS.len()] = [
    (palette::GREEN, WHITE),
    (NAVY, WHITE),
    (palette::BLUE, WHITE),
    (palette::PURPLE, INK),
    (palette::SKY, INK),
    (palette::ORANGE, INK),
    (palette::VERMILION, WHITE),
    (palette::GREY, WHITE),
    (palette::PALE, INK),
];

/// Colours of the parts, and of the text on them.
pub(crate) fn part_colours() -> [(RGBColor, RGBColor); UnitSummary::PARTS.len()] {
    COLOURS
}

const WHITE: RGBColor = RGBColor(255, 255, 255);

/// The darkest of the blues: waits for DRAM are blues and purple, other waits are warm.
const NAVY: RGBColor = RGBColor(0, 62, 110);

pub(super) fn chart(run: &Run, summary: &RunSummary) -> Result<Option<Chart>, ReportError> {
    let Some(cycle) = &summary.cycle else { return Ok(None) };
    let rows = &cycle.units;
    let page = Page {
        name: NAME,
        title: TITLE.into(),
        subtitle: subtitle(run, &frames(run)),
        underlay: None,
    };
    let panel = Panel { left: 150.0, top: 160.0, right: 1080.0, bottom: 630.0 };
    let drawing = page.draw(|canvas| {
        let names: Vec<_> =
            UnitSummary::PARTS.into_iter().zip(COLOURS).map(|(n, (c, _))| (n, c)).collect();
        legend(canvas, 40.0, 112.0, &names)?;
        let scale = Scale::exact(0.0, 100.0, panel.horizontal());
        let ticks = scale.ticks(10);
        let name = "share of the unit's cycles, %; between busy and idle: what it waits for";
        panel.horizontal_axis(canvas, &scale, &ticks, name)?;
        let lines = rows.len() + 1;
        let slot = (panel.bottom - panel.top) / lines as f64;
        let middle = |i: usize| panel.top + (i as f64 + 0.5) * slot;
        let half = (0.34 * slot).min(44.0);
        for (i, row) in rows.iter().enumerate() {
            let text = format!("{} x{}", row.unit.name(), row.instances);
            canvas.text(&text, (panel.left - 14.0, middle(i)), Align::Right, INK)?;
            bar(canvas, &scale, (middle(i), half), &row.shares(), &COLOURS)?;
            let busy = format!("{} M busy", significant(row.busy / 1e6));
            canvas.text(&busy, (panel.right + 14.0, middle(i)), Align::Left, GREY)?;
        }
        dram(canvas, run, &cycle.dram, &panel, &scale, (middle(lines - 1), half))
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// The data bus as a bar of its own: busy or not.
fn dram(
    canvas: &Canvas,
    run: &Run,
    dram: &DramSummary,
    panel: &Panel,
    scale: &Scale,
    place: (f64, f64),
) -> Drawn {
    let busy = dram.busy_frac;
    canvas.text("dram bus", (panel.left - 14.0, place.0), Align::Right, INK)?;
    let colours = [COLOURS[0], COLOURS[COLOURS.len() - 1]];
    bar(canvas, scale, place, &[busy, 1.0 - busy], &colours)?;
    let Some(rate) = dram.bandwidth_gb_s else { return Ok(()) };
    let at = |dy: f64| (panel.right + 14.0, place.0 + dy);
    let rate = format!("{} GB/s", significant(rate));
    match run.facts.machine.dram_peak_gb_s {
        Some(peak) => {
            canvas.text(&rate, at(-11.0), Align::Left, GREY)?;
            canvas.text(&format!("of {} GB/s", significant(peak)), at(11.0), Align::Left, GREY)
        }
        None => canvas.text(&rate, at(0.0), Align::Left, GREY),
    }
}

/// One stacked bar; shares that have room carry their percentage.
fn bar(
    canvas: &Canvas,
    scale: &Scale,
    (middle, half): (f64, f64),
    shares: &[f64],
    colours: &[(RGBColor, RGBColor)],
) -> Drawn {
    let mut before = 0.0;
    for (share, (fill, ink)) in shares.iter().zip(colours) {
        let after = before + share * 100.0;
        let (x0, x1) = (scale.at(before).round(), scale.at(after).round());
        if x1 > x0 {
            canvas.fill((x0, middle - half), (x1, middle + half), *fill)?;
            let text = percent(*share);
            if text_width(&text) + 10.0 < x1 - x0 {
                canvas.text(&text, ((x0 + x1) / 2.0, middle), Align::Centre, *ink)?;
            }
        }
        before = after;
    }
    Ok(())
}
