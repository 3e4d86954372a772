//! The column at the right of the panels: legends, colour scales, lists.

use super::{Align, Drawn, LINE, Page, fitted, legend, plain_width, width};
use crate::{Beside, Colour, Entry, Words};

/// At most as much of the page, page units.
const MOST: f64 = 430.0;
/// Height of a colour scale.
const SCALE: f64 = 200.0;
/// Height of one that is alone.
const TALL: f64 = 460.0;
/// Bands of a colour scale.
const BANDS: u32 = 50;

/// Width of the column; 0 if there is none.
pub(crate) fn room(all: &[Beside]) -> f64 {
    let of = |beside: &Beside| match beside {
        Beside::Entries { title, entries } => {
            let one = entries.iter().map(|e| legend::symbol_width(e.symbol) + plain_width(&e.name));
            one.fold(width(&Words::bold(title.as_str())), f64::max)
        }
        Beside::Scale { title, labels } => {
            let one = labels.iter().map(|l| 32.0 + plain_width(&l.1));
            one.fold(width(&Words::bold(title.as_str())), f64::max)
        }
        Beside::List { title, rows } => {
            let one = rows.iter().map(|(name, value)| plain_width(name) + plain_width(value));
            one.fold(plain_width(title), f64::max) + 64.0
        }
    };
    all.iter().map(of).fold(0.0, f64::max).min(MOST)
}

/// Draws the column from `(left, top)` down.
pub(crate) fn draw(page: &Page, all: &[Beside], left: f64, top: f64, bottom: f64) -> Drawn {
    let mut y = top;
    let end = page.frame.right;
    let scale = if all.len() == 1 { (bottom - top - 80.0).min(TALL) } else { SCALE };
    let heading = |text: &str, y: f64| {
        let words = fitted(&Words::bold(text), end - left);
        page.text(&words, (left, y), Align::Left);
    };
    for beside in all {
        match beside {
            Beside::Entries { title, entries } => {
                if !title.is_empty() {
                    heading(title, y);
                    y += LINE + 4.0;
                }
                for entry in entries {
                    legend::draw(page, entry, (left, y), end - left)?;
                    y += LINE + 4.0;
                }
                y += 14.0;
            }
            Beside::Scale { title, labels } => {
                heading(title, y);
                y += LINE + 4.0;
                let band = scale / f64::from(BANDS);
                for i in 0..BANDS {
                    let from = y + scale - f64::from(i + 1) * band;
                    let colour = Colour::at((f64::from(i) + 0.5) / f64::from(BANDS));
                    page.fill([left, from, left + 22.0, from + band], colour)?;
                }
                for (share, text) in labels {
                    let at = y + (1.0 - share) * scale;
                    page.line(&[(left + 22.0, at), (left + 27.0, at)], Colour::NOTE, 1.0)?;
                    let words = fitted(&Words::note(text.as_str()), end - left - 32.0);
                    page.text(&words, (left + 32.0, at), Align::Left);
                }
                y += scale + 24.0;
            }
            Beside::List { title, rows } => {
                page.text(&Words::note(title.as_str()), (end, y), Align::Right);
                y += LINE + 2.0;
                for (n, (name, value)) in rows.iter().enumerate() {
                    if y > bottom {
                        break;
                    }
                    let number = Words::note((n + 1).to_string());
                    page.text(&number, (left + 26.0, y), Align::Right);
                    page.text(&Words::from(value.as_str()), (end, y), Align::Right);
                    let room = end - left - 38.0 - plain_width(value) - 10.0;
                    let name = fitted(&Words::from(name.as_str()), room);
                    page.text(&name, (left + 38.0, y), Align::Left);
                    y += LINE;
                }
                y += 14.0;
            }
        }
    }
    Ok(())
}

/// Draws the same below panels, from `top` down; returns where it ends.
pub(crate) fn below(page: &Page, all: &[Beside], top: f64) -> Result<f64, String> {
    let (left, right) = (page.frame.left, page.frame.right);
    let mut y = top;
    for beside in all {
        match beside {
            Beside::Entries { title, entries } => {
                let head = (!title.is_empty()).then(|| Entry::note(format!("{title}:")));
                let row: Vec<Entry> = head.into_iter().chain(entries.iter().cloned()).collect();
                y = legend::rows(page, &[row], y + 12.0)? - 12.0;
            }
            Beside::Scale { title, labels } => {
                let heading = fitted(&Words::bold(title.as_str()), right - left);
                page.text(&heading, (left, y + 12.0), Align::Left);
                let bar = [left + 4.0, y + 28.0, right - 4.0, y + 46.0];
                let band = (bar[2] - bar[0]) / f64::from(BANDS);
                for i in 0..BANDS {
                    let from = bar[0] + f64::from(i) * band;
                    let colour = Colour::at((f64::from(i) + 0.5) / f64::from(BANDS));
                    page.fill([from, bar[1], from + band, bar[3]], colour)?;
                }
                let mut free_from = f64::NEG_INFINITY;
                for (share, text) in labels {
                    let (x, wide) = (bar[0] + share * (bar[2] - bar[0]), plain_width(text));
                    let from = (x - wide / 2.0).min(right - wide).max(left);
                    if from >= free_from {
                        let ends = [(x, bar[3]), (x, bar[3] + 5.0)];
                        page.line(&ends, Colour::NOTE, 1.0)?;
                        page.text(&Words::note(text.as_str()), (from, y + 60.0), Align::Left);
                        free_from = from + wide + 10.0;
                    }
                }
                y += 80.0;
            }
            Beside::List { title, rows } => {
                page.text(&Words::note(title.as_str()), (right, y + 12.0), Align::Right);
                for (n, (name, value)) in rows.iter().enumerate() {
                    let at = y + 12.0 + LINE * (n + 1) as f64;
                    let number = Words::note((n + 1).to_string());
                    page.text(&number, (left + 26.0, at), Align::Right);
                    page.text(&Words::from(value.as_str()), (right, at), Align::Right);
                    let room = right - left - 48.0 - plain_width(value);
                    let name = fitted(&Words::from(name.as_str()), room);
                    page.text(&name, (left + 38.0, at), Align::Left);
                }
                y += LINE * (rows.len() + 1) as f64 + 8.0;
            }
        }
    }
    Ok(y)
}
