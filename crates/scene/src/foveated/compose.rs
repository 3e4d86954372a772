//! Four models become one.

use super::{Foveated, LevelPaint, paint_of};
use crate::Gaussians;

/// Why models are not the levels of one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ComposeError {
    /// A level without Gaussians.
    #[error("level {level} has no Gaussians; a level has at least one")]
    Empty {
        /// From 1.
        level: usize,
    },
    /// Another degree of SH.
    #[error(
        "level {level} has SH degree {found}, level 1 has {expected}: they do not belong together"
    )]
    Degree {
        /// From 1.
        level: usize,
        /// Its degree.
        found: u8,
        /// That of level 1.
        expected: u8,
    },
    /// A level that is shown in another way.
    #[error(
        "one of levels 1 and {level} is an anti-aliased model and the other is not: they do not \
         belong together"
    )]
    Kind {
        /// From 1.
        level: usize,
    },
    /// A Gaussian that the level before does not have.
    #[error(
        "Gaussian {index} of level {level} is not in level {before}{why}; a level is a part of \
         the one before, in its order, with the same position, scales, rotation and SH \
         coefficients beyond DC, bit for bit: only DC colour and opacity are its own"
    )]
    NotNested {
        /// From 1.
        level: usize,
        /// Position in the level's file, from 0.
        index: usize,
        /// The level before.
        before: usize,
        /// What is known of the reason, in words.
        why: &'static str,
    },
}

impl Foveated {
    /// Makes one model of its four levels, coarsest last.
    ///
    /// # Errors
    /// Levels that do not belong together: another SH degree, or a Gaussian that the level before
    /// does not have.
    pub fn compose(levels: &[Gaussians; 4]) -> Result<Foveated, ComposeError> {
        let [base, upper @ ..] = levels;
        for (level, scene) in (1..).zip(levels) {
            if scene.is_empty() {
                return Err(ComposeError::Empty { level });
            }
            let (found, expected) = (scene.sh_degree, base.sh_degree);
            if found != expected {
                return Err(ComposeError::Degree { level, found, expected });
            }
            if scene.antialiased != base.antialiased {
                return Err(ComposeError::Kind { level });
            }
        }
        // Positions in level 1 of the Gaussians of the level before.
        let mut places: Vec<usize> = (0..base.len()).collect();
        let mut paints: Vec<[LevelPaint; 3]> =
            (0..base.len()).map(|i| [paint_of(base, i); 3]).collect();
        let mut highest = vec![0u8; base.len()];
        for (k, scene) in upper.iter().enumerate() {
            places = nested(base, &places, scene, k + 2)?;
            for (i, &place) in places.iter().enumerate() {
                highest[place] = k as u8 + 1;
                paints[place][k..].fill(paint_of(scene, i));
            }
        }
        Ok(Foveated { base: base.clone(), highest, paints })
    }
}

/// Positions in level 1 of the Gaussians of `scene`, which must be among those at `places`, in
/// order.
fn nested(
    base: &Gaussians,
    places: &[usize],
    scene: &Gaussians,
    level: usize,
) -> Result<Vec<usize>, ComposeError> {
    let mut left = places.iter();
    let mut found = Vec::with_capacity(scene.len().min(places.len()));
    for index in 0..scene.len() {
        let Some(&place) = left.find(|&&place| is_same(base, place, scene, index)) else {
            let elsewhere = places.iter().any(|&place| is_same(base, place, scene, index));
            let moved = (0..base.len()).any(|i| base.means[i] == scene.means[index]);
            let why = match (elsewhere, moved) {
                (true, _) => " at a place after the one before it: the order differs",
                (_, true) => " with the same parameters, although level 1 has its position",
                _ => "",
            };
            return Err(ComposeError::NotNested { level, index, before: level - 1, why });
        };
        found.push(place);
    }
    Ok(found)
}

/// Whether two Gaussians agree in everything that levels share, bit for bit.
fn is_same(a: &Gaussians, i: usize, b: &Gaussians, j: usize) -> bool {
    fn same(a: &[f32], b: &[f32]) -> bool {
        a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
    }
    let n = a.sh_coefficients();
    let mut channels = a.sh_of(i).chunks_exact(n).zip(b.sh_of(j).chunks_exact(n));
    same(&a.means[i], &b.means[j])
        && same(&a.log_scales[i], &b.log_scales[j])
        && same(&a.rotations[i], &b.rotations[j])
        && channels.all(|(a, b)| same(&a[1..], &b[1..]))
}
