//! Legends: rows of symbols with their meaning.

use super::{Align, Drawn, LINE, Page, fitted, width};
use crate::{Colour, Entry, Symbol, Words};

/// Between two entries.
const GAP: f64 = 28.0;

/// Draws the rows below `top`; returns where they end.
pub(crate) fn rows(page: &Page, rows: &[Vec<Entry>], top: f64) -> Result<f64, String> {
    let mut y = top;
    let (start, end) = (page.frame.left, page.frame.right);
    for row in rows.iter().filter(|r| !r.is_empty()) {
        let mut x = start;
        for entry in row {
            let wide = symbol_width(entry.symbol) + width(&words(entry));
            // A row that is too long goes on in the next line.
            if x > start && x + wide > end {
                (x, y) = (start, y + LINE + 2.0);
            }
            draw(page, entry, (x, y), end - x)?;
            x += wide + GAP;
        }
        y += LINE + 6.0;
    }
    Ok(y)
}

fn words(entry: &Entry) -> Words {
    let colour = if entry.symbol == Symbol::None { Colour::NOTE } else { Colour::INK };
    Words::new(entry.name.clone(), colour)
}

/// Room for a symbol and its distance to the name.
pub(crate) fn symbol_width(symbol: Symbol) -> f64 {
    match symbol {
        Symbol::Line(_) | Symbol::Curve(_) | Symbol::Dashed(_) => 42.0,
        Symbol::None => 0.0,
        Symbol::Fill(_) | Symbol::Dot(_) | Symbol::Ring(..) | Symbol::Square(_) => 26.0,
    }
}

/// Draws an entry, its left end half-way up at `at`.
pub(crate) fn draw(page: &Page, entry: &Entry, at: (f64, f64), room: f64) -> Drawn {
    let (x, y) = at;
    let dot = (x + 9.0, y);
    match entry.symbol {
        Symbol::Fill(colour) => {
            let [l, t, r, b] = [x, y - 9.0, x + 18.0, y + 9.0];
            page.fill([l, t, r, b], colour)?;
            if let Some(edge) = colour.edge() {
                page.line(&[(l, t), (r, t), (r, b), (l, b), (l, t)], edge, 1.0)?;
            }
        }
        Symbol::Dot(colour) => {
            let edge = colour.edge();
            edge.map_or(Ok(()), |edge| page.dot(dot, 7.0, edge))?;
            page.dot(dot, if edge.is_some() { 6.0 } else { 7.0 }, colour)?;
        }
        Symbol::Ring(ring, colour) => {
            page.dot(dot, 9.0, ring)?;
            page.dot(dot, 6.5, colour)?;
        }
        Symbol::Square(colour) => page.fill([x + 3.0, y - 6.0, x + 15.0, y + 6.0], colour)?,
        Symbol::Line(colour) => page.line(&[(x, y), (x + 32.0, y)], colour, 3.0)?,
        Symbol::Curve(colour) => {
            page.line(&[(x, y), (x + 32.0, y)], colour, 2.0)?;
            page.dot((x + 16.0, y), 4.0, colour)?;
        }
        Symbol::Dashed(colour) => {
            page.line(&[(x, y), (x + 12.0, y)], colour, 2.0)?;
            page.line(&[(x + 20.0, y), (x + 32.0, y)], colour, 2.0)?;
        }
        Symbol::None => {}
    }
    let before = symbol_width(entry.symbol);
    page.text(&fitted(&words(entry), room - before), (x + before, y), Align::Left);
    Ok(())
}
