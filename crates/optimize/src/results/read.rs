//! Reading results, which may be of another program, another version, or damaged.

use serde::Deserialize;

use super::{FORMAT, Results, VERSION};

/// Results that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file ends early.
    #[error("ends in the middle (line {line}): it is truncated; run `optimize --resume` again")]
    Truncated {
        /// Line, from 1.
        line: usize,
    },
    /// No JSON.
    #[error("line {line}, column {column}: {what}; run `optimize --resume` again to write it anew")]
    Damaged {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        what: String,
    },
    /// Some other JSON.
    #[error("no results of `powergs-sim optimize`: it has no \"format\": \"{FORMAT}\"")]
    Format,
    /// Another version.
    #[error(
        "version {found}, this program reads {VERSION}; run `optimize --resume` with this program"
    )]
    Version {
        /// The version of the file.
        found: u64,
    },
    /// A value that cannot be.
    #[error("`{key}`: {what}; was the file edited? Run `optimize --resume` to write it anew")]
    Value {
        /// Where.
        key: String,
        /// What is wrong.
        what: String,
    },
}

/// What says whether the rest can be understood.
#[derive(Deserialize)]
struct Head {
    format: Option<String>,
    version: Option<u64>,
}

fn json<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T, ResultsError> {
    serde_json::from_str(text).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        if error.is_eof() {
            return ResultsError::Truncated { line };
        }
        // Line and column are said once.
        let what = error.to_string();
        let end = what.rfind(" at line ").unwrap_or(what.len());
        let what = what[..end].chars().take(200).collect();
        ResultsError::Damaged { line, column, what }
    })
}

impl Results {
    /// Reads `results.json`.
    ///
    /// # Errors
    /// Truncated or damaged text, some other JSON, another version, values that cannot be.
    pub fn parse(text: &str) -> Result<Results, ResultsError> {
        let value: serde_json::Value = json(text)?;
        let head: Head = serde_json::from_value(value).map_err(|_| ResultsError::Format)?;
        if head.format.as_deref() != Some(FORMAT) {
            return Err(ResultsError::Format);
        }
        let found = head.version.ok_or(ResultsError::Format)?;
        if found != u64::from(VERSION) {
            return Err(ResultsError::Version { found });
        }
        let results: Results = json(text)?;
        results.check()?;
        Ok(results)
    }

    /// The file: one object, deterministic.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("numbers and text");
        text + "\n"
    }

    /// What the types do not say.
    fn check(&self) -> Result<(), ResultsError> {
        let wrong = |key: String, what: String| Err(ResultsError::Value { key, what });
        if self.variants.is_empty() {
            return wrong("variants".into(), "is empty".into());
        }
        let known = |name: &str| self.variants.iter().any(|v| v.name == name);
        for (i, v) in self.variants.iter().enumerate() {
            if v.result.as_ref().is_some_and(|name| self.model(name).is_none()) {
                let key = format!("variants[{i}].result");
                return wrong(key, "names a model that is not there".into());
            }
        }
        let watts = |w: f64| w.is_finite() && w >= 0.0;
        for (i, m) in self.models.iter().enumerate() {
            let key = format!("models[{i}]");
            if !(1..=4).contains(&m.level) {
                return wrong(format!("{key}.level"), format!("{} is not 1 to 4", m.level));
            }
            if !known(&m.variant) {
                return wrong(format!("{key}.variant"), "is not one of `variants`".into());
            }
            if !watts(m.display_w) || !watts(m.render_w) {
                return wrong(key, "power is negative".into());
            }
        }
        for (i, f) in self.foveated.iter().enumerate() {
            let key = format!("foveated[{i}]");
            if !known(&f.variant) {
                return wrong(format!("{key}.variant"), "is not one of `variants`".into());
            }
            if f.jobs.iter().any(|job| self.model(job).is_none()) {
                return wrong(format!("{key}.jobs"), "names a model that is not there".into());
            }
            if !watts(f.display_w) || !watts(f.render_w) {
                return wrong(key, "power is negative".into());
            }
        }
        Ok(())
    }
}
