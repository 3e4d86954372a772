//! `state.toml` of a sweep folder: everything that its results depend on. A sweep is continued only
//! with the same.

use serde::{Deserialize, Serialize};

use crate::sweep::outcome::OUTCOME_VERSION;
use powergs_base::{SCHEMA_VERSION, TOOL_VERSION};
use powergs_core::run::{Input, RunError, Store};
use powergs_core::sim::MODEL_VERSION;

/// Its name in the folder.
pub const FILE: &str = "state.toml";

/// How another display rate stands in the record of a sweep.
pub(super) const FPS: &str = "--fps ";

/// What the results of a sweep depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct State {
    schema_version: u32,
    tool_version: String,
    model_version: u32,
    outcome_version: u32,
    /// Options that change results, as they are typed.
    options: Vec<String>,
    /// Files that were read.
    inputs: Vec<StateInput>,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct StateInput {
    role: String,
    name: String,
    bytes: u64,
    xxh3_128: String,
}

impl State {
    /// Flags of the command that change what the sweep file says.
    pub fn flags(&self) -> impl Iterator<Item = &str> {
        // Other options are notes.
        self.options.iter().map(String::as_str).filter(|option| option.starts_with("--"))
    }

    /// The display rate of the command, frames per second.
    pub fn display_fps(&self) -> Option<f64> {
        self.flags().find_map(|flag| flag.strip_prefix(FPS)?.parse().ok())
    }

    /// The state of a sweep that is about to run.
    pub fn new(options: Vec<String>, inputs: &[Input]) -> State {
        let input = |i: &Input| StateInput {
            role: i.role.into(),
            name: i.name.clone(),
            bytes: i.bytes,
            xxh3_128: format!("{:032x}", i.xxh3),
        };
        State {
            schema_version: SCHEMA_VERSION,
            tool_version: TOOL_VERSION.into(),
            model_version: MODEL_VERSION,
            outcome_version: OUTCOME_VERSION,
            options,
            inputs: inputs.iter().map(input).collect(),
        }
    }

    /// The state of a folder; `None` if there is none.
    ///
    /// # Errors
    /// [`RunError::Input`]: the file is not the state of a sweep.
    pub fn read(store: &dyn Store) -> Result<Option<State>, RunError> {
        let Some(text) = store.read_text(FILE)? else { return Ok(None) };
        toml::from_str(&text).map(Some).map_err(|e| RunError::Input {
            place: store.place(FILE),
            message: format!("this is not the state of a sweep; use another folder: {e}"),
        })
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be written.
    pub fn write(&self, store: &dyn Store) -> Result<(), RunError> {
        store.write(FILE, self.toml().as_bytes())
    }

    /// Names of the inputs with a role: `sweep`, `trace`, `machine`, ….
    pub fn names(&self, role: &str) -> Vec<String> {
        let of_role = self.inputs.iter().filter(|input| input.role == role);
        of_role.map(|input| input.name.clone()).collect()
    }

    /// The file.
    pub fn toml(&self) -> String {
        let head = "# What this sweep was made from. It is continued only with the same.\n";
        format!("{head}{}", toml::to_string(self).expect("plain values"))
    }

    /// A hash of everything in it.
    pub fn hash(&self) -> u128 {
        xxhash_rust::xxh3::xxh3_128(self.toml().as_bytes())
    }

    /// How `now` differs from what the folder was begun with, a line each.
    pub fn differences(&self, now: &State) -> Vec<String> {
        let mut found = Vec::new();
        let mut version =
            |what: &str, then: &dyn std::fmt::Display, now: &dyn std::fmt::Display| {
                let (then, now) = (then.to_string(), now.to_string());
                if then != now {
                    found.push(format!("{what} was {then}, now it is {now}"));
                }
            };
        version("the version of the model", &self.model_version, &now.model_version);
        version("the version of outcomes", &self.outcome_version, &now.outcome_version);
        version("the version of the table", &self.schema_version, &now.schema_version);
        version("the options", &self.options.join(" "), &now.options.join(" "));
        found.extend(input_differences(&self.inputs, &now.inputs));
        if found.is_empty() && self != now {
            found.push(format!(
                "the program was {}, now it is {}",
                self.tool_version, now.tool_version
            ));
        }
        found
    }
}

/// How the files that are read now differ from those of then. Several files may have one role and
/// name: two traces `final.bin` in two folders.
fn input_differences(then: &[StateInput], now: &[StateInput]) -> Vec<String> {
    let mut gone: Vec<&StateInput> = then.iter().collect();
    let mut take = |found: &dyn Fn(&StateInput) -> bool| {
        let place = gone.iter().position(|input| found(input))?;
        Some(gone.remove(place))
    };
    let changed: Vec<&StateInput> =
        now.iter().filter(|input| take(&|then| then == *input).is_none()).collect();
    let mut found = Vec::new();
    for input in changed {
        let StateInput { role, name, bytes, .. } = input;
        found.push(match take(&|then| then.role == *role && then.name == *name) {
            Some(then) => {
                format!("{role} `{name}` has changed ({} bytes then, {bytes} now)", then.bytes)
            }
            None => format!("{role} `{name}` is new"),
        });
    }
    found.extend(gone.iter().map(|then| format!("{} `{}` is gone", then.role, then.name)));
    if found.is_empty() && then != now {
        found.push("the files are the same, in another order".to_owned());
    }
    found
}
