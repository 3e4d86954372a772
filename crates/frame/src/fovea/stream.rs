//! Gaze over time: CSV files of an eye tracker.
//!
//! The first line names the columns: `time_s,x,y` for both eyes together, or
//! `time_s,left_x,left_y,right_x,right_y`. Times are seconds and ascend; gazes are shares of width
//! and height. A row with empty cells is a blink: nothing is known. Between samples the last one
//! is **held**; where nothing has been known for longer than the largest gap, there is **no gaze,
//! and that is an error**.

use super::GazeError;
use crate::scene::Eye;

/// One sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GazeSample {
    /// Seconds.
    pub time_s: f64,
    /// Gaze of the left and the right eye; `None` while it is closed.
    pub gaze: [Option<[f32; 2]>; 2],
}

/// The samples of a file, in order of time; at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct GazeStream {
    samples: Vec<GazeSample>,
}

/// A faulty gaze stream.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StreamError {
    /// No column names that are known.
    #[error(
        "line 1: the columns are `{found}`; name them `time_s,x,y` or \
         `time_s,left_x,left_y,right_x,right_y`"
    )]
    Columns {
        /// What is there.
        found: String,
    },
    /// A line that cannot be read.
    #[error("line {line}: {what}")]
    Line {
        /// From 1.
        line: u64,
        /// What is wrong, and what to do.
        what: String,
    },
    /// No samples.
    #[error("no samples: the stream ends after its column names; record it again")]
    Empty,
    /// Nothing is known at a time.
    #[error(
        "no gaze at {time_s:.3} s: {since}; the largest gap that is held is {gap_s} s (--gaze-gap)"
    )]
    Gap {
        /// The time that was asked for.
        time_s: f64,
        /// Where the last gaze is, in words.
        since: String,
        /// The largest gap.
        gap_s: f64,
    },
}

fn line(line: u64, what: impl Into<String>) -> StreamError {
    StreamError::Line { line, what: what.into() }
}

impl GazeStream {
    /// Reads a file.
    ///
    /// # Errors
    /// Unknown columns; cells that are no numbers, gazes outside of the picture and times that do
    /// not ascend, each with its line; a file without samples.
    pub fn parse(text: &str) -> Result<GazeStream, StreamError> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let mut rows = reader.records();
        let columns = match rows.next() {
            None => return Err(StreamError::Columns { found: String::new() }),
            Some(row) => row.map_err(|e| line(1, e.to_string()))?,
        };
        let names: Vec<&str> = columns.iter().collect();
        let eyes: [[usize; 2]; 2] = match names[..] {
            ["time_s", "x", "y"] => [[1, 2]; 2],
            ["time_s", "left_x", "left_y", "right_x", "right_y"] => [[1, 2], [3, 4]],
            _ => {
                let found = names.join(",").chars().take(80).collect();
                return Err(StreamError::Columns { found });
            }
        };
        let mut samples: Vec<GazeSample> = Vec::new();
        for row in rows {
            let row = row.map_err(|e| line(e.position().map_or(0, |p| p.line()), e.to_string()))?;
            let at = row.position().map_or(0, |p| p.line());
            let sample = sample(&row, names.len(), eyes).map_err(|what| line(at, what))?;
            if samples.last().is_some_and(|last| last.time_s >= sample.time_s) {
                return Err(line(at, "times must ascend; sort the file by `time_s`"));
            }
            samples.push(sample);
        }
        if samples.is_empty() { Err(StreamError::Empty) } else { Ok(GazeStream { samples }) }
    }

    /// The samples, in order of time.
    pub fn samples(&self) -> &[GazeSample] {
        &self.samples
    }

    /// The gaze of an eye at a time: the last known one, if it is at most `gap_s` seconds old.
    ///
    /// # Errors
    /// [`StreamError::Gap`] where nothing is known, before the first sample too.
    pub fn at(&self, time_s: f64, eye: Eye, gap_s: f64) -> Result<[f32; 2], StreamError> {
        // A time that is a sample's but for rounding is that sample's.
        let end = self.samples.partition_point(|s| s.time_s <= time_s + 1e-9);
        let known = self.samples[..end].iter().rev();
        let mut known = known.filter_map(|s| s.gaze[eye as usize].map(|gaze| (s.time_s, gaze)));
        let since = match known.next() {
            Some((at, gaze)) if time_s - at <= gap_s + 1e-9 => return Ok(gaze),
            Some((at, _)) => format!("the last one is of {at:.3} s"),
            None => "none was known before".to_owned(),
        };
        Err(StreamError::Gap { time_s, since, gap_s })
    }
}

fn sample(
    row: &csv::StringRecord,
    columns: usize,
    eyes: [[usize; 2]; 2],
) -> Result<GazeSample, String> {
    if row.len() != columns {
        return Err(format!("{} cells, and there are {columns} columns", row.len()));
    }
    let number = |i: usize| {
        let value: Option<f64> = row[i].parse().ok().filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| format!("`{}` is not a number", clip(&row[i])))
    };
    let time_s = number(0)?;
    let mut gaze = [None; 2];
    for (gaze, [x, y]) in gaze.iter_mut().zip(eyes) {
        *gaze = match (row[x].is_empty(), row[y].is_empty()) {
            (true, true) => None,
            (false, false) => {
                let (x, y) = (number(x)?, number(y)?);
                let is_on = |v: f64| (0.0..=1.0).contains(&v);
                if !is_on(x) || !is_on(y) {
                    return Err(GazeError::Gaze { x, y }.to_string());
                }
                Some([x as f32, y as f32])
            }
            _ => return Err("a gaze with one number; leave both cells empty in a blink".into()),
        };
    }
    Ok(GazeSample { time_s, gaze })
}

fn clip(text: &str) -> String {
    text.chars().take(40).collect()
}
