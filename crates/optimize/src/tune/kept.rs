//! Which model of a fine-tune is kept, what views that did not choose it say of it, and going back
//! to it.

use super::super::lambda::AIM;
use super::super::setup::Seen;
use super::super::target::Quality;
use super::gauge::{self, CONFIRM_EVERY};
use super::{Check, DisplayTerm, Keep, Model, Objective, Pruning, TuneError, Tuner};
use powergs_scene::Gaussians;

/// What views that do not choose may miss of a change of those that do, as a share of it: a fifth
/// was seen where λ had just moved the quality by a decibel.
const DRIFT: f64 = 0.2;
/// A larger change, in decibels, counts as this one: far above the target it says nothing.
const DRIFT_MOST_DB: f64 = 1.0;
/// How far above the target the model is that takes the place of one which these views refuse, in
/// units of epsilon.
const SPARE: f64 = 2.0;
/// While it prunes whenever it passes, a model that passes by less than this is looked at over all
/// views that choose before more of it goes, decibels.
const NEAR_DB: f64 = 0.3;
/// The same in HVSQ, of which a prune takes one to two decibels: what is undone goes back to a
/// model that was looked at.
const NEAR_HVSQ_DB: f64 = 2.0;

impl Tuner<'_> {
    /// Whether the target is reached with so much to spare that views which did not choose may
    /// differ a little: by half of what λ is steered for, and by a part of what those that choose
    /// have gone since all were looked at.
    pub(super) fn is_sure(&self, seen: &Seen) -> bool {
        let guard = match gauge::confirming(self.setup.gate_views().len()) {
            0 => 0.0,
            _ => {
                let aim = AIM * self.setup.settings.epsilon_db;
                0.5 * aim
                    + DRIFT * self.state.gauge.drift_db(self.pooled.is_some()).min(DRIFT_MOST_DB)
            }
        };
        self.target.passes(seen.quality) && self.target.margin_db(seen.quality) >= guard
    }

    /// Whether all views that choose are to be looked at: the model of an estimated quality may be
    /// kept.
    pub(super) fn wants_confirmation(&self, quality: Quality, lambda: f64) -> bool {
        let may_pass = self.target.passes(quality) && self.is_pruned();
        let has_sure = self.state.best.as_ref().is_some_and(|(_, check)| check.sure);
        let is_due = !has_sure || self.state.unconfirmed >= CONFIRM_EVERY;
        // More goes wherever it passes: near the target that must not rest on an estimate.
        let prunes = matches!(self.config.pruning, Pruning::WhilePassing { .. }) && lambda == 0.0;
        let near_db = match self.config.objective {
            Objective::Likeness => NEAR_DB,
            Objective::Hvsq { .. } => NEAR_HVSQ_DB,
        };
        let is_near = prunes && self.target.margin_db(quality) < near_db;
        may_pass && self.config.keep != Keep::Last && (is_due || is_near)
    }

    pub(super) fn remember(&mut self, check: Check) {
        // Of each the old model is dropped first, so that never two of a kind are in memory.
        if self.is_better(&check, self.state.best.as_ref()) {
            self.state.best = None;
            self.state.best = Some(self.kept(check));
        }
        let may_fail = gauge::confirming(self.setup.gate_views().len()) > 0;
        let spare_db = SPARE * self.setup.settings.epsilon_db;
        let is_spare =
            may_fail && check.sure && self.target.margin_db(check.seen.quality) >= spare_db;
        if is_spare && self.is_better(&check, self.state.spare.as_ref()) {
            self.state.spare = None;
            self.state.spare = Some(self.kept(check));
        }
    }

    /// What is shown now, as it is read, with its check.
    fn kept(&mut self, check: Check) -> (Gaussians, Check) {
        (self.reader.of(self.state.shown(), &self.state.labels).clone(), check)
    }

    /// Whether what is shown now is to be kept in the place of another.
    fn is_better(&self, check: &Check, best: Option<&(Gaussians, Check)>) -> bool {
        match (self.config.keep, best) {
            (Keep::Last, _) => false,
            (Keep::LastPassing | Keep::Dimmest, None) => true,
            (Keep::LastPassing | Keep::Dimmest, Some((_, best))) if best.sure != check.sure => {
                check.sure
            }
            (Keep::LastPassing, Some(_)) => true,
            (Keep::Dimmest, Some((scene, best))) => {
                // What is to be spent on the display is worth more than what the display takes.
                let price = |check: &Check| match self.config.display {
                    DisplayTerm::Gains { .. } => -self.target.margin_db(check.seen.quality),
                    DisplayTerm::Off | DisplayTerm::Fixed(_) | DisplayTerm::Controlled { .. } => {
                        check.seen.display_w
                    }
                };
                let size = |scene: &Gaussians, check: &Check| (scene.len(), price(check));
                let (now, best) = (size(self.state.shown(), check), size(scene, best));
                now.0 < best.0 || now.0 == best.0 && now.1 < best.1
            }
        }
    }

    /// Looks at the model to keep with all gate views, those that did not choose it among them.
    /// Where it misses the target the fine-tune goes on for a while, by what was found, with less
    /// display term and without pruning. If that was to no avail, an earlier model is kept that had
    /// more to spare, or if there is none, the one that was refused.
    /// Gives what they saw of it, if it is kept as they saw it.
    pub(super) fn confirm(&mut self) -> Result<Option<Seen>, TuneError> {
        let has_others = gauge::confirming(self.setup.gate_views().len()) > 0;
        if self.config.keep == Keep::Last || !has_others {
            return Ok(None);
        }
        let Some((scene, check)) = self.state.best.take() else {
            self.state.best = self.state.spare.take();
            return Ok(None);
        };
        let seen = self.state.gauge.all(self.setup, &scene, self.pooled.as_mut());
        if self.target.passes(seen.quality) {
            self.state.best = Some((scene, check));
            return Ok(Some(seen));
        }
        // Extended once only, so that it ends.
        if self.state.extended.is_some() {
            let spare = self.state.spare.take().filter(|(_, check)| check.sure);
            self.state.best = spare.or(Some((scene, Check { sure: false, ..check })));
            return Ok(None);
        }
        self.state.extended = Some(self.state.iteration);
        self.state.settled = false;
        if let Some(controller) = &mut self.controller {
            controller.retreat(-self.target.margin_db(seen.quality));
        }
        // What was pruned since is too much.
        if scene.len() != self.state.model.scene.len() {
            self.go_back_to(&scene)?;
        }
        if self.state.spare.is_none() {
            self.state.spare = Some((scene, Check { sure: false, ..check }));
        }
        Ok(None)
    }

    /// While it prunes whenever it passes: a prune that it does not recover from is undone, and the
    /// next one is smaller.
    pub(super) fn give_up_if_due(&mut self, lambda: f64) -> Result<(), TuneError> {
        let Pruning::WhilePassing { share, .. } = self.config.pruning else { return Ok(()) };
        let is_pruning = share < 1.0 && lambda == 0.0 && self.may_prune(self.state.iteration);
        if is_pruning && !self.is_done() && self.state.stride.gives_up() {
            return self.undo();
        }
        Ok(())
    }

    /// Whether more may be pruned at a check after this iteration, if the target is reached.
    pub(super) fn may_prune(&self, iteration: u32) -> bool {
        let is_over = match self.config.display {
            DisplayTerm::Controlled { from, .. } | DisplayTerm::Gains { from } => iteration >= from,
            DisplayTerm::Fixed(_) => true,
            DisplayTerm::Off => false,
        };
        !is_over && self.state.extended.is_none()
    }

    /// Goes back to the model that was kept, if more was pruned since.
    fn undo(&mut self) -> Result<(), TuneError> {
        match &self.state.best {
            Some((scene, check)) if scene.len() != self.state.model.scene.len() => {
                let (scene, margin_db) = (scene.clone(), self.target.margin_db(check.seen.quality));
                if let Some(heat) = &mut self.state.heat {
                    heat.recovered(margin_db, self.config.pace);
                }
                self.go_back_to(&scene)
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Trains on from parameters that were kept, without moments or a mean.
    fn go_back_to(&mut self, scene: &Gaussians) -> Result<(), TuneError> {
        self.state.model = Model::fresh(scene);
        self.state.average = None;
        self.reader.label(scene, &mut self.state.labels);
        self.warm_up(self.state.iteration, 0.0)
    }
}
