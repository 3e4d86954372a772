//! The rules that every frame keeps, held on writing and on reading.

use rayon::prelude::*;

use super::column::Id;
use super::{Fovea, Frame, FrameFacts, FrameFault, LEVEL_MAX, NEVER, POINTS_MAX, SIDE_MAX};
use crate::scene::ShDegree;
use crate::splat::Splat;

/// How far rows of a rotation may be from orthonormal: cameras from text files with six digits
/// pass.
const ORTHONORMAL: f64 = 1e-3;

/// Splats that one task checks.
const CHECKED_TOGETHER: usize = 1 << 14;

impl Frame {
    /// Whether the frame keeps the rules of traces; the first broken one otherwise. They are listed
    /// in `docs/trace-format.md`.
    ///
    /// # Errors
    /// The first broken rule.
    pub fn check(&self) -> Result<(), FrameFault> {
        self.facts.check()?;
        let pixels = self.facts.pixels();
        if self.splats.len() as u64 > self.facts.survivors {
            return facts("there are more splats than survivors of the cull");
        }
        same_length(Id::StopRank, self.pixels.stop_rank.len(), pixels)?;
        same_length(Id::Blended, self.pixels.blended.len(), pixels)?;
        let ranks = self.splats.len() as u32;
        check_splats(&self.splats, self.facts.points)?;
        check_stops(Id::StopRank, &self.pixels.stop_rank, ranks)?;
        self.check_blended(ranks)?;
        self.check_survivors()?;
        self.check_frustum()?;
        if let Some(fovea) = &self.fovea {
            fovea.check(ranks, pixels)?;
        }
        self.check_preview()
    }

    fn check_blended(&self, ranks: u32) -> Result<(), FrameFault> {
        let pixels = self.pixels.stop_rank.iter().zip(&self.pixels.blended);
        let limit = |stop: u32| if stop == NEVER { ranks } else { stop + 1 };
        let bad = pixels.map(|(&stop, &n)| n > limit(stop)).position(|bad| bad);
        let Some(i) = bad else { return Ok(()) };
        let value = f64::from(self.pixels.blended[i]);
        fault(Id::Blended, i, value, "is more than the splats up to the stop")
    }

    /// Bits of points are as many as there are points.
    fn check_bits(&self, id: Id, bits: &[u8]) -> Result<(), FrameFault> {
        same_length(id, bits.len(), self.facts.points.div_ceil(8))?;
        let spare = self.facts.points % 8;
        let last = bits.last().copied().unwrap_or(0);
        match spare != 0 && last >> spare != 0 {
            true => fault(id, bits.len() - 1, last.into(), "has bits beyond the scene"),
            false => Ok(()),
        }
    }

    fn check_frustum(&self) -> Result<(), FrameFault> {
        let Some(bits) = &self.frustum_bits else { return Ok(()) };
        self.check_bits(Id::FrustumBits, bits)?;
        let Some(survivors) = &self.survivor_bits else { return Ok(()) };
        let is_behind = |(inside, survives): (&u8, &u8)| inside & !survives != 0;
        let Some(i) = bits.iter().zip(survivors).position(is_behind) else { return Ok(()) };
        fault(Id::FrustumBits, i, bits[i].into(), "is inside the frustum but behind the near plane")
    }

    fn check_survivors(&self) -> Result<(), FrameFault> {
        let Some(bits) = &self.survivor_bits else { return Ok(()) };
        self.check_bits(Id::SurvivorBits, bits)?;
        let count: u64 = bits.iter().map(|b| u64::from(b.count_ones())).sum();
        if count != self.facts.survivors {
            return facts("the survivor bits do not add up to the survivors");
        }
        let is_set = |s: &Splat| bits[s.index as usize / 8] >> (s.index % 8) & 1 == 1;
        let Some(i) = self.splats.iter().position(|s| !is_set(s)) else { return Ok(()) };
        fault(Id::Index, i, self.splats[i].index.into(), "is visible but no survivor of the cull")
    }

    fn check_preview(&self) -> Result<(), FrameFault> {
        let Some(preview) = &self.preview else { return Ok(()) };
        if !(1..=SIDE_MAX).contains(&preview.width) || !(1..=SIDE_MAX).contains(&preview.height) {
            return facts("a side of the preview is not between 1 and 65,536 pixels");
        }
        let due = 3 * u64::from(preview.width) * u64::from(preview.height);
        same_length(Id::Preview, preview.rgb.len(), due)
    }
}

impl FrameFacts {
    /// The SH degree that the frame counts as: 3 where the trace does not say.
    pub fn colour_degree(&self) -> ShDegree {
        self.sh_degree.unwrap_or(ShDegree::MAX)
    }

    /// Pixels of the frame.
    pub fn pixels(&self) -> u64 {
        u64::from(self.camera.width) * u64::from(self.camera.height)
    }

    /// The rules that do not need the columns.
    pub(super) fn check(&self) -> Result<(), FrameFault> {
        let c = &self.camera;
        let sides = 1..=SIDE_MAX;
        let error = (c.world_to_camera * c.world_to_camera.transpose() - glam::DMat3::IDENTITY)
            .to_cols_array();
        let mean = self.mean_linear_rgb.unwrap_or_default();
        let rules = [
            (c.name.len() <= usize::from(u16::MAX), "the view's name is longer than 65,535 bytes"),
            (sides.contains(&c.width), "the width is not between 1 and 65,536 pixels"),
            (sides.contains(&c.height), "the height is not between 1 and 65,536 pixels"),
            (
                [c.fx, c.fy].iter().all(|f| f.is_finite() && *f > 0.0),
                "a focal length is not positive",
            ),
            (c.cx.is_finite() && c.cy.is_finite(), "the principal point is not finite"),
            (
                error.iter().all(|e| e.abs() <= ORTHONORMAL),
                "the camera's rotation is not orthonormal",
            ),
            (c.centre.is_finite(), "the camera's centre is not finite"),
            (self.points <= POINTS_MAX, "the scene has more than 2^32 - 1 Gaussians"),
            (self.survivors <= self.points, "there are more survivors than Gaussians"),
            (self.background.iter().all(|v| v.is_finite()), "the background is not finite"),
            (
                mean.iter().all(|v| (0.0..=1.0).contains(v)),
                "a mean linear colour is not from 0 to 1",
            ),
        ];
        match rules.into_iter().find(|(kept, _)| !kept) {
            Some((_, what)) => facts(what),
            None => Ok(()),
        }
    }
}

impl Fovea {
    fn check(&self, ranks: u32, pixels: u64) -> Result<(), FrameFault> {
        if !self.gaze.iter().all(|g| (0.0..=1.0).contains(g)) {
            return facts("the gaze is not within the image");
        }
        if self.screen.check().is_err() {
            return facts("the virtual screen has a field of view or pooling rate that cannot be");
        }
        same_length(Id::HighestLevel, self.highest_level.len(), u64::from(ranks))?;
        same_length(Id::StopRank2, self.stop_rank_2.len(), pixels)?;
        same_length(Id::ExtraAlpha, self.extra_alpha.len(), pixels)?;
        same_length(Id::Blended2, self.blended_2.len(), pixels)?;
        if let Some(i) = self.highest_level.iter().position(|&l| l > LEVEL_MAX) {
            return fault(Id::HighestLevel, i, self.highest_level[i].into(), "is above level 3");
        }
        check_stops(Id::StopRank2, &self.stop_rank_2, ranks)?;
        for (id, column) in [(Id::ExtraAlpha, &self.extra_alpha), (Id::Blended2, &self.blended_2)] {
            if let Some(i) = column.iter().position(|&n| n > ranks) {
                return fault(id, i, column[i].into(), "is more than the splats of the frame");
            }
        }
        Ok(())
    }
}

/// Finite values, depth order, indices that are in the scene and once each.
fn check_splats(splats: &[Splat], points: u64) -> Result<(), FrameFault> {
    if !splats.par_chunks(CHECKED_TOGETHER).all(|part| are_sound(part, points)) {
        splats.iter().enumerate().try_for_each(|(i, s)| check_splat(i, s, points))?;
    }
    let descends = |pair: &[Splat]| pair[0].order_key() >= pair[1].order_key();
    if let Some(i) = splats.windows(2).position(descends) {
        let rule = "breaks the order: ranks ascend in depth, then in index";
        return fault(Id::Depth, i + 1, splats[i + 1].depth.into(), rule);
    }
    match repeated_index(splats, points) {
        Some(i) => fault(Id::Index, i, splats[i].index.into(), "occurs twice"),
        None => Ok(()),
    }
}

/// Whether [`check_splat`] finds nothing, at the speed of memory: no early exit, so that several
/// splats are looked at together.
fn are_sound(splats: &[Splat], points: u64) -> bool {
    splats.iter().fold(true, |sound, s| {
        let [x, y] = s.mean;
        let [a, b, d] = s.cov;
        // A sum of magnitudes scaled against overflow is finite exactly if all of them are.
        let sum = [x, y, a, b, d].iter().fold(0.0, |sum, v| sum + v.abs() * 0.125);
        sound
            & (u64::from(s.index) < points)
            & (s.depth > 0.0)
            & (s.depth < f32::INFINITY)
            & (sum < f32::INFINITY)
            & (s.opacity >= 0.0)
            & (s.opacity <= 1.0)
    })
}

fn check_splat(i: usize, s: &Splat, points: u64) -> Result<(), FrameFault> {
    let finite = "is not finite";
    let rules = [
        (u64::from(s.index) < points, Id::Index, s.index.into(), "is not in the scene"),
        (s.depth.is_finite() && s.depth > 0.0, Id::Depth, s.depth.into(), "is not positive"),
        (s.mean[0].is_finite(), Id::MeanX, s.mean[0].into(), finite),
        (s.mean[1].is_finite(), Id::MeanY, s.mean[1].into(), finite),
        (s.cov[0].is_finite(), Id::CovA, s.cov[0].into(), finite),
        (s.cov[1].is_finite(), Id::CovB, s.cov[1].into(), finite),
        (s.cov[2].is_finite(), Id::CovD, s.cov[2].into(), finite),
        ((0.0..=1.0).contains(&s.opacity), Id::Opacity, s.opacity.into(), "is not from 0 to 1"),
    ];
    match rules.into_iter().find(|rule| !rule.0) {
        Some((_, id, value, rule)) => fault(id, i, value, rule),
        None => Ok(()),
    }
}

/// The position of the first splat whose index an earlier one has. Memory is in proportion to the
/// splats, whatever size of scene the frame claims.
fn repeated_index(splats: &[Splat], points: u64) -> Option<usize> {
    const BITS_PER_SPLAT: u64 = 256;
    if points <= BITS_PER_SPLAT * splats.len() as u64 {
        let mut seen = vec![0u64; points.div_ceil(64) as usize];
        return splats.iter().position(|s| {
            let (word, bit) = (&mut seen[s.index as usize / 64], 1u64 << (s.index % 64));
            let repeated = *word & bit != 0;
            *word |= bit;
            repeated
        });
    }
    let mut order: Vec<(u32, u32)> = splats.iter().map(|s| s.index).zip(0..).collect();
    order.par_sort_unstable();
    order.windows(2).filter(|p| p[0].0 == p[1].0).map(|p| p[1].1 as usize).min()
}

fn check_stops(id: Id, stops: &[u32], ranks: u32) -> Result<(), FrameFault> {
    match stops.iter().position(|&s| s >= ranks && s != NEVER) {
        Some(i) => fault(id, i, stops[i].into(), "is not the rank of a splat"),
        None => Ok(()),
    }
}

fn same_length(id: Id, found: usize, expected: u64) -> Result<(), FrameFault> {
    let found = found as u64;
    if found == expected {
        return Ok(());
    }
    Err(FrameFault::Length { column: id.column().name, expected, found })
}

fn fault(id: Id, entry: usize, value: f64, rule: &'static str) -> Result<(), FrameFault> {
    Err(FrameFault::Value { column: id.column().name, entry: entry as u64, value, rule })
}

fn facts(what: &'static str) -> Result<(), FrameFault> {
    Err(FrameFault::Facts { what })
}
