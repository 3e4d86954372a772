//! The filters of the pyramid, 5 x 5, and their adjoints.
//!
//! The six bands are odd (point reflection changes their sign): twelve differences of opposite
//! neighbours serve all of them, and the adjoint of a band is minus the band. The low-pass and the
//! high-pass filter are even and their own adjoints. Source: the six-orientation steerable set,
//! centre-cropped as published.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::BANDS;
use super::plane::{LANES, Plane, lanes};

type Filter = [[f32; 5]; 5];

/// Rows −2, −1 and 0 of the low-pass filter; it is symmetric.
const LOW: [[f32; 5]; 3] = [
    [0.00341614, -0.01551246, -0.03848215, -0.01551246, 0.00341614],
    [-0.01551246, 0.05586982, 0.1592557, 0.05586982, -0.01551246],
    [-0.03848215, 0.1592557, 0.40304148, 0.1592557, -0.03848215],
];
/// Rows −2, −1 and 0 of the high-pass filter; it is symmetric.
const HIGH: [[f32; 5]; 3] = [
    [-0.00290081, -0.00673482, -0.00981051, -0.00673482, -0.00290081],
    [-0.00673482, -0.07027679, -0.11435863, -0.07027679, -0.00673482],
    [-0.00981051, -0.11435863, 0.813802, -0.11435863, -0.00981051],
];
/// Rows −2, −1 and 0 of the first three bands; they are odd.
const BAND: [[[f32; 5]; 3]; 3] = [
    [
        [-0.00893064, -0.03075356, 0.0, 0.03075356, 0.00893064],
        [0.01189859, -0.08226445, 0.0, 0.08226445, -0.01189859],
        [0.02755155, -0.11732297, 0.0, 0.11732297, -0.02755155],
    ],
    [
        [-0.01977507, 0.01486305, 0.04435647, -0.00853965, -0.01161195],
        [-0.04084211, -0.04819057, 0.09454202, 0.05394139, -0.03930573],
        [-0.00228219, -0.1222723, 0.0, 0.1222723, 0.00228219],
    ],
    [
        [0.01977507, 0.04084211, 0.00228219, -0.03930573, -0.01161195],
        [-0.01486305, 0.04819057, 0.1222723, 0.05394139, -0.00853965],
        [-0.04435647, -0.09454202, 0.0, 0.09454202, 0.04435647],
    ],
];

/// Half of the neighbours, `(dy, dx)`; the others are opposite.
const HALF: [(isize, isize); 12] = [
    (0, 1),
    (0, 2),
    (1, -2),
    (1, -1),
    (1, 0),
    (1, 1),
    (1, 2),
    (2, -2),
    (2, -1),
    (2, 0),
    (2, 1),
    (2, 2),
];

/// Weights of the six bands at the [`HALF`] neighbours.
const ODD: [[f32; BANDS]; 12] = odd();

const fn at(f: &Filter, (dy, dx): (isize, isize)) -> f32 {
    f[(dy + 2) as usize][(dx + 2) as usize]
}

/// The whole filter; `sign` is what a point reflection does to it.
const fn whole(rows: &[[f32; 5]; 3], sign: f32) -> Filter {
    let mut f = [[0.0; 5]; 5];
    let mut i = 0;
    while i < 25 {
        let (y, x) = (i / 5, i % 5);
        f[y][x] = if y < 3 { rows[y][x] } else { sign * rows[4 - y][4 - x] };
        i += 1;
    }
    f
}

const fn odd() -> [[f32; BANDS]; 12] {
    let first = [whole(&BAND[0], -1.0), whole(&BAND[1], -1.0), whole(&BAND[2], -1.0)];
    let mut table = [[0.0; BANDS]; 12];
    let mut k = 0;
    while k < 12 {
        let (dy, dx) = HALF[k];
        table[k] = [
            at(&first[0], (dy, dx)),
            at(&first[1], (dy, dx)),
            at(&first[2], (dy, dx)),
            // Minus the transpose of the first; the mirror images of the third and the second.
            -at(&first[0], (dx, dy)),
            at(&first[2], (dy, -dx)),
            at(&first[1], (dy, -dx)),
        ];
        k += 1;
    }
    table
}

/// Weights of an even filter at the [`HALF`] neighbours, then at the middle.
const fn even(rows: &[[f32; 5]; 3]) -> [f32; 13] {
    let f = whole(rows, 1.0);
    let mut weights = [0.0; 13];
    let mut k = 0;
    while k < 12 {
        weights[k] = at(&f, HALF[k]);
        k += 1;
    }
    weights[12] = f[2][2];
    weights
}

const EVEN_LOW: [f32; 13] = even(&LOW);
const EVEN_HIGH: [f32; 13] = even(&HIGH);

/// Five rows around row `y` of a plane, `y` counted from its second margin row.
#[inline(always)]
fn around(plane: &Plane, y: usize) -> [&[f32]; 5] {
    [
        plane.whole_row(y),
        plane.whole_row(y + 1),
        plane.whole_row(y + 2),
        plane.whole_row(y + 3),
        plane.whole_row(y + 4),
    ]
}

/// The neighbour and its opposite.
#[inline(always)]
fn opposite<S: Simd>(
    simd: S,
    rows: &[&[f32]; 5],
    i: usize,
    (dy, dx): (isize, isize),
) -> (f32x16<S>, f32x16<S>) {
    let (plus, minus) = (i.wrapping_add_signed(2 + dx), i.wrapping_add_signed(2 - dx));
    (
        f32x16::from_slice(simd, &rows[(2 + dy) as usize][plus..plus + LANES]),
        f32x16::from_slice(simd, &rows[(2 - dy) as usize][minus..minus + LANES]),
    )
}

/// Row `y` of both even filters of a plane with a margin of 2.
#[simd]
pub(crate) fn split_row<S: Simd>(
    simd: S,
    from: &Plane,
    y: usize,
    high: &mut [f32],
    low: &mut [f32],
) {
    let rows = around(from, y);
    for i in (0..lanes(from.width)).step_by(LANES) {
        let middle = f32x16::from_slice(simd, &rows[2][i + 2..i + 2 + LANES]);
        let (mut h, mut l) = (middle * EVEN_HIGH[12], middle * EVEN_LOW[12]);
        for k in 0..12 {
            let (plus, minus) = opposite(simd, &rows, i, HALF[k]);
            let both = plus + minus;
            h = both.mul_add(f32x16::splat(simd, EVEN_HIGH[k]), h);
            l = both.mul_add(f32x16::splat(simd, EVEN_LOW[k]), l);
        }
        h.store_slice(&mut high[i..i + LANES]);
        l.store_slice(&mut low[i..i + LANES]);
    }
    high[from.width..].fill(0.0);
    low[from.width..].fill(0.0);
}

/// Row `y` of the six bands of a plane with a margin of 2.
#[simd]
pub(crate) fn bands_row<S: Simd>(simd: S, from: &Plane, y: usize, out: [&mut [f32]; BANDS]) {
    let rows = around(from, y);
    let width = from.width;
    let [o0, o1, o2, o3, o4, o5] = out;
    for i in (0..lanes(width)).step_by(LANES) {
        let mut sum = [f32x16::splat(simd, 0.0); BANDS];
        for k in 0..12 {
            let (plus, minus) = opposite(simd, &rows, i, HALF[k]);
            let difference = plus - minus;
            for b in 0..BANDS {
                sum[b] = difference.mul_add(f32x16::splat(simd, ODD[k][b]), sum[b]);
            }
        }
        sum[0].store_slice(&mut o0[i..i + LANES]);
        sum[1].store_slice(&mut o1[i..i + LANES]);
        sum[2].store_slice(&mut o2[i..i + LANES]);
        sum[3].store_slice(&mut o3[i..i + LANES]);
        sum[4].store_slice(&mut o4[i..i + LANES]);
        sum[5].store_slice(&mut o5[i..i + LANES]);
    }
    for row in [o0, o1, o2, o3, o4, o5] {
        row[width..].fill(0.0);
    }
}

/// Row `y`, from the margin of 2 on, of the adjoint of [`bands_row`] before margins are folded.
/// The gradients have margins of 4 zeros.
#[simd]
pub(crate) fn bands_adjoint_row<S: Simd>(
    simd: S,
    from: &[Plane; BANDS],
    y: usize,
    out: &mut [f32],
) {
    for i in (0..lanes(from[0].width + 4)).step_by(LANES) {
        let mut sum = f32x16::splat(simd, 0.0);
        for b in 0..BANDS {
            let rows = around(&from[b], y);
            for k in 0..12 {
                let (plus, minus) = opposite(simd, &rows, i, HALF[k]);
                sum = (minus - plus).mul_add(f32x16::splat(simd, ODD[k][b]), sum);
            }
        }
        sum.store_slice(&mut out[i..i + LANES]);
    }
}

/// As [`bands_adjoint_row`], of [`split_row`].
#[simd]
pub(crate) fn split_adjoint_row<S: Simd>(
    simd: S,
    high: &Plane,
    low: &Plane,
    y: usize,
    out: &mut [f32],
) {
    for i in (0..lanes(high.width + 4)).step_by(LANES) {
        let mut sum = f32x16::splat(simd, 0.0);
        let (h, l) = (around(high, y), around(low, y));
        for k in 0..12 {
            let (plus, minus) = opposite(simd, &h, i, HALF[k]);
            sum = (plus + minus).mul_add(f32x16::splat(simd, EVEN_HIGH[k]), sum);
            let (plus, minus) = opposite(simd, &l, i, HALF[k]);
            sum = (plus + minus).mul_add(f32x16::splat(simd, EVEN_LOW[k]), sum);
        }
        let middle = f32x16::from_slice(simd, &h[2][i + 2..i + 2 + LANES]);
        sum = middle.mul_add(f32x16::splat(simd, EVEN_HIGH[12]), sum);
        let middle = f32x16::from_slice(simd, &l[2][i + 2..i + 2 + LANES]);
        sum = middle.mul_add(f32x16::splat(simd, EVEN_LOW[12]), sum);
        sum.store_slice(&mut out[i..i + LANES]);
    }
}
