//! Power states of a channel: active, power-down, self-refresh.

/// Time of one channel by power state, CK. The rest of its time is precharge standby.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sleep {
    pub active: u64,
    pub power_down: u64,
    pub self_refresh: u64,
    /// The time is counted up to here.
    since: u64,
    /// The CK in which the channel became idle, if it is.
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
        // What is neither active nor asleep is precharged standby, and follows from the rest.
        if open {
            self.active += down - self.since;
        }
        self.power_down += own - down;
        self.self_refresh += now - own;
        self.since = now;
    }

    /// A burst arrives at an idle channel.
    pub(super) fn wake(&mut self, now: u64, open: bool, after: &[u64; 2]) {
        self.count(now, open, after);
        self.idle = None;
    }

    /// The channel becomes idle.
    pub(super) fn rest(&mut self, now: u64, open: bool, after: &[u64; 2]) {
        self.count(now, open, after);
        self.idle = Some(now);
    }
}
