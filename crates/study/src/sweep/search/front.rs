//! Dominance: ranks and crowding distances of points, all objectives to be minimised. Points that
//! miss a bound lose against all that keep it, and among themselves by how much they miss it
//! (constraint domination, Deb et al. 2002).

/// What came of a point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrontTrial {
    /// Its objectives, the smaller the better.
    pub costs: Vec<f64>,
    /// How much it misses the bound; zero if it keeps it.
    pub miss: f64,
}

impl From<Vec<f64>> for FrontTrial {
    /// A point that keeps the bound.
    fn from(costs: Vec<f64>) -> FrontTrial {
        FrontTrial { costs, miss: 0.0 }
    }
}

/// Ranks and crowding distances, in the order of the points.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// 0 for points that none beats, 1 for those that only these beat, and so on.
    pub rank: Vec<usize>,
    /// How far its neighbours of the same rank are; infinite at the ends.
    pub crowding: Vec<f64>,
}

/// Whether `a` misses the bound by less than `b`, or by as much, and is nowhere worse and somewhere
/// better.
pub fn dominates(a: &FrontTrial, b: &FrontTrial) -> bool {
    if a.miss != b.miss {
        return a.miss < b.miss;
    }
    let pairs = || a.costs.iter().zip(&b.costs);
    pairs().all(|(x, y)| x <= y) && pairs().any(|(x, y)| x < y)
}

impl Ranked {
    /// Ranks points with their values.
    pub fn new(points: &[(u64, FrontTrial)]) -> Ranked {
        let n = points.len();
        let mut beaten_by = vec![0usize; n];
        let mut beats: Vec<Vec<usize>> = vec![Vec::new(); n];
        for a in 0..n {
            for b in a + 1..n {
                if dominates(&points[a].1, &points[b].1) {
                    beats[a].push(b);
                    beaten_by[b] += 1;
                } else if dominates(&points[b].1, &points[a].1) {
                    beats[b].push(a);
                    beaten_by[a] += 1;
                }
            }
        }
        let mut ranked = Ranked { rank: vec![0; n], crowding: vec![0.0; n] };
        let mut current: Vec<usize> = (0..n).filter(|&i| beaten_by[i] == 0).collect();
        let mut rank = 0;
        while !current.is_empty() {
            let mut next = Vec::new();
            for &i in &current {
                ranked.rank[i] = rank;
                // Fast non-dominated sorting (Deb et al. 2002): a point is next when all that beat
                // it are ranked.
                for &j in &beats[i] {
                    beaten_by[j] -= 1;
                    if beaten_by[j] == 0 {
                        next.push(j);
                    }
                }
            }
            ranked.crowd(points, &current);
            next.sort_unstable();
            current = next;
            rank += 1;
        }
        ranked
    }

    /// Distances within one rank.
    fn crowd(&mut self, points: &[(u64, FrontTrial)], members: &[usize]) {
        let objectives = members.first().map_or(0, |&i| points[i].1.costs.len());
        for k in 0..objectives {
            let mut order = members.to_vec();
            let value = |i: usize| points[i].1.costs[k];
            order.sort_by(|&a, &b| value(a).total_cmp(&value(b)).then(a.cmp(&b)));
            let (first, last) = (order[0], order[order.len() - 1]);
            let width = value(last) - value(first);
            // The ends always stay, so that the front keeps its extent.
            self.crowding[first] = f64::INFINITY;
            self.crowding[last] = f64::INFINITY;
            if width > 0.0 {
                for three in order.windows(3) {
                    self.crowding[three[1]] += (value(three[2]) - value(three[0])) / width;
                }
            }
        }
    }

    /// Whether one point is preferred to another: a lower rank, or more room.
    pub fn better(&self, a: usize, b: usize) -> bool {
        match self.rank[a].cmp(&self.rank[b]) {
            std::cmp::Ordering::Less => true,
            std::cmp::Ordering::Greater => false,
            std::cmp::Ordering::Equal => self.crowding[a] > self.crowding[b],
        }
    }
}

/// The numbers of the best `n` points, ascending.
pub fn best(points: &[(u64, FrontTrial)], n: usize) -> Vec<u64> {
    let ranked = Ranked::new(points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let rank = ranked.rank[a].cmp(&ranked.rank[b]);
        rank.then(ranked.crowding[b].total_cmp(&ranked.crowding[a])).then(a.cmp(&b))
    });
    let mut best: Vec<u64> = order.into_iter().take(n).map(|i| points[i].0).collect();
    best.sort_unstable();
    best
}
