//! The models that commands show, opened as they are named on the command line.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::background::{Background, ShownBackground};
use super::camera_file::CameraArgs;
use super::gaze::{GazeArgs, refuse_plain};
use super::{Context, Exit, Failure, out, sight};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{OpenedModel, is_foveated, open_foveated, open_model_as};
use powergs_scene::{Camera, Foveated, Gaussians, ReadAs, StorageOrder, StoredAxes};

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

/// What the file of a model does not say of itself.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ReadingArgs {
    /// Detail of a streamed scene (lod-meta.json), 0 is the finest [default: 0]
    #[arg(long, value_name = "N")]
    pub detail: Option<u32>,
    /// Where the x, y and z of the file point to, if not as in its format: three letters, right or
    /// left, down or up, front or back. `ply` or `rdf` for SPZ and glTF files that have the axes
    /// of a PLY, `rub` for a PLY that has theirs
    #[arg(long, value_name = "AXES")]
    pub axes: Option<StoredAxes>,
}

impl ReadingArgs {
    /// Reads a model, and prints what is odd about it.
    ///
    /// # Errors
    /// Exit code 3: it cannot be read; 2: it has no such detail.
    pub fn open(&self, path: &Path, context: &Context) -> Result<OpenedModel, Failure> {
        let model = self.open_silently(path)?;
        warn(&model, context);
        Ok(model)
    }

    /// Reads a model; what is odd about it is for the caller to say.
    ///
    /// # Errors
    /// As [`ReadingArgs::open`].
    pub fn open_silently(&self, path: &Path) -> Result<OpenedModel, Failure> {
        Ok(open_model_as(path, ReadAs { detail: self.detail, axes: self.axes })?)
    }
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
    /// The model: PLY, compressed PLY, .splat, .spz, .gltf, .glb, .sog, .fov, or a folder with one
    pub scene: PathBuf,
    /// How it is read.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Background: black, white, or r,g,b from 0 to 1 [default: as the cfg_args of a training run
    /// says, else black]
    #[arg(long)]
    pub background: Option<Background>,
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

    /// The background, sRGB.
    pub fn background(&self, context: &Context) -> [f32; 3] {
        let places = [Some(self.scene.as_path()), self.cameras.cameras.as_deref()];
        ShownBackground::of(self.background, &places).said(context)
    }

    fn model(&self, context: &Context) -> Result<Shown, Failure> {
        let path = &self.scene;
        if !self.gaze.is_given() {
            return Ok(Shown::Plain(self.reading.open(path, context)?));
        }
        if !is_foveated(path) {
            // A file that is not there is said to be that.
            self.reading.open_silently(path)?;
            refuse_plain(path.display())?;
        }
        if self.reading.detail.is_some() {
            let what = "--detail is of streamed scenes, a gaze of foveated models: leave one out";
            return Err(Failure::new(Exit::Usage, what));
        }
        if self.reading.axes.is_some() {
            let what = "--axes: a foveated model has those that it was made with; leave it out";
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
