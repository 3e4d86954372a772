//! The knee of a front: the design from which every further gain is dear.
//!
//! Every cost is scaled so that the best value on the front is 0 and the worst is 1. The *merit* of
//! a design is the mean of its scaled costs, and the knee is the design with the smallest. With two
//! objectives that is the design farthest from the straight line between the two ends of the
//! front, on the side of the origin; with more it is the farthest from the hyperplane through the
//! scaled ends. No design off the front has a smaller merit than the design that beats it, but for
//! noise; no merit counts as smaller than that of the knee, so the first of a ranking by merit is
//! the knee.

use super::front::{self, Costs};

/// The scale of the costs of a front.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct KneeScaling {
    /// Smallest cost on the front, by objective.
    pub best: Vec<f64>,
    /// From there to the largest on the front; if all are equal there, to the largest of all
    /// designs; 0 for an objective that never varies.
    pub range: Vec<f64>,
}

impl KneeScaling {
    /// The scale of `costs` with the front `members`.
    pub fn of(costs: &Costs, members: &[usize]) -> KneeScaling {
        let k = costs.objectives();
        let fold = |designs: &mut dyn Iterator<Item = usize>| {
            let mut ends = vec![(f64::INFINITY, f64::NEG_INFINITY); k];
            for design in designs {
                for ((low, high), cost) in ends.iter_mut().zip(costs.of(design)) {
                    (*low, *high) = (low.min(*cost), high.max(*cost));
                }
            }
            ends
        };
        let front = fold(&mut members.iter().copied());
        let all = fold(&mut (0..costs.len()));
        let range = |((low, high), (_, highest)): (&(f64, f64), &(f64, f64))| {
            let range = if high > low { high - low } else { highest - low };
            if range.is_finite() { range.max(0.0) } else { 0.0 }
        };
        KneeScaling {
            best: front.iter().map(|(low, _)| *low).collect(),
            range: front.iter().zip(&all).map(range).collect(),
        }
    }

    /// The scaled costs of a design; objectives that never vary have 0.
    pub fn scaled(&self, cost: &[f64]) -> Vec<f64> {
        let one = |((c, best), range): ((&f64, &f64), &f64)| {
            if *range > 0.0 { (c - best) / range } else { 0.0 }
        };
        cost.iter().zip(&self.best).zip(&self.range).map(one).collect()
    }

    /// The mean of the scaled costs over the objectives that vary; 0 if none does.
    pub fn merit(&self, cost: &[f64]) -> f64 {
        let varying = self.range.iter().filter(|r| **r > 0.0).count().max(1);
        self.scaled(cost).iter().sum::<f64>() / varying as f64
    }
}

/// The front with one design of those that differ by noise only, ascending. Of those the one with
/// the smallest merit is kept, the first of equals.
pub fn front(costs: &Costs, epsilon: f64) -> Vec<usize> {
    let mut members = front::front(costs);
    let scaling = KneeScaling::of(costs, &members);
    let merit = |d: &usize| scaling.merit(costs.of(*d));
    // Stable, so that of equals the first point comes first.
    members.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
    let mut kept = front::thinned(costs, &members, epsilon);
    kept.sort_unstable();
    kept
}

/// The design with the smallest merit, the first of equals; `None` for an empty front.
pub fn knee(costs: &Costs, members: &[usize], scaling: &KneeScaling) -> Option<usize> {
    let merit = |design: &usize| scaling.merit(costs.of(*design));
    members.iter().copied().min_by(|a, b| merit(a).total_cmp(&merit(b)))
}

/// The end of the front for every objective: the design with the smallest cost there, of equals
/// the one with the smallest merit.
pub fn ends(costs: &Costs, members: &[usize], scaling: &KneeScaling) -> Vec<usize> {
    let end = |j: usize| {
        let key = |d: usize| (costs.of(d)[j], scaling.merit(costs.of(d)));
        members.iter().copied().min_by(|&a, &b| {
            let ((a, a_merit), (b, b_merit)) = (key(a), key(b));
            a.total_cmp(&b).then(a_merit.total_cmp(&b_merit))
        })
    };
    (0..costs.objectives()).filter_map(end).collect()
}
