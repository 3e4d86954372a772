//! The models that commands show, opened as they are named on the command line.

use std::path::Path;

use super::gaze::{GazeArgs, refuse_plain};
use super::{Context, Exit, Failure, out};
use powergs_scene::files::{OpenedModel, is_foveated, open_foveated, open_model};
use powergs_scene::{Foveated, Gaussians};

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

/// A trained model that is to be made cheaper, and its name for people.
///
/// # Errors
/// Exit code 3: it cannot be read, or has no Gaussians.
pub fn trained(
    path: &Path,
    detail: Option<u32>,
    context: &Context,
) -> Result<(String, Gaussians), Failure> {
    let scene = open_model(path, detail)?;
    warn(&scene, context);
    if scene.gaussians.is_empty() {
        let what = format!("{}: the model has no Gaussians", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    Ok((name_of(&scene.path), scene.gaussians))
}

/// What a command shows: a plain model, or all levels of a foveated one.
#[derive(Debug)]
pub enum Shown {
    /// A plain model.
    Plain(OpenedModel),
    /// A foveated model.
    Foveated(Box<Foveated>),
}

impl Shown {
    /// Opens what a command with gaze flags shows: with a gaze a foveated model is needed, without
    /// one such a model gives its level 1. `detail` is that of a streamed scene.
    ///
    /// # Errors
    /// Exit code 3 for a model that cannot be read; 2 for a gaze with a plain model, or with a
    /// detail of a streamed one.
    pub fn open(
        path: &Path,
        detail: Option<u32>,
        gaze: &GazeArgs,
        context: &Context,
    ) -> Result<Shown, Failure> {
        if !gaze.is_given() {
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

    /// Level 1, or the only one.
    pub fn base(&self) -> &Gaussians {
        match self {
            Shown::Plain(scene) => &scene.gaussians,
            Shown::Foveated(model) => &model.base,
        }
    }
}
