//! From a request to a campaign: checks, reference images, the split of the views, the panel.

use powergs_base::quantity::Watts;
use powergs_scene::Camera;

use super::collect::Collected;
use super::{Campaign, CampaignError, GivenViews};
use crate::counted::PowerCounted;
use crate::foveated::levels_shown;
use crate::invalid::{Invalid, in_range};
use crate::judged::{JudgedSize, in_priced_size};
use crate::request::Request;
use crate::settings::{Gate, GateSize};
use crate::views::{largest, split};
use crate::watch::CampaignWatch;

/// As many views are named in a warning.
const NAMED: usize = 5;

impl Campaign {
    /// Checks a request, renders the references if they are the dense model's own, and scales the
    /// panel.
    ///
    /// # Errors
    /// [`CampaignError`]: a request that is out of range, cameras that see nothing, test views that
    /// LPIPS is not defined for, a panel that cannot be scaled, references that cannot be kept.
    ///
    /// # Panics
    /// Without cameras.
    pub fn open(request: Request, watch: &dyn CampaignWatch) -> Result<Campaign, CampaignError> {
        let Request { goals, settings, cameras, references, background, .. } = request;
        settings.check()?;
        request.oracle.check()?;
        let names: Vec<String> = request.externals.iter().map(|(name, _)| name.clone()).collect();
        let is_own = references.is_own();
        // What is wrong with the request is said before any work.
        goals.plan(settings.gate, is_own, &names, 1)?;
        if let Some(ratio) = request.display_ratio {
            in_range("display_ratio", ratio, 0.001, 1000.0)?;
        }
        if request.foveation.is_some() && !request.power_cameras.have_sizes_of(&cameras) {
            return Err(Invalid::LevelsAtOtherSize.into());
        }
        let mut views = Collected {
            renderer: &*request.renderer,
            dense: &request.dense,
            background,
            watch,
            cameras,
            references,
            seen: Vec::new(),
        };
        views.look()?;
        let unseen = views.cameras.iter().zip(&views.seen).filter(|(_, shown)| **shown == 0);
        let unseen: Vec<&str> = unseen.map(|(camera, _)| camera.name.as_str()).collect();
        if unseen.len() == views.cameras.len() {
            return Err(CampaignError::NothingSeen);
        }
        if !unseen.is_empty() {
            let (n, names) = (unseen.len(), unseen[..unseen.len().min(NAMED)].join(", "));
            let more = if n > NAMED { ", …" } else { "" };
            let all = views.cameras.len();
            watch.warn(&format!("{n} of {all} views see nothing of the model: {names}{more}"));
        }
        let mut split = split(&views.cameras, request.validation_every);
        // Views that do not gate have no reason not to train.
        let trains = goals.train_on_validation || settings.gate == Gate::Test;
        if trains {
            split = split.validation_trains();
        }
        split.notes.iter().for_each(|note| watch.note(note));
        // Before views are added below, which gate or test and count for nothing else.
        let (power_views, priced) = request.power_views.of(
            &views.cameras,
            &split,
            &request.power_cameras,
            request.full_size,
        )?;
        let given = GivenViews {
            count: views.cameras.len(),
            split: split.clone(),
            photos: (!is_own).then(|| views.references.images().digest()),
        };
        let all = largest(&views.cameras);
        // Levels of the periphery are for the size that they are trained at.
        let in_priced_size = in_priced_size(&views.cameras, &request.power_cameras, &priced)
            .filter(|_| request.foveation.is_none());
        let is_priced = in_priced_size.is_none();
        let mut judged = JudgedSize { trained: all, judged: all, is_priced };
        let as_judged = in_priced_size.filter(|_| settings.gate_size == GateSize::Priced);
        if let Some(as_judged) = &as_judged {
            judged = views.judge(&mut split, settings.gate, as_judged)?;
        }
        for &view in request.lpips.iter().flat_map(|_| &split.test) {
            let Camera { name, width, height, .. } = &views.cameras[view];
            let checked =
                request.lpips.as_ref().map_or(Ok(()), |l| l.0.check_size(*width, *height));
            checked.map_err(|error| CampaignError::Lpips { view: name.clone(), error })?;
        }
        if settings.gate == Gate::Validation && request.foveation.is_none() {
            let missing = request.least_gate.saturating_sub(split.validation.len());
            split.also_validate(views.make(as_judged.as_deref(), missing)?);
        }
        let Collected { cameras, references, .. } = views;
        let shown = request.foveation.as_ref().map(|f| levels_shown(f.screens, &power_views));
        // Once more, now that it is known how many levels the views show.
        let plan = goals.plan(settings.gate, is_own, &names, shown.unwrap_or(1))?;
        let mut campaign = Campaign {
            name: request.name,
            dense: request.dense,
            externals: request.externals,
            cameras,
            references,
            background,
            split,
            given,
            judged,
            power_views,
            priced,
            renderer: request.renderer,
            counted: PowerCounted::by(request.oracle.counts()),
            oracle: request.oracle,
            display: request.display,
            settings,
            plan,
            ratio_study: goals.ratio_study,
            foveation: request.foveation,
            lpips: request.lpips,
            keep_all: request.keep_all,
        };
        if let Some(ratio) = request.display_ratio {
            let factor = campaign.display_factor(ratio)?;
            let display = &mut campaign.display;
            display.scale *= factor;
            display.static_power = Watts(display.static_power.0 * factor);
            campaign.counted.display_ratio = Some(ratio);
            campaign.counted.display_factor = factor;
        }
        Ok(campaign)
    }

    /// The factor on the power of the panel at which the dense model's display power is `ratio`
    /// times its rendering power.
    fn display_factor(&self, ratio: f64) -> Result<f64, CampaignError> {
        let watts = self.setup().watts(&self.dense);
        let what = || "the dense model".to_owned();
        let watts = watts.map_err(|error| CampaignError::Sim { what: what(), error })?;
        if watts.display_w <= 0.0 {
            return Err(CampaignError::NoDisplayPower);
        }
        Ok(ratio * watts.render_w / watts.display_w)
    }
}
