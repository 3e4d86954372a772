//! Cancellation and progress of a run.

/// Cancellation and progress. All methods may be called from any thread.
pub trait Watch: Sync {
    /// Whether the run is to stop: finished work is kept. Most work in flight is finished; frames
    /// that may take long ask on the way, and are dropped.
    fn is_cancelled(&self) -> bool {
        false
    }

    /// A session begins: the number of frames, and of simulations (a frame counts once for every
    /// machine that simulates it).
    fn begins(&self, frames: u64, simulations: u64) {
        let _ = (frames, simulations);
    }

    /// `n` more frames have gone through a machine each.
    fn simulated(&self, n: u64) {
        let _ = n;
    }

    /// A frame has gone through all machines.
    fn frame_done(&self) {}
}

/// Runs to the end without reporting progress.
impl Watch for () {}
