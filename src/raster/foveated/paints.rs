//! Splats in the form that blending uses, once for every level that the picture shows.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::super::blend::Paint;
use super::LevelFilter;
use crate::scene::Foveated;
use crate::splat::Splat;
use crate::splat::project::{LANES, SH_C0, opacities};

/// Splats worked on together.
const PART: usize = 16 * LANES;

/// Splats by rank, and their paints in every level.
pub(super) struct LevelPaints {
    /// Splats whose opacity is the largest of their levels.
    pub splats: Vec<Splat>,
    /// Their highest levels.
    pub highest: Vec<u8>,
    /// Per level, by rank; levels that no tile shows are empty, and splats that a level does not
    /// have are blank.
    pub paints: [Vec<Paint>; 4],
}

impl LevelPaints {
    /// Paints of `splats`, whose `colours` are those of level 1 before the clamp at black.
    pub fn new(
        model: &Foveated,
        mut splats: Vec<Splat>,
        colours: &[[f32; 3]],
        filter: &LevelFilter,
        level: Level,
    ) -> LevelPaints {
        let tiles = filter.first.iter().zip(&filter.blends);
        let mut shown = [false; 4];
        for (&first, &blends) in tiles {
            shown[usize::from(first)] = true;
            shown[usize::from(first) + usize::from(blends)] = true;
        }
        let n = splats.len();
        let mut paints = shown.map(|s| vec![Paint::default(); if s { n } else { 0 }]);
        let mut highest = vec![0; n];
        let [a, b, c, d] = paints.each_mut().map(|paints| {
            let mut parts: Vec<&mut [Paint]> = paints.chunks_mut(PART).collect();
            parts.resize_with(n.div_ceil(PART), Default::default);
            parts
        });
        splats
            .par_chunks_mut(PART)
            .zip(colours.par_chunks(PART))
            .zip(highest.par_chunks_mut(PART))
            .zip(a.into_par_iter().zip(b).zip(c.into_par_iter().zip(d)))
            .for_each(|(((splats, colours), highest), ((a, b), (c, d)))| {
                let part = Part { model, splats, colours, highest };
                part.fill([a, b, c, d], level);
            });
        LevelPaints { splats, highest, paints }
    }
}

/// Some splats.
struct Part<'a> {
    model: &'a Foveated,
    splats: &'a mut [Splat],
    colours: &'a [[f32; 3]],
    highest: &'a mut [u8],
}

impl Part<'_> {
    fn fill(self, mut paints: [&mut [Paint]; 4], level: Level) {
        let model = self.model;
        let n = self.splats.len();
        // Opacities of levels 2 to 4.
        let mut upper = [[0.0f32; PART]; 3];
        for (i, splat) in self.splats.iter().enumerate() {
            let own = &model.paints[splat.index as usize];
            self.highest[i] = model.highest[splat.index as usize];
            for (lanes, paint) in upper.iter_mut().zip(own) {
                lanes[i] = paint.logit_opacity;
            }
        }
        for lanes in &mut upper {
            for lanes in lanes[..n.next_multiple_of(LANES)].as_chunks_mut().0 {
                *lanes = dispatch!(level, simd => opacities(simd, *lanes));
            }
        }
        for (i, splat) in self.splats.iter_mut().enumerate() {
            let index = splat.index as usize;
            let highest = usize::from(self.highest[i]);
            let raw = self.colours[i];
            let base = Paint::new(splat, raw.map(|c| c.max(0.0)));
            let first = model.paint(0, index).dc;
            for (k, paints) in paints.iter_mut().enumerate().take(highest + 1) {
                let Some(paint) = paints.get_mut(i) else { continue };
                *paint = base;
                if k > 0 {
                    let dc = model.paints[index][k - 1].dc;
                    let colour = |c: usize| (raw[c] + SH_C0 * (dc[c] - first[c])).max(0.0);
                    *paint = base.repainted(upper[k - 1][i], std::array::from_fn(colour));
                }
            }
            let most = upper[..highest].iter().map(|lanes| lanes[i]);
            splat.opacity = most.fold(splat.opacity, f32::max);
        }
    }
}
