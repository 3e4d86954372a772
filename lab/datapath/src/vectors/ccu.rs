//! Work of a culling and conversion unit.

use super::{Event, Vectors, halves};
use crate::ccu::{Ccu, Gaussian, Settings};

/// A mean is taken.
pub const TAKES_MEAN: u16 = 0;
/// Whether it is kept.
pub const VERDICT: u16 = 1;
/// A shape is taken.
pub const TAKES_SHAPE: u16 = 2;
/// A splat leaves: five numbers.
pub const SPLAT: u16 = 3;
/// A pair leaves: splat, column, row, sub-tiles, u, v.
pub const PAIR: u16 = 4;
/// Coefficients are taken.
pub const TAKES_COEFFICIENTS: u16 = 5;
/// A colour leaves: three numbers.
pub const COLOUR: u16 = 6;

/// A Gaussian and its coefficients, three of a channel each, those beyond the degree 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CcuWork {
    /// Mean and shape.
    pub gaussian: Gaussian,
    /// Coefficients of its colour.
    pub coefficients: [u16; 48],
}

/// Gaussians for `rtl/tb/ccu.cpp` in the view of `settings`, with `pause` cycles behind each.
/// Cycles are not stated: laps of three engines begin at multiples of their own lengths.
pub fn ccu(unit: &Ccu, settings: &Settings, degree: u32, pause: u16, work: &[CcuWork]) -> Vectors {
    let mut stimulus = vec![0; super::HEAD];
    let [columns, rows] = settings.tiles.map(|n| n as u16);
    stimulus.extend([pause, degree as u16, columns, rows]);
    stimulus.extend(settings.numbers.iter().flat_map(|&number| halves(number)));
    let mut expected = Vec::new();
    let mut tell = |kind, words| expected.push(Event { kind, cycle: 0, words });
    let mut seen = 0u16;
    for CcuWork { gaussian, coefficients } in work {
        let splat = unit.splat(settings, gaussian);
        let numbers = gaussian.mean.iter().chain(&gaussian.shape);
        stimulus.extend(numbers.flat_map(|&number| halves(number)));
        stimulus.push(u16::from(splat.is_some()));
        stimulus.extend(coefficients);
        let is_kept = unit.cull(settings, &gaussian.mean).kept;
        tell(TAKES_MEAN, Vec::new());
        tell(VERDICT, vec![u16::from(is_kept)]);
        if is_kept {
            tell(TAKES_SHAPE, Vec::new());
        }
        let Some((converted, walk)) = splat else { continue };
        let [a, b, c] = converted.root;
        tell(SPLAT, vec![converted.depth, a, b, c, converted.opacity]);
        for pair in walk.pairs(unit.narrow()) {
            let [x, y] = pair.tile.map(|at| at as u16);
            let [u, v] = pair.local;
            tell(PAIR, vec![seen & 0xff, x, y, pair.subtiles as u16, u, v]);
        }
        seen = seen.wrapping_add(1);
        tell(TAKES_COEFFICIENTS, Vec::new());
        tell(COLOUR, unit.colour(degree, &converted.direction, coefficients).to_vec());
    }
    expected.sort_by_key(|event| event.kind);
    Vectors { stimulus, expected, event_words: 9, timed: false }
}
