//! The views that power is counted in, where they are not those that models are compared in.

use std::path::{Path, PathBuf};

use super::{Context, Exit, Failure, out};
use powergs_optimize::views::PowerCameras;
use powergs_scene::Camera;
use powergs_scene::camera::edit::resized;
use powergs_scene::camera::views::ViewSelection;
use powergs_scene::files::open_cameras;

/// Memory for a pixel of a view in training, bytes, about.
const PIXEL: u64 = 64;

/// Where power is counted.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct PowerViewArgs {
    /// Image size that power is counted and quality measured at, pixels: that of the screen;
    /// another aspect keeps the vertical field of view [default: that of the cameras, whatever
    /// --size says]
    #[arg(long, value_name = "WxH", value_parser = super::camera_file::image_size)]
    pub power_size: Option<(u32, u32)>,
    /// Camera file of the views that power is counted in [default: those of --cameras]
    #[arg(hide_short_help = true, long, value_name = "PATH")]
    pub power_cameras: Option<PathBuf>,
    /// Count power in pairs of these views, this far apart (world units): both eyes in each period
    /// of the display, and two panels
    #[arg(hide_short_help = true, long, value_name = "EYE_DISTANCE")]
    pub power_stereo: Option<f64>,
}

impl PowerViewArgs {
    /// The cameras that power is counted with, and the largest size that the camera file says.
    /// `views`: as models are compared in them; `whole`: the same at the size of their file.
    /// `keeps_size`: without a size of its own, power is counted at that of `views`.
    ///
    /// # Errors
    /// Exit code 2: a view that takes too much memory, a distance that is none; 3: a camera file
    /// that cannot be read.
    pub fn cameras(
        &self,
        (model, keeps_size): (Option<&Path>, bool),
        context: &Context,
        views: &[Camera],
        whole: Option<Vec<Camera>>,
    ) -> Result<(PowerCameras, Option<[u32; 2]>), Failure> {
        let size = |c: &Camera| [c.width, c.height];
        let largest =
            whole.iter().flatten().max_by_key(|c| u64::from(c.width) * u64::from(c.height));
        let full_size = largest.map(size);
        let wanted = self.power_size;
        let sized = |cameras: Vec<Camera>| match wanted {
            Some((w, h)) => cameras.iter().map(|c| resized(c, w, h)).collect(),
            None => cameras,
        };
        let cameras = match &self.power_cameras {
            Some(file) => {
                let file = open_cameras(file, wanted, model)?;
                let warnings = file.warnings.iter().chain(&file.doubts);
                for warning in warnings.filter(|_| !context.global.quiet) {
                    out::complain(format!("warning: {warning}"));
                }
                PowerCameras::Others(sized(file.cameras))
            }
            // Levels of the periphery are for the size that they are trained at.
            None if keeps_size && wanted.is_none() => PowerCameras::Same,
            None => {
                let shown = sized(whole.unwrap_or_else(|| views.to_vec()));
                let is_same = shown.iter().map(size).eq(views.iter().map(size));
                if is_same { PowerCameras::Same } else { PowerCameras::Shown(shown) }
            }
        };
        let cameras = match (self.power_stereo, cameras) {
            (None, cameras) => cameras,
            (Some(distance), cameras) => {
                let single = match cameras {
                    PowerCameras::Same => views.to_vec(),
                    PowerCameras::Shown(cameras) | PowerCameras::Others(cameras) => cameras,
                };
                let pairs = ViewSelection { stereo: Some(distance), ..ViewSelection::default() };
                let usage = |e| Failure::new(Exit::Usage, format!("--power-{e}"));
                PowerCameras::Others(pairs.of(single).map_err(usage)?.0)
            }
        };
        if let PowerCameras::Shown(cameras) | PowerCameras::Others(cameras) = &cameras {
            fits_memory(cameras, context)?;
        }
        Ok((cameras, full_size))
    }
}

/// Refuses views whose frames take more memory than is allowed.
///
/// # Errors
/// Exit code 2: such a view.
pub fn fits_memory(cameras: &[Camera], context: &Context) -> Result<(), Failure> {
    for Camera { name, width, height, .. } in cameras {
        let bytes = u64::from(*width) * u64::from(*height) * PIXEL;
        context.global.memory.check(bytes).map_err(|over| {
            let what = format!("view {name}: a frame of {width}x{height} pixels {over}");
            Failure::new(Exit::Usage, what)
        })?;
    }
    Ok(())
}
