//! Which of several models stay after a short fine-tune.

use std::collections::BTreeMap;

/// What a short fine-tune says of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Watts on the best of some machines.
    pub watts: f64,
    /// Distance from the quality, dB; 0 where it is reached.
    pub margin_db: f64,
}

impl Trial {
    /// Whether it is better in one and not worse in the other.
    fn beats(&self, other: &Trial) -> bool {
        let (a, b) = (self, other);
        a.watts <= b.watts
            && a.margin_db >= b.margin_db
            && (a.watts, a.margin_db) != (b.watts, b.margin_db)
    }
}

/// Which `most` of the trials stay: those that the fewest others beat, of as many the nearest to
/// the quality and the one with the fewest watts in turn, then the first. Short fine-tunes end at
/// qualities of their own, and watts that miss the quality are no price: so both decide, and no
/// rate of exchange; the nearest to the quality always stays.
pub fn better(trials: &[Trial], most: usize) -> Vec<bool> {
    let beaten = |trial: &Trial| trials.iter().filter(|other| other.beats(trial)).count();
    let mut levels: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, trial) in trials.iter().enumerate() {
        levels.entry(beaten(trial)).or_default().push(i);
    }
    let mut order = Vec::new();
    for level in levels.values() {
        let (mut near, mut cheap) = (Vec::new(), level.clone());
        cheap.sort_by(|&a, &b| trials[a].watts.total_cmp(&trials[b].watts));
        // Sorted by watts already: a stable sort leaves equal qualities in that order.
        near.clone_from(&cheap);
        near.sort_by(|&a, &b| trials[b].margin_db.total_cmp(&trials[a].margin_db));
        for i in near.into_iter().zip(cheap).flat_map(|(near, cheap)| [near, cheap]) {
            if !order.contains(&i) {
                order.push(i);
            }
        }
    }
    let mut stays = vec![false; trials.len()];
    order.iter().take(most).for_each(|&i| stays[i] = true);
    stays
}
