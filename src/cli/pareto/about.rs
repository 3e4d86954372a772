//! What the analysis of a sweep says about it besides its numbers.

use std::collections::BTreeSet;

use powergs_report::sweep::Provenance;
use powergs_study::analysis::question::default_objectives;
use powergs_study::analysis::{Objective, Question};
use powergs_study::sweep::run::OpenedSweep;

/// A sweep as its analysis sees it.
#[derive(Debug, Default)]
pub(super) struct About {
    /// The question of the sweep file; empty without one.
    pub text: String,
    /// Objectives of the sweep file.
    pub objectives: Vec<Objective>,
    /// Columns of keys that follow from others.
    pub followers: BTreeSet<String>,
    /// Names of sweep files.
    pub sweeps: Vec<String>,
    /// Names of traces.
    pub traces: Vec<String>,
}

impl About {
    /// A sweep that was just run.
    pub(super) fn of_sweep(sweep: &OpenedSweep<'_>) -> About {
        let file = &sweep.file;
        let derived = file.derived.0.iter().map(|(key, _)| key.clone());
        // Of keys that are varied together, all but the first follow.
        let zips = file.axes.iter().filter_map(|axis| axis.zip.as_ref());
        let together = zips.flat_map(|zip| zip.0.iter().skip(1).map(|(key, _)| key.clone()));
        About {
            text: file.question.trim().to_owned(),
            objectives: sweep.objectives.clone(),
            followers: derived.chain(together).collect(),
            sweeps: sweep.state.names("sweep"),
            traces: sweep.state.names("trace"),
        }
    }

    /// The question of the sweep file, with the answers that are asked for by default.
    pub(super) fn question(&self) -> Question {
        let objectives = match self.objectives.is_empty() {
            false => self.objectives.clone(),
            true => default_objectives(),
        };
        Question { text: self.text.clone(), ..Question::of(objectives) }
    }

    /// Where a report comes from: the sweep by the names of its files, and what was typed for this
    /// report. Nothing in it depends on where the folder is.
    pub(super) fn provenance(&self, typed: &[String]) -> Provenance {
        let title = self.sweeps.first().map_or("", |name| name.trim_end_matches(".toml"));
        let words = ["powergs-sim".to_owned(), "sweep".to_owned()].into_iter();
        let words = words.chain(self.sweeps.iter().cloned()).chain(["--traces".to_owned()]);
        let mut commands = vec![line(words.chain(self.traces.iter().cloned()))];
        if self.sweeps.is_empty() {
            commands.clear();
        }
        match typed {
            [] => commands.push("powergs-sim pareto DIR".into()),
            typed => commands.push(line(typed.iter().cloned())),
        }
        Provenance { title: format!("Sweep {title}").trim().to_owned(), commands }
    }
}

/// Words as one line of a shell; the program without its folder.
fn line(words: impl Iterator<Item = String>) -> String {
    let quoted = |(i, word): (usize, String)| {
        let word = match (i, word.rsplit(['/', '\\']).next()) {
            (0, Some(name)) => name.to_owned(),
            _ => word,
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    words.enumerate().map(quoted).collect::<Vec<_>>().join(" ")
}
