//! Which of several models stay after a short fine-tune.

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

/// Which `most` of the trials stay: those that the fewest others beat, of these the ones with the
/// fewest watts, then the first. Short fine-tunes end at qualities of their own, and watts that miss
/// the quality are no price: so both decide, and no rate of exchange.
pub fn better(trials: &[Trial], most: usize) -> Vec<bool> {
    let beaten = |trial: &Trial| trials.iter().filter(|other| other.beats(trial)).count();
    let mut order: Vec<(usize, usize)> =
        trials.iter().enumerate().map(|(i, trial)| (beaten(trial), i)).collect();
    let watts = |i: usize| trials[i].watts;
    order.sort_by(|a, b| a.0.cmp(&b.0).then(watts(a.1).total_cmp(&watts(b.1))).then(a.1.cmp(&b.1)));
    let mut stays = vec![false; trials.len()];
    order.iter().take(most).for_each(|(_, i)| stays[*i] = true);
    stays
}
