//! The flags of commands that train models: which model, in which views, how good.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::background::{Background, ShownBackground};
use super::camera_file::CameraArgs;
use super::scene_file::ReadingArgs;
use super::{Context, Exit, Failure, demo_scene, scene_file};
use powergs_optimize::request::Goal;
use powergs_scene::{Gaussians, StoredAxes};

/// The model that is to be made cheaper.
#[derive(Debug, clap::Args)]
pub struct DenseArgs {
    /// The dense model: PLY, compressed PLY, .splat, .spz, .gltf, .glb, .sog, or a folder with one
    pub model: Option<PathBuf>,
    /// Detail of a streamed scene (lod-meta.json), 0 is the finest
    #[arg(hide_short_help = true, long, value_name = "N")]
    pub detail: Option<u32>,
    /// Where the x, y and z of its file point to, if not as in its format: `ply` for SPZ and glTF
    /// files that have the axes of a PLY, or three letters (rdf, rub)
    #[arg(hide_short_help = true, long, value_name = "AXES")]
    pub axes: Option<StoredAxes>,
}

impl DenseArgs {
    /// The model, that of the demonstration where none is named, and its name for people.
    ///
    /// # Errors
    /// Exit code 3: it cannot be read, or has no Gaussians.
    pub fn open(&self, context: &Context) -> Result<(String, Gaussians), Failure> {
        let Some(path) = &self.model else { return Ok(("demo".into(), demo_scene::model()?)) };
        let reading = ReadingArgs { detail: self.detail, axes: self.axes };
        let scene = reading.open(path, context)?;
        if scene.gaussians.is_empty() {
            let what = format!("{}: the model has no Gaussians", path.display());
            return Err(Failure::new(Exit::BadInput, what));
        }
        Ok((scene_file::name_of(&scene.path), scene.gaussians))
    }
}

/// The views that it is trained and compared in.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Views")]
pub struct TrainingViewArgs {
    /// Camera file: INRIA cameras.json, NeRF transforms.json, or a COLMAP folder
    #[arg(long, value_name = "PATH")]
    pub cameras: Option<PathBuf>,
    /// Instead of a file: N views on a circle around the scene
    #[arg(long, value_name = "N", conflicts_with = "cameras")]
    pub orbit: Option<usize>,
    /// Only every K-th view, starting with the first
    #[arg(hide_short_help = true, long, value_name = "K")]
    pub every: Option<NonZeroUsize>,
    /// Background: black, white, or r,g,b from 0 to 1 [default: as the cfg_args of a training run
    /// says, else black]
    #[arg(hide_short_help = true, long)]
    pub background: Option<Background>,
    /// Of the training views, every K-th validates [default: as many as there are test views]
    #[arg(hide_short_help = true, long, value_name = "K")]
    pub validation: Option<NonZeroUsize>,
}

impl TrainingViewArgs {
    /// The same as flags of commands that show a scene.
    pub fn source(&self, size: Option<(u32, u32)>) -> CameraArgs {
        let (cameras, orbit, every) = (self.cameras.clone(), self.orbit, self.every);
        CameraArgs { cameras, orbit, every, size, ..CameraArgs::default() }
    }

    /// What is behind the model at `model`.
    pub fn background(&self, model: Option<&Path>) -> ShownBackground {
        ShownBackground::of(self.background, &[model, self.cameras.as_deref()])
    }
}

/// How like its references it must be, in numbers.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Quality")]
pub struct LikenessArgs {
    /// PSNR, decibels
    #[arg(long, value_name = "DB", group = "goal")]
    pub quality_db: Option<f64>,
    /// SSIM beside --quality-db [default: none]
    #[arg(hide_short_help = true, long, value_name = "SSIM", requires = "quality_db")]
    pub quality_ssim: Option<f64>,
}

impl LikenessArgs {
    /// The goal that they ask for, if they do.
    pub fn goal(&self) -> Option<Goal> {
        let ssim = self.quality_ssim.unwrap_or(0.0);
        self.quality_db.map(|psnr_db| Goal::Absolute { psnr_db, ssim })
    }
}
