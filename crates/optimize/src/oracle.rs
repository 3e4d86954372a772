//! What a candidate costs: a trait, implemented by the closed-form `paper` model and by the
//! simulated machine.
//!
//! Power is taken at the display rate: the energy of that many frames a second plus static and
//! refresh power. It is not the power of a machine that renders as fast as it can. Every frame is
//! simulated as the first of its trace.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use crate::counted::PowerCounts;
use crate::invalid::Invalid;
use powergs_base::budget::Budget;
use powergs_base::picture::Picture;
use powergs_core::run::frames::eyes;
use powergs_core::run::{PaperModel, RunError, System};
use powergs_core::sim::paper::{UnitPrices, breakdown};
use powergs_core::sim::{FrameReport, Label, SimError};
use powergs_core::workload::paper::{Padding, TileLoad, count, count_foveated};
use powergs_energy::Component;
use powergs_energy::action::Phase;
use powergs_frame::display::Display;
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, FoveatedFrame, Options, Rendered, render};
use powergs_scene::{Camera, Gaussians};

/// Watts by stage and component, in the orders of [`Phase::ALL`] and [`Component::ALL`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct OracleParts(pub [[f64; Component::ALL.len()]; Phase::ALL.len()]);

impl OracleParts {
    /// Everything, watts.
    pub fn total_w(&self) -> f64 {
        self.0.iter().flatten().sum()
    }

    /// One stage, watts.
    pub fn stage_w(&self, stage: Phase) -> f64 {
        self.0[stage as usize].iter().sum()
    }

    fn add(&mut self, other: &OracleParts, weight: f64) {
        for (mine, theirs) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *mine += weight * theirs;
        }
    }
}

/// The power of a model, mean over views.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct OracleWatts {
    /// Rendering, at the display rate.
    pub render_w: f64,
    /// The display that shows the images.
    pub display_w: f64,
    /// Rendering by stage and component.
    pub parts: OracleParts,
}

impl OracleWatts {
    /// The mean over frames: for each, rendering power by part and display power, watts.
    pub fn mean(frames: &[(OracleParts, f64)]) -> OracleWatts {
        let (mut watts, weight) = (OracleWatts::default(), 1.0 / frames.len().max(1) as f64);
        for (parts, display_w) in frames {
            watts.parts.add(parts, weight);
            watts.display_w += weight * display_w;
        }
        watts.render_w = watts.parts.total_w();
        watts
    }

    /// Rendering and display.
    pub fn total_w(&self) -> f64 {
        self.render_w + self.display_w
    }
}

/// A rendered frame, with the reference tiling and [`Detail::Counters`].
#[derive(Debug)]
pub enum RenderedFrame {
    /// Of a plain model.
    Plain(Rendered),
    /// Of a foveated one.
    Foveated(FoveatedFrame),
}

impl RenderedFrame {
    /// The picture.
    pub fn picture(&self) -> &Picture {
        match self {
            RenderedFrame::Plain(rendered) => &rendered.picture,
            RenderedFrame::Foveated(frame) => &frame.picture,
        }
    }

    /// What a trace has of it.
    fn into_frame(self, camera: &Camera, background: [f32; 3]) -> Frame {
        match self {
            RenderedFrame::Plain(rendered) => rendered.into_frame(camera, background),
            RenderedFrame::Foveated(frame) => frame.into_frame(camera, background),
        }
    }
}

/// Gives the power that rendering takes.
pub trait PowerOracle: Send + Sync {
    /// The name in every output.
    fn name(&self) -> String;

    /// By which counts its answers are.
    fn counts(&self) -> PowerCounts;

    /// A hash of everything that its answers depend on.
    fn id(&self) -> u128;

    /// Frames shown per second.
    fn fps(&self) -> f64;

    /// Whether it can answer for models that are made here.
    ///
    /// # Errors
    /// [`Invalid`]: why not.
    fn check(&self) -> Result<(), Invalid> {
        Ok(())
    }

    /// Watts of showing this frame again and again at the display rate.
    ///
    /// # Errors
    /// [`SimError`]: a machine that cannot run the frame, or a defect of the simulator.
    fn frame(
        &self,
        shot: RenderedFrame,
        camera: &Camera,
        background: [f32; 3],
    ) -> Result<OracleParts, SimError>;

    /// Watts of showing these views, one after the other in each period of the display: both eyes
    /// of a pair.
    ///
    /// # Errors
    /// As [`PowerOracle::frame`].
    fn views(
        &self,
        shots: Vec<(RenderedFrame, &Camera)>,
        background: [f32; 3],
    ) -> Result<OracleParts, SimError> {
        let mut all = OracleParts::default();
        for (shot, camera) in shots {
            all.add(&self.frame(shot, camera, background)?, 1.0);
        }
        Ok(all)
    }

    /// Mean power of `scene` over `views`, which must not be empty; of pairs that of both eyes with
    /// two panels. The display term is that of the displayed images (8 bits a channel). Frames are
    /// worked on in parallel and added in order.
    ///
    /// # Errors
    /// As [`PowerOracle::frame`].
    fn watts(
        &self,
        scene: &Gaussians,
        views: &[Camera],
        background: [f32; 3],
        display: &Display,
    ) -> Result<OracleWatts, SimError> {
        assert!(!views.is_empty(), "power is a mean over at least one view");
        let options = Options { background, ..Options::reference(Detail::Counters) };
        let frame = |views: &[Camera]| {
            let mut display_w = 0.0;
            let mut shots = Vec::with_capacity(views.len());
            for camera in views {
                let rendered = render(scene, camera, &options);
                display_w += display.power(rendered.picture.mean_linear_rgb()).0;
                shots.push((RenderedFrame::Plain(rendered), camera));
            }
            Ok((self.views(shots, background)?, display_w))
        };
        let frames: Vec<Result<(OracleParts, f64), SimError>> =
            views.par_chunks(eyes(views)).map(frame).collect();
        Ok(OracleWatts::mean(&frames.into_iter().collect::<Result<Vec<_>, _>>()?))
    }
}

/// The published closed-form model: counts times three unit prices, no time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperOracle {
    /// Unit prices.
    pub prices: UnitPrices,
    /// Frames shown per second.
    pub fps: f64,
}

impl PowerOracle for PaperOracle {
    fn name(&self) -> String {
        "paper".into()
    }

    fn counts(&self) -> PowerCounts {
        PowerCounts::ClosedForm
    }

    fn id(&self) -> u128 {
        let UnitPrices { flop_pj, sram_pj_per_byte, dram_pj_per_byte } = self.prices;
        hash_of([flop_pj, sram_pj_per_byte, dram_pj_per_byte, self.fps].map(f64::to_le_bytes))
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn frame(&self, shot: RenderedFrame, _: &Camera, _: [f32; 3]) -> Result<OracleParts, SimError> {
        let load = |entries: u32, loaded: u32| TileLoad {
            entries: f64::from(entries),
            loaded: f64::from(loaded),
        };
        let pixels = shot.picture().pixels.len() as u64;
        let counts = match &shot {
            RenderedFrame::Plain(rendered) => {
                let tiles = rendered.tiles.iter().map(|t| load(t.entries, t.loaded));
                count(&rendered.counters, &tiles.collect::<Vec<_>>(), pixels)
            }
            RenderedFrame::Foveated(frame) => {
                let tiles = frame.tiles.iter().map(|t| load(t.count.entries, t.count.loaded));
                let tiles: Vec<TileLoad> = tiles.collect();
                count_foveated(&frame.counters, &frame.fovea, &tiles, pixels)
            }
        };
        let energy = breakdown(&counts, &self.prices);
        let watts = self.fps * 1e-12;
        Ok(OracleParts(Phase::ALL.map(|s| Component::ALL.map(|c| energy.part(s, c).0 * watts))))
    }
}

impl PaperOracle {
    /// The model with the published prices, at a display rate in frames a second.
    ///
    /// # Errors
    /// [`RunError::Internal`]: the table of prices is damaged.
    pub fn published(fps: f64) -> Result<PaperOracle, RunError> {
        Ok(PaperOracle { prices: PaperModel::new(Padding::TrueTiles)?.prices, fps })
    }
}

fn hash_of(parts: impl IntoIterator<Item = impl AsRef<[u8]>>) -> u128 {
    let mut hash = Xxh3::new();
    parts.into_iter().for_each(|part| hash.update(part.as_ref()));
    hash.digest128()
}

/// The simulated machine.
#[derive(Debug, Clone)]
pub struct CycleOracle {
    /// The machine with its prices.
    pub system: System,
    /// Frames shown per second.
    pub fps: f64,
    /// Memory that the tile lists of a frame may take.
    pub memory: Budget,
}

impl PowerOracle for CycleOracle {
    fn name(&self) -> String {
        self.system.machine().name.clone()
    }

    fn counts(&self) -> PowerCounts {
        PowerCounts::Machine
    }

    fn check(&self) -> Result<(), Invalid> {
        let machine = self.system.machine();
        if !machine.flow().task(machine).is_shown() {
            return Err(Invalid::Trains(machine.name.clone()));
        }
        // Frames are simulated one by one.
        machine.flow().goes_over(machine, 1).map_err(Invalid::Alone)?;
        if machine.flow().runs_any_frame() {
            return Ok(());
        }
        let (machine, flow) = (machine.name.clone(), machine.flow().key());
        Err(Invalid::OnlyRecorded { machine, flow })
    }

    fn id(&self) -> u128 {
        hash_of([&self.system.id().to_le_bytes()[..], &self.fps.to_le_bytes()])
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn frame(
        &self,
        shot: RenderedFrame,
        camera: &Camera,
        background: [f32; 3],
    ) -> Result<OracleParts, SimError> {
        Ok(self.parts(&self.report(shot, camera, background)?))
    }

    /// Standby is paid once, for the time of both.
    fn views(
        &self,
        shots: Vec<(RenderedFrame, &Camera)>,
        background: [f32; 3],
    ) -> Result<OracleParts, SimError> {
        let reports = shots.into_iter().map(|(shot, camera)| self.report(shot, camera, background));
        let reports: Vec<FrameReport> = reports.collect::<Result<_, _>>()?;
        let whole = reports.into_iter().reduce(FrameReport::with_right);
        Ok(whole.map_or_else(OracleParts::default, |report| self.parts(&report)))
    }
}

impl CycleOracle {
    /// Simulates a frame on the machine.
    ///
    /// # Errors
    /// [`SimError`]: a machine that cannot run the frame, or a defect of the simulator.
    pub fn report(
        &self,
        shot: RenderedFrame,
        camera: &Camera,
        background: [f32; 3],
    ) -> Result<FrameReport, SimError> {
        let frame = shot.into_frame(camera, background);
        let machine = self.system.machine();
        let key = machine.flow().work_key(machine);
        key.demand(&frame, self.memory)?;
        self.system.simulate(Label::default(), &*key.prepare(&frame))
    }

    /// What [`PowerOracle::frame`] says of a frame with this report.
    pub(crate) fn parts(&self, report: &FrameReport) -> OracleParts {
        at_rate(report, self.fps)
    }
}

/// Power of a report at a display rate: dynamic power of the stages, and static and refresh power.
///
/// A frame that misses the rate counts with its energy times `fps`, more than the machine can draw:
/// its power would fall when it gets slower, and a search must not gain by that.
fn at_rate(report: &FrameReport, fps: f64) -> OracleParts {
    let mut parts = OracleParts::default();
    for stage in Phase::WORK {
        for component in Component::ALL {
            parts.0[stage as usize][component as usize] =
                report.energy.part(stage, component).0 * fps * 1e-12;
        }
    }
    // Per frame that is asked for, like the work above: a late one pays for all the time it takes.
    let frames_per_shown = fps / report.displayed_fps(fps);
    let paid_for_time = [Component::Leakage, Component::Background, Component::Refresh];
    for (component, watts) in paid_for_time.into_iter().zip(report.standby_w(fps)) {
        parts.0[Phase::Standby as usize][component as usize] = watts * frames_per_shown;
    }
    parts
}
