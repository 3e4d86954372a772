//! The designs that no other design beats: the Pareto front, for any number of objectives.
//!
//! Objectives are *costs* here: smaller is better, and an objective to be maximised is negated. A
//! design is beaten (dominated) by another that is worse in no objective and better in one at
//! least. Designs with equal costs do not beat each other: all of them are on the front, or none. A
//! design with a cost that is not finite is on no front and beats no other.

/// Costs of many designs, `k` each.
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    k: usize,
    data: Vec<f64>,
}

impl Costs {
    /// No designs yet, with `k` costs each; `k` is at least one.
    pub fn new(k: usize) -> Costs {
        assert!(k > 0, "a front needs an objective");
        Costs { k, data: Vec::new() }
    }

    /// Adds a design. `costs` are as many as each design has.
    pub fn push(&mut self, costs: &[f64]) {
        assert_eq!(costs.len(), self.k, "costs of another number of objectives");
        // Zero has one sign here, so that equal costs are equal in every order.
        self.data.extend(costs.iter().map(|c| c + 0.0));
    }

    /// How many objectives there are.
    pub fn objectives(&self) -> usize {
        self.k
    }

    /// How many designs there are.
    pub fn len(&self) -> usize {
        self.data.len() / self.k
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// The costs of one design.
    pub fn of(&self, design: usize) -> &[f64] {
        &self.data[design * self.k..][..self.k]
    }
}

/// Whether `a` beats `b`: nowhere worse, somewhere better.
pub fn dominates(a: &[f64], b: &[f64]) -> bool {
    let mut better = false;
    for (a, b) in a.iter().zip(b) {
        if !a.is_finite() || !b.is_finite() || a > b {
            return false;
        }
        better |= a < b;
    }
    better
}

/// Whether two values are alike: they differ by at most the share `epsilon` of the larger one.
pub fn is_alike(a: f64, b: f64, epsilon: f64) -> bool {
    (a - b).abs() <= epsilon * a.abs().max(b.abs())
}

/// Whether two designs are alike in every objective.
pub fn are_alike(a: &[f64], b: &[f64], epsilon: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| is_alike(*a, *b, epsilon))
}

/// Whether `a` is nowhere worse than `b` by more than the share `epsilon`.
fn covers(a: &[f64], b: &[f64], epsilon: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b || is_alike(*a, *b, epsilon))
}

/// Whether `a` beats `b` by more than noise: nowhere worse and somewhere better, where differences
/// up to the share `epsilon` do not count.
pub fn beats(a: &[f64], b: &[f64], epsilon: f64) -> bool {
    covers(a, b, epsilon) && a.iter().zip(b).any(|(a, b)| a < b && !is_alike(*a, *b, epsilon))
}

/// The designs of a front that differ by more than noise: of those that another one covers up to
/// the share `epsilon`, none is kept. Earlier ones of `members` are preferred, in whose order the
/// kept ones are.
pub fn thinned(costs: &Costs, members: &[usize], epsilon: f64) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for &design in members {
        let cost = costs.of(design);
        if !kept.iter().any(|&k| covers(costs.of(k), cost, epsilon)) {
            kept.retain(|&k| !covers(cost, costs.of(k), epsilon));
            kept.push(design);
        }
    }
    kept
}

/// For each of `members` the other designs that are alike, ascending; each design once, with the
/// first that it is alike to.
pub fn twins(costs: &Costs, members: &[usize], epsilon: f64) -> Vec<Vec<usize>> {
    let mut by_first: Vec<usize> = (0..members.len()).collect();
    let first = |place: usize| costs.of(members[place])[0];
    by_first.sort_by(|&a, &b| first(a).total_cmp(&first(b)));
    let mut is_member = vec![false; costs.len()];
    members.iter().for_each(|&m| is_member[m] = true);
    let mut all = vec![Vec::new(); members.len()];
    for design in (0..costs.len()).filter(|&d| !is_member[d]) {
        let cost = costs.of(design);
        // Whoever is alike is within this of the first objective.
        let reach = 2.0 * epsilon * cost[0].abs();
        let begin = by_first.partition_point(|&place| first(place) < cost[0] - reach);
        let near = by_first[begin..].iter().take_while(|&&p| first(p) <= cost[0] + reach);
        let alike = near.filter(|&&p| are_alike(costs.of(members[p]), cost, epsilon));
        if let Some(&place) = alike.min() {
            all[place].push(design);
        }
    }
    all
}

/// The designs on the front, ascending.
///
/// Divide and conquer after Kung, Luccio and Preparata (JACM 22, 1975): O(n log n) for two
/// objectives, O(n log^(k-2) n) for more.
pub fn front(costs: &Costs) -> Vec<usize> {
    let finite = |i: &usize| costs.of(*i).iter().all(|c| c.is_finite());
    let mut order: Vec<usize> = (0..costs.len()).filter(finite).collect();
    order.sort_by(|&a, &b| lexicographic(costs.of(a), costs.of(b)).then(a.cmp(&b)));
    // Of equal designs one stands for all, so that among those left weak dominance is dominance.
    let same = |a: &usize, b: &usize| costs.of(*a) == costs.of(*b);
    let distinct: Vec<usize> =
        order.chunk_by(same).map(|group| *group.first().expect("not empty")).collect();
    let mut kept = unbeaten(costs, distinct);
    kept.sort_by(|&a, &b| lexicographic(costs.of(a), costs.of(b)));
    let mut members = Vec::new();
    let mut winners = kept.iter().peekable();
    for group in order.chunk_by(same) {
        if winners.next_if(|w| **w == group[0]).is_some() {
            members.extend_from_slice(group);
        }
    }
    members.sort_unstable();
    members
}

fn lexicographic(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    // Zeros of either sign are equal; only finite numbers come here.
    let one = |(a, b): (&f64, &f64)| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
    a.iter().zip(b).map(one).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
}

/// Below this many pairs every pair is compared.
const FEW_PAIRS: usize = 1024;

/// The unbeaten of `designs`, which are distinct and in lexicographic order, so that an earlier one
/// is never beaten by a later one.
fn unbeaten(costs: &Costs, designs: Vec<usize>) -> Vec<usize> {
    let k = costs.objectives();
    if k <= 2 {
        return staircase(costs, &designs);
    }
    if designs.len() * designs.len() <= FEW_PAIRS {
        let mut kept: Vec<usize> = Vec::new();
        for d in designs {
            if !kept.iter().any(|&a| weakly(costs.of(a), costs.of(d))) {
                kept.push(d);
            }
        }
        return kept;
    }
    let mut first = designs;
    let second = first.split_off(first.len() / 2);
    let mut first = unbeaten(costs, first);
    let second = unbeaten(costs, second);
    // The first cost of the earlier half is nowhere larger: only the others decide.
    let others: Vec<usize> = (1..k).collect();
    let left = not_below(costs, &first, second, &others);
    first.extend(left);
    first
}

/// The front of one or two objectives: each design must be better in the last one than all before.
fn staircase(costs: &Costs, designs: &[usize]) -> Vec<usize> {
    let last = costs.objectives() - 1;
    let mut kept: Vec<usize> = Vec::new();
    for &d in designs {
        let best = kept.last().map_or(f64::INFINITY, |&a| costs.of(a)[last]);
        if costs.of(d)[last] < best {
            kept.push(d);
        }
    }
    kept
}

fn weakly(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b)
}

/// Those of `second` that none of `first` equals or beats in the objectives `keys`.
fn not_below(costs: &Costs, first: &[usize], second: Vec<usize>, keys: &[usize]) -> Vec<usize> {
    if first.is_empty() || second.is_empty() {
        return second;
    }
    let Some((&key, others)) = keys.split_last() else { return Vec::new() };
    if first.len() * second.len() <= FEW_PAIRS {
        let below = |a: usize, b: usize| keys.iter().all(|&j| costs.of(a)[j] <= costs.of(b)[j]);
        return second.into_iter().filter(|&b| !first.iter().any(|&a| below(a, b))).collect();
    }
    if let &[other] = others {
        return not_below_in_two(costs, first, second, other, key);
    }
    let value = |i: usize| costs.of(i)[key];
    let Some(middle) = middle(first.iter().chain(&second).map(|&i| value(i))) else {
        return not_below(costs, first, second, others); // all equal: decides nothing
    };
    let (low_a, high_a): (Vec<usize>, Vec<usize>) =
        first.iter().partition(|&&i| value(i) <= middle);
    let (low_b, high_b): (Vec<usize>, Vec<usize>) =
        second.into_iter().partition(|&i| value(i) <= middle);
    let mut left = not_below(costs, &low_a, low_b, keys);
    let high = not_below(costs, &low_a, high_b, others);
    left.extend(not_below(costs, &high_a, high, keys));
    left
}

/// A value that parts others: not all are above it, not all are at or below it.
fn middle(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    let half = (values.len() - 1) / 2;
    let (_, &mut median, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    if values.iter().any(|v| *v > median) {
        return Some(median);
    }
    values.into_iter().filter(|v| *v < median).max_by(f64::total_cmp)
}

/// As [`not_below`] for the objectives `x` and `y`: one walk in the order of `x`.
fn not_below_in_two(
    costs: &Costs,
    first: &[usize],
    second: Vec<usize>,
    x: usize,
    y: usize,
) -> Vec<usize> {
    let by_x = |&a: &usize, &b: &usize| costs.of(a)[x].total_cmp(&costs.of(b)[x]);
    let (mut first, mut second) = (first.to_vec(), second);
    first.sort_by(by_x);
    second.sort_by(by_x);
    let mut lowest = f64::INFINITY;
    let mut ahead = first.into_iter().peekable();
    second.retain(|&b| {
        while let Some(a) = ahead.next_if(|&a| costs.of(a)[x] <= costs.of(b)[x]) {
            lowest = lowest.min(costs.of(a)[y]);
        }
        costs.of(b)[y] < lowest
    });
    second
}
