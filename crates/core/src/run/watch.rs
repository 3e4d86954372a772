//! How whoever started a run stops it, and hears how far it is.

/// Cancellation and progress. All methods may be called from any thread.
pub trait Watch: Sync {
    /// Whether the run is to stop. What is in flight is finished; what was done stays.
    fn is_cancelled(&self) -> bool {
        false
    }

    /// A session begins: so many frames, and with each frame counted once for every machine that it
    /// goes through, so many simulations.
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
