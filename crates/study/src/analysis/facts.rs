//! What the analysis of a sweep says about it besides its numbers.

use std::collections::BTreeSet;

use powergs_core::run::{RunError, Store};

use super::{Misses, Question, Table};
use crate::sweep::SweepFile;
use crate::sweep::expr::Expr;
use crate::sweep::file::Objectives;
use crate::sweep::run::finish::{Finished, RUN_FILE, SWEEP_FILE};
use crate::sweep::run::{HandOut, OpenedSweep, State};
use crate::sweep::space::FreeAxis;

/// A sweep as its analysis sees it.
#[derive(Debug, Default)]
pub struct SweepFacts {
    /// The question of the sweep file; empty without one.
    pub question: String,
    /// Objectives of the sweep file.
    pub objectives: Option<Objectives>,
    /// Frames per second that the display shows, as the sweep file or `--fps` says.
    pub display_fps: Option<f64>,
    /// Flags of the command that change what the sweep file says.
    pub options: Vec<String>,
    /// Axes that cost nothing; of a sweep in a folder, if it is finished.
    pub free: Vec<FreeAxis>,
    /// What is right in the base machine and in the energy tables, and doubtful; of a sweep in a
    /// folder, if it is finished.
    pub doubts: Vec<String>,
    /// Points that constraints exclude.
    pub excluded: u64,
    /// Columns of keys that follow from others.
    pub followers: BTreeSet<String>,
    /// Columns of axes that count only where a condition holds.
    pub conditions: Vec<(String, Expr)>,
    /// What its designs are handed out with; none where that is not known.
    pub hand_out: Option<HandOut>,
    /// How many designs of the front were to be confirmed with `banked`; of a sweep in a folder, if
    /// it is finished.
    pub confirm: Option<u16>,
    /// Names of sweep files.
    pub sweeps: Vec<String>,
    /// Names of traces.
    pub traces: Vec<String>,
}

impl SweepFacts {
    /// A sweep that was just run.
    pub fn of(sweep: &OpenedSweep<'_>) -> SweepFacts {
        SweepFacts {
            free: sweep.designs.space.free_axes(),
            doubts: sweep.designs.doubts(),
            hand_out: sweep.hand_out.clone(),
            ..SweepFacts::of_files(Some(&sweep.file), Some(&sweep.state))
        }
    }

    /// A finished sweep in a folder. Its sweep file may be absent; so may the record of its inputs,
    /// and that of another version of the program is as good as none.
    ///
    /// # Errors
    /// [`RunError::Input`]: the sweep file is damaged; [`RunError::Output`]: the folder cannot be
    /// read.
    pub fn read(folder: &dyn Store) -> Result<SweepFacts, RunError> {
        let text = folder.read_text(SWEEP_FILE)?;
        let file = text.map(|text| SweepFile::parse(&text)).transpose();
        let file = file.map_err(|e| RunError::Input {
            place: folder.place(SWEEP_FILE),
            message: e.to_string(),
        })?;
        let record = folder.read_text(RUN_FILE)?;
        let state = record.and_then(|text| toml::from_str(&text).ok());
        let finished = Finished::noted(folder);
        Ok(SweepFacts {
            excluded: finished.as_ref().map_or(0, |f| f.excluded),
            confirm: finished.as_ref().map(|f| f.confirm),
            hand_out: HandOut::read(folder),
            doubts: finished.as_ref().map_or_else(Vec::new, |f| f.doubts.clone()),
            free: finished.map_or_else(Vec::new, |f| f.free),
            ..SweepFacts::of_files(file.as_ref(), state.as_ref())
        })
    }

    fn of_files(file: Option<&SweepFile>, state: Option<&State>) -> SweepFacts {
        let flags = state.iter().flat_map(|state| state.flags());
        let options: Vec<String> = flags.map(str::to_owned).collect();
        let display_fps = state.and_then(State::display_fps);
        let names = |role| state.map_or_else(Vec::new, |state: &State| state.names(role));
        SweepFacts {
            question: file.map_or("", |file| file.question.trim()).to_owned(),
            objectives: file.map(|file| file.objectives.clone()),
            display_fps: display_fps.or(file.map(|file| file.display_fps)),
            options,
            free: Vec::new(),
            doubts: Vec::new(),
            excluded: 0,
            followers: file.map_or_else(BTreeSet::new, followers),
            conditions: file.map_or_else(Vec::new, conditions),
            hand_out: None,
            confirm: None,
            sweeps: names("sweep"),
            traces: names("trace"),
        }
    }

    /// Tells a table which columns follow from others, which axes count where, and how many designs
    /// are left out.
    pub fn settle(&self, table: &mut Table, excluded: u64) {
        table.follow(&self.followers);
        table.restrict(&self.conditions);
        table.leave_out(excluded as usize);
    }

    /// The question of the sweep file, with the answers that are asked for by default.
    pub fn question(&self) -> Question {
        let objectives = self.objectives.clone().unwrap_or_default();
        Question {
            text: self.question.clone(),
            misses: match objectives.include_misses {
                true => Misses::Included,
                false => Misses::Behind,
            },
            free: self.free.clone(),
            doubts: self.doubts.clone(),
            epsilon: objectives.epsilon,
            display_fps: self.display_fps,
            ..Question::of(objectives.all())
        }
    }
}

/// The columns of axes with a condition. Names of variants say themselves where there is none.
fn conditions(file: &SweepFile) -> Vec<(String, Expr)> {
    let mut all = Vec::new();
    for axis in &file.axes {
        let Some(Ok(when)) = axis.when.as_deref().map(Expr::parse) else { continue };
        let together = axis.zip.iter().flat_map(|zip| zip.0.iter().map(|(key, _)| key));
        let keys = axis.key.iter().chain(together);
        all.extend(keys.map(|key| (key.clone(), when.clone())));
    }
    all
}

/// Derived keys, also those that follow an axis by default, and of keys that are varied together
/// all but the first.
fn followers(file: &SweepFile) -> BTreeSet<String> {
    let derived = file.derived.0.iter().map(|(key, _)| key.clone());
    let zips = file.axes.iter().filter_map(|axis| axis.zip.as_ref());
    let together = zips.flat_map(|zip| zip.0.iter().skip(1).map(|(key, _)| key.clone()));
    let carried = crate::sweep::space::carried::keys(file).into_iter().map(str::to_owned);
    derived.chain(together).chain(carried).collect()
}
