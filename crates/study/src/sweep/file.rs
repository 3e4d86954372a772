//! Sweep files: `arch-configs/sweeps/*.toml` as they are written. What they span is a
//! [`Space`](super::space::Space).

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::objective::{EPSILON, Objective};
use place::Places;
use powergs_base::config::{self, ConfigError, Problem};

pub(super) mod place;
mod settings;

pub use settings::{Raw, Settings, Zip, ZipValues};

/// A sweep file. Its keys have the right types; whether they name anything is checked with the
/// space.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SweepFile {
    /// The question that the sweep answers; the report repeats it.
    pub question: String,
    /// Machine that everything starts from: a name, or a path.
    pub base: String,
    /// Keys that every point has, as `--set` gives them.
    #[serde(default)]
    pub set: Settings,
    /// Traces; those of the command line come in their place.
    #[serde(default)]
    pub traces: Vec<TraceSpec>,
    /// Energy tables that price every point; without any, the machine's own.
    #[serde(default)]
    pub energy: Vec<EnergySpec>,
    /// Display preset, a name or a path; without it there is no display power.
    pub display: Option<String>,
    /// Frames per second that the display shows.
    #[serde(default = "display_fps")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 10000, "x-unit" = "1/s"))]
    pub display_fps: f64,
    /// What is wanted; columns of the results.
    #[serde(default)]
    pub objectives: Objectives,
    /// What is varied, the last axis fastest.
    #[serde(default)]
    pub axes: Vec<AxisSpec>,
    /// Keys that follow from others: an expression for each.
    #[serde(default)]
    pub derived: Settings,
    /// Expressions that every point must fulfil before it is simulated.
    #[serde(default)]
    pub constraints: Vec<String>,
    /// Which points of the space are taken.
    #[serde(default)]
    pub sampling: Sampling,
    /// Whether the conditions of axes may hold at none of the points: where several sweeps have the
    /// same axes, so that points have the same numbers in all of them.
    #[serde(skip)]
    #[schemars(skip)]
    pub has_common_axes: bool,
    /// Where the files lie that it names, but for `base`; the working folder without one.
    #[serde(skip)]
    #[schemars(skip)]
    pub folder: Option<PathBuf>,
    /// What was set on a command line: `key=value`, whose keys are among those of `set`.
    #[serde(skip)]
    #[schemars(skip)]
    pub typed: Vec<String>,
    /// The text, for the places of problems.
    #[serde(skip)]
    #[schemars(skip)]
    pub(super) text: String,
}

const fn display_fps() -> f64 {
    60.0
}

/// One or more traces.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TraceSpec {
    /// Path of a trace file; `*` and `?` stand for any characters of a name.
    pub path: String,
    /// Name in results; without one, that of the file.
    pub label: Option<String>,
    /// Share in means over traces, any positive number.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1e9, "x-unit" = "weight"))]
    pub weight: f64,
}

const fn one() -> f64 {
    1.0
}

/// One energy table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EnergySpec {
    /// Name in results: letters, digits, `-`, `_` and `.`.
    pub label: String,
    /// Name of the table, or a path.
    pub table: String,
    /// Keys of the table that are different, e.g. the price of DRAM.
    #[serde(default)]
    pub set: Settings,
}

/// Columns of the results that are to be small or large.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Objectives {
    /// The smaller the better.
    #[serde(default)]
    pub minimize: Vec<String>,
    /// The larger the better.
    #[serde(default)]
    pub maximize: Vec<String>,
    /// Whether designs that miss the display rate rank like all others; they rank behind without
    /// it.
    #[serde(default)]
    pub include_misses: bool,
    /// Values that differ by at most this share of the larger one count as equal.
    #[serde(default = "epsilon")]
    #[schemars(extend("minimum" = 0, "maximum" = 0.5, "x-unit" = "share"))]
    pub epsilon: f64,
}

const fn epsilon() -> f64 {
    EPSILON
}

impl Objectives {
    /// All, those that are to be small first.
    pub fn all(&self) -> Vec<Objective> {
        let minimize = self.minimize.iter().map(Objective::minimize);
        minimize.chain(self.maximize.iter().map(Objective::maximize)).collect()
    }
}

impl Default for Objectives {
    fn default() -> Self {
        let columns = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        Self {
            minimize: columns(&["power_w.mean", "area_mm2"]),
            maximize: columns(&["fps.mean"]),
            include_misses: false,
            epsilon: EPSILON,
        }
    }
}

/// One axis: exactly one of `key` with `values` or `range`, `zip`, and `variants`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct AxisSpec {
    /// The key that is varied: `vru.cores`, `dram:timing.burst`, `machine`.
    pub key: Option<String>,
    /// Its values, in order.
    pub values: Option<Vec<Raw>>,
    /// Its values as a row of numbers.
    pub range: Option<RangeSpec>,
    /// Name of an axis with several keys; that of its first key, if there is none.
    pub name: Option<String>,
    /// Keys whose n-th values go together; all lists have the same length.
    pub zip: Option<Zip>,
    /// Settings with a name.
    pub variants: Option<Vec<VariantSpec>>,
    /// The axis counts only where this expression holds; elsewhere its keys keep what they have.
    pub when: Option<String>,
}

/// A row of numbers.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RangeSpec {
    /// The first value.
    pub from: Raw,
    /// The last value, or what the last value does not exceed.
    pub to: Raw,
    /// Difference of neighbours.
    pub step: Option<Raw>,
    /// Ratio of neighbours.
    #[schemars(extend("exclusiveMinimum" = 1, "maximum" = 1e9, "x-unit" = "factor"))]
    pub factor: Option<f64>,
    /// Number of values, both ends among them.
    #[schemars(range(min = 2, max = 100_000), extend("x-unit" = "values"))]
    pub count: Option<u32>,
    /// How `count` values are spaced; `log2` alone doubles from value to value.
    pub scale: Option<Scale>,
}

/// How numbers are spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Powers of two.
    Log2,
    /// Equal ratios.
    Geometric,
}

/// Settings with a name.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct VariantSpec {
    /// The value of the axis.
    pub name: String,
    /// Keys with their values.
    #[serde(default)]
    pub set: Settings,
}

/// Which points are taken.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Sampling {
    /// How they are chosen.
    pub method: Method,
    /// How many, before constraints; all points of a `grid` without it. `nsga2` simulates at most
    /// that many.
    #[schemars(range(min = 1, max = 1_000_000_000_000u64), extend("x-unit" = "points"))]
    pub points: Option<u64>,
    /// Seed of everything that is drawn.
    #[schemars(extend("x-unit" = "seed"))]
    pub seed: u64,
    /// Points of a generation of `nsga2`.
    #[schemars(range(min = 4, max = 10_000), extend("x-unit" = "points"))]
    pub population: u32,
    /// Generations of `nsga2`, the first among them.
    #[schemars(range(min = 1, max = 100_000), extend("x-unit" = "generations"))]
    pub generations: u32,
}

impl Sampling {
    /// Points of a generation of a search: fewer than four have no front to spread.
    pub fn generation(&self) -> u32 {
        self.population.max(4)
    }

    /// Points that a search asks for, at most.
    pub fn searched(&self) -> u64 {
        u64::from(self.generation()) * u64::from(self.generations)
    }
}

impl Default for Sampling {
    fn default() -> Self {
        Self { method: Method::Grid, points: None, seed: 1, population: 32, generations: 16 }
    }
}

/// How points are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Every point, or `points` of them evenly spread over their numbers.
    Grid,
    /// Drawn at random, each once.
    Random,
    /// Latin hypercube: along every axis all values are drawn equally often.
    Lhs,
    /// The Sobol sequence with a random shift: covers the space evenly, any first part of it too.
    Sobol,
    /// Adaptive search for the Pareto front of the objectives.
    Nsga2,
}

impl Method {
    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Method::Grid => "grid",
            Method::Random => "random",
            Method::Lhs => "lhs",
            Method::Sobol => "sobol",
            Method::Nsga2 => "nsga2",
        }
    }
}

impl SweepFile {
    /// Reads a sweep file.
    ///
    /// # Errors
    /// Everything that is wrong with its form, each with its line: unknown keys, missing ones,
    /// wrong types. What its axes name is checked by [`Space::new`](super::space::Space::new).
    pub fn parse(text: &str) -> Result<SweepFile, ConfigError> {
        let (file, problems) = SweepFile::parse_around(text)?;
        if problems.is_empty() { Ok(file) } else { Err(ConfigError::new(problems)) }
    }

    /// As [`SweepFile::parse`], but problems that do not keep its space from being looked at are
    /// beside it, such as unknown keys: [`Space::whole`](super::space::Space::whole) tells them
    /// with the others.
    ///
    /// # Errors
    /// As [`SweepFile::parse`], if there is a problem of another kind.
    pub fn parse_around(text: &str) -> Result<(SweepFile, Vec<Problem>), ConfigError> {
        let (config, mut problems) = config::document::parse_around::<SweepFile>(text, &[])?;
        let mut file = config.value;
        text.clone_into(&mut file.text);
        problems.extend(file.own_problems());
        Ok((file, problems))
    }

    /// Places in the text.
    pub(super) fn places(&self) -> Places<'_> {
        Places::new(&self.text, &self.typed)
    }

    /// The text that it was read from.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn own_problems(&self) -> Vec<Problem> {
        let places = self.places();
        let mut problems = Vec::new();
        let mut wrong = |path: &str, message: String| problems.push(places.problem(path, message));
        if self.question.trim().is_empty() {
            wrong("question", "`question` is empty: say what the sweep is to answer".into());
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        for (i, energy) in self.energy.iter().enumerate() {
            let path = format!("energy.{i}.label");
            let label = &energy.label;
            if label.is_empty() || !label.chars().all(plain) || label.starts_with('.') {
                wrong(&path, "`label` must be letters, digits, `-`, `_` and `.`".into());
            }
            if self.energy[..i].iter().any(|e| e.label == *label) {
                wrong(&path, format!("a second table with the label `{label}`"));
            }
            if ["energy", "dram", "display", "machine"].contains(&label.as_str()) {
                wrong(&path, format!("`{label}:` means a file in expressions: take another label"));
            }
        }
        if !(0.0..=0.5).contains(&self.objectives.epsilon) {
            wrong("objectives.epsilon", "`epsilon` must be a share from 0 to 0.5".into());
        }
        let columns = self.objectives.minimize.iter().chain(&self.objectives.maximize);
        let columns: Vec<&String> = columns.collect();
        if columns.is_empty() {
            wrong("objectives", "`objectives` names no column: leave it out, or name one".into());
        }
        for (i, column) in columns.iter().enumerate() {
            if columns[..i].contains(column) {
                wrong("objectives", format!("the objective `{column}` appears twice"));
            }
        }
        problems
    }
}
