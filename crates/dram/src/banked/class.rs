//! The first of all commands of a class, kept while no other can overtake it.

/// The key of no command.
pub(super) const NO_KEY: u64 = u64::MAX;

/// Whether a command goes before another, by times and keys.
#[inline]
pub(super) fn goes_first(a: (u64, u64), b: (u64, u64)) -> bool {
    a.0 < b.0 || (a.0 == b.0 && a.1 < b.1)
}

/// The first command of a class.
#[derive(Debug, Clone, Copy)]
pub(super) struct Class {
    /// First CK in which it meets all timing constraints but that of the bus.
    pub time: u64,
    pub key: u64,
    /// From this CK on an older command may come before it; 0: look at the banks again.
    pub overtaken: u64,
    /// First CK of a younger command that has to wait.
    younger: u64,
    pub bank: usize,
}

impl Class {
    pub(super) const STALE: Class =
        Class { time: u64::MAX, key: NO_KEY, overtaken: 0, younger: u64::MAX, bank: usize::MAX };

    pub(super) const EMPTY: Class = Class { overtaken: u64::MAX, ..Class::STALE };

    /// Adds a command; nothing can go before `floor`.
    #[inline]
    pub(super) fn add(&mut self, floor: u64, time: u64, key: u64, bank: usize) {
        if !goes_first((time.max(floor), key), (self.time.max(floor), self.key)) {
            // It has to wait for its own bank: once that is over, it overtakes the first if it is
            // older.
            if time > floor {
                let which = if key < self.key { &mut self.overtaken } else { &mut self.younger };
                *which = time.min(*which);
            }
            return;
        }
        if key > self.key {
            // Those younger than the old one may be older than this.
            self.overtaken = self.overtaken.min(self.younger).min(self.time);
        } else if self.time > floor {
            self.younger = self.younger.min(self.time);
        }
        (self.time, self.key, self.bank) = (time, key, bank);
    }

    /// Looks at the banks again for the next plan.
    #[inline]
    pub(super) fn set_stale(&mut self) {
        self.overtaken = 0;
    }

    /// The command of a bank changed, or is new.
    #[inline]
    pub(super) fn change(&mut self, floor: u64, time: u64, key: u64, bank: usize) {
        // The first command itself changed, or another one may be first by now.
        if self.bank == bank || floor >= self.overtaken {
            self.overtaken = 0;
        } else if key != NO_KEY {
            self.add(floor, time, key, bank);
        }
    }

    /// Looks at the banks again if a command of this one was first.
    #[inline]
    pub(super) fn forget(&mut self, bank: usize) {
        if self.bank == bank {
            self.overtaken = 0;
        }
    }
}
