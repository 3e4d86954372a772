//! The table of samples: CSV with columns `rho`, `display_w`, `render_w`, and others that are not
//! looked at, but for two: rows that say `false` under `passed` missed the quality target and are
//! left out, and `display_spent_w`, display power with all quality above the target spent, takes
//! the place of `display_w` where it has a number.

use std::io::Read;

use super::Sample;

/// More rows are no table of samples.
const ROWS_MAX: usize = 100_000;
/// Longer files are no table of samples.
const BYTES_MAX: u64 = 64 << 20;

/// A table that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// Not CSV, or not readable.
    #[error("{0}; write CSV with the columns rho, display_w, render_w")]
    Csv(#[from] csv::Error),
    /// A column is missing.
    #[error("line 1: no column `{column}`; write the columns rho, display_w, render_w")]
    Column {
        /// Its name.
        column: &'static str,
    },
    /// A value is no number.
    #[error("line {line}, column `{column}`: `{value}` is not {wanted}")]
    Value {
        /// Line of the file, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// What stands there, shortened.
        value: String,
        /// What should.
        wanted: &'static str,
    },
    /// Too long.
    #[error("more than {ROWS_MAX} rows or {BYTES_MAX} bytes: this is not a table of samples")]
    TooLong,
}

/// Reads a table. Returns the samples in the order of the file, and how many rows were left out
/// because they missed the target.
///
/// # Errors
/// Not CSV, a missing column, a value that is no number (with its line), too many rows.
pub fn read_samples(input: impl Read) -> Result<(Vec<Sample>, usize), SampleError> {
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(input.take(BYTES_MAX));
    let headers = reader.headers()?.clone();
    let find = |column: &'static str| match headers.iter().position(|h| h == column) {
        Some(i) => Ok((column, i)),
        None => Err(SampleError::Column { column }),
    };
    let columns = [find("rho")?, find("display_w")?, find("render_w")?];
    let spent = headers.iter().position(|h| h == "display_spent_w");
    let passed = headers.iter().position(|h| h == "passed");
    let (mut samples, mut left_out) = (Vec::new(), 0);
    for (row, record) in reader.records().enumerate() {
        let record = record?;
        if row == ROWS_MAX {
            return Err(SampleError::TooLong);
        }
        let line = record.position().map_or(0, csv::Position::line);
        let bad = |column, value: &str, wanted| {
            let value = value.chars().take(40).collect();
            SampleError::Value { line, column, value, wanted }
        };
        match passed.map(|i| &record[i]) {
            None | Some("true" | "1" | "yes") => {}
            Some("false" | "0" | "no") => {
                left_out += 1;
                continue;
            }
            Some(other) => return Err(bad("passed", other, "true or false")),
        }
        let mut values = [0.0; 3];
        for ((column, i), value) in columns.iter().zip(&mut values) {
            let spent = spent.filter(|s| *column == "display_w" && !record[*s].is_empty());
            let (column, i) = match spent {
                Some(spent) => (&"display_spent_w", spent),
                None => (column, *i),
            };
            let text = &record[i];
            let number = text.parse().ok().filter(|v: &f64| v.is_finite());
            *value = number.ok_or_else(|| bad(column, text, "a finite number"))?;
        }
        samples.push(Sample { rho: values[0], display_w: values[1], render_w: values[2] });
    }
    if reader.position().byte() >= BYTES_MAX {
        return Err(SampleError::TooLong);
    }
    Ok((samples, left_out))
}
