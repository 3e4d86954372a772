//! Frames that are rendered as they are asked for: a model and the cameras that see it.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use powergs_base::budget::Budget;
use powergs_core::run::frames::eyes;
use powergs_core::run::{Frames, Pending, RunError};
use powergs_frame::fovea::ScreenGaze;
use powergs_frame::splat::project::inside_frustum;
use powergs_frame::trace::Frame;
use powergs_raster::{Canvas, Detail, Options, render_foveated};
use powergs_scene::{Camera, Foveated, Gaussians};

/// What the cameras see.
#[derive(Debug, Clone)]
enum RenderedModel {
    Plain(Arc<Gaussians>),
    /// With the gaze of each view.
    Foveated(Arc<Foveated>, Vec<ScreenGaze>),
}

/// Views of a model, rendered with the reference tiling and all counters.
#[derive(Debug, Clone)]
pub struct RenderedViews {
    name: String,
    model: RenderedModel,
    cameras: Vec<Camera>,
    options: Options,
    budget: Budget,
    canvases: Canvases,
}

/// What views are rendered on: as many as there were at once. They stay as long as the views.
#[derive(Debug, Clone, Default)]
struct Canvases(Arc<Mutex<Vec<Canvas>>>);

impl Canvases {
    fn frame(&self, scene: &Gaussians, camera: &Camera, options: &Options) -> Frame {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Locked to take one and to give it back, not meanwhile: views are rendered at the same
        // time.
        let mut canvas = free().pop().unwrap_or_default();
        let frame = canvas.frame(scene, camera, options);
        free().push(canvas);
        frame
    }
}

/// Memory for a pixel of a frame while it is rendered and the one before is written, bytes.
const PIXEL: u64 = 48;
/// The same of a foveated frame.
const FOVEATED_PIXEL: u64 = 80;

impl RenderedViews {
    /// The views of `cameras` on a black background.
    pub fn new(name: &str, scene: Arc<Gaussians>, cameras: Vec<Camera>) -> RenderedViews {
        RenderedViews::of(name, RenderedModel::Plain(scene), cameras)
    }

    /// The views of a foveated model: each camera with where the viewer looks.
    pub fn foveated(
        name: &str,
        model: Arc<Foveated>,
        views: impl IntoIterator<Item = (Camera, ScreenGaze)>,
    ) -> RenderedViews {
        let (cameras, gazes) = views.into_iter().unzip();
        RenderedViews::of(name, RenderedModel::Foveated(model, gazes), cameras)
    }

    fn of(name: &str, model: RenderedModel, cameras: Vec<Camera>) -> RenderedViews {
        let options = Options::reference(Detail::Counters);
        let (budget, canvases) = (Budget::DEFAULT, Canvases::default());
        RenderedViews { name: name.to_owned(), model, cameras, options, budget, canvases }
    }

    /// The same on another background, linear RGB.
    pub fn on_background(mut self, background: [f32; 3]) -> RenderedViews {
        self.options.background = background;
        self
    }
}

/// The views of `cameras` as frames of a run.
pub fn rendered(name: &str, scene: Arc<Gaussians>, cameras: Vec<Camera>) -> Box<dyn Frames> {
    Box::new(RenderedViews::new(name, scene, cameras))
}

impl Frames for RenderedViews {
    fn name(&self) -> &str {
        &self.name
    }

    fn range(&self) -> Range<usize> {
        0..self.cameras.len()
    }

    fn size(&mut self) -> Result<(u32, u32), RunError> {
        Ok(self.cameras.first().map_or((0, 0), |camera| (camera.width, camera.height)))
    }

    fn eyes(&self) -> usize {
        eyes(&self.cameras)
    }

    fn budget(&self) -> Budget {
        self.budget
    }

    fn allow(&mut self, budget: Budget) {
        self.budget = budget;
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        let (camera, options) = (self.cameras[position].clone(), self.options);
        let pixel = match self.model {
            RenderedModel::Plain(_) => PIXEL,
            RenderedModel::Foveated(..) => FOVEATED_PIXEL,
        };
        let bytes = u64::from(camera.width) * u64::from(camera.height) * pixel;
        self.budget.check(bytes).map_err(|over| {
            let Camera { name, width, height, .. } = &camera;
            RunError::Request(format!("view {name}: a frame of {width}x{height} pixels {over}"))
        })?;
        Ok(match &self.model {
            RenderedModel::Plain(scene) => {
                let (scene, canvases) = (Arc::clone(scene), self.canvases.clone());
                Pending::new(bytes, move || Ok(Arc::new(canvases.frame(&scene, &camera, &options))))
            }
            RenderedModel::Foveated(model, gazes) => {
                let (model, gaze) = (Arc::clone(model), gazes[position]);
                Pending::new(bytes, move || {
                    let rendered = render_foveated(&model, &camera, &gaze, &options)
                        .map_err(|e| RunError::Request(format!("--gaze: {e}")))?;
                    let frame = rendered.into_frame(&camera, options.background);
                    let frustum_bits = Some(inside_frustum(&model.base, &camera));
                    Ok(Arc::new(Frame { frustum_bits, ..frame }))
                })
            }
        })
    }
}
