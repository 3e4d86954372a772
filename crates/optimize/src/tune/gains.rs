//! What a model has above its target, spent on the display at once: its colours are scaled by a
//! gain of each channel, which needs no iterations.
//!
//! With gains `1 - s a_c` the mean square error grows by `s² Σ a_c² E[x_c²]`, and the display takes
//! `s Σ a_c x_c ∂P/∂x_c` less, so the direction that buys most is
//! `a_c = (Σ x_c ∂P/∂x_c) / E[x_c²]`. Light goes with the power 2.2 or so of a value, so where the
//! error is a mean square, what buys most in each pixel is nearly in proportion to its value, too:
//! gains buy nearly all that there is to buy. A display term beside the published loss buys less
//! for the same PSNR, because four fifths of that loss are L1, which would rather have a few values
//! far off. Pictures over black scale exactly, so gains are taken back before a model trains on.
//!
//! HVSQ compares means and deviations of pools, which gains scale as well, so it grows by about
//! the same square. A level of the periphery has the coefficients beyond the constant one in
//! common with the others, and scales the constant one alone; the length is found by looking,
//! whatever that shows.

use serde::{Deserialize, Serialize};

use super::super::lambda::AIM;
use super::super::setup::Seen;
use super::{Check, DisplayTerm, State, Trains, Tuner};
use powergs_base::picture::Picture;
use powergs_quality::loss::display_term;
use powergs_scene::Gaussians;
use powergs_scene::convert::SH_C0;

/// Training views that say what gains buy.
const VIEWS: usize = 8;
/// Looks over all gate views at most.
pub(crate) const LOOKS: usize = 8;
/// How near it comes to what is aimed at, as a share of the distance from the target.
const NEAR: f64 = 0.5;
/// The longest shift: what the channel that loses most loses of its light values.
const LONGEST: f64 = 0.9;

/// A gain of each colour channel, from 0 to 1: 1 leaves it as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gains(pub [f32; 3]);

impl Gains {
    /// Scales the colours of all Gaussians, as far as they train: where all coefficients do, their
    /// picture over black is scaled by the same, else it is what each shows from all sides that is.
    pub fn apply(self, scene: &mut Gaussians, trains: Trains) {
        scale(scene, self.0, trains);
    }

    /// Takes them back.
    pub fn undo(self, scene: &mut Gaussians, trains: Trains) {
        scale(scene, self.0.map(f32::recip), trains);
    }
}

/// What was spent on the display.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// By these gains.
    pub gains: Gains,
    /// What all gate views saw of the model with them.
    pub seen: Seen,
    /// How much more above the target the model was when it was chosen than all gate views found
    /// it before it was dimmed, decibels.
    pub luck_db: f64,
}

impl State {
    /// Gives the model to keep the gains that it is to end with, if there are any, and its check
    /// what was seen of it then.
    pub(super) fn dim(&self, scene: &mut Gaussians, check: &mut Check, trains: Trains) {
        if let Some(Spent { gains, seen, .. }) = self.spent {
            gains.apply(scene, trains);
            check.seen = seen;
        }
    }
}

impl Tuner<'_> {
    /// Finds the gains that spend what the model to keep has above the target. `seen` is what all
    /// gate views saw of it, if they just did.
    pub(super) fn spend(&mut self, seen: Option<Seen>) {
        if !matches!(self.config.display, DisplayTerm::Gains { .. }) {
            return;
        }
        if let Some((scene, check)) = self.state.best.take() {
            let seen = seen.unwrap_or_else(|| self.see(&scene));
            self.state.spent = self.found(&scene, seen, &check);
            self.state.best = Some((scene, check));
        }
    }

    /// The length of the shift at which all gate views together are just above the target. It is
    /// one number for all of them and nothing is chosen by it, so that none looks better than it
    /// is.
    fn found(&mut self, scene: &Gaussians, seen: Seen, check: &Check) -> Option<Spent> {
        let target = self.target;
        let before_db = target.margin_db(seen.quality);
        let luck_db = target.margin_db(check.seen.quality) - before_db;
        let aim_db = AIM * self.setup.settings.epsilon_db;
        let is_due = before_db.is_finite() && before_db > aim_db;
        let (direction, growth) = self.direction(scene).filter(|_| is_due)?;
        // The square error in units of that at the target.
        let error = |margin_db: f64| 10f64.powf(-margin_db / 10.0);
        let (before, goal) = (error(before_db), error(aim_db));
        // The first guess is by the square error alone; then by what the target says of it.
        let by_square = |growth: f64| ((goal - before) / growth).sqrt();
        let mut length = by_square(growth / target.square_error()).min(LONGEST);
        let (mut low, mut high) = (0.0, None);
        let mut found = None;
        for _ in 0..LOOKS {
            let mut shifted = scene.clone();
            let gains = Gains(direction.map(|a| (1.0 - length * a) as f32));
            gains.apply(&mut shifted, self.config.trains);
            let seen = self.see(&shifted);
            let margin_db = target.margin_db(seen.quality);
            let is_near = (margin_db - aim_db).abs() < NEAR * aim_db;
            match margin_db >= aim_db {
                true => low = length,
                false => high = Some(length),
            }
            if target.passes(seen.quality) && (is_near || margin_db >= aim_db) {
                found = Some(Spent { gains, seen, luck_db });
            }
            if is_near || low >= LONGEST {
                break;
            }
            let growth = (error(margin_db) - before) / (length * length);
            // Not a number where the quality did not fall: then the length is halved or doubled
            // below.
            let next = by_square(growth);
            length = match high {
                Some(high) if low < next && next < high => next,
                Some(high) => 0.5 * (low + high),
                None if next > low => next.min(2.0 * low).min(LONGEST),
                None => (2.0 * low).min(LONGEST),
            };
        }
        found
    }

    fn see(&mut self, scene: &Gaussians) -> Seen {
        let read = self.reader.of(scene, &self.state.labels);
        self.state.gauge.all(self.setup, read, self.pooled.as_mut())
    }

    /// What each channel loses, relative to the one that loses most, and the growth of the mean
    /// square error with the square of the length; `None` where the display gains nothing.
    fn direction(&mut self, scene: &Gaussians) -> Option<([f64; 3], f64)> {
        let (mut slopes, mut squares) = ([0.0; 3], [0.0; 3]);
        let train = &self.setup.split.train;
        let views = train.len().min(VIEWS);
        let mut by_pixel = Vec::new();
        for i in 0..views {
            let picture: Picture = self.setup.look(scene, train[i * train.len() / views]);
            by_pixel.clear();
            by_pixel.resize(picture.pixels.len(), [0.0; 3]);
            display_term(&picture, 1.0, self.setup.display, &mut by_pixel);
            let values = (3 * picture.pixels.len() * views) as f64;
            for (pixel, slope) in picture.pixels.iter().zip(&by_pixel) {
                for c in 0..3 {
                    let value = f64::from(pixel[c]);
                    slopes[c] += value * f64::from(slope[c]);
                    squares[c] += value * value / values;
                }
            }
        }
        let price = |c: usize| if squares[c] > 0.0 { slopes[c] / squares[c] } else { 0.0 };
        let most = (0..3).map(price).fold(0.0, f64::max);
        let direction: [f64; 3] = std::array::from_fn(|c| (price(c) / most).max(0.0));
        let growth: f64 = (0..3).map(|c| direction[c] * direction[c] * squares[c]).sum();
        (growth > 0.0 && growth.is_finite()).then_some((direction, growth))
    }
}

fn scale(scene: &mut Gaussians, gains: [f32; 3], trains: Trains) {
    let n = (usize::from(scene.sh_degree) + 1).pow(2);
    let scaled = match trains {
        Trains::All | Trains::Colours => n,
        Trains::ColoursAndOpacities => 1,
    };
    for of_channel in scene.sh.chunks_exact_mut(3 * n) {
        for (c, gain) in gains.iter().enumerate() {
            let sh = &mut of_channel[c * n..c * n + scaled];
            sh.iter_mut().for_each(|value| *value *= gain);
            // Colours are 0.5 and what the harmonics add to it.
            sh[0] += (gain - 1.0) * (0.5 / SH_C0) as f32;
        }
    }
}
