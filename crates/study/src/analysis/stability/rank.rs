//! How alike two rankings are.

/// Kendall's τ-b of two measures of the same things: 1 for the same order, -1 for the reverse, ties
/// counted as Kendall (1945) does; `None` where one of them is the same for all. O(n log n) after
/// Knight (JASA 61, 1966).
pub fn kendall(x: &[f64], y: &[f64]) -> Option<f64> {
    assert_eq!(x.len(), y.len(), "two measures of the same things");
    let mut pairs: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let n = pairs.len() as u64;
    let all = n * n.saturating_sub(1) / 2;
    let tied_x = ties(&pairs, |a, b| a.0 == b.0);
    let tied_both = ties(&pairs, |a, b| a == b);
    let mut ys: Vec<f64> = pairs.iter().map(|p| p.1).collect();
    let mut room = vec![0.0; ys.len()];
    let swaps = sorted_with_swaps(&mut ys, &mut room);
    let tied_y = ties(&ys, |a, b| a == b);
    let agreement = all as f64 - tied_x as f64 - tied_y as f64 + tied_both as f64;
    let root = (((all - tied_x) as f64) * ((all - tied_y) as f64)).sqrt();
    (root > 0.0).then(|| (agreement - 2.0 * swaps as f64) / root)
}

/// Pairs of equal neighbours in sorted order.
fn ties<T>(sorted: &[T], same: impl Fn(&T, &T) -> bool) -> u64 {
    let pairs = |group: &[T]| group.len() as u64 * (group.len() as u64 - 1) / 2;
    sorted.chunk_by(same).map(pairs).sum()
}

/// Sorts and counts how many pairs were in the wrong order.
fn sorted_with_swaps(values: &mut [f64], room: &mut [f64]) -> u64 {
    let n = values.len();
    if n < 2 {
        return 0;
    }
    let half = n / 2;
    let mut swaps = sorted_with_swaps(&mut values[..half], &mut room[..half]);
    swaps += sorted_with_swaps(&mut values[half..], &mut room[half..]);
    let (mut i, mut j) = (0, half);
    for place in room.iter_mut() {
        if j == n || (i < half && values[i] <= values[j]) {
            *place = values[i];
            i += 1;
        } else {
            *place = values[j];
            j += 1;
            swaps += (half - i) as u64;
        }
    }
    values.copy_from_slice(room);
    swaps
}

/// Spearman's ρ: the correlation of the ranks, ties at their mean rank; `None` where one of the
/// measures is the same for all.
pub fn spearman(x: &[f64], y: &[f64]) -> Option<f64> {
    assert_eq!(x.len(), y.len(), "two measures of the same things");
    let (x, y) = (ranks(x), ranks(y));
    let mean = (x.len() as f64 + 1.0) / 2.0;
    let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
    for (a, b) in x.iter().zip(&y) {
        let (a, b) = (a - mean, b - mean);
        xy += a * b;
        xx += a * a;
        yy += b * b;
    }
    (xx > 0.0 && yy > 0.0).then(|| xy / (xx * yy).sqrt())
}

/// Ranks from 1; equal values share the mean of theirs.
pub fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut before = 0;
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let rank = before as f64 + (group.len() as f64 + 1.0) / 2.0;
        for &i in group {
            ranks[i] = rank;
        }
        before += group.len();
    }
    ranks
}
