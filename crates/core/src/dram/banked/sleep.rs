//! How long a channel was awake with a row open, powered down, refreshing itself.

/// Time of one channel by state, CK. What is none of these is awake with all rows closed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sleep {
    pub active: u64,
    pub power_down: u64,
    pub self_refresh: u64,
    /// From when the time is not yet counted.
    since: u64,
    /// Since when nothing has waited, if so.
    idle: Option<u64>,
}

impl Sleep {
    /// Counts the time until `now`; `open` says whether a row was open in it.
    pub(super) fn count(&mut self, now: u64, open: bool, after: &[u64; 2]) {
        let now = now.max(self.since);
        let from = |threshold: u64| {
            self.idle.map_or(now, |idle| idle.saturating_add(threshold).clamp(self.since, now))
        };
        let (down, own) = (from(after[0]), from(after[1]));
        if open {
            self.active += down - self.since;
        }
        self.power_down += own - down;
        self.self_refresh += now - own;
        self.since = now;
    }

    /// Something waits again.
    pub(super) fn wake(&mut self, now: u64, open: bool, after: &[u64; 2]) {
        self.count(now, open, after);
        self.idle = None;
    }

    /// Nothing waits any more.
    pub(super) fn rest(&mut self, now: u64, open: bool, after: &[u64; 2]) {
        self.count(now, open, after);
        self.idle = Some(now);
    }
}
