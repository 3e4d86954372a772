//! The order check against a sorter that moves every entry.

use powergs_core::workload::order::{DepthKey, PivotRule, SortCheck, Sorter, check};
use powergs_core::workload::{FrameWorkload, Geometry, bin};

use super::support::{GEOMETRIES, dense_frame};

/// An entry on its way: key, arrival, exact place in its list.
type Entry = (u32, u32, u32);

fn pivots(part: &[Entry], sorter: Sorter) -> Vec<u32> {
    let n = u64::from(sorter.pivots) + 1;
    let mut keys: Vec<u32> = part.iter().map(|e| e.0).collect();
    match sorter.rule {
        PivotRule::Range => {
            let low = u64::from(*keys.iter().min().unwrap());
            let high = u64::from(*keys.iter().max().unwrap());
            (1..n).map(|j| (low + (high - low) * j / n) as u32).collect()
        }
        PivotRule::Quantile => {
            let sampled = (0..8 * n as usize).map(|k| keys[k * keys.len() / (8 * n as usize)]);
            keys = sampled.collect();
            keys.sort_unstable();
            keys.into_iter().step_by(8).skip(1).collect()
        }
    }
}

/// What leaves the sorter of a list, and the lengths of its parts.
fn sorted(list: &[u32], w: &FrameWorkload, sorter: Sorter) -> (Vec<Entry>, Vec<usize>) {
    let entry = |(place, &rank): (u32, &u32)| {
        (sorter.key.of(w.depth[rank as usize]), w.index[rank as usize], place)
    };
    let mut entries: Vec<Entry> = (0..).zip(list).map(entry).collect();
    entries.sort_by_key(|e| e.1);
    let chunk = w.geometry.chunk as usize;
    let mut parts = vec![entries];
    let mut reach = chunk;
    while reach < list.len() {
        let mut next = Vec::new();
        for part in parts {
            if part.len() <= chunk {
                next.push(part);
                continue;
            }
            let pivots = pivots(&part, sorter);
            let mut split = vec![Vec::new(); pivots.len() + 1];
            for entry in part {
                split[pivots.iter().filter(|&&p| p <= entry.0).count()].push(entry);
            }
            next.extend(split.into_iter().filter(|p| !p.is_empty()));
        }
        parts = next;
        reach *= sorter.pivots as usize + 1;
    }
    let lengths = parts.iter().map(Vec::len).collect();
    let mut out = Vec::new();
    for part in parts {
        for piece in part.chunks(chunk) {
            let mut piece = piece.to_vec();
            piece.sort_by_key(|e| e.0);
            out.extend(piece);
        }
    }
    (out, lengths)
}

fn naive(w: &FrameWorkload, sorter: Sorter) -> SortCheck {
    let mut sum = SortCheck::default();
    let lists = w.groups_x() * w.groups_y();
    for (group, list) in (0..lists).map(|g| (g as usize, w.group_list(g))) {
        let needed = match w.groups.get(group) {
            Some(group) => group.sorted,
            None => w.tiles[group].loaded,
        } as usize;
        let (mut out, parts) = sorted(&list, w, sorter);
        out.truncate(needed);
        let depth = |e: &Entry| w.depth[list[e.2 as usize] as usize];
        let mut inverted = 0;
        for (i, a) in out.iter().enumerate() {
            for b in &out[i + 1..] {
                inverted += u64::from(depth(a) > depth(b));
                sum.inverted_by_precision += u64::from(depth(a) > depth(b) && a.0 == b.0);
            }
            sum.displacement = sum.displacement.max(a.2.abs_diff(i as u32));
        }
        let due = |i: usize| w.depth[list[i] as usize];
        for i in 0..needed {
            for j in 0..i {
                let equal = sorter.key.of(due(i)) == sorter.key.of(due(j));
                sum.equal_key_pairs += u64::from(equal && due(i) != due(j));
            }
        }
        sum.lists += u64::from(!list.is_empty());
        sum.disordered_lists += u64::from(inverted > 0);
        sum.inverted_pairs += inverted;
        sum.entries += out.len() as u64;
        sum.adjacent_pairs += out.windows(2).filter(|w| depth(&w[0]) > depth(&w[1])).count() as u64;
        let chunk = w.geometry.chunk as usize;
        sum.oversized_entries += parts.iter().filter(|&&n| n > chunk).sum::<usize>() as u64;
        sum.longest_part = sum.longest_part.max(parts.iter().copied().max().unwrap_or(0) as u32);
    }
    sum
}

#[test]
fn the_check_equals_a_sorter_that_moves_every_entry() {
    let mut frame = dense_frame(41);
    // Arrival has nothing to do with depth, and some depths are equal.
    for (i, splat) in frame.splats.iter_mut().enumerate() {
        splat.depth = (splat.depth * 512.0).floor() / 512.0 + 1e-6 * (i % 2) as f32;
    }
    frame.splats.sort_by_key(|s| s.order_key());
    let (mut by_precision, mut by_pivots) = (0, 0);
    for geometry in GEOMETRIES {
        let w = bin(&frame, geometry);
        for key in [DepthKey::Fp16, DepthKey::Bf16, DepthKey::Fp32] {
            for (pivots, rule) in
                [(7, PivotRule::Range), (7, PivotRule::Quantile), (1, PivotRule::Range)]
            {
                let sorter = Sorter { key, pivots, rule };
                let found = check(&w, sorter);
                assert_eq!(found, naive(&w, sorter), "{geometry:?} {sorter:?}");
                by_precision += found.inverted_by_precision;
                by_pivots += found.inverted_pairs - found.inverted_by_precision;
            }
        }
    }
    assert!(by_precision > 0 && by_pivots > 0, "both happen here");
}

#[test]
fn full_keys_and_lists_of_one_chunk_are_exact() {
    let frame = dense_frame(42);
    let w = bin(&frame, Geometry { chunk: 6000, ..Geometry::REFERENCE });
    let exact = Sorter { key: DepthKey::Fp32, pivots: 7, rule: PivotRule::Range };
    let found = check(&w, exact);
    assert_eq!(found.entries, w.counters.tile_loads);
    let clean = SortCheck {
        lists: found.lists,
        entries: found.entries,
        longest_part: found.longest_part,
        ..SortCheck::default()
    };
    assert_eq!(found, clean);
    let half = check(&w, Sorter { key: DepthKey::Fp16, ..exact });
    assert!(half.inverted_pairs > 0);
    assert_eq!(half.inverted_by_precision, half.inverted_pairs);
    assert!(half.inverted_pairs <= half.equal_key_pairs);
    assert!(half.adjacent_pairs <= half.inverted_pairs);
}

#[test]
fn threads_do_not_matter() {
    let w = bin(&dense_frame(43), GEOMETRIES[1]);
    let sorter = Sorter { key: DepthKey::Bf16, pivots: 3, rule: PivotRule::Quantile };
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| check(&w, sorter))
    };
    assert_eq!(with(1), with(7));
}

/// The value of a binary16, by definition.
fn value(bits: u32) -> f64 {
    let (exponent, mantissa) = ((bits >> 10) as i32, f64::from(bits & 1023));
    match exponent {
        0 => mantissa * 2f64.powi(-24),
        e => (1.0 + mantissa / 1024.0) * 2f64.powi(e - 15),
    }
}

#[test]
fn half_precision_is_the_nearest_ties_to_even() {
    for bits in 1..0x7bff {
        let (below, own, above) = (value(bits - 1), value(bits), value(bits + 1));
        assert_eq!(DepthKey::Fp16.of(own as f32), bits);
        // Half-way between two is exact in f32.
        let (low, high) = ((below + own) as f32 / 2.0, (own + above) as f32 / 2.0);
        let even = |lower: u32| lower + lower % 2;
        assert_eq!(DepthKey::Fp16.of(low), even(bits - 1));
        assert_eq!(DepthKey::Fp16.of(low.next_up()), bits);
        assert_eq!(DepthKey::Fp16.of(high), even(bits));
        assert_eq!(DepthKey::Fp16.of(high.next_down()), bits);
    }
    for (depth, bits) in [(65519.99, 0x7bff), (65520.0, 0x7c00), (f32::MAX, 0x7c00), (0.0, 0)] {
        assert_eq!(DepthKey::Fp16.of(depth), bits, "{depth}");
    }
    assert_eq!(DepthKey::Bf16.of(1.0), 0x3f80);
    assert_eq!(DepthKey::Fp32.of(1.0), 0x3f80_0000);
}
