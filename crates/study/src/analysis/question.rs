//! What is asked of a table of results.

use std::fmt;

use super::table::Table;
use crate::sweep::expr::Expr;
pub use crate::sweep::objective::{EPSILON, Goal, Objective};
use crate::sweep::space::FreeAxis;

/// Which rows of a point count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// The weighted mean over the traces.
    Mean,
    /// Of each column the worst trace.
    Worst,
    /// The trace of this label.
    Trace(String),
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Scope::Mean => f.write_str("mean over the traces"),
            Scope::Worst => f.write_str("worst trace of each column"),
            Scope::Trace(label) => write!(f, "trace {label}"),
        }
    }
}

/// How a question names a design.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Named {
    /// The base machine.
    Baseline,
    /// A point by its number.
    Point(u64),
    /// A point by the hex digits that its hash begins with, at least four.
    Id(String),
}

/// What is asked of a table of results.
#[derive(Debug, Clone)]
pub struct Question {
    /// The question of the sweep file, in words; empty if it states none.
    pub text: String,
    /// What to make small or large, at least one.
    pub objectives: Vec<Objective>,
    /// Designs that do not meet it are left out.
    pub condition: Option<Expr>,
    /// Which rows of a point count.
    pub scope: Scope,
    /// Label of the energy table; `None`: the first of the results.
    pub energy_table: Option<String>,
    /// The column that colours the points of the charts; `None`: one that suits.
    pub colour: Option<String>,
    /// The design whose distance from the front is asked for.
    pub design: Named,
    /// How many of the top designs the rankings show.
    pub top: usize,
    /// Values that differ by at most this share of the larger one count as equal.
    pub epsilon: f64,
    /// What becomes of designs that miss the display rate.
    pub misses: Misses,
    /// Axes that cost nothing, where that is known: only words need them.
    pub free: Vec<FreeAxis>,
    /// What is right in the base machine and in the energy tables, and doubtful, in sentences
    /// without their ends: only words need them.
    pub doubts: Vec<String>,
    /// Frames per second that the display shows, where that is known: only words need it.
    pub display_fps: Option<f64>,
    /// A line where powers are, watts: only charts need it.
    pub budget_w: Option<f64>,
}

/// What becomes of designs that take longer than a display period for some frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Misses {
    /// They rank behind all that meet the display rate.
    #[default]
    Behind,
    /// They are ranked like all others.
    Included,
}

impl Question {
    /// The default question with these objectives.
    pub fn of(objectives: Vec<Objective>) -> Question {
        Question {
            text: String::new(),
            objectives,
            condition: None,
            scope: Scope::Mean,
            energy_table: None,
            colour: None,
            design: Named::Baseline,
            top: 10,
            epsilon: EPSILON,
            misses: Misses::Behind,
            free: Vec::new(),
            doubts: Vec::new(),
            display_fps: None,
            budget_w: None,
        }
    }

    /// The metrics besides the axes that an answer needs.
    pub fn needs(&self, column: &str) -> bool {
        let part =
            |name: &str| name == column || name.split_once(':').is_some_and(|n| n.1 == column);
        let named = |o: &Objective| o.name == column || o.columns().iter().any(|c| part(c));
        USEFUL.contains(&column)
            || ENERGY_PARTS.contains(&column)
            || POWER_PARTS.contains(&column)
            || self.objectives.iter().any(named)
            || self.colour.as_deref() == Some(column)
            || self.condition.as_ref().is_some_and(|c| c.names().into_iter().any(part))
    }
}

/// Metrics that prices, charts and tables use besides the objectives.
const USEFUL: [&str; 13] = [
    "area_mm2",
    "area_mm2.core",
    "dram_bytes",
    "frame_time_ms.p99",
    "power_w.mean",
    "fps.mean",
    "fps.min",
    "energy_pj.mean",
    "frame_time_ms.mean",
    "frame_time_ms.max",
    "frame_latency_ms",
    "deadline_missed_frac",
    "frames",
];

/// The parts of the energy of a frame.
pub const ENERGY_PARTS: [&str; 6] = [
    "energy_pj.dram",
    "energy_pj.sram",
    "energy_pj.flop",
    "energy_pj.leakage",
    "energy_pj.background",
    "energy_pj.refresh",
];

/// The parts of the power at the display rate.
const POWER_PARTS: [&str; 6] = [
    "power_w.dram",
    "power_w.sram",
    "power_w.flop",
    "power_w.leakage",
    "power_w.background",
    "power_w.refresh",
];

/// Why a table does not answer a question.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AnalysisError {
    /// A name that is no column.
    #[error("no column `{name}`{hint}")]
    Column {
        /// The name.
        name: String,
        /// What to write instead.
        hint: String,
    },
    /// A column of words where numbers are needed.
    #[error("column `{0}` has words: an objective needs numbers")]
    Words(String),
    /// No objective, or one that is named twice.
    #[error("{0}")]
    Objectives(String),
    /// A label that does not occur.
    #[error("no {what} `{name}` in the results: there are {known}")]
    Label {
        /// `energy table` or `trace`.
        what: &'static str,
        /// The label.
        name: String,
        /// The labels that occur.
        known: String,
    },
    /// The condition cannot be evaluated.
    #[error("the condition: {0}")]
    Condition(String),
    /// No row of the wanted kind has all objectives.
    #[error("no design has a value of every objective ({scope}, energy table `{energy_table}`)")]
    Nothing {
        /// Which rows were analysed.
        scope: String,
        /// Which energy table.
        energy_table: String,
    },
    /// No design meets the condition.
    #[error(
        "none of {designs} designs meets the condition on every trace{}{}{}",
        parts_text(.parts),
        .nearest.as_ref().map_or(String::new(), |nearest| format!("; nearest: {nearest}")),
        tables_text(.tables)
    )]
    Unmet {
        /// Designs that were analysed.
        designs: usize,
        /// Each part of the condition with the number of designs that meet it.
        parts: Vec<(String, usize)>,
        /// The design that misses it least, and each part that it misses, by which share of its
        /// limit and where, in words.
        nearest: Option<String>,
        /// Other energy tables under which some designs meet it, and how many.
        tables: Vec<(String, usize)>,
    },
    /// A design that is not there.
    #[error(
        "no design `{0}` in the results: name a point (`12`), the first digits of its id, or \
         `baseline`"
    )]
    Design(String),
    /// A hash that several designs begin with.
    #[error("several designs begin with `{0}`: write more digits")]
    Ambiguous(String),
}

fn parts_text(parts: &[(String, usize)]) -> String {
    if parts.len() < 2 {
        return String::new();
    }
    let one = |(text, n): &(String, usize)| format!("`{text}` alone: {n}");
    format!("; {}", parts.iter().map(one).collect::<Vec<_>>().join(", "))
}

fn tables_text(tables: &[(String, usize)]) -> String {
    let one = |(label, n): &(String, usize)| format!("; under `{label}` {n} meet it");
    tables.iter().map(one).collect()
}

impl AnalysisError {
    /// No column of the table is called `name`.
    pub(crate) fn column(name: &str, table: &Table) -> AnalysisError {
        let names: Vec<&str> = super::designs::names(table).collect();
        let axes = table.axes.iter().map(|(axis, _)| axis.as_str());
        let hint = crate::sweep::run::column_hint(name, &names, axes);
        AnalysisError::Column { name: name.to_owned(), hint }
    }
}
