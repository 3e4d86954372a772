//! The top designs under every ranking: a line per design that rises and falls (a bump chart).

use plotters::style::RGBColor;

use super::words;
use crate::ReportError;
use crate::charts::Chart;
use crate::format::significant;
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, fitted, palette};
use powergs_study::analysis::Analysis;

const NAME: &str = "stability";
const TITLE: &str = "Do the top designs stay on top?";
/// Rankings in one chart besides the reference.
const MOST: usize = 8;
/// Lines in one chart.
const LINES: usize = 10;
const PANEL: Panel = Panel { left: 190.0, top: 150.0, right: 1030.0, bottom: 600.0 };

/// Colours of the lines, the first the boldest.
const COLOURS: [RGBColor; LINES] = [
    palette::VERMILION,
    palette::BLUE,
    palette::GREEN,
    palette::ORANGE,
    palette::PURPLE,
    palette::SKY,
    RGBColor(120, 94, 40),
    RGBColor(70, 70, 150),
    RGBColor(150, 60, 80),
    palette::GREY,
];

/// The chart; `None` without another ranking.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn chart(analysis: &Analysis) -> Result<Option<Chart>, ReportError> {
    let stability = &analysis.stability;
    if stability.alternatives.is_empty() || stability.top.len() < 2 {
        return Ok(None);
    }
    // What fits under a title; the page has it whole.
    let words = words::stability(analysis);
    let subtitle = words.split("; ").take(2).collect::<Vec<_>>().join("; ");
    let page = Page { name: NAME, title: TITLE.into(), subtitle, underlay: None };
    let drawing = page.draw(|canvas| drawing(canvas, analysis))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn drawing(canvas: &Canvas, analysis: &Analysis) -> Drawn {
    let stability = &analysis.stability;
    let alternatives = &stability.alternatives[..stability.alternatives.len().min(MOST)];
    let top = &stability.top[..stability.top.len().min(LINES)];
    let columns = alternatives.len() + 1;
    let x = |i: usize| PANEL.left + i as f64 * (PANEL.right - PANEL.left) / (columns - 1) as f64;
    // Ranks 1 to `top`, then a band for what fell out.
    let lanes = top.len() + 1;
    let lane = (PANEL.bottom - PANEL.top) / lanes as f64;
    let y = |rank: usize| PANEL.top + (rank.min(lanes) as f64 - 0.5) * lane;
    let width = (PANEL.right - PANEL.left) / (columns - 1) as f64 - 12.0;
    for rank in 1..=lanes {
        canvas.line(&[(PANEL.left, y(rank)), (PANEL.right, y(rank))], GRID, 1)?;
        let below = format!("> {}", top.len());
        let text = if rank == lanes { below } else { rank.to_string() };
        canvas.text(&text, (PANEL.left - 100.0, y(rank)), Align::Right, GREY)?;
    }
    canvas.text("rank by merit", (40.0, (PANEL.top + PANEL.bottom) / 2.0), Align::Upwards, INK)?;
    let head = |i: usize, name: &str, below: &str| {
        canvas.bold(&fitted(name, width / 1.125), (x(i), PANEL.top - 18.0), Align::Centre, INK)?;
        canvas.text(below, (x(i), PANEL.bottom + 30.0), Align::Centre, GREY)
    };
    head(0, &analysis.energy_table, "reference")?;
    for (i, alternative) in alternatives.iter().enumerate() {
        let tau = alternative.kendall.map_or("-".into(), significant);
        head(i + 1, &alternative.label, &format!("τ {tau}"))?;
    }
    for (i, alternative) in alternatives.iter().enumerate() {
        let fallen = alternative.ranks.iter().take(top.len()).flatten();
        let fallen = fallen.filter(|r| **r > top.len()).count();
        if fallen > 0 {
            let place = (x(i + 1), y(lanes) + 22.0);
            canvas.text(&format!("{fallen} fell out"), place, Align::Centre, GREY)?;
        }
    }
    for (line, &row) in top.iter().enumerate().rev() {
        let ranks = alternatives.iter().map(|a| a.ranks[line]);
        let ranks: Vec<Option<usize>> = std::iter::once(Some(line + 1)).chain(ranks).collect();
        let at = |(i, rank): (usize, &Option<usize>)| rank.map(|rank| (x(i), y(rank)));
        let points: Vec<Option<(f64, f64)>> = ranks.iter().enumerate().map(at).collect();
        let colour = COLOURS[line];
        for pair in points.windows(2) {
            if let [Some(a), Some(b)] = pair {
                canvas.line(&[*a, *b], colour, if line == 0 { 5 } else { 3 })?;
            }
        }
        for point in points.iter().flatten() {
            canvas.dot(*point, if line == 0 { 9 } else { 7 }, colour)?;
        }
        let label = analysis.table.label(row);
        let last = points.last().copied().flatten();
        if let Some(last) = last.filter(|p| p.1 < y(lanes)) {
            canvas.bold(&label, (last.0 + 18.0, last.1), Align::Left, colour)?;
        }
        canvas.bold(&label, (x(0) - 18.0, y(line + 1)), Align::Right, colour)?;
    }
    Ok(())
}
