//! Recorded: the run of a machine that is not modelled here, as another simulator tells it.
//!
//! A file of rows says, frame by frame, how many cycles the machine takes with a memory that
//! answers at once, how often it does what an energy table has a price for, and which bytes it
//! reads and writes, when, and when it needs them ([`mod@file`]). Its requests are timed by the
//! memory of the machine file: the run stands still while something that it needs is not there, and
//! while `recorded.outstanding` requests are under way. Everything behind that is as for other
//! dataflows: prices, area, statistics, sweeps over the memory and the clock.
//!
//! Frames are told apart by what is in them ([`Frame::id`]), so that a run is never taken for that
//! of another trace.

mod doubt;
pub mod file;
mod play;
mod tables;

use std::sync::Arc;

use super::{
    Dataflow, FlowDecl, FlowOutcome, FrameTask, Incompatible, Opener, SimError, TablesDecl, Task,
    Work, WorkKey, WorkKind,
};
use crate::kernel::stream::{Streams, reads, writes};
use crate::kernel::timeline::Observer;
use crate::machine::check::{Found, SIZE_MAX};
use crate::machine::{BufferSpec, Machine};
use crate::stage::{Bias, StageDecl, hardware, omit, streams, work};
use crate::workload::demand::Unbinnable;
use powergs_base::budget::Budget;
use powergs_base::config::suggest::nearest;
use powergs_energy::action::{Inventory, Phase};
use powergs_energy::hardware::PartFacts;
use powergs_frame::scene::ShDegree;
use powergs_frame::splat::Counters;
use powergs_frame::trace::Frame;

pub use file::{RecordedFrame, RecordedRun};
pub use play::calibration;
pub use tables::{Attached, PartAmount, Recorded, RecordedSpec, RecordedUnit};

const KEY: &str = "recorded";

/// What no dataflow of this program has.
pub const ENGINE: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<RecordedSpec>().count(ENGINE.key)),
    works: &[work("operation", 1, "What a unit does that is not modelled here.")],
    streams: &[
        read("recorded-read.preprocessing", Phase::Preprocessing),
        write("recorded-write.preprocessing", Phase::Preprocessing),
        read("recorded-read.sorting", Phase::Sorting),
        write("recorded-write.sorting", Phase::Sorting),
        read("recorded-read.rendering", Phase::Rendering),
        write("recorded-write.rendering", Phase::Rendering),
    ],
    also_waits: &["features"],
    omits: &[
        omit("what the simulator leaves out that made the run", Bias::Either, ""),
        omit("order of requests that another memory would bring about", Bias::Either, "A125"),
    ],
    behind: &["A125"],
    ..StageDecl::new(
        "engine",
        "units that are not modelled here",
        Phase::Rendering,
        "Whatever a machine has that no dataflow of this program knows.",
    )
};

const fn read(key: &'static str, phase: Phase) -> crate::kernel::stream::StreamDecl {
    reads(key, "what a recorded run reads", &[], [key, key]).of(phase)
}

const fn write(key: &'static str, phase: Phase) -> crate::kernel::stream::StreamDecl {
    writes(key, "what a recorded run writes", [key, key]).of(phase)
}

/// Its stages.
pub const STAGES: &[&StageDecl] = &[&ENGINE];

/// The dataflow with its stages.
pub const FLOW: FlowDecl = FlowDecl { flow: &RecordedFlow, stages: STAGES };

/// Their streams.
pub const STREAMS: Streams = streams(STAGES);

/// The dataflow.
pub struct RecordedFlow;

impl Dataflow for RecordedFlow {
    fn key(&self) -> &'static str {
        KEY
    }

    fn means(&self) -> &'static str {
        "a run that another simulator made: its cycles and counts, with the memory timed here"
    }

    fn stages(&self) -> &'static [&'static StageDecl] {
        FLOW.stages
    }

    fn tables(&self) -> TablesDecl {
        TablesDecl::of::<Recorded>()
    }

    /// Another simulator may issue requests of all phases at any time.
    fn overlaps(&self, _: &Machine) -> bool {
        true
    }

    fn task(&self, machine: &Machine) -> Task {
        Task::named(&machine.of_type::<RecordedSpec>().task).unwrap_or(Task::RENDER)
    }

    fn under_way(&self, machine: &Machine) -> u64 {
        u64::from(machine.of_type::<RecordedSpec>().under_way)
    }

    fn check(&self, machine: &Machine, found: &mut Found) {
        let spec = machine.of_type::<RecordedSpec>();
        if Task::named(&spec.task).is_none() {
            let message = format!(
                "`recorded.task` = \"{}\" must be what comparisons call a task: render, train all, \
                 train visible, gradients, track; of some pixels e.g. \"track, 1 pixel in 256\"",
                spec.task
            );
            found.add("recorded.task", message);
        }
        let units: Vec<&str> = hardware().units().map(|(_, unit)| unit.key).collect();
        if spec.units.is_empty() {
            let message = format!(
                "[recorded.units] names no units: without them the machine has no area and no \
                 leakage; add e.g. `{}.count = 4` (known: {})",
                ENGINE.key,
                units.join(", ")
            );
            found.add("recorded.units", message);
        }
        for (stage, unit) in &spec.units {
            let parts: Vec<&str> = parts_of(stage).map(|part| part.key).collect();
            let needed = parts_of(stage).filter(|part| !part.may_lack).map(|part| part.key);
            let lacks: Vec<&str> = needed.filter(|part| !unit.parts.contains_key(*part)).collect();
            let strange = unit.parts.keys().find(|part| !parts.contains(&part.as_str()));
            let wrong =
                unit.parts.iter().find(|(_, amount)| !(PART_MIN..PART_MAX).contains(&amount.0));
            let message = match (units.contains(&stage.as_str()), strange, &lacks[..], wrong) {
                (false, ..) => unknown("kind of unit", stage, &units),
                (true, Some(part), ..) => unknown(&format!("part of `{stage}`"), part, &parts),
                (true, None, [_, ..], _) => {
                    let keys = |part: &&str| format!("`recorded.units.{stage}.parts.{part}`");
                    format!(
                        "how much of `{}` has one of the {}? Set {}",
                        lacks.join("`, `"),
                        hardware_words(stage),
                        lacks.iter().map(keys).collect::<Vec<_>>().join(", ")
                    )
                }
                (true, None, [], Some((part, PartAmount(amount)))) => format!(
                    "`recorded.units.{stage}.parts.{part}` = {amount} must be at least {PART_MIN} \
                     and below {PART_MAX}"
                ),
                (true, None, [], None) => continue,
            };
            found.add("recorded.units", message);
        }
        let buffers: Vec<String> = hardware().buffers().map(|(_, buffer)| buffer.key()).collect();
        for name in spec.buffers.keys().filter(|name| !buffers.contains(name)) {
            let known: Vec<&str> = buffers.iter().map(String::as_str).collect();
            found.add("recorded.buffers", unknown("buffer", name, &known));
        }
        for (name, BufferSpec { capacity, word, .. }) in &spec.buffers {
            if *capacity > SIZE_MAX || word.0 == 0 {
                let message = format!(
                    "`recorded.buffers.{name}` must have at most {SIZE_MAX} and a word above 0 B"
                );
                found.add("recorded.buffers", message);
            }
        }
    }

    fn inventory(&self, machine: &Machine) -> Inventory {
        let (spec, hardware) = (machine.of_type::<RecordedSpec>(), hardware());
        let memory = |buffer: Option<&BufferSpec>| buffer.map(|spec| spec.shared(1));
        let amount =
            |stage: &str, key: &str| spec.units.get(stage)?.parts.get(key).map(|amount| amount.0);
        Inventory {
            memories: hardware
                .buffers()
                .map(|(_, buffer)| memory(spec.buffers.get(&buffer.key())).unwrap_or_default())
                .collect(),
            units: hardware.stages().map(|(_, stage)| spec.count(stage.key)).collect(),
            parts: hardware
                .parts()
                .map(|(_, stage, part)| amount(hardware.stage(stage).key, part.key).unwrap_or(0.0))
                .collect(),
        }
    }

    fn attach(&self, machine: &mut Machine, open: &mut Opener<'_>) -> Result<(), String> {
        let name = machine.of_type::<RecordedSpec>().file.clone();
        let run = RecordedRun::read(open(&name)?).map_err(|e| format!("{name}: {e}"))?;
        run.fits(machine.of_type()).map_err(|e| format!("{name}: {e}"))?;
        let all: &mut Recorded = machine.tables.all_mut().expect("a machine has its tables");
        all.recorded.run = Attached(Some(Arc::new(run)));
        Ok(())
    }

    fn keep(&self, machine: &mut Machine, old: &Machine) -> Result<(), String> {
        let (new, old) = (machine.tables.all_mut::<Recorded>(), old.tables.get::<RecordedSpec>());
        let (Some(Recorded { recorded: new }), Some(old)) = (new, old) else { return Ok(()) };
        let same = [
            ("file", new.file == old.file),
            ("units", new.units == old.units),
            ("buffers", new.buffers == old.buffers),
        ];
        if let Some((key, _)) = same.into_iter().find(|(_, is_same)| !is_same) {
            return Err(fixed(&format!("recorded.{key}")));
        }
        new.run = old.run.clone();
        Ok(())
    }

    fn fixed(&self, key: &str) -> Option<String> {
        let is = |own: &str| key == own || key.starts_with(&format!("{own}."));
        let all = ["recorded.file", "recorded.units", "recorded.buffers"];
        all.iter().any(|own| is(own)).then(|| fixed(key))
    }

    /// Requests and cycles of the run, whatever file it is in.
    fn timing(&self, machine: &Machine) -> Vec<u8> {
        let spec: &RecordedSpec = machine.of_type();
        let units: Vec<_> = spec.units.iter().map(|(key, unit)| (key, unit.count)).collect();
        let id = spec.run.get().map_or(0, |run| run.xxh3);
        serde_json::to_vec(&(machine.clock, spec.outstanding, units, format!("{id:032x}")))
            .expect("numbers and strings")
    }

    fn runs_any_frame(&self) -> bool {
        false
    }

    fn tile(&self, _: &Machine, [width, height]: [u32; 2]) -> [u32; 2] {
        [width.max(1), height.max(1)]
    }

    fn work_key(&self, _: &Machine) -> WorkKey {
        WorkKey { kind: &RecordedFrames, numbers: Vec::new() }
    }

    fn doubt(&self, machine: &Machine) -> Option<String> {
        let spec: &RecordedSpec = machine.of_type();
        spec.run.get()?.doubt(spec)
    }

    fn fits(&self, task: &FrameTask<'_>) -> Result<(), Incompatible> {
        frame_of(task).map(|_| ())
    }

    fn run(
        &self,
        task: &FrameTask<'_>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<FlowOutcome, SimError> {
        let frame = frame_of(task)?;
        Ok(match observer {
            None => play::run(task, frame, &mut ()),
            Some(mut observer) => play::run(task, frame, &mut observer),
        })
    }
}

/// Amounts of parts that are believed: as energy tables.
const PART_MIN: f64 = 1e-3;
const PART_MAX: f64 = 1e6;

/// That there is nothing with a name, what is most like it, and what there is.
fn unknown(kind: &str, name: &str, known: &[&str]) -> String {
    let near = nearest(name, known.iter().copied());
    let near = near.map_or_else(|| ".".to_owned(), |near| format!("; did you mean `{near}`?"));
    let all = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    format!("no {kind} `{name}`{near} Energy tables know: {all}")
}

fn hardware_words(stage: &str) -> &'static str {
    let hardware = hardware();
    hardware.stage_called(stage).map_or("units", |id| hardware.stage(id).words)
}

/// Why a key that describes a run cannot be changed.
fn fixed(key: &str) -> String {
    format!(
        "`{key}` says what the run was made with, and stays as it is: make a run of the other \
         machine, with a machine file of its own"
    )
}

/// The parts that one unit of a stage has.
fn parts_of(stage: &str) -> impl Iterator<Item = &'static PartFacts> {
    let parts = hardware().parts();
    parts.filter(move |(_, of, _)| hardware().stage(*of).key == stage).map(|(.., part)| part)
}

/// What a frame of a run goes by.
#[derive(Debug)]
struct FrameIdentity {
    id: u64,
    sh_degree: ShDegree,
    counters: Counters,
}

/// Frames by what is in them.
struct RecordedFrames;

impl WorkKind for RecordedFrames {
    fn name(&self) -> &'static str {
        KEY
    }

    fn demand(&self, _: &Frame, _: &[u32], _: Budget) -> Result<u64, Unbinnable> {
        Ok(size_of::<FrameIdentity>() as u64)
    }

    fn prepare(&self, frame: &Frame, _: &[u32]) -> Box<dyn Work> {
        Box::new(FrameIdentity {
            id: frame.id(),
            sh_degree: frame.facts.colour_degree(),
            counters: Counters {
                points: frame.facts.points,
                survivors: frame.facts.survivors,
                intersecting_points: frame.splats.len() as u64,
                blends: frame.pixels.blended.iter().map(|n| u64::from(*n)).sum(),
                ..Counters::default()
            },
        })
    }
}

impl Work for FrameIdentity {
    fn key(&self) -> WorkKey {
        WorkKey { kind: &RecordedFrames, numbers: Vec::new() }
    }

    fn counters(&self) -> &Counters {
        &self.counters
    }

    fn sh_degree(&self) -> ShDegree {
        self.sh_degree
    }

    fn tiles(&self) -> usize {
        1
    }

    fn bytes(&self) -> usize {
        size_of::<FrameIdentity>()
    }
}

/// What the run of a machine has of a frame.
fn frame_of<'a>(task: &FrameTask<'a>) -> Result<&'a RecordedFrame, Incompatible> {
    let machine = task.machine;
    let other = |why: String| Incompatible::Other { machine: machine.name.clone(), why };
    let Some(work) = task.work.of::<FrameIdentity>() else {
        return Err(Incompatible::Work {
            work: task.work.key().to_string(),
            machine: machine.name.clone(),
            needed: RecordedFlow.work_key(machine).to_string(),
        });
    };
    let spec: &RecordedSpec = machine.of_type();
    let run = spec.run.get().ok_or_else(|| other("its run has not been read".into()))?;
    run.frames.get(&work.id).ok_or_else(|| {
        other(format!(
            "`{}` has no frame {:016x}, which is frame {} of the trace; it has {}. Another trace, \
             or frames that were not run: `powergs-sim trace dump TRACE --frame {} --what facts` \
             says the `id` of a frame, `--frames` leaves out frames",
            spec.file,
            work.id,
            task.frame,
            run.told_frames(),
            task.frame,
        ))
    })
}
