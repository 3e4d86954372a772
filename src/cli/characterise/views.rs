//! Units that need a scene: its splats in the tiles of some views, or its Gaussians in one.

use std::path::PathBuf;

use super::super::camera_file::CameraArgs;
use super::super::progress::Progress;
use super::super::scene_file::warn;
use super::super::{Context, Exit, Failure};
use super::Target;
use powergs_datapath::ccu::programs::FACTORS;
use powergs_datapath::ccu::{self as datapath, Ccu, Gaussian};
use powergs_datapath::{NumberFormat, Vrc, WideFormat};
use powergs_gates::characterise::vrc::{Splat, Work};
use powergs_gates::characterise::{ccu, vrc};
use powergs_gates::netlist::Netlist;
use powergs_raster::{CorePixels, CoreWork, Detail, Options, core_work};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{OpenedModel, open_model};
use powergs_scene::{Camera, Gaussians};
use rayon::prelude::*;

/// A scene, views of it, and where the prices go.
#[derive(Debug, clap::Args)]
struct Scene {
    /// The model: PLY, compressed PLY, .splat, .spz, .sog, or a folder with a meta.json
    #[arg(long, value_name = "PATH")]
    scene: PathBuf,
    /// Level of detail of a streamed scene (lod-meta.json)
    #[arg(long, value_name = "N")]
    lod: Option<u32>,
    #[command(flatten)]
    cameras: CameraArgs,
    #[command(flatten)]
    target: Target,
}

/// Arguments of `characterise vrc`.
#[derive(Debug, clap::Args)]
pub(super) struct Core {
    #[command(flatten)]
    scene: Scene,
    /// Slots that are simulated in all views together, a splat at a pixel each: sub-tiles are
    /// picked all over the images
    #[arg(long, value_name = "N", default_value_t = 2_000_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000))]
    slots: u64,
    /// Numbers of the core: e5m10 (FP16)
    #[arg(long, value_name = "FORMAT", default_value = "e5m10")]
    format: NumberFormat,
}

/// Arguments of `characterise ccu`.
#[derive(Debug, clap::Args)]
pub(super) struct Front {
    #[command(flatten)]
    scene: Scene,
    /// Gaussians that are simulated in the first view, picked all over the scene
    #[arg(long, value_name = "N", default_value_t = 30_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(1_000..=10_000_000))]
    gaussians: u64,
}

/// Host memory for a pixel of a view.
const PIXEL: u64 = 40;
/// Host memory for a slot: records and outcomes of a splat at 4 pixels or more.
const SLOT: u64 = 16;

impl Scene {
    fn open(&self, context: &Context) -> Result<OpenedModel, Failure> {
        let model = open_model(&self.scene, self.lod)?;
        warn(&model, context);
        Ok(model)
    }
}

impl Front {
    /// Prices of a culling and conversion unit.
    pub(super) fn run(&self, context: &Context) -> Result<Exit, Failure> {
        let Scene { target, scene, cameras, .. } = &self.scene;
        let netlist = target.netlist("ccu")?;
        let model = self.scene.open(context)?;
        let views = cameras.cameras(|| SceneBounds::of(&model.gaussians))?;
        views.warn(context);
        let (view, gaussians) =
            ccu_work(&model.gaussians, &views.cameras[0], self.gaussians as usize);
        let found = ccu::prices(&netlist, &view, &gaussians);
        target.write(("ccu", &scene.display().to_string()), &netlist, found, context)
    }
}

/// What the unit of `rtl/` makes of `count` Gaussians of a scene.
fn ccu_work(scene: &Gaussians, camera: &Camera, count: usize) -> (ccu::View, Vec<ccu::Gaussian>) {
    let wide = WideFormat::new(8, 15).expect("24 bits");
    let unit = Ccu::new(wide, NumberFormat::FP16).expect("formats that fit");
    let rows = [0, 1, 2].map(|row| camera.world_to_camera.row(row).to_array());
    let settings = datapath::camera(
        wide,
        camera.centre.to_array(),
        rows,
        [camera.fx, camera.fy],
        [camera.cx, camera.cy],
        [camera.width, camera.height],
    );
    let degree = u32::from(scene.sh_degree.min(3));
    let view = ccu::View { numbers: settings.numbers.to_vec(), tiles: settings.tiles, degree };
    let number = |value: f64| wide.from_f64(value);
    let kept = (scene.sh_degree as usize + 1).pow(2);
    let one = |i: usize| {
        let mean = scene.means[i].map(|m| number(f64::from(m)));
        let turn = scene.rotations[i].map(f64::from);
        let length = turn.iter().map(|q| q * q).sum::<f64>().sqrt() / std::f64::consts::SQRT_2;
        let scales = scene.log_scales[i].map(|s| f64::from(s).exp());
        let opacity = 1.0 / (1.0 + (-f64::from(scene.logit_opacities[i])).exp());
        let mut shape = [0; 8];
        let numbers = scales.into_iter().chain(turn.map(|q| q / length)).chain([opacity]);
        shape.iter_mut().zip(numbers).for_each(|(bits, value)| *bits = number(value));
        let is_kept = unit.cull(&settings, &mean).kept;
        let seen = unit.splat(&settings, &Gaussian { mean, shape }).map(|(splat, walk)| {
            let mut coefficients = [0u16; 48];
            for k in 0..kept.min(16) {
                for channel in 0..3 {
                    let of = scene.sh[(3 * i + channel) * kept + k] * FACTORS[k];
                    let half = if k == 0 { 0.5 } else { 0.0 };
                    coefficients[3 * k + channel] = NumberFormat::FP16.from_f32(of + half);
                }
            }
            let [a, b, c] = splat.root;
            ccu::Seen {
                splat: [splat.depth, a, b, c, splat.opacity],
                candidates: walk.candidates() as u32,
                pairs: walk.pairs(NumberFormat::FP16).len() as u32,
                colour: unit.colour(degree, &splat.direction, &coefficients),
                coefficients: coefficients.to_vec(),
            }
        });
        ccu::Gaussian { mean, shape: is_kept.then_some(shape), seen }
    };
    let stride = scene.len().div_ceil(count).max(1);
    let all: Vec<usize> = (0..scene.len()).step_by(stride).collect();
    (view, all.into_par_iter().map(one).collect())
}

impl Core {
    /// Prices of a volume-rendering core.
    pub(super) fn run(&self, context: &Context) -> Result<Exit, Failure> {
        let unit = match self.format {
            NumberFormat::FP16 => "vrc".to_owned(),
            format => format!("vrc-{format}"),
        };
        let netlist = self.scene.target.netlist(&unit)?;
        let vrc = Vrc::new(self.format).expect("there is a netlist");
        let model = self.scene.open(context)?;
        let Some(work) = self.work(&vrc, &netlist, &model, context)? else {
            return Ok(Exit::Interrupted);
        };
        let scene = self.scene.scene.display().to_string();
        let found = vrc::prices(&netlist, &work);
        self.scene.target.write((&unit, &scene), &netlist, found, context)
    }

    /// `None`: interrupted.
    fn work(
        &self,
        vrc: &Vrc,
        netlist: &Netlist,
        model: &OpenedModel,
        context: &Context,
    ) -> Result<Option<Vec<Work>>, Failure> {
        let views = self.scene.cameras.cameras(|| SceneBounds::of(&model.gaussians))?;
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
