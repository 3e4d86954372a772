//! Colours of the points of a chart by a third column: a scale for numbers, a list for names.

use plotters::style::RGBColor;

use super::measure::Measure;
use crate::format::{rounded, shortened};
use crate::plot::{Align, Canvas, Drawn, GREY, INK, palette};
use powergs_study::analysis::Analysis;
use powergs_study::analysis::table::{Values, Words};

/// Names that get a colour of their own, and numbers that are listed one by one.
const LISTED: usize = 8;

/// Colours of names.
const NAMES: [RGBColor; LISTED] = [
    palette::BLUE,
    palette::ORANGE,
    palette::GREEN,
    palette::VERMILION,
    palette::SKY,
    palette::PURPLE,
    palette::YELLOW,
    palette::GREY,
];

/// Dark to light in equal steps of brightness, for any colour vision (viridis).
const STOPS: [(u8, u8, u8); 7] = [
    (68, 1, 84),
    (68, 58, 131),
    (49, 104, 142),
    (33, 145, 140),
    (53, 183, 121),
    (143, 215, 68),
    (240, 220, 40),
];

/// The colour at a share of the scale, from 0 to 1.
pub fn at(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (place as usize).min(STOPS.len() - 2);
    let part = place - i as f64;
    let (a, b) = (STOPS[i], STOPS[i + 1]);
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Above this ratio of the largest to the smallest value colours are logarithmic.
const FACTORS: f64 = 5.0;

fn is_logarithmic(low: f64, high: f64) -> bool {
    low > 0.0 && high > FACTORS * low
}

/// Where `x` is on the scale from `low` to `high`.
fn share(x: f64, low: f64, high: f64) -> f64 {
    if high <= low {
        0.5
    } else if is_logarithmic(low, high) {
        (x.max(low) / low).ln() / (high / low).ln()
    } else {
        (x - low) / (high - low)
    }
}

/// The value in the middle of the scale.
fn centre(low: f64, high: f64) -> f64 {
    if is_logarithmic(low, high) { (low * high).sqrt() } else { (low + high) / 2.0 }
}

/// How points are coloured.
#[derive(Debug)]
pub enum Key<'t> {
    /// By a number, dark to light.
    Scale { measure: Measure, numbers: Vec<f64>, low: f64, high: f64 },
    /// By a word; what has no colour of its own is grey.
    List { name: String, words: &'t Words, colours: Vec<Option<RGBColor>>, order: Vec<u32> },
    /// All alike.
    None,
}

impl<'t> Key<'t> {
    /// The column that the question names; else the third objective, else the axis that moves most.
    pub fn of(analysis: &Analysis<'t>, shown: [&str; 2]) -> Key<'t> {
        let objectives = analysis.question.objectives.iter().map(|o| o.name.as_str());
        let third = objectives.clone().find(|name| !shown.contains(name));
        let axis = analysis.axes.first().map(|a| a.name.as_str());
        let name = analysis.question.colour.as_deref().or(third).or(axis);
        name.map_or(Key::None, |name| Key::named(analysis, name, &analysis.rows))
    }

    /// By the column `name`, for the designs `rows`.
    pub fn named(analysis: &Analysis<'t>, name: &str, rows: &[u32]) -> Key<'t> {
        let table = analysis.table;
        if let Some(words) = table.axis(name) {
            return Key::words(rows, name, words);
        }
        match table.metrics.iter().find(|c| c.name == name).map(|c| &c.values) {
            Some(Values::Words(words)) => Key::words(rows, name, words),
            Some(Values::Numbers(numbers)) => Key::scale(rows, name, numbers.clone()),
            None => Key::None,
        }
    }

    fn words(rows: &[u32], name: &str, words: &'t Words) -> Key<'t> {
        let mut seen = vec![false; words.distinct().len()];
        rows.iter().for_each(|&row| seen[words.code(row) as usize] = true);
        let order: Vec<u32> =
            words.ordered().into_iter().filter(|code| seen[*code as usize]).collect();
        let numeric = words.is_numeric();
        if numeric && order.len() > LISTED {
            let all = 0..words.len() as u32;
            let numbers = all.map(|row| words.number(row).unwrap_or(f64::NAN)).collect();
            return Key::scale(rows, name, numbers);
        }
        let mut colours = vec![None; words.distinct().len()];
        for (i, &code) in order.iter().take(LISTED).enumerate() {
            let share = i as f64 / (order.len() - 1).max(1) as f64;
            colours[code as usize] = Some(if numeric { at(share) } else { NAMES[i] });
        }
        Key::List { name: name.to_owned(), words, colours, order }
    }

    fn scale(rows: &[u32], name: &str, numbers: Vec<f64>) -> Key<'t> {
        let shown = rows.iter().map(|row| numbers[*row as usize]);
        let ends = shown
            .filter(|x| x.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |e, x| (e.0.min(x), e.1.max(x)));
        let measure = Measure::of(name);
        Key::Scale { measure, numbers, low: ends.0, high: ends.1 }
    }

    /// The colour of a row.
    pub fn colour(&self, row: u32) -> RGBColor {
        match self {
            Key::None => palette::BLUE,
            Key::Scale { numbers, low, high, .. } => {
                let x = numbers[row as usize];
                if x.is_nan() { palette::PALE } else { at(share(x, *low, *high)) }
            }
            Key::List { words, colours, .. } => {
                colours[words.code(row) as usize].unwrap_or(palette::PALE)
            }
        }
    }

    /// The legend, in a column `width` wide from `(left, top)` down.
    pub fn legend(&self, canvas: &Canvas, (left, top): (f64, f64), width: usize) -> Drawn {
        match self {
            Key::None => Ok(()),
            Key::Scale { measure, low, high, .. } => {
                let words = measure.words.as_str();
                canvas.bold(&shortened(words, width), (left, top), Align::Left, INK)?;
                const STEPS: i32 = 40;
                let (first, height) = (top + 24.0, 5.0);
                let bottom = first + f64::from(STEPS) * height;
                for i in (0..STEPS).rev() {
                    let y = first + f64::from(STEPS - 1 - i) * height;
                    let colour = at((f64::from(i) + 0.5) / f64::from(STEPS));
                    // Down to the end, so that no seam shows between the steps.
                    canvas.fill((left, y), (left + 22.0, bottom), colour)?;
                }
                let middle = (first + bottom) / 2.0;
                for (x, y) in
                    [(*high, first + 8.0), (centre(*low, *high), middle), (*low, bottom - 8.0)]
                {
                    canvas.text(&measure.text(x), (left + 32.0, y), Align::Left, GREY)?;
                }
                Ok(())
            }
            Key::List { name, words, colours, order } => {
                canvas.bold(&shortened(name, width), (left, top), Align::Left, INK)?;
                let mut y = top + 30.0;
                for &code in order.iter().take(LISTED) {
                    let colour = colours[code as usize].unwrap_or(palette::PALE);
                    canvas.dot((left + 8.0, y), 7, colour)?;
                    let word = shortened(&rounded(&words.distinct()[code as usize]), width - 3);
                    canvas.text(&word, (left + 26.0, y), Align::Left, INK)?;
                    y += 26.0;
                }
                if order.len() > LISTED {
                    canvas.dot((left + 8.0, y), 7, palette::PALE)?;
                    canvas.text("other", (left + 26.0, y), Align::Left, INK)?;
                }
                Ok(())
            }
        }
    }
}
