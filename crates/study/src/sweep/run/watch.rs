//! What a sweep tells its caller.

use powergs_core::run::Watch;

use crate::sweep::objective::Objective;
use crate::sweep::record::Record;

/// Cancellation and progress of a sweep. [`Watch::simulated`] counts frames on machines. All
/// methods may be called from any thread.
pub trait SweepWatch: Watch {
    /// The space is about to be walked: at most `points` points.
    fn planning(&self, points: u64) {
        let _ = points;
    }

    /// `n` more points are planned.
    fn planned(&self, n: u64) {
        let _ = n;
    }

    /// Work begins: machines times frames, and what is wanted of the designs.
    fn working(&self, machine_frames: u64, objectives: &[Objective]) {
        let _ = (machine_frames, objectives);
    }

    /// So much of the work was done before.
    fn known(&self, machine_frames: u64) {
        let _ = machine_frames;
    }

    /// A design has a result.
    fn result(&self, record: &Record) {
        let _ = record;
    }

    /// Something that is not wrong, but that people should know.
    fn note(&self, text: &str) {
        let _ = text;
    }
}

impl SweepWatch for () {}
