//! Axes that are too short: the whole front is at one of their ends.

use super::table::Table;

/// An axis whose first or last value all designs of a front have.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct AtEnd {
    /// Name of the axis.
    pub axis: String,
    /// The value that they have.
    pub value: String,
    /// The value at the other end.
    pub other: String,
    /// Whether it is the largest.
    pub is_largest: bool,
}

/// The axes of numbers at one end of which every design of a front is. `entries` are the rows of
/// the front, each with those that are equal to it: a design that has an equal elsewhere on the
/// axis is not bound by its end. `rows` are all rows, for the ends. Below zero, and below one of
/// something that is counted, there is nothing: such an end is none.
pub fn at_ends(table: &Table, rows: &[u32], entries: &[Vec<u32>]) -> Vec<AtEnd> {
    let mut found = Vec::new();
    for (axis, words) in table.axes.iter().filter(|(_, words)| words.is_numeric()) {
        let value = |row: &u32| words.number(*row).unwrap_or(f64::NAN);
        let by_value = |a: &&u32, b: &&u32| value(a).total_cmp(&value(b));
        let ends = (rows.iter().min_by(by_value), rows.iter().max_by(by_value));
        let (Some(least), Some(most)) = ends else { continue };
        if value(least) >= value(most) {
            continue;
        }
        let all_at = |end: f64| {
            !entries.is_empty() && entries.iter().all(|e| e.iter().all(|row| value(row) == end))
        };
        let is_last = |row: &u32| {
            let is_count = words.distinct().iter().all(|w| w.parse::<u64>().is_ok());
            value(row) <= 0.0 || (is_count && value(row) <= 1.0)
        };
        let word = |row: &u32| words.word(*row).to_owned();
        if all_at(value(most)) {
            let (value, other) = (word(most), word(least));
            found.push(AtEnd { axis: axis.clone(), value, other, is_largest: true });
        } else if all_at(value(least)) && !is_last(least) {
            let (value, other) = (word(least), word(most));
            found.push(AtEnd { axis: axis.clone(), value, other, is_largest: false });
        }
    }
    found
}
