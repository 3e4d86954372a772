//! The three nearest neighbours of every point of a cloud: a k-d tree that lies in the order of its
//! points, the median of every stretch in the middle.

use rayon::prelude::*;

/// Stretches that are looked through point by point.
const LEAF: usize = 8;

/// The mean of the squared distances of every point to its three nearest neighbours, world units²,
/// in the order of the points. Fewer neighbours: the mean of those; none: 0.
pub fn nearest_three(points: &[[f32; 3]]) -> Vec<f32> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    arrange(points, &mut order, 0);
    (0..points.len() as u32)
        .into_par_iter()
        .map(|own| {
            let mut best = Nearest { own, at: points[own as usize], squares: [f32::INFINITY; 3] };
            best.search(points, &order, 0);
            let found = best.squares.iter().filter(|d| d.is_finite());
            let n = found.clone().count().max(1) as f32;
            found.sum::<f32>() / n
        })
        .collect()
}

/// Puts the median along `axis` into the middle, what is before it in front, and so on.
fn arrange(points: &[[f32; 3]], order: &mut [u32], axis: usize) {
    if order.len() <= LEAF {
        return;
    }
    let middle = order.len() / 2;
    let place = |i: &u32| points[*i as usize][axis];
    // Ties by index: the tree is the same in every run.
    order.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
    let (before, rest) = order.split_at_mut(middle);
    let next = (axis + 1) % 3;
    let after = &mut rest[1..];
    rayon::join(|| arrange(points, before, next), || arrange(points, after, next));
}

/// The nearest so far.
struct Nearest {
    own: u32,
    at: [f32; 3],
    /// Ascending.
    squares: [f32; 3],
}

impl Nearest {
    fn search(&mut self, points: &[[f32; 3]], order: &[u32], axis: usize) {
        if order.len() <= LEAF {
            order.iter().for_each(|i| self.meet(points, *i));
            return;
        }
        let middle = order.len() / 2;
        let (before, after) = (&order[..middle], &order[middle + 1..]);
        let off = self.at[axis] - points[order[middle] as usize][axis];
        let (near, far) = if off < 0.0 { (before, after) } else { (after, before) };
        let next = (axis + 1) % 3;
        self.search(points, near, next);
        self.meet(points, order[middle]);
        if off * off < self.squares[2] {
            self.search(points, far, next);
        }
    }

    fn meet(&mut self, points: &[[f32; 3]], other: u32) {
        if other == self.own {
            return;
        }
        let to = points[other as usize];
        let square: f32 = (0..3).map(|k| (to[k] - self.at[k]).powi(2)).sum();
        let [first, second, third] = self.squares;
        self.squares = match square {
            s if s < first => [s, first, second],
            s if s < second => [first, s, second],
            s if s < third => [first, second, s],
            _ => return,
        };
    }
}
