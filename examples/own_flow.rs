//! A dataflow of one's own: blending without an order. The whole program, and one more dataflow.
//!
//! A host converts Gaussians; each blending unit takes a tile, reads the Gaussians that touch it in
//! chunks, in the order in which they are stored, adds them up for every pixel that they cover, and
//! divides by the weights at the end. Nothing is sorted and nothing stops early.
//!
//! `cargo run --release --example own_flow -- COMMAND`, with `replay traces/demo.bin --arch
//! examples/own_flow/unsorted.toml`, `sweep examples/own_flow/sweep.toml --traces traces/demo.bin`,
//! `explain BLENDER`, or any other command of the program.

use std::process::ExitCode;

use powergs_sim::extend::action::{ActionCounts, Phase};
use powergs_sim::extend::flow::{
    self, Dataflow, FlowOutcome, FrameTask, SimError, TablesDecl, WorkKey,
};
use powergs_sim::extend::kernel::buffer::{BufferAllocator, usage};
use powergs_sim::extend::kernel::calibration::{Calibration, CalibrationRecorder, Recording};
use powergs_sim::extend::kernel::ledger::{Account, cycles};
use powergs_sim::extend::kernel::memory::{Arrival, Memory, NEVER, Ranges, Request};
use powergs_sim::extend::kernel::stream::{Streams, reads, writes};
use powergs_sim::extend::kernel::timeline::{Observer, State};
use powergs_sim::extend::kernel::{self, FrameTiming, Histogram, drive};
use powergs_sim::extend::quantity::Bytes;
use powergs_sim::extend::resident::{Cut, RegionShape, ResidentFrame};
use powergs_sim::extend::stage::{
    Bias, StageDecl, Stall, also, buffer, double, hardware, omit, part, streams, work,
};
use powergs_sim::extend::{BufferSpec, Machine, Reference};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The `[blender]` table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BlenderSpec {
    /// Units.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "units"))]
    pub units: u32,
    /// Pixels that one evaluates in a cycle.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "lanes"))]
    pub lanes: u32,
    /// Side of a tile.
    #[schemars(range(min = 8, max = 256), extend("x-unit" = "pixels"))]
    pub tile: u32,
    /// A converted Gaussian.
    pub feature: Bytes,
    /// A finished pixel.
    pub pixel: Bytes,
    /// Where the Gaussians of a tile are, or pass through where they are too many.
    pub store: BufferSpec,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Unsorted {
    /// Units that add up and divide.
    blender: BlenderSpec,
}

flow::flow_tables!(Unsorted, UnsortedFlow, [blender]);

const BLENDER: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<BlenderSpec>().units),
    works: &[work("divide", 4, "One pixel divided by its weight.").a_cycle(|_| 1.0)],
    also_works: &[
        also("alpha").a_cycle(|m| f64::from(m.of_type::<BlenderSpec>().lanes)),
        also("blend").a_cycle(|m| f64::from(m.of_type::<BlenderSpec>().lanes)),
    ],
    buffers: &[buffer("blender_in", "blender.store", |m| {
        m.of_type::<BlenderSpec>().store.shared(m.of_type::<BlenderSpec>().units)
    })],
    streams: &[
        reads("gaussians", "Gaussians of a tile, from the host", &[], ["image", "image"]),
        writes("image", "finished pixels", ["gaussians", "gaussians"]),
    ],
    parts: &[part("lanes", "Lanes: a pixel each.", |m| {
        f64::from(m.of_type::<BlenderSpec>().lanes)
    })],
    also_waits: &["features"],
    doubles: &[
        double("blender.units, their buffer", &["blender.units", "blender.store.capacity"], &[]),
        double("blender.lanes", &["blender.lanes"], &[]),
    ],
    omits: &[omit("conversion by the host", Bias::Optimistic, "")],
    ..StageDecl::new(
        "blender",
        "blending units",
        Phase::Rendering,
        "Adds up the Gaussians of a tile in any order, and divides by their weights.",
    )
};

const STREAMS: Streams = streams(&[&BLENDER]);

/// The dataflow.
pub struct UnsortedFlow;

impl Dataflow for UnsortedFlow {
    fn key(&self) -> &'static str {
        "unsorted"
    }

    fn means(&self) -> &'static str {
        "Gaussians are added up in the order of storage, and pixels divided by their weights"
    }

    fn stages(&self) -> &'static [&'static StageDecl] {
        &[&BLENDER]
    }

    fn tables(&self) -> TablesDecl {
        TablesDecl::of::<Unsorted>()
    }

    fn tile(&self, machine: &Machine, _: [u32; 2]) -> [u32; 2] {
        [machine.of_type::<BlenderSpec>().tile; 2]
    }

    /// Tiles are read, worked on and written at the same time.
    fn overlaps(&self, _: &Machine) -> bool {
        true
    }

    /// That of machines with resident pixels: which Gaussians meet a tile, and in how many steps.
    fn work_key(&self, machine: &Machine) -> WorkKey {
        let BlenderSpec { tile, lanes, .. } = *machine.of_type::<BlenderSpec>();
        // Its pixels go through no banks that could hold a step up.
        let (words, banks) = (0, 1);
        RegionShape { width: tile, height: tile, cut: Cut::Box, lanes, words, banks, depths: false }
            .key()
    }

    fn run(
        &self,
        task: &FrameTask<'_>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<FlowOutcome, SimError> {
        self.fits(task)?;
        let (machine, frame) = (task.machine, task.work.of().expect("it has the key"));
        let on_device = |m: &Machine, r: &mut CalibrationRecorder| through(m, frame, None, r).1;
        let flat = Reference::calibration(machine, task.memo, |_| {}, on_device, &STREAMS);
        Ok(match observer {
            None => through(machine, frame, flat.as_deref(), &mut ()).0,
            Some(mut observer) => through(machine, frame, flat.as_deref(), &mut observer).0,
        })
    }
}

/// What a unit does with its tile.
#[derive(Clone, Copy)]
enum Doing {
    Nothing,
    Reads(Arrival),
    Works(u64),
    Writes(Arrival),
}

struct Unit {
    doing: Doing,
    tile: usize,
    store: BufferAllocator,
    account: Account,
}

/// All units, with what they share.
struct Blenders<'a, O> {
    spec: &'a BlenderSpec,
    frame: &'a ResidentFrame,
    memory: Memory<'a, Ranges>,
    units: Vec<Unit>,
    next_tile: usize,
    end: u64,
    observer: &'a mut O,
}

impl<O: Observer> Blenders<'_, O> {
    /// Asks for something of the tile of a unit.
    fn ask(&mut self, unit: usize, now: u64, stream: &str, [place, bytes]: [u64; 2]) -> Arrival {
        let request = Request { owner: unit as u32, stream: STREAMS.id(stream), bytes };
        self.memory.issue(now, request, |_| [place, bytes], self.observer)
    }

    /// The next thing that a unit does in this cycle, if it need not wait for it.
    fn next(&mut self, unit: usize, now: u64) -> Doing {
        let BlenderSpec { feature, pixel, tile, lanes, .. } = *self.spec;
        let Unit { doing, tile: own, .. } = self.units[unit];
        let region = self.frame.regions[own];
        let bytes = u64::from(region.entries) * feature.0;
        match doing {
            Doing::Nothing => {
                self.units[unit].store.fill(now, bytes);
                let place = u64::from(region.start) * feature.0;
                Doing::Reads(self.ask(unit, now, "gaussians", [place, bytes]))
            }
            Doing::Reads(_) => {
                let entries = self.frame.of(&region).iter();
                let cycles: u64 = entries.map(|entry| u64::from(entry.cycles)).sum();
                Doing::Works(now + cycles + u64::from(region.pixels.div_ceil(lanes)))
            }
            Doing::Works(_) => {
                self.units[unit].store.release(now, bytes);
                let base = self.frame.entries.len() as u64 * feature.0;
                let place = base + own as u64 * u64::from(tile).pow(2) * pixel.0;
                let bytes = u64::from(region.pixels) * pixel.0;
                Doing::Writes(self.ask(unit, now, "image", [place, bytes]))
            }
            Doing::Writes(_) => Doing::Nothing,
        }
    }
}

impl<O: Observer> kernel::Agents for Blenders<'_, O> {
    fn step(&mut self, unit: usize, now: u64) -> u64 {
        self.units[unit].account.up_to(now, self.observer);
        loop {
            let own = &self.units[unit];
            let (state, wake) = match own.doing {
                Doing::Reads(arrival) => {
                    (State::Stalled(Stall::of("features")), self.memory.at(arrival))
                }
                Doing::Writes(arrival) => (State::Stalled(Stall::OUTPUT), self.memory.at(arrival)),
                Doing::Works(until) => (State::Busy(own.tile as u32), until),
                Doing::Nothing if self.next_tile == self.frame.regions.len() => {
                    (State::Idle, NEVER)
                }
                Doing::Nothing => {
                    self.units[unit].tile = self.next_tile;
                    self.next_tile += 1;
                    (State::Idle, now)
                }
            };
            if wake > now {
                self.units[unit].account.is(state);
                return wake;
            }
            self.units[unit].doing = self.next(unit, now);
            self.end = now;
        }
    }

    fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        self.memory.advance(until)
    }
}

fn through<O: Observer>(
    machine: &Machine,
    frame: &ResidentFrame,
    calibration: Option<&Calibration>,
    observer: &mut O,
) -> (FlowOutcome, Option<Recording>) {
    let spec: &BlenderSpec = machine.of_type();
    let stage = hardware().stage_called("blender").expect("it is registered");
    let read = frame.entries.len() as u64 * spec.feature.0;
    let end = read + frame.regions.len() as u64 * u64::from(spec.tile).pow(2) * spec.pixel.0;
    let unit = |n: u32| Unit {
        doing: Doing::Nothing,
        tile: 0,
        store: BufferAllocator::new(spec.store.capacity.0 / u64::from(spec.units)),
        account: Account::new(stage, n),
    };
    let mut all = Blenders {
        spec,
        frame,
        memory: Memory::new(Ranges { end }, &STREAMS, machine.memory(), calibration),
        units: (0..spec.units).map(unit).collect(),
        next_tile: 0,
        end: 0,
        observer,
    };
    drive(&mut all, 0..spec.units as usize, 0);
    let end = all.end;
    all.memory.close(end);
    all.units.iter_mut().for_each(|unit| unit.account.up_to(end, all.observer));
    let store = hardware().buffer_called("blender-in").expect("declared");
    let timing = FrameTiming {
        frame: end,
        preprocessing_end: 0,
        units: vec![cycles(stage, 1, all.units.iter().map(|unit| &unit.account.ledger))],
        dram: all.memory.usage(),
        buffers: vec![usage(store, all.units.iter().map(|unit| &unit.store))],
        tile_cycles: Histogram::EMPTY,
    };
    let pixels: u64 = frame.regions.iter().map(|region| u64::from(region.pixels)).sum();
    let evaluated: u64 = frame.entries.iter().map(|entry| u64::from(entry.pixels)).sum();
    let counts = [
        ("alpha", evaluated),
        ("blend", evaluated),
        ("divide", pixels),
        ("sram-write.blender-in", read),
        ("sram-read.blender-in", read),
        ("dram-read", read),
        ("dram-write", pixels * spec.pixel.0),
    ];
    let mut actions = ActionCounts::default();
    for (key, n) in counts {
        actions.charge(Phase::Rendering, hardware().action_called(key).expect("declared"), n);
    }
    let outcome = FlowOutcome::plain(timing, actions, all.memory.traffic(), evaluated);
    (outcome, all.memory.recording())
}

/// The program, with one more dataflow.
fn main() -> ExitCode {
    flow::register(&UnsortedFlow).expect("nothing has asked for dataflows yet");
    powergs_sim::cli::main()
}
