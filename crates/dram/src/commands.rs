//! Commands of a device in one frame, by the stage of the accelerator that they serve.

/// Commands that the DRAM device issued for the requests of one stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageCommands {
    /// Bursts read.
    pub reads: u64,
    /// Bursts written.
    pub writes: u64,
    /// Rows opened.
    pub activates: u64,
}

/// Commands of a DRAM device in one frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DramCommands {
    /// Bytes of a burst.
    pub burst_bytes: u64,
    /// For preprocessing, sorting and rendering.
    pub stages: [StageCommands; 3],
    /// Rows closed.
    pub precharges: u64,
    /// Refreshes, of one channel and all its banks each.
    pub refreshes: u64,
    /// Refreshes of one bank.
    pub bank_refreshes: u64,
}

impl StageCommands {
    /// Adds those of other requests.
    pub fn add(&mut self, other: StageCommands) {
        self.reads += other.reads;
        self.writes += other.writes;
        self.activates += other.activates;
    }

    /// Bursts read and written.
    pub(crate) fn bursts(&self) -> u64 {
        self.reads + self.writes
    }

    /// Share of the bursts that found their row open, 0 to 1; `None` without bursts.
    pub fn row_hit_frac(&self) -> Option<f64> {
        let bursts = self.bursts();
        (bursts > 0).then(|| (1.0 - self.activates as f64 / bursts as f64).max(0.0))
    }
}

impl DramCommands {
    /// Reads, writes and activates of all stages.
    pub fn total(&self) -> StageCommands {
        let sum = |field: fn(&StageCommands) -> u64| self.stages.iter().map(field).sum();
        StageCommands {
            reads: sum(|s| s.reads),
            writes: sum(|s| s.writes),
            activates: sum(|s| s.activates),
        }
    }

    /// Bytes that bursts moved; more than were asked for where records do not fill them.
    pub fn moved_bytes(&self) -> u64 {
        self.total().bursts() * self.burst_bytes
    }
}
