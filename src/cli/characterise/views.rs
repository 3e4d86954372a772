//! Rendering units: splats of a scene in the tiles of some views.

use std::path::PathBuf;

use super::super::camera_file::CameraArgs;
use super::super::progress::Progress;
use super::super::scene_file::warn;
use super::super::{Context, Exit, Failure};
use super::Target;
use powergs_datapath::{NumberFormat, Vrc};
use powergs_gates::characterise::vrc::{Splat, Work};
use powergs_gates::characterise::{CharacteriseError, Characterised};
use powergs_gates::netlist::Netlist;
use powergs_raster::{CorePixels, CoreWork, Detail, Options, core_work};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{OpenedModel, open_model};

/// Arguments of `characterise vrc`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The model: PLY, compressed PLY, .splat, .spz, .sog, or a folder with a meta.json
    #[arg(long, value_name = "PATH")]
    scene: PathBuf,
    /// Level of detail of a streamed scene (lod-meta.json)
    #[arg(long, value_name = "N")]
    lod: Option<u32>,
    #[command(flatten)]
    cameras: CameraArgs,
    /// Slots that are simulated in all views together, a splat at a pixel each: sub-tiles are
    /// picked all over the images
    #[arg(long, value_name = "N", default_value_t = 2_000_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000))]
    slots: u64,
    /// Numbers of the core: e5m10 (FP16)
    #[arg(long, value_name = "FORMAT", default_value = "e5m10")]
    format: NumberFormat,
    #[command(flatten)]
    target: Target,
}

/// Host memory for a pixel of a view.
const PIXEL: u64 = 40;
/// Host memory for a slot: records and outcomes of a splat at 4 pixels or more.
const SLOT: u64 = 16;

impl Args {
    pub(super) fn vrc(
        &self,
        prices: fn(&Netlist, &[Work]) -> Result<Characterised, CharacteriseError>,
        context: &Context,
    ) -> Result<Exit, Failure> {
        let unit = match self.format {
            NumberFormat::FP16 => "vrc".to_owned(),
            format => format!("vrc-{format}"),
        };
        let netlist = self.target.netlist(&unit)?;
        let vrc = Vrc::new(self.format).expect("there is a netlist");
        let model = open_model(&self.scene, self.lod)?;
        warn(&model, context);
        let Some(work) = self.work(&vrc, &netlist, &model, context)? else {
            return Ok(Exit::Interrupted);
        };
        let scene = self.scene.display().to_string();
        self.target.write((&unit, &scene), &netlist, prices(&netlist, &work), context)
    }

    /// `None`: interrupted.
    fn work(
        &self,
        vrc: &Vrc,
        netlist: &Netlist,
        model: &OpenedModel,
        context: &Context,
    ) -> Result<Option<Vec<Work>>, Failure> {
        let views = self.cameras.cameras(|| SceneBounds::of(&model.gaussians))?;
        views.warn(context);
        let options = Options::reference(Detail::Image);
        let pixels = match netlist.port("open_mask").map_or(4, |port| port.nets.len()) {
            16 => CorePixels { columns: 4, rows: 4 },
            _ => CorePixels { columns: 2, rows: 2 },
        };
        let slots = self.slots / views.cameras.len() as u64;
        let progress = Progress::new(context, views.cameras.len() as u64, "views");
        let mut work = Vec::new();
        for camera in &views.cameras {
            if context.is_cancelled() {
                return Ok(None);
            }
            let bytes = u64::from(camera.width) * u64::from(camera.height) * PIXEL;
            context.global.memory.check(bytes + self.slots * SLOT).map_err(|over| {
                let what = format!("view {}: lists of its sub-tiles {over}", camera.name);
                Failure::new(Exit::Usage, what)
            })?;
            let keys = Some(NumberFormat::FP16);
            let found = core_work(&model.gaussians, camera, &options, (vrc, keys), pixels, slots);
            work.extend(found.iter().map(told));
            progress.advance(1);
        }
        Ok(Some(work))
    }
}

/// As the gates are told.
fn told(work: &CoreWork) -> Work {
    let splat = |splat: &powergs_raster::CoreSplat| {
        let record = splat.record;
        let [u0, v0] = record.mean;
        let [a, b, c] = record.root;
        let [red, green, blue] = record.colour;
        let numbers = [u0, v0, a, b, c, record.opacity, red, green, blue];
        Splat { numbers, outcomes: splat.outcomes }
    };
    let pixel = |pixel: &powergs_datapath::Pixel| {
        let [red, green, blue] = pixel.colour;
        [red, green, blue, pixel.transmittance]
    };
    Work {
        place: work.place,
        mask: work.mask,
        splats: work.splats.iter().map(splat).collect(),
        pixels: work.pixels.iter().map(pixel).collect(),
    }
}
