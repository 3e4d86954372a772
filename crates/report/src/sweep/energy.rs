//! Where the energy goes along the front: a stacked bar per design.

use super::measure::Measure;
use super::words;
use crate::ReportError;
use crate::charts::{Chart, component_colour};
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, fitted, legend};
use powergs_core::energy::Component;
use powergs_study::analysis::Analysis;

const NAME: &str = "energy_front";
const TITLE: &str = "Energy per frame along the front";
/// Bars that a slide has room for.
const MOST: usize = 16;
const PANEL: Panel = Panel { left: 220.0, top: 140.0, right: 860.0, bottom: 640.0 };

/// The chart; `None` where the results have no parts of the energy.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn chart(analysis: &Analysis) -> Result<Option<Chart>, ReportError> {
    let rows = shown(analysis);
    let parts: Option<Vec<[f64; Component::ALL.len()]>> =
        rows.iter().map(|&row| parts(analysis, row)).collect();
    let Some(parts) = parts else { return Ok(None) };
    let first = Measure::of(&analysis.question.objectives[0].name).words;
    let all = analysis.front.len();
    let which = if all + 1 > MOST { format!("some of the {all}") } else { format!("all {all}") };
    let subtitle = format!(
        "{which} designs on the front, the best in {first} first; {}, energy table {}",
        analysis.question.scope, analysis.energy_table
    );
    let page = Page { name: NAME, title: TITLE.into(), subtitle, underlay: None };
    let drawing = page.draw(|canvas| {
        let names: Vec<_> = Component::ALL.map(|c| (c.name(), component_colour(c))).to_vec();
        legend(canvas, 40.0, 108.0, &names)?;
        bars(canvas, analysis, &rows, &parts)
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// The named design, then designs of the front in equal steps, the knee among them.
fn shown(analysis: &Analysis) -> Vec<u32> {
    let named = analysis.named.as_ref().map(|n| n.row).filter(|r| !analysis.front.contains(r));
    let mut rows: Vec<u32> = named.into_iter().collect();
    rows.extend(spread(&analysis.front, MOST - rows.len(), analysis.knee));
    rows
}

/// At most `most` of `rows` in equal steps, with both ends and `must`.
pub fn spread(rows: &[u32], most: usize, must: u32) -> Vec<u32> {
    if rows.len() <= most {
        return rows.to_vec();
    }
    let must = rows.iter().position(|r| *r == must);
    let last = rows.len() - 1;
    let mut places: Vec<usize> = (0..most).map(|i| i * last / (most - 1)).collect();
    if let Some(must) = must.filter(|m| !places.contains(m)) {
        let near = (1..most - 1).min_by_key(|i| places[*i].abs_diff(must)).unwrap_or(0);
        places[near] = must;
    }
    places.into_iter().map(|i| rows[i]).collect()
}

fn parts(analysis: &Analysis, row: u32) -> Option<[f64; Component::ALL.len()]> {
    let mut parts = [0.0; Component::ALL.len()];
    for (part, component) in parts.iter_mut().zip(Component::ALL) {
        *part = analysis.table.number(&format!("energy_pj.{}", component.name()), row)?;
    }
    Some(parts)
}

fn bars(
    canvas: &Canvas,
    analysis: &Analysis,
    rows: &[u32],
    parts: &[[f64; Component::ALL.len()]],
) -> Drawn {
    let sums: Vec<f64> = parts.iter().map(|p| p.iter().sum()).collect();
    let largest = sums.iter().copied().fold(0.0, f64::max);
    let (factor, name) = Measure::of("energy_pj.mean").axis(largest);
    let scale = Scale::from_zero(largest * factor, PANEL.horizontal());
    for tick in scale.ticks(6) {
        let x = scale.at(tick);
        canvas.line(&[(x, PANEL.top), (x, PANEL.bottom)], GRID, 1)?;
    }
    PANEL.horizontal_axis(canvas, &scale, &scale.ticks(6), &name)?;
    let slot = (PANEL.bottom - PANEL.top) / rows.len() as f64;
    let half = (0.36 * slot).min(22.0);
    for (i, (&row, parts)) in rows.iter().zip(parts).enumerate() {
        let y = PANEL.top + (i as f64 + 0.5) * slot;
        let label = analysis.table.label(row);
        let at = (PANEL.left - 14.0, y);
        if row == analysis.knee {
            canvas.bold(&format!("knee {label}"), at, Align::Right, INK)?;
        } else {
            canvas.text(&label, at, Align::Right, INK)?;
        }
        let mut before = 0.0;
        for (part, component) in parts.iter().zip(Component::ALL) {
            let after = before + part * factor;
            let (x0, x1) = (scale.at(before).round(), scale.at(after).round());
            if x1 > x0 {
                canvas.fill((x0, y - half), (x1, y + half), component_colour(component))?;
            }
            before = after;
        }
        let facts = others(analysis, row);
        let facts = fitted(&facts, 1250.0 - PANEL.right - 20.0);
        canvas.text(&facts, (PANEL.right + 16.0, y), Align::Left, GREY)?;
    }
    Ok(())
}

/// The objectives that are no energy.
fn others(analysis: &Analysis, row: u32) -> String {
    let mut all = Vec::new();
    for (j, o) in analysis.question.objectives.iter().enumerate() {
        if !o.name.starts_with("energy_pj") {
            all.push(Measure::of(&o.name).text(analysis.value(j, row)));
        }
    }
    if all.is_empty() { words::settings(analysis, row) } else { all.join(", ") }
}
