//! DRAM bytes by phase.

/// DRAM bytes of one stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageTraffic {
    /// Read.
    pub read: u64,
    /// Written.
    pub write: u64,
}

/// DRAM bytes by stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// In the order of [`Phase::WORK`](powergs_energy::action::Phase::WORK).
    pub stages: [StageTraffic; 3],
}

impl Traffic {
    /// Bytes of all stages.
    pub fn total(&self) -> StageTraffic {
        let [a, b, c] = self.stages;
        StageTraffic { read: a.read + b.read + c.read, write: a.write + b.write + c.write }
    }
}
