//! From a request to a campaign: checks, reference images, the split of the views, the panel.

use powergs_base::picture::Picture;
use powergs_base::quantity::Watts;
use powergs_core::run::RunError;
use powergs_frame::display::Display;
use powergs_scene::{Camera, Gaussians};

use super::{Campaign, CampaignError};
use crate::between::between;
use crate::foveated::levels_shown;
use crate::invalid::{Invalid, in_range};
use crate::references::{Reference, ReferenceImages};
use crate::renderer::Renderer;
use crate::request::Request;
use crate::settings::Gate;
use crate::views::split;
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
        let Request { goals, settings, mut cameras, mut references, background, .. } = request;
        settings.check()?;
        request.oracle.check()?;
        let names: Vec<String> = request.externals.iter().map(|(name, _)| name.clone()).collect();
        let is_own = references.is_own();
        // What is wrong with the request is said before any work.
        goals.plan(settings.gate, is_own, &names, 1)?;
        if let Some(ratio) = request.display_ratio {
            in_range("display_ratio", ratio, 0.001, 1000.0)?;
        }
        let model = (&*request.renderer, &request.dense, background);
        if request.foveation.is_some() && !request.power_cameras.have_sizes_of(&cameras) {
            return Err(Invalid::LevelsAtOtherSize.into());
        }
        let seen = look(model, &cameras, &mut references, watch)?;
        let unseen = cameras.iter().zip(&seen).filter(|(_, shown)| **shown == 0);
        let unseen: Vec<&str> = unseen.map(|(camera, _)| camera.name.as_str()).collect();
        if unseen.len() == cameras.len() {
            return Err(CampaignError::NothingSeen);
        }
        if !unseen.is_empty() {
            let (n, names) = (unseen.len(), unseen[..unseen.len().min(NAMED)].join(", "));
            let more = if n > NAMED { ", …" } else { "" };
            let all = cameras.len();
            watch.warn(&format!("{n} of {all} views see nothing of the model: {names}{more}"));
        }
        let mut split = split(&cameras, request.validation_every);
        // Views that do not gate have no reason not to train.
        let trains = goals.train_on_validation || settings.gate == Gate::Test;
        if trains {
            split = split.validation_trains();
        }
        split.notes.iter().for_each(|note| watch.note(note));
        for &view in request.lpips.iter().flat_map(|_| &split.test) {
            let Camera { name, width, height, .. } = &cameras[view];
            let checked =
                request.lpips.as_ref().map_or(Ok(()), |l| l.0.check_size(*width, *height));
            checked.map_err(|error| CampaignError::Lpips { view: name.clone(), error })?;
        }
        // Before views are made below, which gate and count for nothing else.
        let (power_views, priced) =
            request.power_views.of(&cameras, &split, &request.power_cameras, request.full_size)?;
        if settings.gate == Gate::Validation && request.foveation.is_none() {
            let missing = request.least_gate.saturating_sub(split.validation.len());
            let first = cameras.len();
            make_views(model, (&mut cameras, &mut references), &seen, missing)?;
            split.also_validate(first..cameras.len());
        }
        let shown = request.foveation.as_ref().map(|f| levels_shown(f.screen, &power_views));
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
            power_views,
            priced,
            renderer: request.renderer,
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
            campaign.display = campaign.scaled(ratio)?;
        }
        Ok(campaign)
    }

    /// The panel at which the dense model's display power is `ratio` times its rendering power.
    fn scaled(&self, ratio: f64) -> Result<Display, CampaignError> {
        let watts = self.setup().watts(&self.dense);
        let what = || "the dense model".to_owned();
        let watts = watts.map_err(|error| CampaignError::Sim { what: what(), error })?;
        if watts.display_w <= 0.0 {
            return Err(CampaignError::NoDisplayPower);
        }
        let factor = ratio * watts.render_w / watts.display_w;
        let display = self.display.clone();
        let static_power = Watts(display.static_power.0 * factor);
        Ok(Display { scale: display.scale * factor, static_power, ..display })
    }
}

/// Looks at the dense model from every camera: how many pixels it shows anything in. Where
/// references are its own renders, this is where they are made.
fn look(
    (renderer, dense, background): (&dyn Renderer, &Gaussians, [f32; 3]),
    cameras: &[Camera],
    references: &mut ReferenceImages,
    watch: &dyn CampaignWatch,
) -> Result<Vec<usize>, RunError> {
    if references.is_own() {
        watch.rendering(cameras.len() as u64);
    }
    let mut look = |camera: &Camera| {
        let picture = renderer.look(dense, camera, background);
        if let ReferenceImages::OwnRenders(sink) = references {
            sink.push(Reference::new(&picture))?;
            watch.rendered();
        }
        Ok(shown(&picture, background))
    };
    cameras.iter().map(&mut look).collect()
}

/// Pixels that show something.
fn shown(picture: &Picture, background: [f32; 3]) -> usize {
    picture.pixels.iter().filter(|pixel| **pixel != background).count()
}

/// Where references are the dense model's own renders: `missing` views between `cameras`, which are
/// added to them, with their references. `seen` says how many pixels show something in each. A view
/// that shows less than half of what its neighbours do is somewhere else, and left out: inside of
/// things, or beside them.
fn make_views(
    (renderer, dense, background): (&dyn Renderer, &Gaussians, [f32; 3]),
    (cameras, references): (&mut Vec<Camera>, &mut ReferenceImages),
    seen: &[usize],
    missing: usize,
) -> Result<(), RunError> {
    let ReferenceImages::OwnRenders(sink) = references else { return Ok(()) };
    for (camera, [a, b]) in between(cameras, missing) {
        let picture = renderer.look(dense, &camera, background);
        if 2 * shown(&picture, background) >= seen[a].min(seen[b]).max(1) {
            sink.push(Reference::new(&picture))?;
            cameras.push(camera);
        }
    }
    Ok(())
}
