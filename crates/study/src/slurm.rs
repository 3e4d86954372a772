//! Work in parts on a Slurm cluster, a sweep's or a co-design's: the settings file, the job script,
//! and what Slurm answers.
//!
//! One array job, one part (`--shard i/N`) for each task. The script notes the exit code of its
//! part in a file, so that a part that ended can be told from one that was lost.

pub mod script;
pub mod state;

use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

use powergs_base::config::{self, Config, ConfigError, Problem};
use powergs_base::quantity::Nanoseconds;

/// Most parts; `MaxArraySize` of a cluster is usually smaller (1001).
pub const SHARDS_MAX: u32 = 99_999;

/// `sbatch.toml`: how parts go to a Slurm cluster.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Settings {
    /// Parts of the work, one array task each.
    #[schemars(extend("minimum" = 1, "maximum" = SHARDS_MAX, "x-unit" = "parts"))]
    pub shards: u32,
    /// Tasks that run at the same time at most; absent: as many as the cluster gives.
    #[schemars(extend("minimum" = 1, "maximum" = SHARDS_MAX, "x-unit" = "tasks"))]
    pub at_once: Option<u32>,
    /// How often a lost part is submitted again, before it is given up.
    #[serde(default = "retries")]
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "x-unit" = "times"))]
    pub retries: u32,
    /// Time between two looks at the job, 0.1 s to 1 h.
    #[serde(default = "poll")]
    pub poll: Nanoseconds,
    /// The simulator on the nodes; absent: this program, by its full path.
    pub program: Option<String>,
    /// Shell lines that run before it, each a whole command: `module load gcc`.
    #[serde(default)]
    pub setup: Vec<String>,
    /// Environment variables of the simulator.
    #[serde(default)]
    pub environment: BTreeMap<String, String>,
    /// Long options of `sbatch` without the dashes: `partition = "long"`, `mem = "4G"`,
    /// `exclusive = true`.
    #[serde(default)]
    pub sbatch: BTreeMap<String, SbatchValue>,
}

fn retries() -> u32 {
    3
}

fn poll() -> Nanoseconds {
    Nanoseconds(15e9)
}

/// The value of an `sbatch` option.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SbatchValue {
    /// `--name=text`.
    Text(String),
    /// `--name` alone.
    Flag,
    /// Left out.
    Off,
}

/// Options of `sbatch` that the script sets itself, or that would break following the job.
const OURS: [(&str, &str); 12] = [
    ("array", "set by `shards` and `at-once`"),
    ("chdir", "the tasks run in the folder of the submission"),
    ("error", "the logs are in the output folder under slurm/"),
    ("export", "use [environment]"),
    ("export-file", "use [environment]"),
    ("help", "no option for a job"),
    ("open-mode", "logs are appended to"),
    ("output", "the logs are in the output folder under slurm/"),
    ("parsable", "set by the program"),
    ("test-only", "use --print to look at the script"),
    ("wait", "the program follows the job itself"),
    ("wrap", "the program writes the script"),
];

impl Settings {
    /// Reads `sbatch.toml`.
    ///
    /// # Errors
    /// Everything that is wrong, each with its line: unknown keys, values out of range, options
    /// that the script sets itself, line breaks and other control characters.
    pub fn parse(text: &str) -> Result<Settings, ConfigError> {
        let config = config::parse::<Settings>(text, &[])?;
        let problems = problems(&config);
        config.checked(problems)
    }

    /// Time between two looks at the job, seconds.
    pub fn poll_s(&self) -> f64 {
        self.poll.0 / 1e9
    }
}

fn problems(config: &Config<Settings>) -> Vec<Problem> {
    let settings = &config.value;
    let mut found = Vec::new();
    let mut wrong = |key: &str, message: String| found.push(config.problem(key, message));
    if !(0.1..=3600.0).contains(&settings.poll_s()) {
        wrong("poll", format!("`poll` must be 0.1 s to 1 h, not {}", settings.poll));
    }
    if let Some(program) = &settings.program {
        plain("program", program).unwrap_or_else(|m| wrong("program", m));
    }
    for line in &settings.setup {
        plain("setup", line).unwrap_or_else(|m| wrong("setup", m));
    }
    for (name, value) in &settings.environment {
        let key = format!("environment.{name}");
        let start = |c: char| c.is_ascii_alphabetic() || c == '_';
        let rest = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !(name.starts_with(start) && name.chars().all(rest)) {
            wrong(
                &key,
                format!("`{name}` is not the name of a variable: use letters, digits and _"),
            );
        }
        plain(name, value).unwrap_or_else(|m| wrong(&key, m));
    }
    for (name, value) in &settings.sbatch {
        let key = format!("sbatch.{name}");
        if let Err(message) = option(name, value) {
            wrong(&key, message);
        }
    }
    found
}

/// Whether `name = value` can stand in an `#SBATCH` line.
fn option(name: &str, value: &SbatchValue) -> Result<(), String> {
    if name.contains('_') {
        return Err(format!("options of sbatch have dashes: `{}`", name.replace('_', "-")));
    }
    let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !(name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(letters)) {
        return Err(format!(
            "`{name}` is not a long option of sbatch: write it without dashes before \
                            it, in small letters"
        ));
    }
    if name.len() == 1 {
        return Err(format!("`{name}` is a short option of sbatch: write the long one"));
    }
    if let Some((_, instead)) = OURS.iter().find(|(ours, _)| *ours == name) {
        return Err(format!("`{name}` cannot be set here: {instead}"));
    }
    match value {
        SbatchValue::Text(text) => {
            plain(name, text)?;
            script::directive_value(text).map(|_| ()).map_err(|e| format!("`{name}`: {e}"))
        }
        SbatchValue::Flag | SbatchValue::Off => Ok(()),
    }
}

/// Refuses line breaks and other control characters, and nothing at all.
fn plain(name: &str, text: &str) -> Result<(), String> {
    if text.chars().any(char::is_control) {
        return Err(format!("`{name}` holds a line break or another control character"));
    }
    if text.trim().is_empty() && name != "setup" {
        return Err(format!("`{name}` is empty"));
    }
    Ok(())
}

struct OptionText;

impl Visitor<'_> for OptionText {
    type Value = SbatchValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a text, a whole number, true or false")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<SbatchValue, E> {
        Ok(SbatchValue::Text(text.to_owned()))
    }

    fn visit_i64<E: Error>(self, n: i64) -> Result<SbatchValue, E> {
        Ok(SbatchValue::Text(n.to_string()))
    }

    fn visit_bool<E: Error>(self, on: bool) -> Result<SbatchValue, E> {
        Ok(if on { SbatchValue::Flag } else { SbatchValue::Off })
    }
}

impl<'de> Deserialize<'de> for SbatchValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OptionText)
    }
}

impl JsonSchema for SbatchValue {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SbatchValue".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "x-unit": "a text, a whole number, true or false", "examples": ["1"] })
    }
}
