//! Which models stay in the store: those that later jobs start from, that the run ends with or that
//! it compares with, and then as many as there is room for, because another panel or machine may
//! want them.
//!
//! What stays is a function of the outcomes alone, so that a run which is continued has the models
//! that it looks for, and what is kept for comparisons never takes the room of a sample.

use super::Plan;
use crate::job::Place;
use crate::outcome::Outcome;
use crate::role::{Baseline, Role};
use crate::schedule::Schedule;

/// Samples are kept while all models of the search have together no more Gaussians than so many
/// dense models.
const MOST: usize = 4;

impl Plan {
    /// The finished jobs whose models are kept after all of `done`, in their order. `points` is the
    /// size of the dense model.
    pub fn kept<'a>(&self, points: usize, done: &'a [Outcome]) -> Vec<&'a Outcome> {
        let mut kept: Vec<&Outcome> = Vec::new();
        // What is gone does not come back, so every step counts.
        for (i, new) in done.iter().enumerate() {
            if has_model(new) {
                kept.push(new);
            }
            let needed = self.needed(&done[..=i]);
            let spare = self.spare(&kept, new.place, self.is_over(&done[..=i]));
            let is_search = |o: &&&Outcome| matches!(o.role, Role::Sample | Role::Optimum);
            let of_search = needed.iter().filter(is_search);
            let mut taken: usize = of_search.map(|o| o.points).sum();
            let mut stays: Vec<&str> = needed.iter().map(|o| o.name.as_str()).collect();
            for o in spare {
                if !stays.contains(&o.name.as_str()) && taken + o.points <= MOST * points {
                    taken += o.points;
                    stays.push(&o.name);
                }
            }
            kept.retain(|o| stays.contains(&o.name.as_str()));
        }
        kept
    }

    /// The models that a later job starts from, that the run ends with or that it compares with,
    /// each once. Priced anew without the comparisons a run would say nothing of what the method is
    /// worth, and without the model that shares are shares of nothing of another size.
    fn needed<'a>(&self, done: &'a [Outcome]) -> Vec<&'a Outcome> {
        let mut needed: Vec<&Outcome> = Vec::new();
        for variant in 0..self.variants.len() as u8 {
            needed.extend(self.result(done, variant));
            let levels = if self.levels > 1 { self.levels } else { 1 };
            for level in 0..levels {
                let place = Place { variant, level };
                needed.extend(self.model_at(done, None, place));
                if levels > 1 {
                    let lines = [Baseline::RenderOnly, Baseline::DisplayOnly];
                    needed
                        .extend(lines.iter().filter_map(|b| self.model_at(done, Some(*b), place)));
                }
            }
        }
        let is_compared = |o: &&Outcome| match o.role {
            Role::HeldOut => self.holds_out,
            Role::Baseline(_) => true,
            Role::Dense | Role::Sample | Role::Optimum | Role::External(_) | Role::Sweep(_) => {
                false
            }
        };
        needed.extend(done.iter().filter(is_compared));
        let last = done.last();
        // It is retried, or the next of a list starts from it.
        let is_adaptive = matches!(self.schedule, Schedule::Adaptive { .. });
        needed.extend(last.filter(|o| o.role == Role::Sample && !(is_adaptive && o.passed)));
        needed.extend(self.lowest(done));
        if matches!(self.schedule, Schedule::Published { .. }) {
            let here = |o: &&Outcome| last.is_some_and(|l| l.place == o.place);
            if !done.iter().filter(here).any(|o| o.role == Role::Optimum) {
                needed.extend(done.iter().filter(here).filter(|o| o.role == Role::Sample));
            }
        }
        let mut names = Vec::new();
        needed.retain(|o| {
            let is_new = has_model(o) && !names.contains(&&o.name);
            names.push(&o.name);
            is_new
        });
        needed
    }

    /// The least pruned sample of the last quality that has one: whatever the ratio, a sample that
    /// follows can start from it.
    fn lowest<'a>(&self, done: &'a [Outcome]) -> Option<&'a Outcome> {
        if self.is_over(done) {
            return None;
        }
        let passed = done.iter().filter(|o| is_passed_sample(o));
        passed.min_by(|a, b| b.place.variant.cmp(&a.place.variant).then(a.rho.total_cmp(&b.rho)))
    }

    /// Whether the search of the last quality has ended at level 1.
    fn is_over(&self, done: &[Outcome]) -> bool {
        let last = self.variants.len().saturating_sub(1) as u8;
        let end = Place { variant: last, level: 0 };
        done.iter().any(|o| o.role == Role::Optimum && o.place == end)
    }

    /// What is kept while there is room, first what a search may start from: the models of its
    /// place that reach their target, then those of other places; then what missed and may reach a
    /// lower quality. The smallest first, so that there are many.
    fn spare<'a>(&self, kept: &[&'a Outcome], here: Place, is_over: bool) -> Vec<&'a Outcome> {
        let has_lower = |o: &Outcome| usize::from(o.place.variant) + 1 < self.variants.len();
        let class = |o: &Outcome| match o.role {
            Role::Sample | Role::Optimum if o.passed => Some(u8::from(o.place != here)),
            Role::Sample if o.place.level == 0 && has_lower(o) && !is_over => Some(2),
            Role::Sample
            | Role::Optimum
            | Role::Baseline(_)
            | Role::Dense
            | Role::HeldOut
            | Role::External(_)
            | Role::Sweep(_) => None,
        };
        let classed = kept.iter().filter_map(|o| Some((class(o)?, *o)));
        let mut spare: Vec<(u8, &Outcome)> = classed.collect();
        spare.sort_by_key(|(class, o)| (*class, o.points));
        spare.into_iter().map(|(_, o)| o).collect()
    }
}

/// Whether training left a model.
fn has_model(o: &Outcome) -> bool {
    match o.role {
        Role::HeldOut | Role::Sample | Role::Optimum | Role::Baseline(_) => true,
        Role::Dense | Role::External(_) | Role::Sweep(_) => false,
    }
}

fn is_passed_sample(o: &Outcome) -> bool {
    o.role == Role::Sample && o.passed && o.place.level == 0
}
