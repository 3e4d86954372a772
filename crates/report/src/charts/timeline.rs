//! Units by time: what each did in every column of the picture.

use plotters::style::RGBColor;

use super::Chart;
use super::cycles::part_colours;
use crate::ReportError;
use crate::plot::{Align, Canvas, Drawn, INK, Page, Panel, Scale, legend, palette, text_width};
use crate::timeline::{COLUMNS, IDLE, MOST_INSTANCES, Picture, Row, STATES};
use powergs_core::accel::Stall;

const NAME: &str = "timeline";
const TITLE: &str = "What every unit does when";

/// A second green: neighbours in a row can be told apart.
const DARK: RGBColor = RGBColor(0, 120, 88);

fn colours() -> [RGBColor; STATES] {
    let parts = part_colours();
    let mut colours = [palette::PALE; STATES];
    (colours[0], colours[1]) = (parts[0].0, DARK);
    for cause in Stall::ALL {
        colours[2 + cause as usize] = parts[1 + cause as usize].0;
    }
    colours[IDLE] = parts[parts.len() - 1].0;
    colours
}

/// The chart of a finished picture; `what` names the frame and the tiles.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn chart(picture: &Picture, clock_hz: f64, what: &str) -> Result<Chart, ReportError> {
    let cut = if picture.cut {
        format!("; the first {MOST_INSTANCES} of each kind of unit")
    } else {
        String::new()
    };
    let page =
        Page { name: NAME, title: TITLE.into(), subtitle: format!("{what}{cut}"), underlay: None };
    let drawing = page.draw(|canvas| draw(canvas, picture, clock_hz))?;
    Ok(Chart { name: NAME, title: TITLE, drawing })
}

fn draw(canvas: &Canvas, picture: &Picture, clock_hz: f64) -> Drawn {
    let panel = Panel { left: 100.0, top: 140.0, right: 100.0 + COLUMNS as f64, bottom: 640.0 };
    let colours = colours();
    let mut names = vec![("busy", colours[0]), ("with the next", colours[1])];
    names.extend(Stall::ALL.map(|s| (s.name(), colours[2 + s as usize])));
    names.push(("idle", colours[IDLE]));
    legend(canvas, 40.0, 108.0, &names)?;
    let us = |cycle: u64| cycle as f64 / clock_hz * 1e6;
    let (start, end) = (us(picture.cycles.start), us(picture.cycles.end));
    let scale = Scale::exact(start, end, panel.horizontal());
    panel.horizontal_axis(canvas, &scale, &scale.ticks(10), "time since the frame began, µs")?;
    let rows: Vec<&Row> = picture.rows().collect();
    let slot = (panel.bottom - panel.top) / rows.len().max(1) as f64;
    // Every name where there is room, else every second, third, …
    let every = (15.0 / slot).ceil().max(1.0) as usize;
    for (i, row) in rows.into_iter().enumerate() {
        let (top, bottom) = (panel.top + i as f64 * slot, panel.top + (i as f64 + 0.86) * slot);
        let middle = (top + bottom) / 2.0;
        if i % every == 0 {
            canvas.text(&row.name, (panel.left - 10.0, middle), Align::Right, INK)?;
        }
        let mut from = 0;
        for column in 1..=COLUMNS {
            if column == COLUMNS || row.state(column) != row.state(from) {
                let x = |c: usize| panel.left + c as f64;
                canvas.fill((x(from), top), (x(column), bottom), colours[row.state(from)])?;
                from = column;
            }
        }
        if slot < 18.0 {
            continue;
        }
        for item in &row.items {
            let (x0, x1) = (scale.at(us(item.cycles.start)), scale.at(us(item.cycles.end)));
            let text = item.number.to_string();
            if text_width(&text) + 8.0 < x1 - x0 {
                let white = RGBColor(255, 255, 255);
                canvas.text(&text, ((x0 + x1) / 2.0, middle), Align::Centre, white)?;
            }
        }
    }
    Ok(())
}
