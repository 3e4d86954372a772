//! PageDesigns that a page lets people look at one by one, where scripts run.

use std::collections::BTreeMap;

use serde::Serialize;

/// All of them, as the page holds them.
#[derive(Debug, Clone, Default, Serialize)]
pub struct PageDesigns {
    /// The machine that they differ from; empty if it is not known.
    pub base: String,
    /// A trace that they were simulated on; empty if none is known.
    pub trace: String,
    /// A condition, as an example.
    pub example: String,
    /// What is known of each.
    pub columns: Vec<DesignColumn>,
    /// Name and whether it is on the front, design by design.
    pub names: Vec<(String, bool)>,
    /// Values, design by design in the order of the columns; `None` where there is none.
    pub rows: Vec<Vec<Option<DesignValue>>>,
    /// Values of a column as files have them, where that is not the value itself.
    pub written: BTreeMap<usize, BTreeMap<String, String>>,
    /// Beginnings of the commands of designs.
    pub replays: Vec<DesignReplay>,
    /// What each design adds to one of them, design by design; none where they are not known.
    pub offers: Vec<DesignOffer>,
    /// What the commands of a design are together.
    pub together: String,
    /// Columns that the scatter begins with: across, up, colour.
    pub x: usize,
    /// See `x`.
    pub y: usize,
    /// See `x`.
    pub colour: usize,
}

/// The beginnings of the commands of some designs, quoted for a shell.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DesignReplay {
    /// One for each trace, without the words of a design.
    pub commands: Vec<String>,
    /// The same as comments of a machine file, with its place as `FILE`.
    pub comments: Vec<String>,
}

/// What is handed out of a design.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DesignOffer {
    /// Which beginnings its commands have.
    pub replay: usize,
    /// The words of the design, quoted for a shell.
    pub words: String,
    /// Those of them that a machine file cannot say.
    pub others: String,
    /// Its machine file.
    pub file: String,
}

/// A column.
#[derive(Debug, Clone, Default, Serialize)]
pub struct DesignColumn {
    /// Its name in conditions.
    pub name: String,
    /// Its name where there is little room.
    pub short: String,
    /// What it is.
    pub title: String,
    /// Unit of its values; empty for none.
    pub unit: String,
    /// How much one of that unit is in base units; `None` for texts and plain numbers.
    pub si: Option<f64>,
    /// Whether it has an axis of the parallel plot.
    pub plot: bool,
    /// The key of a machine that it is the value of.
    pub key: Option<String>,
}

/// A value.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum DesignValue {
    /// A number in the unit of the column.
    Number(f64),
    /// A text.
    Text(String),
}

impl PageDesigns {
    /// The data as a script reads it: JSON that ends no element of the page.
    pub(super) fn json(&self) -> String {
        let text = serde_json::to_string(self).unwrap_or_default();
        text.replace('<', "\\u003c")
    }
}
