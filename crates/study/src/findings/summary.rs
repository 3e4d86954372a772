//! The summary of a run: means over its frames and the constants of its machine. Frames have equal
//! weight, but a mean power is energy over time. Every conclusion is drawn from this.

use powergs_core::accel::{BufferUse, FrameTiming, Stall};
use powergs_core::sim::statistics::{Aggregate, Value, Weight};
use powergs_core::sim::{CycleReport, FrameReport, RegionReport};
use powergs_dram::{DramCommands, StageCommands};
use powergs_energy::action::{Buffer, Stage, UnitKind};
use powergs_energy::{Component, Standby};
use powergs_frame::fovea::LEVELS;

use crate::run_record::Run;

/// Means over the frames of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSummary {
    /// Energy of a frame.
    pub energy: EnergyMeans,
    /// Frames per second that the display gets: its rate, or what is reached of it.
    pub displayed_fps: f64,
    /// Power at the display rate, watts: energy over the time for which the frames are shown.
    pub power_w: f64,
    /// Parts of it that are paid for time, watts, in the order of `Standby::COMPONENTS`.
    pub standby_w: [f64; Standby::COMPONENTS.len()],
    /// DRAM bytes of a frame by stage, in the order of [`Stage::WORK`].
    pub dram_bytes: [ReadWrite; Stage::WORK.len()],
    /// DRAM bytes of a frame, all stages.
    pub all_dram_bytes: ReadWrite,
    /// Power of the display, watts, where every frame has one.
    pub display_w: Option<f64>,
    /// Power at the display rate and that of the display, watts, where every frame has one.
    pub rendering_plus_display_w: Option<f64>,
    /// Area of the die, mm², where the energy table knows it.
    pub area_mm2: Option<f64>,
    /// The part of it that papers print: without PHY and memory controllers, mm².
    pub core_mm2: Option<f64>,
    /// What only the `cycle` model knows.
    pub cycle: Option<CycleSummary>,
}

/// Mean energy of a frame, picojoules. Standby parts are for the frame's own time.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyMeans {
    /// Everything.
    pub total_pj: f64,
    /// In the order of [`Component::ALL`].
    pub component_pj: [f64; Component::ALL.len()],
    /// In the order of [`Stage::ALL`].
    pub stage_pj: [f64; Stage::ALL.len()],
    /// By stage that works (order of [`Stage::WORK`]) and component of work (order of
    /// [`EnergyMeans::WORK`]).
    pub work_pj: [[f64; EnergyMeans::WORK.len()]; Stage::WORK.len()],
}

impl EnergyMeans {
    /// The components that are paid for work.
    pub const WORK: [Component; 3] = [Component::Dram, Component::Sram, Component::Flop];

    /// One component, picojoules.
    pub fn component(&self, component: Component) -> f64 {
        self.component_pj[component as usize]
    }

    /// One stage, picojoules.
    pub fn stage(&self, stage: Stage) -> f64 {
        self.stage_pj[stage as usize]
    }
}

/// Mean bytes of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ReadWrite {
    /// Read.
    pub read: f64,
    /// Written.
    pub write: f64,
}

impl ReadWrite {
    /// Both.
    pub fn sum(self) -> f64 {
        self.read + self.write
    }
}

/// Means of what only the `cycle` model knows.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleSummary {
    /// Time of a frame, milliseconds.
    pub frame_time_ms: f64,
    /// 99 % of the frames take at most this, milliseconds.
    pub frame_time_p99_ms: f64,
    /// The slowest frame, milliseconds.
    pub frame_time_max_ms: f64,
    /// Frames that took longer than the display period.
    pub deadline_misses: u64,
    /// Length of a frame, cycles.
    pub frame_cycles: f64,
    /// Cycles until the last CCU was done.
    pub preprocessing_cycles: f64,
    /// In the order of [`UnitKind::ALL`].
    pub units: [UnitSummary; UnitKind::ALL.len()],
    /// Colour units; `None` where CCUs evaluate colours.
    pub colour: Option<ColourSummary>,
    /// Lanes at work while their rendering core works, 0 to 1; `None` where a frame renders
    /// nothing.
    pub lane_utilisation: Option<f64>,
    /// The DRAM.
    pub dram: DramSummary,
    /// The buffers that the machine has, in the order of [`Buffer::FILLED`].
    pub buffers: Vec<BufferSummary>,
    /// R1 to R4, where all frames are foveated.
    pub regions: Option<[RegionMeans; LEVELS]>,
}

/// Where the cycles of one kind of unit went, summed over its instances, mean over the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitSummary {
    /// Which kind.
    pub unit: UnitKind,
    /// How many of them the machine has.
    pub instances: u32,
    /// Cycles with work.
    pub busy: f64,
    /// Cycles with work that could not proceed, by cause (order of [`Stall::ALL`]).
    pub stalls: [f64; Stall::ALL.len()],
    /// Cycles without work.
    pub idle: f64,
}

impl UnitSummary {
    /// What the parts of all cycles are called: busy, stalls by cause, idle.
    pub const PARTS: [&'static str; Stall::ALL.len() + 2] = {
        let mut parts = ["busy"; Stall::ALL.len() + 2];
        let mut i = 0;
        while i < Stall::ALL.len() {
            parts[i + 1] = Stall::ALL[i].name();
            i += 1;
        }
        parts[Stall::ALL.len() + 1] = "idle";
        parts
    };

    /// Cycles in the order of [`UnitSummary::PARTS`].
    pub fn parts(&self) -> [f64; UnitSummary::PARTS.len()] {
        let mut parts = [self.busy; UnitSummary::PARTS.len()];
        parts[1..=Stall::ALL.len()].copy_from_slice(&self.stalls);
        parts[Stall::ALL.len() + 1] = self.idle;
        parts
    }

    /// The parts as shares of all cycles; all zero if there are none.
    pub fn shares(&self) -> [f64; UnitSummary::PARTS.len()] {
        let total: f64 = self.parts().iter().sum();
        self.parts().map(|c| if total == 0.0 { 0.0 } else { c / total })
    }
}

/// What colour units did, mean over the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourSummary {
    /// Share of the frame in which they worked, 0 to 1.
    pub busy_frac: f64,
    /// Cycles in which rendering units waited for colours alone, summed over them: a part of their
    /// [`Stall::Input`].
    pub waits: f64,
}

/// Means of what the DRAM did.
#[derive(Debug, Clone, PartialEq)]
pub struct DramSummary {
    /// Share of the frame in which the data bus moved data, 0 to 1.
    pub busy_frac: f64,
    /// Bytes over the frame time, 10⁹ bytes per second; `None` where a frame takes no time.
    pub bandwidth_gb_s: Option<f64>,
    /// Bytes of the second master over the frame time, 10⁹ bytes per second; 0 without one.
    pub second_master_gb_s: Option<f64>,
    /// Bytes a frame that are read and that nobody wrote.
    pub unwritten_bytes: Option<f64>,
    /// Share of the bursts that found their row open, where commands are counted and there are any.
    pub row_hit_frac: Option<f64>,
    /// Bytes moved per byte that was asked for, where commands are counted.
    pub moved_per_requested: Option<f64>,
    /// Commands by stage (order of [`Stage::WORK`]), where the model of the DRAM counts them.
    pub commands: Option<[CommandMeans; Stage::WORK.len()]>,
}

/// Mean commands of one stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandMeans {
    /// Bursts read.
    pub reads: f64,
    /// Bursts written.
    pub writes: f64,
    /// Rows opened.
    pub activates: f64,
}

/// What one buffer held and passed on, all its shares together, mean over the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BufferSummary {
    /// Which.
    pub buffer: Buffer,
    /// Its size, bytes.
    pub capacity: u64,
    /// The most that it held, bytes.
    pub peak: f64,
    /// What it held on average, bytes; `None` where a frame takes no time.
    pub mean: Option<f64>,
    /// Bytes that entered.
    pub filled: f64,
    /// Bytes that left because they had been used.
    pub consumed: f64,
    /// Bytes that left unused.
    pub discarded: f64,
}

/// Means of one region of foveated frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionMeans {
    /// Tiles.
    pub tiles: f64,
    /// List entries that they load.
    pub entries: f64,
    /// Cycles for which the rendering units of a core work on them.
    pub cycles: f64,
    /// Energy of their sorting and rendering, picojoules.
    pub energy_pj: f64,
}

impl RunSummary {
    /// The summary of a run; `None` without frames.
    pub fn of(run: &Run) -> Option<RunSummary> {
        let (frames, fps) = (Frames(&run.frames), run.facts.display_fps);
        let bytes = |stages: &'static [usize]| ReadWrite {
            read: frames.count(|f| stages.iter().map(|&i| f.stages[i].read).sum()),
            write: frames.count(|f| stages.iter().map(|&i| f.stages[i].write).sum()),
        };
        let first = run.frames.first()?;
        Some(RunSummary {
            energy: frames.energy(),
            displayed_fps: frames.shown(fps, |f| Some(f.displayed_fps(fps))).unwrap_or(fps),
            power_w: frames.shown(fps, |f| Some(f.power_display_rate_w(fps))).unwrap_or(f64::NAN),
            standby_w: std::array::from_fn(|i| {
                frames.shown(fps, |f| Some(f.standby_w(fps)[i])).unwrap_or(f64::NAN)
            }),
            dram_bytes: [bytes(&[0]), bytes(&[1]), bytes(&[2])],
            all_dram_bytes: bytes(&[0, 1, 2]),
            display_w: frames.shown(fps, |f| f.display_w),
            rendering_plus_display_w: frames
                .shown(fps, |f| Some(f.power_display_rate_w(fps) + f.display_w?)),
            area_mm2: frames.known(|f| Some(f.area?.total().0)),
            core_mm2: frames.known(|f| Some(f.area?.core().0)),
            cycle: first.cycle().map(|cycle| frames.cycle(cycle, fps)),
        })
    }

    /// Frames over the simulated time of all of them, per second: the rate of the run.
    pub fn throughput_fps(&self) -> Option<f64> {
        Some(1.0 / self.mean_s()?)
    }

    /// Energy of all frames over the simulated time of all of them, watts: power at full rate.
    pub fn throughput_power_w(&self) -> Option<f64> {
        Some(self.energy.total_pj * 1e-12 / self.mean_s()?)
    }

    /// Whether the run falls short of a display rate, frames per second.
    pub fn misses(&self, fps: f64) -> bool {
        self.displayed_fps < fps * (1.0 - 1e-9)
    }

    /// Energy of a frame at the display rate, standby until the next one included, joules.
    pub fn displayed_energy_j(&self) -> f64 {
        self.power_w / self.displayed_fps
    }

    /// Mean time of a frame, seconds; above zero.
    fn mean_s(&self) -> Option<f64> {
        Some(self.cycle.as_ref()?.frame_time_ms * 1e-3).filter(|s| *s > 0.0)
    }
}

/// The frames of a run, of one model, at least one.
struct Frames<'a>(&'a [FrameReport]);

impl Frames<'_> {
    /// The aggregate of a measure; `None` where a frame does not have it, or it is not finite.
    fn aggregate(&self, of: impl Fn(&FrameReport) -> Option<f64>) -> Option<Aggregate> {
        let value = |f| of(f).filter(|x| x.is_finite()).map(Value::Real);
        Aggregate::of(self.0.iter().map(value))
    }

    /// The mean of a measure that a frame may not have.
    fn known(&self, of: impl Fn(&FrameReport) -> Option<f64>) -> Option<f64> {
        self.aggregate(of).map(|a| a.mean)
    }

    /// The mean of a measure over the time for which the frames are shown on a display at `fps`.
    fn shown(&self, fps: f64, of: impl Fn(&FrameReport) -> Option<f64>) -> Option<f64> {
        let value = |f| of(f).filter(|x| x.is_finite()).map(Value::Real);
        let weighted = self.0.iter().map(|f| (value(f), Weight::Displayed.of(f, fps)));
        Aggregate::weighted(weighted).map(|a| a.mean)
    }

    /// The mean of a measure that every frame has.
    fn mean(&self, of: impl Fn(&FrameReport) -> f64) -> f64 {
        self.known(|f| Some(of(f))).unwrap_or(f64::NAN)
    }

    /// The mean of a count.
    fn count(&self, of: impl Fn(&FrameReport) -> u64) -> f64 {
        self.mean(|f| of(f) as f64)
    }

    /// The mean of a count of the `cycle` model, in which all frames are if one of them is.
    fn cycles(&self, of: impl Fn(&FrameTiming) -> u64) -> f64 {
        self.count(|f| f.timing().map_or(0, &of))
    }

    fn energy(&self) -> EnergyMeans {
        EnergyMeans {
            total_pj: self.mean(|f| f.energy.total().0),
            component_pj: Component::ALL.map(|c| self.mean(|f| f.energy.component(c).0)),
            stage_pj: Stage::ALL.map(|s| self.mean(|f| f.energy.stage(s).0)),
            work_pj: Stage::WORK
                .map(|s| EnergyMeans::WORK.map(|c| self.mean(|f| f.energy.part(s, c).0))),
        }
    }

    fn cycle(&self, first: &CycleReport, fps: f64) -> CycleSummary {
        let time_ms = self.aggregate(|f| f.frame_time_s().map(|s| s * 1e3));
        let times = time_ms.map_or([f64::NAN; 3], |a| [a.mean, a.p99.as_f64(), a.max.as_f64()]);
        let lanes =
            |c: &CycleReport| c.live_evaluations as f64 / c.timing.unit(UnitKind::Vru).busy as f64;
        CycleSummary {
            frame_time_ms: times[0],
            frame_time_p99_ms: times[1],
            frame_time_max_ms: times[2],
            deadline_misses: self.0.iter().filter(|f| f.misses_deadline(fps)).count() as u64,
            frame_cycles: self.cycles(|t| t.frame),
            preprocessing_cycles: self.cycles(|t| t.preprocessing_end),
            units: UnitKind::ALL.map(|unit| self.unit(first, unit)),
            colour: first.timing.colour.map(|colour| ColourSummary {
                busy_frac: self.cycles(|t| t.colour.map_or(0, |c| c.busy))
                    / (f64::from(colour.units) * self.cycles(|t| t.frame)).max(1.0),
                waits: self.cycles(|t| t.colour.map_or(0, |c| c.waits)),
            }),
            lane_utilisation: self.known(|f| f.cycle().map(lanes)),
            dram: self.dram(first),
            buffers: first.timing.buffers.iter().map(|buffer| self.buffer(buffer)).collect(),
            regions: self.regions(first),
        }
    }

    fn unit(&self, first: &CycleReport, unit: UnitKind) -> UnitSummary {
        UnitSummary {
            unit,
            instances: first.timing.unit(unit).instances,
            busy: self.cycles(|t| t.unit(unit).busy),
            stalls: std::array::from_fn(|i| self.cycles(|t| t.unit(unit).stalls[i])),
            idle: self.cycles(|t| t.unit(unit).idle),
        }
    }

    fn dram(&self, first: &CycleReport) -> DramSummary {
        let known = |of: fn(&CycleReport) -> Option<f64>| self.known(|f| of(f.cycle()?));
        let commands = |i: usize| {
            let of = |field: fn(&StageCommands) -> u64| {
                self.cycles(|t| t.dram.commands.as_ref().map_or(0, |c| field(&c.stages[i])))
            };
            let (reads, writes) = (of(|s| s.reads), of(|s| s.writes));
            CommandMeans { reads, writes, activates: of(|s| s.activates) }
        };
        let counted = first.timing.dram.commands.is_some();
        DramSummary {
            busy_frac: self.mean(|f| f.timing().map_or(0.0, FrameTiming::dram_busy_frac)),
            bandwidth_gb_s: known(|c| Some(c.dram_bandwidth_gb_s())),
            unwritten_bytes: known(|c| Some(c.unwritten_bytes as f64)),
            second_master_gb_s: known(|c| {
                Some(c.timing.dram.second_master_bytes as f64 * 1e-9 / c.frame_time_s())
            }),
            row_hit_frac: known(|c| c.timing.dram.commands.as_ref()?.total().row_hit_frac()),
            moved_per_requested: known(|c| {
                let moved = c.timing.dram.commands.as_ref().map(DramCommands::moved_bytes)?;
                Some(moved as f64 / c.timing.dram.requested_bytes() as f64)
            }),
            commands: counted.then(|| [0, 1, 2].map(commands)),
        }
    }

    fn buffer(&self, first: &BufferUse) -> BufferSummary {
        let buffer = first.buffer;
        let of = |field: fn(&BufferUse) -> u64| self.cycles(|t| t.buffer(buffer).map_or(0, field));
        let held = |t: &FrameTiming| Some(t.buffer(buffer)?.byte_cycles as f64 / t.frame as f64);
        BufferSummary {
            buffer,
            capacity: first.capacity,
            peak: of(|b| b.peak),
            mean: self.known(|f| held(f.timing()?)),
            filled: of(|b| b.filled),
            consumed: of(|b| b.consumed),
            discarded: of(|b| b.discarded),
        }
    }

    /// `None` where one of the frames is not foveated.
    fn regions(&self, first: &CycleReport) -> Option<[RegionMeans; LEVELS]> {
        first.fovea?;
        let of = |k: usize, field: fn(&RegionReport) -> f64| {
            self.known(|f| f.regions().map(|regions| field(&regions[k])))
        };
        let region = |k| {
            Some(RegionMeans {
                tiles: of(k, |r| r.tiles as f64)?,
                entries: of(k, |r| r.entries as f64)?,
                cycles: of(k, |r| r.cycles as f64)?,
                energy_pj: of(k, |r| r.energy_pj)?,
            })
        };
        Some([region(0)?, region(1)?, region(2)?, region(3)?])
    }
}
