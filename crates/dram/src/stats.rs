//! Activity of a memory: bytes, commands, busy buses, latencies.

/// Classes of requests that statistics keep apart.
pub const CLASSES: usize = 26;

/// Activity of a memory. Times are in CK.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stats {
    /// Everything.
    pub total: Traffic,
    /// The same by class of request; commands that serve no request count in `total` only.
    pub classes: [Traffic; CLASSES],
    /// Read commands.
    pub reads: u64,
    /// Write commands.
    pub writes: u64,
    /// Activates.
    pub activates: u64,
    /// Precharges of one bank, those at the end of a burst (closed page) included.
    pub precharges: u64,
    /// Precharges of all banks before a refresh.
    pub precharges_all: u64,
    /// Refreshes of all banks of a pseudo channel.
    pub refreshes_all: u64,
    /// Refreshes of one bank.
    pub refreshes_bank: u64,
    /// Commands that synchronise the data clock.
    pub clock_syncs: u64,
    /// CK for which the data bus with the most traffic moved data.
    pub busy_max: u64,
    /// Mean of that over all data buses.
    pub busy_mean: f64,
    /// Channel CK awake with a row open.
    pub active: u64,
    /// Channel CK in power-down.
    pub power_down: u64,
    /// Channel CK in self-refresh.
    pub self_refresh: u64,
    /// The last simulated CK.
    pub until: u64,
    /// Latency of read requests.
    pub latency: Latency,
}

impl Stats {
    /// Part of the column commands that found their row open: `1 - ACT / (RD + WR)`. Slightly
    /// negative when refresh closes rows before they were used; 0 without commands.
    pub fn row_hit_rate(&self) -> f64 {
        let columns = self.reads + self.writes;
        if columns == 0 { 0.0 } else { 1.0 - self.activates as f64 / columns as f64 }
    }

    /// All commands by name.
    pub fn commands(&self) -> [(&'static str, u64); 8] {
        [
            ("ACT", self.activates),
            ("PRE", self.precharges),
            ("PREab", self.precharges_all),
            ("RD", self.reads),
            ("WR", self.writes),
            ("REFab", self.refreshes_all),
            ("REFpb", self.refreshes_bank),
            ("CAS", self.clock_syncs),
        ]
    }
}

/// Bytes and bursts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Requests that were completed.
    pub requests: u64,
    /// Bytes that were asked for by reads.
    pub read_bytes: u64,
    /// Bytes that were asked for by writes.
    pub write_bytes: u64,
    /// Bursts of all requests, merged ones included.
    pub bursts: u64,
    /// Bytes that reads and writes moved over a data bus.
    pub moved_bytes: u64,
    /// Bursts that reads moved.
    pub reads: u64,
    /// Bursts that writes moved.
    pub writes: u64,
    /// Writes merged into one that waited for the same burst.
    pub absorbed_writes: u64,
    /// Reads answered from a write that waited.
    pub forwarded_reads: u64,
    /// Bursts whose first command was their read or write: the row was open.
    pub row_hits: u64,
    /// Bursts whose first command was an activate: the bank was closed.
    pub row_misses: u64,
    /// Bursts whose first command was a precharge: another row was open.
    pub row_conflicts: u64,
    /// Sum of the latencies of its read requests, CK.
    pub latency: u64,
    /// Read requests in that sum.
    pub latency_requests: u64,
}

impl Traffic {
    /// Bytes requested, read and written.
    pub fn requested_bytes(&self) -> u64 {
        self.read_bytes + self.write_bytes
    }
}

/// Latencies up to this many CK are counted exactly.
const EXACT: u64 = 1 << 13;

/// Buckets of one octave above that: 1/64 of resolution.
const PER_OCTAVE_BITS: u32 = 6;

/// A histogram of latencies in CK: exact below 8192, to one part in 64 above. Mean and maximum are
/// exact.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Latency {
    buckets: Vec<u32>,
    count: u64,
    sum: u64,
    max: u64,
}

impl Latency {
    /// Counts one.
    pub(crate) fn add(&mut self, latency: u64) {
        let bucket = bucket(latency);
        if bucket >= self.buckets.len() {
            self.buckets.resize(bucket + 1, 0);
        }
        self.buckets[bucket] = self.buckets[bucket].saturating_add(1);
        self.count += 1;
        self.sum += latency;
        self.max = self.max.max(latency);
    }

    /// Number of read requests.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean, CK; 0 if there are none.
    pub fn mean(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum as f64 / self.count as f64 }
    }

    /// The largest latency, CK.
    pub fn max(&self) -> u64 {
        self.max
    }

    /// The smallest latency that at least `fraction` of all do not exceed, CK; 0 if there are none.
    pub fn percentile(&self, fraction: f64) -> u64 {
        let wanted = (fraction * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (i, n) in self.buckets.iter().enumerate() {
            seen += u64::from(*n);
            if seen >= wanted {
                return lowest(i).min(self.max);
            }
        }
        self.max
    }
}

fn bucket(latency: u64) -> usize {
    if latency < EXACT {
        return latency as usize;
    }
    let octave = latency.ilog2() - EXACT.ilog2();
    let fine = (latency >> (latency.ilog2() - PER_OCTAVE_BITS)) & ((1 << PER_OCTAVE_BITS) - 1);
    (EXACT + (u64::from(octave) << PER_OCTAVE_BITS) + fine) as usize
}

fn lowest(bucket: usize) -> u64 {
    let bucket = bucket as u64;
    if bucket < EXACT {
        return bucket;
    }
    let above = bucket - EXACT;
    let (octave, fine) = (above >> PER_OCTAVE_BITS, above & ((1 << PER_OCTAVE_BITS) - 1));
    ((1 << PER_OCTAVE_BITS) + fine) << (octave + u64::from(EXACT.ilog2() - PER_OCTAVE_BITS))
}
