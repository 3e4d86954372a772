//! The models that commands show, opened as they are named on the command line.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::background::Background;
use super::camera_file::CameraArgs;
use super::gaze::{GazeArgs, refuse_plain};
use super::{Context, Exit, Failure, out, sight};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{OpenedModel, is_foveated, open_foveated, open_model};
use powergs_scene::{Camera, Foveated, Gaussians, StorageOrder};

/// Prints the warnings of a model on standard error, unless that is silenced.
pub fn warn(model: &OpenedModel, context: &Context) {
    if !context.global.quiet {
        let name = model.path.display();
        model.warnings.iter().for_each(|w| out::complain(format!("{name}: {w}")));
    }
}

/// A name for people: that of the file, or that of its folder if the file has one of the names that
/// every trainer or exporter uses.
pub fn name_of(path: &Path) -> String {
    let is_common = |name: &String| {
        ["meta", "lod-meta", "point_cloud"].contains(&name.as_str())
            || name.starts_with("iteration_")
    };
    let stems = path.ancestors().filter_map(|p| p.file_stem());
    let mut names = stems.map(|s| s.to_string_lossy().into_owned());
    names.find(|name| !is_common(name)).unwrap_or_else(|| "model".into())
}

/// How the Gaussians of a model are sorted.
#[derive(Debug, clap::Args)]
pub struct OrderArgs {
    /// Sort the Gaussians when the model is loaded: as stored, along a Morton or Hilbert curve of
    /// their centres, or the most opaque first. Pictures stay, addresses follow
    #[arg(long, value_name = "ORDER", default_value = "storage", value_parser = orders())]
    pub order: StorageOrder,
}

fn orders() -> impl TypedValueParser<Value = StorageOrder> {
    let names = PossibleValuesParser::new(StorageOrder::ALL.map(StorageOrder::name));
    names.map(|name| StorageOrder::from_name(&name).expect("one of the names"))
}

impl OrderArgs {
    /// Sorts a model.
    pub fn sort(&self, scene: &mut Gaussians) {
        if let Some(order) = self.order.of(scene) {
            *scene = scene.permuted(&order);
        }
    }
}

/// The model that a command shows, its views, and where the viewer looks.
#[derive(Debug, clap::Args)]
pub struct ShownArgs {
    /// The model: PLY, compressed PLY, .splat, .spz, .glb, .sog, .fov, or a folder with one
    pub scene: PathBuf,
    /// Detail of a streamed scene (lod-meta.json), 0 is the finest
    #[arg(long, value_name = "N")]
    pub detail: Option<u32>,
    /// Background: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
    /// The views.
    #[command(flatten)]
    pub cameras: CameraArgs,
    /// Where somebody looks.
    #[command(flatten)]
    pub gaze: GazeArgs,
}

impl ShownArgs {
    /// The model and its views. With a gaze a foveated model is needed, without one such a model
    /// gives its level 1.
    ///
    /// # Errors
    /// Exit code 3 for a model or cameras that cannot be read; 2 for a gaze with a plain model, or
    /// with a detail of a streamed one, and for views that cannot be.
    pub fn open(&self, context: &Context) -> Result<(Shown, Vec<Camera>), Failure> {
        let scene = self.model(context)?;
        let views = self.cameras.cameras(Some(&self.scene), || SceneBounds::of(scene.base()))?;
        views.warn(context);
        sight::check(scene.base(), &views.cameras, context);
        Ok((scene, views.cameras))
    }

    fn model(&self, context: &Context) -> Result<Shown, Failure> {
        let (path, detail) = (&self.scene, self.detail);
        if !self.gaze.is_given() {
            let scene = open_model(path, detail)?;
            warn(&scene, context);
            return Ok(Shown::Plain(scene));
        }
        if !is_foveated(path) {
            // A file that is not there is said to be that.
            open_model(path, detail)?;
            refuse_plain(path.display())?;
        }
        if detail.is_some() {
            let what = "--detail is of streamed scenes, a gaze of foveated models: leave one out";
            return Err(Failure::new(Exit::Usage, what));
        }
        Ok(Shown::Foveated(Box::new(open_foveated(path)?)))
    }
}

/// What a command shows: a plain model, or all levels of a foveated one.
#[derive(Debug)]
pub enum Shown {
    /// A plain model.
    Plain(OpenedModel),
    /// A foveated model.
    Foveated(Box<Foveated>),
}

impl OrderArgs {
    /// Sorts what a command shows.
    pub fn sort_shown(&self, shown: &mut Shown) {
        match shown {
            Shown::Plain(scene) => self.sort(&mut scene.gaussians),
            Shown::Foveated(model) => model.sort(self.order),
        }
    }
}

impl Shown {
    /// Level 1, or the only one.
    pub fn base(&self) -> &Gaussians {
        match self {
            Shown::Plain(scene) => &scene.gaussians,
            Shown::Foveated(model) => &model.base,
        }
    }
}
