//! Colours of the points of a chart by a third column: a scale for numbers, a list for names.

use super::measure::Measure;
use crate::format::{rounded, shortened};
use powergs_chart::{Beside, Colour, Entry, Symbol};
use powergs_study::analysis::Analysis;
use powergs_study::analysis::table::{Values, Words};

/// Names that get a colour of their own, and numbers that are listed one by one.
const LISTED: usize = Colour::SERIES.len();

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
pub enum ColourKey<'t> {
    /// By a number, dark to light.
    Scale { measure: Measure, numbers: Vec<f64>, low: f64, high: f64 },
    /// By a word; what has no colour of its own is grey.
    List { name: String, words: &'t Words, colours: Vec<Option<Colour>>, order: Vec<u32> },
    /// All alike.
    None,
}

impl<'t> ColourKey<'t> {
    /// The column that the question names; else the third objective, else the axis that moves most.
    pub fn of(analysis: &Analysis<'t>, shown: [&str; 2]) -> ColourKey<'t> {
        let objectives = analysis.question.objectives.iter().map(|o| o.name.as_str());
        let third = objectives.clone().find(|name| !shown.contains(name));
        let axis = analysis.axes.first().map(|a| a.name.as_str());
        let name = analysis.question.colour.as_deref().or(third).or(axis);
        name.map_or(ColourKey::None, |name| ColourKey::named(analysis, name, &analysis.rows))
    }

    /// By the column `name`, for the designs `rows`.
    pub fn named(analysis: &Analysis<'t>, name: &str, rows: &[u32]) -> ColourKey<'t> {
        let table = analysis.table;
        if let Some(words) = table.axis(name) {
            return ColourKey::words(rows, name, words);
        }
        match table.metrics.iter().find(|c| c.name == name).map(|c| &c.values) {
            Some(Values::Words(words)) => ColourKey::words(rows, name, words),
            Some(Values::Numbers(numbers)) => ColourKey::scale(rows, name, numbers.clone()),
            None => ColourKey::None,
        }
    }

    fn words(rows: &[u32], name: &str, words: &'t Words) -> ColourKey<'t> {
        let mut seen = vec![false; words.distinct().len()];
        rows.iter().for_each(|&row| seen[words.code(row) as usize] = true);
        let order: Vec<u32> =
            words.ordered().into_iter().filter(|code| seen[*code as usize]).collect();
        let numeric = words.is_numeric();
        if numeric && order.len() > LISTED {
            let all = 0..words.len() as u32;
            let numbers = all.map(|row| words.number(row).unwrap_or(f64::NAN)).collect();
            return ColourKey::scale(rows, name, numbers);
        }
        let mut colours = vec![None; words.distinct().len()];
        for (i, &code) in order.iter().take(LISTED).enumerate() {
            let share = i as f64 / (order.len() - 1).max(1) as f64;
            colours[code as usize] =
                Some(if numeric { Colour::at(share) } else { Colour::SERIES[i] });
        }
        ColourKey::List { name: name.to_owned(), words, colours, order }
    }

    fn scale(rows: &[u32], name: &str, numbers: Vec<f64>) -> ColourKey<'t> {
        let shown = rows.iter().map(|row| numbers[*row as usize]);
        let ends = shown
            .filter(|x| x.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |e, x| (e.0.min(x), e.1.max(x)));
        let measure = Measure::of(name);
        ColourKey::Scale { measure, numbers, low: ends.0, high: ends.1 }
    }

    /// The colour of a row.
    pub fn colour(&self, row: u32) -> Colour {
        match self {
            ColourKey::None => Colour::BLUE,
            ColourKey::Scale { numbers, low, high, .. } => {
                let x = numbers[row as usize];
                if x.is_nan() { Colour::PALE } else { Colour::at(share(x, *low, *high)) }
            }
            ColourKey::List { words, colours, .. } => {
                colours[words.code(row) as usize].unwrap_or(Colour::PALE)
            }
        }
    }

    /// What explains the colours.
    pub fn beside(&self) -> Option<Beside> {
        match self {
            ColourKey::None => None,
            ColourKey::Scale { measure, low, high, .. } => {
                let middle = centre(*low, *high);
                let labels = [(0.0, *low), (0.5, middle), (1.0, *high)];
                let labels = match measure.text(*low) == measure.text(*high) {
                    // Colours of differences that nobody cares for need no scale.
                    true => vec![(0.5, measure.text(middle))],
                    false => labels.map(|(share, x)| (share, measure.text(x))).into(),
                };
                Some(Beside::Scale { title: measure.words.clone(), labels })
            }
            ColourKey::List { name, words, colours, order } => {
                let entry = |&code: &u32| {
                    let colour = colours[code as usize].unwrap_or(Colour::PALE);
                    let word = rounded(&words.distinct()[code as usize]);
                    Entry::new(shortened(&word, 24), Symbol::Dot(colour))
                };
                let mut entries: Vec<Entry> = order.iter().take(LISTED).map(entry).collect();
                if order.len() > LISTED {
                    entries.push(Entry::new("other", Symbol::Dot(Colour::PALE)));
                }
                Some(Beside::Entries { title: name.clone(), entries })
            }
        }
    }
}
