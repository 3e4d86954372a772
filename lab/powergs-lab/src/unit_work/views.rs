//! Units that need a scene: its splats in the tiles of some views, or its Gaussians in one.

use std::path::PathBuf;

use crate::{CorePixels, CoreWork, FrontEnd, TileWork, core_work, tile_work};
use powergs_datapath::{NumberFormat, Vrc};
use powergs_raster::{Detail, Options};
use powergs_scene::Camera;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{OpenedModel, open_model};
use powergs_sim::cli::camera_file::CameraArgs;
use powergs_sim::cli::progress::Progress;
use powergs_sim::cli::scene_file::warn;
use powergs_sim::cli::{Context, Exit, Failure};

/// A scene and views of it.
#[derive(Debug, clap::Args)]
pub struct Scene {
    /// The model: PLY, compressed PLY, .splat, .spz, .glb, .sog, or a folder with one
    #[arg(long, value_name = "PATH")]
    scene: PathBuf,
    /// Level of detail of a streamed scene (lod-meta.json)
    #[arg(long, value_name = "N")]
    lod: Option<u32>,
    #[command(flatten)]
    cameras: CameraArgs,
}

/// Host memory for a pixel of a view.
const PIXEL: u64 = 40;
/// Host memory for a slot: records and outcomes of a splat at 4 pixels or more.
const SLOT: u64 = 16;
/// Slots of a splat in a sub-tile of a rendering unit, and host memory for it: a record and its
/// copy.
const SUBTILE_SLOTS: u64 = 64;
const SUBTILE: u64 = 64;

impl Scene {
    /// The scene, for messages.
    pub fn source(&self) -> String {
        self.scene.display().to_string()
    }

    fn open(&self, context: &Context) -> Result<(OpenedModel, Vec<Camera>), Failure> {
        let model = open_model(&self.scene, self.lod)?;
        warn(&model, context);
        let bounds = || SceneBounds::of(&model.gaussians);
        let views = self.cameras.cameras(Some(&self.scene), bounds)?;
        views.warn(context);
        Ok((model, views.cameras))
    }

    /// `work` of `count` Gaussians, picked all over the scene, in the first view.
    pub fn front_end<T>(
        &self,
        count: u64,
        work: impl FnOnce(&FrontEnd, &[usize]) -> T,
        context: &Context,
    ) -> Result<T, Failure> {
        let (model, cameras) = self.open(context)?;
        let scene = &model.gaussians;
        let front = FrontEnd::new(scene, &cameras[0], NumberFormat::FP16);
        let stride = scene.len().div_ceil(usize::try_from(count).unwrap_or(usize::MAX)).max(1);
        let picked: Vec<usize> = (0..scene.len()).step_by(stride).collect();
        Ok(work(&front.expect("FP16 has enough exponent"), &picked))
    }

    /// Work of single cores, about `slots` (splat, pixel) slots of it; `None`: interrupted.
    pub fn cores(
        &self,
        (vrc, pixels): (&Vrc, CorePixels),
        slots: u64,
        context: &Context,
    ) -> Result<Option<Vec<CoreWork>>, Failure> {
        let keys = Some(NumberFormat::FP16);
        let of = |model: &OpenedModel, camera: &Camera, slots| {
            let options = Options::reference(Detail::Image);
            core_work(&model.gaussians, camera, &options, (vrc, keys), pixels, slots)
        };
        self.views(slots, slots * SLOT, of, context)
    }

    /// Work of rendering units, about `slots` (splat, pixel) slots of it; `None`: interrupted.
    pub fn tiles(
        &self,
        vrc: &Vrc,
        slots: u64,
        context: &Context,
    ) -> Result<Option<Vec<TileWork>>, Failure> {
        let keys = Some(NumberFormat::FP16);
        let of = |model: &OpenedModel, camera: &Camera, slots: u64| {
            let options = Options::reference(Detail::Image);
            let pairs = slots.div_ceil(SUBTILE_SLOTS);
            tile_work(&model.gaussians, camera, &options, (vrc, keys), pairs)
        };
        self.views(slots, slots.div_ceil(SUBTILE_SLOTS) * SUBTILE, of, context)
    }

    fn views<T>(
        &self,
        slots: u64,
        held: u64,
        of: impl Fn(&OpenedModel, &Camera, u64) -> Vec<T>,
        context: &Context,
    ) -> Result<Option<Vec<T>>, Failure> {
        let (model, cameras) = self.open(context)?;
        let progress = Progress::new(context, cameras.len() as u64, "views");
        let mut work = Vec::new();
        for camera in &cameras {
            if context.is_cancelled() {
                return Ok(None);
            }
            let bytes = u64::from(camera.width) * u64::from(camera.height) * PIXEL;
            context.global.memory.check(bytes + held).map_err(|over| {
                let what = format!("view {}: lists of its sub-tiles {over}", camera.name);
                Failure::new(Exit::Usage, what)
            })?;
            work.extend(of(&model, camera, slots / cameras.len() as u64));
            progress.advance(1);
        }
        Ok(Some(work))
    }
}
