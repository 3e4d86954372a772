//! A sweep as an array job of Slurm.

use std::ffi::OsString;
use std::path::Path;

use super::args::{Definition, MergeArgs, SweepArgs};
use super::parts;
use crate::cli::slurm::{SlurmParts, flag};
use crate::cli::{Context, Exit, Failure};
use powergs_core::run::FileStore;
use powergs_study::sweep::run::{OpenedSweep, folder};

/// The parts of a sweep.
pub struct SweepParts<'a, 's> {
    /// What was typed.
    pub args: &'a SweepArgs,
    /// The sweep, checked.
    pub sweep: &'a OpenedSweep<'s>,
    /// Flags of every command.
    pub context: &'a Context,
}

impl SlurmParts for SweepParts<'_, '_> {
    const COMMAND: &'static str = "sweep";

    fn arguments(&self) -> Vec<OsString> {
        let SweepArgs { definition, store, .. } = self.args;
        let Definition { file, traces, only, changes, points, dram_model, fps, display } =
            definition;
        let mut words: Vec<OsString> = file.iter().map(OsString::from).collect();
        words.extend(traces.iter().map(|t| flag("traces", t)));
        words.extend(only.frames.map(|frames| flag("frames", frames.to_string())));
        words.extend(changes.sets.iter().map(|s| flag("set", s)));
        words.extend(points.map(|n| flag("points", n.to_string())));
        words.extend(fps.map(|fps| flag("fps", fps.to_string())));
        words.extend(display.iter().map(|name| flag("display", name)));
        words.extend(dram_model.map(|model| flag("dram-model", model.key())));
        words.extend(store.as_ref().map(|path| flag("store", path)));
        words.push(flag("memory", self.context.global.memory.to_string()));
        words
    }

    fn finish(&self, out: &Path) -> Vec<OsString> {
        vec!["sweep".into(), "merge".into(), out.into()]
    }

    fn begin(&self, out: &Path) -> Result<(), Failure> {
        let (state, existing) = (&self.sweep.state, self.args.run.existing());
        Ok(folder::begin(&FileStore::new(out), state, existing)?)
    }

    fn end(self, out: &Path) -> Result<Exit, Failure> {
        let merge = MergeArgs {
            folder: out.to_owned(),
            from: Vec::new(),
            confirm: self.args.confirm,
            charts: self.args.charts.clone(),
        };
        parts::merge(&merge, self.context)
    }
}
