//! The models of a finished run on another machine, panel, display rate or in another size. Nothing
//! is trained: they are measured anew, and the search goes on from there. In the same size samples
//! reach the target, whatever power is; in another one their quality is measured there, too.

use serde::{Deserialize, Serialize};

use powergs_base::TOOL_VERSION;
use powergs_core::run::{RunError, Store};
use powergs_core::sim::MODEL_VERSION;
use powergs_scene::Gaussians;

use super::{Campaign, CampaignError, Run};
use crate::checkpoint::{Checkpoints, Progress};
use crate::job::Place;
use crate::outcome::Outcome;
use crate::role::{FORMER_OPTIMUM, Role};
use crate::setup::Setup;
use crate::watch::CampaignWatch;

/// What a run says of itself, for those who use its models.
const MARK: &str = "checkpoints/run.json";
/// The file.
const FORMAT: &str = "powergs-sim-run";
/// Models that are named in a note.
const NAMED: usize = 5;

/// A run whose models can be priced here.
struct RepriceSource {
    fingerprint: u128,
    /// Whether its models were judged in the views that judge here.
    is_judged_alike: bool,
}

/// What a run says of itself.
#[derive(Debug, Serialize, Deserialize)]
struct RepriceMark {
    format: String,
    tool_version: String,
    model_version: u32,
    /// A hash of everything that the models depend on, but for what power is and the size in which
    /// quality is measured.
    inputs: String,
    /// The same with that size; empty in runs of before.
    #[serde(default)]
    judged: String,
    /// A hash of everything that the numbers depend on.
    fingerprint: String,
}

impl Campaign {
    /// What stands in the store of a run beside its checkpoints.
    pub(super) fn mark(&self, store: &dyn Store) -> Result<(), RunError> {
        let mark = RepriceMark {
            format: FORMAT.into(),
            tool_version: TOOL_VERSION.into(),
            model_version: MODEL_VERSION,
            inputs: format!("{:032x}", self.sources()),
            judged: format!("{:032x}", self.inputs()),
            fingerprint: format!("{:032x}", self.fingerprint()),
        };
        let text = serde_json::to_string_pretty(&mark).expect("text and a number");
        store.write(MARK, (text + "\n").as_bytes())
    }

    /// Reads all that [`Campaign::reprice`] will read of `from`, so that what cannot be priced is
    /// refused before anything is made or replaced.
    ///
    /// # Errors
    /// Those of [`Campaign::reprice`] that `from` is to blame for.
    pub fn can_reprice(&self, from: &dyn Store) -> Result<(), CampaignError> {
        let other = Checkpoints::new(from, self.source_in(from)?.fingerprint);
        let finished = other.load()?.ok_or_else(|| no_run(from))?.outcomes;
        for outcome in finished.iter().filter(|outcome| outcome.role != Role::Dense) {
            if other.has_model(&outcome.name)? {
                other.load_model(&outcome.name)?;
            }
        }
        Ok(())
    }

    /// Whether a store says of its run what those who use its models ask for.
    pub(super) fn is_marked(&self, store: &dyn Store) -> Result<bool, RunError> {
        Ok(store.open(MARK)?.is_some())
    }

    /// Begins a run in `to` with the models of a finished one in `from`, which differs in what
    /// power is at most: machine, panel, display rate, size. They are measured as this campaign
    /// measures, their quality where that is in another size than before. Models that were not kept
    /// are left out of the plan. Where `to` has that run already, it goes on. [`Run::priced`]
    /// reports them. Where `makes` says so, [`Run::work`] makes what the search wants next: a few
    /// samples around the new minimum, the optimum there, and the levels of the periphery, which
    /// are parts of the model of level 1. Without, levels stay where theirs is still the one that
    /// takes least. `None`: cancelled.
    ///
    /// # Errors
    /// [`RunError::Input`]: no run in `from`, one of another version or of other inputs, a damaged
    /// one; another run in `to`; everything that measuring models fails with.
    pub fn reprice<'a>(
        &'a mut self,
        from: &dyn Store,
        to: &'a dyn Store,
        makes: bool,
        watch: &dyn CampaignWatch,
    ) -> Result<Option<Run<'a>>, CampaignError> {
        let source = self.source_in(from)?;
        let other = Checkpoints::new(from, source.fingerprint);
        let finished = other.load()?.ok_or_else(|| no_run(from))?.outcomes;
        let mut kept = Vec::new();
        for outcome in &finished {
            kept.push(self.brought(outcome.role).is_some() || other.has_model(&outcome.name)?);
        }
        let lost: Vec<&str> = finished
            .iter()
            .zip(&kept)
            .filter(|(_, kept)| !**kept)
            .map(|(o, _)| o.name.as_str())
            .collect();
        if !lost.is_empty() {
            let more = if lost.len() > NAMED { ", …" } else { "" };
            let names = lost[..lost.len().min(NAMED)].join(", ");
            watch.note(&format!("without a kept model, and left out: {names}{more}"));
        }
        self.plan.baselines.retain(|b| {
            finished.iter().zip(&kept).any(|(o, kept)| *kept && o.role == Role::Baseline(*b))
        });
        // The samples are those that there are, and a few more around the new minimum if models are
        // made; targets are shares of what was reached then.
        let is_sample =
            |o: &Outcome| matches!(o.role, Role::Sample | Role::Optimum) && o.place.level == 0;
        let samples = finished.iter().zip(&kept).filter(|(o, kept)| **kept && is_sample(o));
        let mut given = vec![0; self.plan.variants.len()];
        samples.for_each(|(o, _)| given[usize::from(o.place.variant)] += 1);
        self.plan.given = Some(given);
        let held_out = finished.iter().zip(&kept).find(|(o, _)| o.role == Role::HeldOut);
        if let Some((outcome, false)) = held_out {
            self.plan.reference = Some((outcome.gate.quality, outcome.test.quality));
            self.plan.holds_out = false;
        }
        self.plan.sweep_weights.clear();
        let run = match Checkpoints::new(to, self.fingerprint()).load()? {
            // Outcomes are written once all models are: where one is, the models are whole.
            Some(progress) if !progress.outcomes.is_empty() => return Ok(Some(self.resume(to)?)),
            Some(_) => self.resume(to)?,
            None => self.begin(to)?,
        };
        let setup = self.setup();
        let stays = |o: &Outcome| !(makes && is_our_level(o));
        let (mut before, mut outcomes): (Vec<&Outcome>, Vec<Outcome>) = (Vec::new(), Vec::new());
        watch.planned(0);
        for (outcome, _) in finished.iter().zip(kept).filter(|(o, kept)| *kept && stays(o)) {
            if watch.is_cancelled() {
                return Ok(None);
            }
            let stored = match self.brought(outcome.role) {
                Some(_) => None,
                None => Some(other.load_model(&outcome.name)?.scene),
            };
            let scene = stored.as_ref().or(self.brought(outcome.role)).unwrap_or(&self.dense);
            let dense = finished.first().zip(outcomes.first());
            let mut priced = priced(&setup, outcome, dense, scene)?;
            if !source.is_judged_alike {
                let (role, place) = (priced.role, priced.place);
                let judge = |quality| self.plan.judge(&outcomes, role, place, quality);
                priced = priced.judged_anew(&setup, scene, judge);
            }
            outcomes.push(renamed(priced));
            before.push(outcome);
        }
        let gone = if makes { Vec::new() } else { self.stale(&finished, &before, &outcomes) };
        if !gone.is_empty() {
            watch.note(
                "another model takes least at level 1: the levels of the periphery are of the one \
                 before, and left out; --realise makes new ones",
            );
        }
        if !source.is_judged_alike {
            watch.note(&self.judged_note(&before, &outcomes));
        }
        let mut progress = Progress::default();
        for (place, (outcome, old)) in outcomes.into_iter().zip(before).enumerate() {
            if gone.contains(&place) {
                continue;
            }
            if self.brought(outcome.role).is_none() {
                let scene = other.load_model(&old.name)?.scene;
                run.checkpoints.save_scene(&outcome.name, &scene)?;
            }
            watch.outcome(&outcome);
            progress.outcomes.push(outcome);
        }
        run.checkpoints.save(&progress.outcomes, &progress.history, None)?;
        Ok(Some(Run { progress, ..run }))
    }

    /// The model of a role that the user brought: no run keeps it.
    fn brought(&self, role: Role) -> Option<&Gaussians> {
        match role {
            Role::Dense => Some(&self.dense),
            Role::External(position) => self.externals.get(position).map(|(_, scene)| scene),
            Role::HeldOut | Role::Sample | Role::Optimum | Role::Baseline(_) | Role::Sweep(_) => {
                None
            }
        }
    }

    /// What another size makes of models that had reached their targets.
    fn judged_note(&self, before: &[&Outcome], now: &[Outcome]) -> String {
        let is_made = |o: &Outcome| !matches!(o.role, Role::Dense | Role::HeldOut);
        let passed = || before.iter().zip(now).filter(|(was, _)| was.passed && is_made(was));
        let (all, missed) = (passed().count(), passed().filter(|(_, is)| !is.passed).count());
        let [width, height] = self.judged.judged;
        format!(
            "quality was measured anew at {width}x{height}: of {all} models that had reached \
             their target, {missed} miss it there"
        )
    }

    /// The places of our levels that are parts of a model which does not stand for the level before
    /// any more. `finished`: everything that there was; `before` and `now`: what is still there,
    /// as it was and as it is priced.
    fn stale(&self, finished: &[Outcome], before: &[&Outcome], now: &[Outcome]) -> Vec<usize> {
        let mut stale = Vec::new();
        for variant in 0..self.plan.variants.len() as u8 {
            let stands = |done: &[Outcome], level| {
                self.plan.model_at(done, None, Place { variant, level }).map(|o| o.name.clone())
            };
            let moved = (0..self.plan.levels.saturating_sub(1)).find(|level| {
                let new = stands(now, *level);
                let was = now.iter().position(|o| Some(&o.name) == new.as_ref());
                was.map(|place| before[place].name.clone()) != stands(finished, *level)
            });
            let Some(moved) = moved else { continue };
            let is_above = |o: &Outcome| {
                is_our_level(o) && o.place.variant == variant && o.place.level > moved
            };
            stale.extend((0..now.len()).filter(|i| is_above(&now[*i])));
        }
        stale
    }

    /// What is to know of the run in a store, which has the inputs of this campaign.
    fn source_in(&self, from: &dyn Store) -> Result<RepriceSource, RunError> {
        let text = from.read_text(MARK)?.ok_or_else(|| no_run(from))?;
        let wrong = |message: String| RunError::Input { place: from.place(""), message };
        let damaged = || {
            let what = format!("{MARK} is no record of a run; is it damaged?");
            wrong(what)
        };
        let mark: RepriceMark = serde_json::from_str(&text).map_err(|_| damaged())?;
        if mark.format != FORMAT {
            return Err(damaged());
        }
        if (mark.tool_version.as_str(), mark.model_version) != (TOOL_VERSION, MODEL_VERSION) {
            return Err(wrong(format!(
                "the run was made by version {} (model version {}), this is {TOOL_VERSION} \
                 ({MODEL_VERSION}): its numbers follow other rules; run it anew with this program, \
                 or price it with that one",
                mark.tool_version, mark.model_version
            )));
        }
        if mark.inputs != format!("{:032x}", self.sources()) {
            return Err(wrong(
                "the run had other inputs: its model, views, photos, target or settings have \
                 changed since; give the same, and change what power is only"
                    .into(),
            ));
        }
        let fingerprint = u128::from_str_radix(&mark.fingerprint, 16).map_err(|_| damaged())?;
        let is_judged_alike = mark.judged == format!("{:032x}", self.inputs());
        Ok(RepriceSource { fingerprint, is_judged_alike })
    }
}

fn no_run(from: &dyn Store) -> RunError {
    RunError::Input {
        place: from.place(""),
        message: "holds no finished run of this version; give the folder of one".into(),
    }
}

/// Whether a model was made for the periphery, and not for a comparison.
fn is_our_level(outcome: &Outcome) -> bool {
    outcome.place.level > 0 && matches!(outcome.role, Role::Sample | Role::Optimum)
}

/// The outcome of a model as it is measured now. `dense`: the dense model before and now. λ belongs
/// to the power that it weighs.
fn priced(
    setup: &Setup<'_>,
    before: &Outcome,
    dense: Option<(&Outcome, &Outcome)>,
    scene: &Gaussians,
) -> Result<Outcome, CampaignError> {
    let what = || format!("model {}", before.name);
    let sim = |error| CampaignError::Sim { what: what(), error };
    let shown = |views: &[usize]| setup.see(scene, views, None).display_w;
    let mut priced = before.clone();
    priced.gate.display_w = shown(setup.gate_views());
    priced.test.display_w = shown(&setup.split.test);
    priced.watts = setup.watts(scene).map_err(sim)?;
    if let Some((old, new)) = dense
        && new.gate.display_w > 0.0
    {
        let factor = old.gate.display_w / new.gate.display_w;
        priced.lambda = before.lambda.map(|lambda| lambda * factor);
        priced.passing_lambda = before.passing_lambda.map(|lambda| lambda * factor);
    }
    Ok(priced)
}

/// The optimum of before is a sample now, because the minimum is elsewhere, and says what it was.
fn renamed(outcome: Outcome) -> Outcome {
    if outcome.role != Role::Optimum {
        return outcome;
    }
    let name = outcome.name.replace(&Role::Optimum.name(), FORMER_OPTIMUM);
    Outcome { name, role: Role::Sample, ..outcome }
}
