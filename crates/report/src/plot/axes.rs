//! Panels with axes, and legends.

use plotters::style::RGBColor;

use super::scale::label;
use super::{Align, Canvas, Drawn, GREY, GRID, INK, Scale, TEXT, text_width};

/// A rectangle of the page with axes around it; coordinates are those of the data area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Panel {
    /// Left edge.
    pub left: f64,
    /// Top edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Bottom edge.
    pub bottom: f64,
}

impl Panel {
    /// The vertical page range, upwards, for a [`Scale`].
    pub fn vertical(&self) -> (f64, f64) {
        (self.bottom, self.top)
    }

    /// The horizontal page range for a [`Scale`].
    pub fn horizontal(&self) -> (f64, f64) {
        (self.left, self.right)
    }

    /// Grid lines and labels of a vertical scale at the left, its name beside the labels.
    pub fn vertical_axis(&self, canvas: &Canvas, scale: &Scale, name: &str) -> Drawn {
        self.vertical_ticks(canvas, scale, 6, name)
    }

    /// As [`Panel::vertical_axis`] with about `count` labels, for low panels.
    pub fn vertical_ticks(
        &self,
        canvas: &Canvas,
        scale: &Scale,
        count: usize,
        name: &str,
    ) -> Drawn {
        let ticks = scale.ticks(count);
        for &tick in &ticks {
            let y = scale.at(tick);
            canvas.line(&[(self.left, y), (self.right, y)], GRID, 1)?;
            canvas.text(&label(tick, &ticks), (self.left - 10.0, y), Align::Right, GREY)?;
        }
        let widest = ticks.iter().map(|t| text_width(&label(*t, &ticks))).fold(0.0, f64::max);
        let x = self.left - 22.0 - widest - TEXT / 2.0;
        canvas.text(name, (x, (self.top + self.bottom) / 2.0), Align::Upwards, INK)?;
        canvas.line(&[(self.left, self.bottom), (self.right, self.bottom)], GREY, 1)
    }

    /// Ticks and labels of a horizontal scale at the bottom, its name below. Labels that would
    /// touch their neighbour are left out.
    pub fn horizontal_axis(
        &self,
        canvas: &Canvas,
        scale: &Scale,
        ticks: &[f64],
        name: &str,
    ) -> Drawn {
        let mut free_from = f64::NEG_INFINITY;
        for &tick in ticks {
            let x = scale.at(tick);
            canvas.line(&[(x, self.bottom), (x, self.bottom + 6.0)], GREY, 1)?;
            let text = label(tick, ticks);
            let half = text_width(&text) / 2.0;
            if x - half > free_from {
                canvas.text(&text, (x, self.bottom + 22.0), Align::Centre, GREY)?;
                free_from = x + half + 8.0;
            }
        }
        let middle = (self.left + self.right) / 2.0;
        canvas.text(name, (middle, self.bottom + 50.0), Align::Centre, INK)?;
        canvas.line(&[(self.left, self.bottom), (self.right, self.bottom)], GREY, 1)
    }
}

/// A row of swatches with their names, starting at `(left, y)`.
pub fn legend(canvas: &Canvas, left: f64, y: f64, entries: &[(&str, RGBColor)]) -> Drawn {
    let mut x = left;
    for (name, colour) in entries {
        canvas.fill((x, y - 9.0), (x + 18.0, y + 9.0), *colour)?;
        canvas.text(name, (x + 26.0, y), Align::Left, INK)?;
        x += 26.0 + text_width(name) + 28.0;
    }
    Ok(())
}
