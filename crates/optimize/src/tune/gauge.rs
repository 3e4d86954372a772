//! Checks of the quality that look at a few gate views in turn, and at all of them only to confirm.

use serde::{Deserialize, Serialize};

use super::super::setup::{Seen, Setup};
use super::super::target::Quality;
use powergs_scene::Gaussians;

/// Gate views that a check looks at, at least.
const FEWEST: usize = 2;
/// One gate view in so many is looked at by a check.
const SHARE: usize = 5;
/// Checks between two models that are confirmed to be kept.
pub(super) const CONFIRM_EVERY: u32 = 5;
/// A picture that equals its reference counts with this PSNR, so that sums stay finite, decibels.
const PSNR_MOST: f64 = 120.0;

/// What is known of the gate views. What a few of them gained or lost since they were last looked
/// at is counted for the others too, the more the longer ago that was, so views of different
/// difficulty do not mix.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Gauge {
    /// By gate view: PSNR in dB, SSIM, HVSQ (0 where it is not measured), display power in watts.
    views: Vec<[f64; 4]>,
    /// The next view to look at.
    next: usize,
}

impl Gauge {
    /// How often all of so many gate views could be looked at in the time of a check: a turn, and a
    /// confirmation every [`CONFIRM_EVERY`] checks.
    pub(crate) fn looks(gate: usize) -> f64 {
        let turn = turn(gate).min(gate) as f64 / gate.max(1) as f64;
        (turn + 1.0 / f64::from(CONFIRM_EVERY)).min(1.0)
    }

    /// Looks at all gate views: an exact mean.
    pub fn all(&mut self, setup: &Setup<'_>, scene: &Gaussians, pooling: Option<f64>) -> Seen {
        let seen = setup.see_each(scene, setup.gate_views(), pooling);
        self.views = seen.iter().map(values).collect();
        Seen::mean(&seen)
    }

    /// Looks at the views whose turn it is: an estimate of the mean of all. The first time it is
    /// exact.
    pub fn some(&mut self, setup: &Setup<'_>, scene: &Gaussians, pooling: Option<f64>) -> Seen {
        let gate = setup.gate_views();
        let count = turn(gate.len());
        if self.views.len() != gate.len() || count >= gate.len() {
            return self.all(setup, scene, pooling);
        }
        let first = self.next;
        let turn: Vec<usize> = (0..count).map(|i| (first + i) % gate.len()).collect();
        self.next = (first + count) % gate.len();
        let views: Vec<usize> = turn.iter().map(|&i| gate[i]).collect();
        let seen: Vec<_> = setup.see_each(scene, &views, pooling).iter().map(values).collect();
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
        let mean = |k: usize| self.views.iter().map(|v| v[k]).sum::<f64>() / gate.len() as f64;
        let quality = Quality { psnr_db: mean(0), ssim: mean(1), hvsq: pooling.map(|_| mean(2)) };
        Seen { quality, display_w: mean(3) }
    }
}

/// The views of a check, of so many.
fn turn(gate: usize) -> usize {
    FEWEST.max(gate.div_ceil(SHARE))
}

fn values(seen: &Seen) -> [f64; 4] {
    let Quality { psnr_db, ssim, hvsq } = seen.quality;
    [psnr_db.min(PSNR_MOST), ssim, hvsq.unwrap_or(0.0), seen.display_w]
}
