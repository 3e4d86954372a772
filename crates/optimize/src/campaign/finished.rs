//! What a campaign ends with: the final model, everything that was found, and pictures.

use powergs_core::run::RunError;
use powergs_scene::{Foveated, Gaussians};

use super::{CampaignError, Run};
use crate::conclusion::Conclusion;
use crate::foveated::{FovealError, Levels, MeasuredFoveated, Method, Viewer, cheapest, lines};
use crate::history::HistoryRow;
use crate::job::Place;
use crate::outcome::{Outcome, at};
use crate::pictures::{Album, BeforeAfter};
use crate::ratio_study::{RatioRow, ratios};
use crate::results::{ChangeRecord, LostRecord, Results};
use crate::setup::Setup;

/// What a campaign ends with.
#[derive(Debug)]
pub struct Finished {
    /// What became of each job, in order.
    pub outcomes: Vec<Outcome>,
    /// Every iteration of every job.
    pub history: Vec<HistoryRow>,
    /// What the samples of level 1 of the first variant say.
    pub conclusion: Conclusion,
    /// The job that made the result: the model with the fewest watts that reached the target, ours
    /// or a comparison; `None` if none did.
    pub result: Option<String>,
    /// Its model.
    pub model: Option<Gaussians>,
    /// The models of further qualities that were reached, under their names.
    pub others: Vec<(String, Gaussians)>,
    /// The first test view, before and after.
    pub pictures: Option<BeforeAfter>,
    /// Savings over display-to-render ratios; empty if they were not asked for.
    pub ratios: Vec<RatioRow>,
    /// The foveated models.
    pub foveated: Option<FoveatedModels>,
    /// Everything that the run found, for files and programs.
    pub results: Results,
}

impl Finished {
    /// The outcomes of level 1 of the first variant: what there is without foveation.
    pub fn first(&self) -> Vec<Outcome> {
        at(&self.outcomes, Place::default())
    }
}

/// The foveated models of a campaign.
#[derive(Debug)]
pub struct FoveatedModels {
    /// All methods of all variants, measured.
    pub measured: Vec<MeasuredFoveated>,
    /// Speed of the dense model on the machine, frames a second.
    pub dense_fps: f64,
    /// The method that takes the fewest watts for the first variant, ours or a comparison whose
    /// levels all reach their targets, and its model; `None` if there is none of ours. The colour
    /// filter is no model.
    pub result: Option<(Method, Foveated)>,
    /// A view as its models show it.
    pub album: Option<Album>,
}

impl Run<'_> {
    /// Composes and measures what was made. `stopped`: why the run ended before its jobs were done.
    pub(super) fn finished(self, stopped: Option<&str>) -> Result<Finished, CampaignError> {
        let campaign = self.campaign;
        let setup = campaign.setup();
        let outcomes = &self.progress.outcomes;
        let conclusion = campaign.plan.conclusion(outcomes, Place::default());
        let result = campaign.plan.result(outcomes, 0).map(|o| o.name.clone());
        let load = |name: &Option<String>| match name {
            Some(name) => Ok(Some(self.checkpoints.load_model(name)?.scene)),
            None => Ok::<_, RunError>(None),
        };
        let model = load(&result)?;
        let others = self.others()?;
        let shown = |scene: &Gaussians, name: &str| {
            BeforeAfter::of(&setup, scene, format!("result ({name})"))
        };
        let pictures =
            model.as_ref().zip(result.as_deref()).map(|(scene, name)| shown(scene, name));
        let foveated = if model.is_some() { self.foveated(&setup)? } else { None };
        // What the method does to colours is seen on its own model.
        let own = match conclusion.best == result {
            true => pictures.clone(),
            false => load(&conclusion.best)?
                .zip(conclusion.best.as_deref())
                .map(|(scene, name)| shown(&scene, name)),
        };
        let mean_change = own.map(|pictures| ChangeRecord {
            level_1: pictures.mean_change(),
            dense: Some(pictures.mean_dense()),
            view: pictures.view,
            regions: foveated.as_ref().and_then(|f| f.album.as_ref()).map(|a| a.change),
        });
        let done = (&outcomes[..], &self.progress.history[..]);
        let is_own = campaign.references.is_own();
        let lost = model.as_ref().map(|scene| LostRecord::of(&setup, scene, is_own));
        let of_result = (mean_change, lost.unwrap_or_default());
        let results = Results::of(campaign, done, stopped, foveated.as_ref(), of_result);
        let first = at(outcomes, Place::default());
        let ratios = if campaign.ratio_study { ratios(&first) } else { Vec::new() };
        let (outcomes, history) = (self.progress.outcomes, self.progress.history);
        Ok(Finished {
            outcomes,
            history,
            conclusion,
            result,
            model,
            others,
            pictures,
            ratios,
            foveated,
            results,
        })
    }

    /// The models of the qualities after the first.
    fn others(&self) -> Result<Vec<(String, Gaussians)>, CampaignError> {
        let plan = &self.campaign.plan;
        let mut others = Vec::new();
        for (variant, quality) in (0..).zip(&plan.variants).skip(1) {
            if let Some(result) = plan.result(&self.progress.outcomes, variant) {
                let scene = self.checkpoints.load_model(&result.name)?.scene;
                others.push((quality.name.clone(), scene));
            }
        }
        Ok(others)
    }

    fn foveated(&self, setup: &Setup<'_>) -> Result<Option<FoveatedModels>, CampaignError> {
        let campaign = self.campaign;
        let Some(foveation) = &campaign.foveation else { return Ok(None) };
        let viewer = Viewer {
            setup,
            screens: foveation.screens,
            clock: &foveation.clock,
            cost: foveation.filter,
        };
        let mut measured = Vec::new();
        let (mut ours, mut pruned, mut dimmed) = (None, None, None);
        let dense_fps = viewer.plain_fps(&campaign.dense)?;
        for levels in lines(&campaign.plan, &self.progress.outcomes) {
            let model = self.compose(&levels)?;
            let (method, is_first) = (levels.method, levels.variant == 0);
            measured.push(viewer.measure(levels, &model)?);
            match method {
                Method::PowerGs if is_first => ours = Some(model),
                Method::FrRender if is_first => pruned = Some(model),
                Method::FrDisplay if is_first => dimmed = Some(model),
                Method::PowerGs | Method::FrRender | Method::FrDisplay | Method::RtgsD22 => {}
            }
        }
        let album = |ours: &Foveated| {
            Album::of(&viewer, ours, pruned.as_ref(), campaign.references.is_own())
        };
        let album = ours.as_ref().map(album).transpose().map_err(FovealError::from)?;
        // The colour filter changes what is shown, and has no model of its own.
        let model = match cheapest(&measured, 0) {
            Some(Method::PowerGs) => ours,
            Some(Method::FrRender) => pruned,
            Some(Method::FrDisplay) => dimmed,
            Some(Method::RtgsD22) | None => None,
        };
        let result = cheapest(&measured, 0).zip(model);
        Ok(Some(FoveatedModels { measured, dense_fps, result, album }))
    }

    /// The four levels as one model.
    fn compose(&self, levels: &Levels) -> Result<Foveated, CampaignError> {
        let load = |job: &String| Ok(self.checkpoints.load_model(job)?.scene);
        let models = levels.jobs.iter().map(load).collect::<Result<Vec<Gaussians>, RunError>>()?;
        let four = models.try_into();
        let models: [Gaussians; Foveated::LEVELS] =
            four.map_err(|_| RunError::Internal("a foveated model without four levels".into()))?;
        let model = Foveated::compose(&models);
        Ok(model.map_err(|e| RunError::Internal(format!("the levels of a run: {e}")))?)
    }
}
