//! What became of one design on one trace under one energy table, as it is kept in journals.

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;

/// What became of one design on one trace under one energy table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// It was simulated.
    Ok(Outcome),
    /// It could not be simulated, for this reason.
    Failed(String),
    /// The simulator contradicted itself: a defect of ours.
    Defect(String),
}

impl Record {
    /// One line of JSON.
    pub fn text(&self) -> String {
        serde_json::to_string(self).expect("numbers and texts")
    }

    /// Reads [`Record::text`]; `None` if it is none.
    pub fn parse(text: &str) -> Option<Record> {
        serde_json::from_str(text).ok()
    }
}
