//! Checks of the quality that look at a few gate views in turn. A third of the gate views does not
//! choose: it says a few times how much easier or harder than the others it is, and in the end,
//! when the model to keep is chosen, what that is worth on views that did not choose it.

use serde::{Deserialize, Serialize};

use super::super::pooled::Pooled;
use super::super::setup::{Seen, Setup};
use super::super::target::Quality;
use powergs_scene::Gaussians;

/// Choosing views that a check looks at, at least.
const FEWEST: usize = 2;
/// One choosing view in so many is looked at by a check.
const SHARE: usize = 5;
/// Checks between two at which all choosing views are looked at, so that the model may be kept.
pub(super) const CONFIRM_EVERY: u32 = 5;
/// One gate view in so many does not choose.
const CONFIRMING: usize = 3;
/// Parts of a fine-tune; in each all gate views are looked at once.
const PARTS: u32 = 8;
/// A picture that equals its reference counts with this PSNR, so that sums stay finite, decibels.
const PSNR_MOST: f64 = 120.0;

/// Whether the gate view at a position does not choose, but confirms what was chosen.
pub(crate) fn confirms(position: usize) -> bool {
    position % CONFIRMING == CONFIRMING - 1
}

/// Gate views of so many that do not choose.
pub fn confirming(gate: usize) -> usize {
    gate / CONFIRMING
}

/// What is known of the gate views. What a few of them gained or lost since they were last looked
/// at is counted for the others too, the more the longer ago that was, so views of different
/// difficulty do not mix.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Gauge {
    /// By choosing view: PSNR in dB, SSIM, HVSQ (0 where it is not measured), display power in
    /// watts.
    views: Vec<[f64; 4]>,
    /// The next of them to look at.
    next: usize,
    /// What the mean of all gate views has more than that of those that choose: the first two as
    /// differences, the others as ratios.
    offset: [f64; 4],
    /// The mean quality of those that choose when all were looked at, dB: PSNR, or where it is
    /// measured how small HVSQ is.
    base_db: f64,
    /// The part of the fine-tune in which all gate views were looked at.
    part: u32,
}

impl Gauge {
    /// How often all of so many gate views could be looked at in the time of a check: a turn, and
    /// those that choose every [`CONFIRM_EVERY`] checks.
    pub(crate) fn looks(gate: usize) -> f64 {
        let choosing = gate - confirming(gate);
        let turn = turn(choosing).min(choosing) as f64;
        let all = choosing as f64 / f64::from(CONFIRM_EVERY);
        ((turn + all) / gate.max(1) as f64).min(1.0)
    }

    /// Looks at all gate views: an exact mean, and what those that choose are to be corrected by.
    pub fn all(
        &mut self,
        setup: &Setup<'_>,
        scene: &Gaussians,
        pooled: Option<&mut Pooled>,
    ) -> Seen {
        let is_pooled = pooled.is_some();
        let seen = setup.see_each(scene, setup.gate_views(), pooled);
        let every: Vec<[f64; 4]> = seen.iter().map(values).collect();
        let all = (0..).zip(&every);
        self.views = all.filter(|(i, _)| !confirms(*i)).map(|(_, v)| *v).collect();
        let (here, there) = (mean(&self.views), mean(&every));
        self.base_db = quality_db(here, is_pooled);
        let ratio = |k: usize| if here[k] > 0.0 { there[k] / here[k] } else { 1.0 };
        self.offset = [there[0] - here[0], there[1] - here[1], ratio(2), ratio(3)];
        Seen::mean(&seen)
    }

    /// How far the quality of the views that choose has gone since all were looked at, dB: so far
    /// may the others have gone, too, or not.
    pub(super) fn drift_db(&self, is_pooled: bool) -> f64 {
        (quality_db(mean(&self.views), is_pooled) - self.base_db).abs()
    }

    /// Looks at all gate views once in every part of a fine-tune, whatever they show: the first
    /// time that `iteration` of `iterations` lies in it.
    pub(super) fn correct(
        &mut self,
        setup: &Setup<'_>,
        scene: &Gaussians,
        pooled: Option<&mut Pooled>,
        (iteration, iterations): (u32, u32),
    ) {
        let part = u64::from(iteration) * u64::from(PARTS) / u64::from(iterations.max(1));
        if confirming(setup.gate_views().len()) > 0 && part > u64::from(self.part) {
            self.part = part as u32;
            self.all(setup, scene, pooled);
        }
    }

    /// Looks at all views that choose: an estimate of the mean of all. The first time it is exact.
    pub fn chosen(
        &mut self,
        setup: &Setup<'_>,
        scene: &Gaussians,
        pooled: Option<&mut Pooled>,
    ) -> Seen {
        if self.views.is_empty() {
            return self.all(setup, scene, pooled);
        }
        let is_pooled = pooled.is_some();
        let views = choosing(setup.gate_views());
        self.views = setup.see_each(scene, &views, pooled).iter().map(values).collect();
        self.estimate(is_pooled)
    }

    /// Looks at the views whose turn it is: an estimate of the mean of all. The first time it is
    /// exact.
    pub fn some(
        &mut self,
        setup: &Setup<'_>,
        scene: &Gaussians,
        pooled: Option<&mut Pooled>,
    ) -> Seen {
        let gate = choosing(setup.gate_views());
        let count = turn(gate.len());
        if self.views.len() != gate.len() || count >= gate.len() {
            return self.chosen(setup, scene, pooled);
        }
        let is_pooled = pooled.is_some();
        let first = self.next;
        let turn: Vec<usize> = (0..count).map(|i| (first + i) % gate.len()).collect();
        self.next = (first + count) % gate.len();
        let views: Vec<usize> = turn.iter().map(|&i| gate[i]).collect();
        let seen: Vec<_> = setup.see_each(scene, &views, pooled).iter().map(values).collect();
        let mut change = [0.0; 4];
        for (&i, now) in turn.iter().zip(&seen) {
            for k in 0..4 {
                change[k] += (now[k] - self.views[i][k]) / count as f64;
            }
        }
        // The last to be looked at again are those that were looked at last.
        for offset in count..gate.len() {
            let age = (gate.len() - offset) as f64 / (gate.len() - count) as f64;
            let view = &mut self.views[(first + offset) % gate.len()];
            view.iter_mut().zip(change).for_each(|(value, change)| *value += age * change);
        }
        for (&i, now) in turn.iter().zip(&seen) {
            self.views[i] = *now;
        }
        self.estimate(is_pooled)
    }

    /// The mean over all gate views, as those that choose and what is known of the others say.
    fn estimate(&self, is_pooled: bool) -> Seen {
        let ([psnr_db, ssim, hvsq, display_w], by) = (mean(&self.views), self.offset);
        let quality = Quality {
            psnr_db: psnr_db + by[0],
            ssim: ssim + by[1],
            hvsq: is_pooled.then_some(hvsq * by[2]),
        };
        Seen { quality, display_w: display_w * by[3] }
    }
}

/// The gate views that choose.
fn choosing(gate: &[usize]) -> Vec<usize> {
    (0..).zip(gate).filter(|(i, _)| !confirms(*i)).map(|(_, view)| *view).collect()
}

/// The views of a check, of so many that choose.
fn turn(choosing: usize) -> usize {
    FEWEST.max(choosing.div_ceil(SHARE))
}

/// PSNR, or where it is measured how small HVSQ is, in the decibels in which a target is missed.
fn quality_db(values: [f64; 4], is_pooled: bool) -> f64 {
    match is_pooled {
        false => values[0],
        true => -10.0 * values[2].max(f64::MIN_POSITIVE).log10(),
    }
}

fn mean(views: &[[f64; 4]]) -> [f64; 4] {
    let mean = |k: usize| views.iter().map(|v| v[k]).sum::<f64>() / views.len().max(1) as f64;
    std::array::from_fn(mean)
}

fn values(seen: &Seen) -> [f64; 4] {
    let Quality { psnr_db, ssim, hvsq } = seen.quality;
    [psnr_db.min(PSNR_MOST), ssim, hvsq.unwrap_or(0.0), seen.display_w]
}
