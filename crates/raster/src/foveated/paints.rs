//! Splats in the form that blending uses, in all levels that tiles show them in.
//!
//! A paint holds the lowest level in which a splat is shown, and the changes of the next level:
//! most splats touch few tiles and need no more. A separate list has the changes of further levels.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::super::blend::{BATCH, Paint, Palette, Tint};
use super::super::prepare::{in_depth_order, project_then};
use powergs_frame::splat::Splat;
use powergs_frame::splat::levels::LevelFilter;
use powergs_frame::splat::project::{LANES, SH_C0, View, Visible, compensations, opacities};
use powergs_scene::{Camera, Foveated};

/// Where in `levels` of a paint its place in the list of further tints starts, bits.
const FURTHER: u32 = 4;

/// Visible splats by rank, and their paints.
pub(super) struct LevelPaints {
    /// Splats whose opacity is the largest of their levels.
    pub splats: Vec<Splat>,
    /// Their highest levels.
    pub highest: Vec<u8>,
    /// One bit per Gaussian: passed the cull.
    pub survivor_bits: Vec<u8>,
    /// `levels` is the lowest level that is shown, in two bits, the highest that there is, in two,
    /// and the place in `further` of the level after the next.
    paints: Vec<Paint>,
    further: Vec<Tint>,
}

/// Visible splats of a part of the scene, in order.
#[derive(Default)]
struct Layers {
    /// Splats whose opacity is the largest of their levels.
    splats: Vec<Splat>,
    /// As in [`LevelPaints`], with places in the list of the part.
    paints: Vec<Paint>,
    further: Vec<Tint>,
}

/// What makes the layers of a part.
struct Maker<'a> {
    model: &'a Foveated,
    view: &'a View,
    filter: &'a LevelFilter,
    level: Level,
    /// Leave out splats that no tile shows.
    only_shown: bool,
}

impl LevelPaints {
    /// Projects a model. If `only_shown`, splats that no tile shows are left out.
    pub(crate) fn new(
        model: &Foveated,
        camera: &Camera,
        filter: &LevelFilter,
        level: Level,
        only_shown: bool,
    ) -> LevelPaints {
        let view = View::unclamped(camera);
        let maker = Maker { model, view: &view, filter, level, only_shown };
        let (mut parts, mut survivor_bits) = (Vec::new(), Vec::new());
        project_then(
            &model.base,
            &view,
            level,
            &mut parts,
            &mut survivor_bits,
            |visible, layers| {
                *layers = maker.layers(visible);
            },
        );
        let starts: Vec<u32> = parts
            .iter()
            .scan(0, |end, p| Some(std::mem::replace(end, *end + p.further.len() as u32)))
            .collect();
        let further = parts.iter().flat_map(|part| &part.further).copied().collect();
        let shown: Vec<Vec<(Splat, Paint)>> = parts
            .into_iter()
            .map(|part| part.splats.into_iter().zip(part.paints).collect())
            .collect();
        let depth = |shown: &(Splat, Paint)| shown.0.depth;
        let (mut splats, mut paints) = (Vec::new(), Vec::new());
        let outputs = (&mut splats, &mut paints);
        in_depth_order(&shown, depth, &mut Vec::new(), outputs, |part, (splat, mut paint)| {
            paint.levels += starts[part] << FURTHER;
            (splat, paint)
        });
        let highest = paints.par_iter().map(|paint| highest(paint) as u8).collect();
        LevelPaints { splats, highest, survivor_bits, paints, further }
    }

    /// The paints of a level.
    pub(crate) fn of_level(&self, level: u8) -> OfLevel<'_> {
        OfLevel { paints: &self.paints, further: &self.further, level: u32::from(level) }
    }
}

/// The paints of one level.
#[derive(Clone, Copy)]
pub(super) struct OfLevel<'a> {
    paints: &'a [Paint],
    further: &'a [Tint],
    level: u32,
}

impl Palette for OfLevel<'_> {
    #[inline(always)]
    fn fetch(&self, ranks: &[u32], near: &mut [Paint; BATCH]) {
        self.paints.fetch(ranks, near);
        for paint in &mut near[..ranks.len()] {
            let up = self.level - lowest(paint);
            if up > 0 {
                paint.set_tint(self.tint(paint, up));
            }
        }
    }
}

impl OfLevel<'_> {
    /// As [`Palette::fetch`], with the tints of the same splats in the next level; opacity 0 where
    /// that level does not have them.
    #[inline(always)]
    pub(crate) fn fetch_two(
        &self,
        ranks: &[u32],
        near: &mut [Paint; BATCH],
        next: &mut [Tint; BATCH],
    ) {
        self.paints.fetch(ranks, near);
        for (paint, next) in near[..ranks.len()].iter_mut().zip(next) {
            let up = self.level - lowest(paint);
            *next = match highest(paint) > self.level {
                true => self.tint(paint, up + 1),
                false => Tint::NOTHING,
            };
            if up > 0 {
                paint.set_tint(self.tint(paint, up));
            }
        }
    }

    /// The tint of a splat `up` levels above its lowest one; `up` is not 0.
    #[inline(always)]
    fn tint(&self, paint: &Paint, up: u32) -> Tint {
        if up == 1 {
            paint.next
        } else {
            self.further[((paint.levels >> FURTHER) + up - 2) as usize]
        }
    }
}

/// The level of a paint.
#[inline(always)]
fn lowest(paint: &Paint) -> u32 {
    paint.levels & 3
}

/// The highest level that has the splat.
#[inline(always)]
fn highest(paint: &Paint) -> u32 {
    paint.levels >> 2 & 3
}

impl Maker<'_> {
    fn layers(&self, visible: &[Visible]) -> Layers {
        let n = visible.len();
        let (splats, paints) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut out = Layers { splats, paints, further: Vec::new() };
        for visible in visible.chunks(LANES) {
            // Nothing but reads, so that their cache misses overlap.
            let mut logits = [[0.0; LANES]; 3];
            let mut dc = 0.0;
            for (i, v) in visible.iter().enumerate() {
                let own = &self.model.paints[v.splat.index as usize];
                dc += own[0].dc[0];
                for (lanes, paint) in logits.iter_mut().zip(own) {
                    lanes[i] = paint.logit_opacity;
                }
            }
            // Else the compiler would leave out these reads, whose values are not used here.
            std::hint::black_box(dc);
            let [a, b, c] = logits;
            let mut upper = dispatch!(self.level, simd =>
                [opacities(simd, a), opacities(simd, b), opacities(simd, c)]);
            if self.model.base.antialiased {
                self.compensate(visible, &mut upper);
            }
            for (i, v) in visible.iter().enumerate() {
                let rect = v.splat.tile_rect(&self.filter.grid);
                let highest = self.model.highest[v.splat.index as usize];
                let span = self.filter.span(&rect, highest);
                if span.is_some() || !self.only_shown {
                    let opacities = [v.splat.opacity, upper[0][i], upper[1][i], upper[2][i]];
                    let (lowest, last) = span.unwrap_or_default();
                    self.add(v, highest, opacities, lowest, last, &mut out);
                }
            }
        }
        out
    }

    /// Compensates the opacities of upper levels for the low-pass; those of the base are.
    fn compensate(&self, visible: &[Visible], upper: &mut [[f32; LANES]; 3]) {
        let mut indices = [0; LANES];
        for (index, v) in indices.iter_mut().zip(visible) {
            *index = v.splat.index;
        }
        let (scene, indices) = (&self.model.base, &indices[..visible.len()]);
        let factors = dispatch!(self.level, simd => compensations(simd, scene, self.view, indices));
        for opacities in upper {
            for (opacity, factor) in opacities.iter_mut().zip(factors) {
                *opacity *= factor;
            }
        }
    }

    /// Adds a splat that is shown in levels `lowest` to `last`.
    #[inline(always)]
    fn add(
        &self,
        v: &Visible,
        highest: u8,
        opacities: [f32; 4],
        lowest: u8,
        last: u8,
        out: &mut Layers,
    ) {
        let mut splat = v.splat;
        // The brightest level decides which tiles are touched: the list serves all levels.
        for &opacity in &opacities[1..=usize::from(highest)] {
            splat.opacity = splat.opacity.max(opacity);
        }
        out.splats.push(splat);
        let further = (out.further.len() as u32) << FURTHER;
        let mut paint = if lowest == 0 {
            Paint::new(&v.splat, [v.colour[0].max(0.0), v.colour[1].max(0.0), v.colour[2].max(0.0)])
        } else {
            let opacity = opacities[usize::from(lowest)];
            Paint::new(&Splat { opacity, ..v.splat }, self.colour(v, lowest))
        };
        for level in lowest + 1..=last {
            let tint = Tint::new(opacities[usize::from(level)], self.colour(v, level));
            if level == lowest + 1 {
                paint.next = tint;
            } else {
                out.further.push(tint);
            }
        }
        paint.levels = u32::from(lowest) | u32::from(highest) << 2 | further;
        out.paints.push(paint);
    }

    /// The colour of a splat in a level above the first.
    #[inline(always)]
    fn colour(&self, v: &Visible, level: u8) -> [f32; 3] {
        let index = v.splat.index as usize;
        let base = &self.model.base;
        let (sh, n) = (base.sh_of(index), base.sh_coefficients());
        let dc = &self.model.paints[index][usize::from(level) - 1].dc;
        let mut colour = v.colour;
        for (c, value) in colour.iter_mut().enumerate() {
            *value = (*value + SH_C0 * (dc[c] - sh[c * n])).max(0.0);
        }
        colour
    }
}
