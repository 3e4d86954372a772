//! What a campaign ends with: the final model, everything that was found, and pictures.

use powergs_core::run::RunError;
use powergs_scene::{Foveated, Gaussians};

use super::{CampaignError, Run};
use crate::conclusion::Conclusion;
use crate::foveated::{Foveal, FovealError, Levels, Method, Viewer, lines};
use crate::history::HistoryRow;
use crate::job::Place;
use crate::outcome::{Outcome, at};
use crate::pictures::{Album, BeforeAfter};
use crate::ratio_study::{RatioRow, ratios};
use crate::results::{ChangeRecord, Results};
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
    /// The model with the fewest watts that reached the target; `None` if none did.
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
    pub measured: Vec<Foveal>,
    /// Speed of the dense model on the machine, frames a second.
    pub dense_fps: f64,
    /// Our model of the first variant.
    pub model: Option<Foveated>,
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
        let model = match &conclusion.best {
            Some(best) => Some(self.checkpoints.load_model(best)?.scene),
            None => None,
        };
        let others = self.others()?;
        let best = model.as_ref().zip(conclusion.best.as_deref());
        let pictures =
            best.map(|(scene, best)| BeforeAfter::of(&setup, scene, format!("result ({best})")));
        let foveated = if model.is_some() { self.foveated(&setup)? } else { None };
        let mean_change = pictures.as_ref().map(|pictures| ChangeRecord {
            view: pictures.view.clone(),
            level_1: pictures.mean_change(),
            dense: Some(pictures.mean_dense()),
            regions: foveated.as_ref().and_then(|f| f.album.as_ref()).map(|a| a.change),
        });
        let results = Results::of(campaign, outcomes, stopped, foveated.as_ref(), mean_change);
        let first = at(outcomes, Place::default());
        let ratios = if campaign.ratio_study { ratios(&first) } else { Vec::new() };
        let (outcomes, history) = (self.progress.outcomes, self.progress.history);
        Ok(Finished {
            outcomes,
            history,
            conclusion,
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
            let place = Place { variant, level: 0 };
            if let Some(best) = plan.conclusion(&self.progress.outcomes, place).best {
                others.push((quality.name.clone(), self.checkpoints.load_model(&best)?.scene));
            }
        }
        Ok(others)
    }

    fn foveated(&self, setup: &Setup<'_>) -> Result<Option<FoveatedModels>, CampaignError> {
        let campaign = self.campaign;
        let Some(foveation) = &campaign.foveation else { return Ok(None) };
        let viewer = Viewer {
            setup,
            screen: foveation.screen,
            clock: &foveation.clock,
            cost: foveation.filter,
        };
        let (mut measured, mut ours, mut pruned) = (Vec::new(), None, None);
        let dense_fps = viewer.plain_fps(&campaign.dense)?;
        for levels in lines(&campaign.plan, &self.progress.outcomes) {
            let model = self.compose(&levels)?;
            let (method, is_first) = (levels.method, levels.variant == 0);
            measured.push(viewer.measure(levels, &model)?);
            match method {
                Method::PowerGs if is_first => ours = Some(model),
                Method::FrRender if is_first => pruned = Some(model),
                Method::PowerGs | Method::FrRender | Method::FrDisplay | Method::RtgsD22 => {}
            }
        }
        let album = |ours: &Foveated| {
            Album::of(&viewer, ours, pruned.as_ref(), campaign.references.is_own())
        };
        let album = ours.as_ref().map(album).transpose().map_err(FovealError::from)?;
        Ok(Some(FoveatedModels { measured, dense_fps, model: ours, album }))
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
