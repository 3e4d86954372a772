//! Quaternions as the codes of their three smaller components.

use super::convert::quaternion;

/// Components below this are not left out: the error of one that is derived grows as it shrinks.
/// The largest is never below 0.5.
const LEAST: f64 = 0.4;

/// A rotation: the place of the component that is left out, and the codes of the others in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SmallestThree {
    pub place: u32,
    pub codes: [u32; 3],
}

/// The codes that are read back as the rotation closest to `q`, whose length is not zero. What a
/// reader made of such codes is found again exactly, also where the component that was left out is
/// no longer the largest.
pub(super) fn encode(
    q: [f32; 4],
    code: impl Fn(f64) -> u32,
    value: impl Fn(u32) -> f64,
) -> SmallestThree {
    let wide = q.map(f64::from);
    let length = wide.iter().map(|c| c * c).sum::<f64>().sqrt();
    let unit = wide.map(|c| c / length);
    let mut best = (f64::INFINITY, SmallestThree { place: 0, codes: [0; 3] });
    for place in 0..4 {
        let sign = unit[place].signum();
        let mut others = (0..4).filter(|&other| other != place).map(|other| sign * unit[other]);
        let codes = [(); 3].map(|()| code(others.next().expect("three others")));
        let found = SmallestThree { place: place as u32, codes };
        let read = quaternion(codes.map(&value), place);
        if read == q {
            return found;
        }
        let apart = unit.iter().zip(read).map(|(c, r)| (sign * c - f64::from(r)).abs());
        let error = apart.fold(0.0, f64::max);
        if unit[place].abs() >= LEAST && error < best.0 {
            best = (error, found);
        }
    }
    best.1
}
