//! The entries of the catalogue, group by group.

mod cost;
mod fovea;
mod machine;
mod memory;

use super::{Key, Kind, Statistic, Value, Weight};
use crate::flow::{self, Dataflow};
use crate::sim::{FrameReport, StageBytes};
use crate::stage::{stage, stages};
use powergs_energy::action::{Phase, StageId};
use powergs_frame::splat::Counters;

pub(super) fn all() -> Vec<Statistic> {
    let mut list = Vec::new();
    time(&mut list);
    cost::power(&mut list);
    cost::energy(&mut list);
    cost::area(&mut list);
    bytes(&mut list);
    counters(&mut list);
    machine::units(&mut list);
    machine::tiles(&mut list);
    memory::dram(&mut list);
    memory::buffers(&mut list);
    measured(&mut list);
    fovea::fovea(&mut list);
    machine::actions(&mut list);
    list
}

type List = Vec<Statistic>;

fn count(
    list: &mut List,
    name: impl Into<String>,
    unit: &'static str,
    definition: impl Into<String>,
    read: impl Fn(&FrameReport) -> Option<u64> + Send + Sync + 'static,
) {
    list.push(Statistic {
        name: name.into(),
        unit,
        definition: definition.into(),
        kind: Kind::Count,
        weight: Weight::Frame,
        flows: Vec::new(),
        read: Box::new(move |frame, _| read(frame).map(Value::Count)),
    });
}

/// A measure; a value that is not finite counts as not measured.
fn real(
    list: &mut List,
    name: impl Into<String>,
    unit: &'static str,
    definition: impl Into<String>,
    read: impl Fn(&FrameReport, f64) -> Option<f64> + Send + Sync + 'static,
) {
    weighted(list, Weight::Frame, name, unit, definition, read);
}

/// A measure whose mean over frames is weighted.
fn weighted(
    list: &mut List,
    weight: Weight,
    name: impl Into<String>,
    unit: &'static str,
    definition: impl Into<String>,
    read: impl Fn(&FrameReport, f64) -> Option<f64> + Send + Sync + 'static,
) {
    list.push(Statistic {
        name: name.into(),
        unit,
        definition: definition.into(),
        kind: Kind::Real,
        weight,
        flows: Vec::new(),
        read: Box::new(move |frame, fps| {
            read(frame, fps).filter(|x| x.is_finite()).map(Value::Real)
        }),
    });
}

/// Says that statistics are of machines of the dataflows that have one of these stages.
fn of_stages(statistics: &mut [Statistic], stages: impl IntoIterator<Item = StageId>) {
    let keys: Vec<&str> = stages.into_iter().map(|id| stage(id).key).collect();
    let has = |flow: &&'static dyn Dataflow| flow.stages().iter().any(|s| keys.contains(&s.key));
    let flows: Vec<&str> = flow::all().filter(has).map(|flow| flow.key()).collect();
    statistics.iter_mut().for_each(|statistic| statistic.flows.clone_from(&flows));
}

/// What stages measure, each number once: flows may have it in common.
fn measured(list: &mut List) {
    for stat in stages().iter().flat_map(|stage| stage.stats).filter(|stat| stat.is_shown()) {
        if list.iter().any(|known| known.name == stat.name) {
            continue;
        }
        let has = |flow: &&'static dyn Dataflow| {
            flow.stages().iter().any(|stage| stage.stats.contains(stat))
        };
        list.push(Statistic {
            name: stat.name.into(),
            unit: stat.unit,
            definition: stat.means.into(),
            kind: if stat.is_count() { Kind::Count } else { Kind::Real },
            weight: Weight::Frame,
            flows: flow::all().filter(has).map(|flow| flow.key()).collect(),
            read: Box::new(move |frame, _| {
                let cycle = frame.cycle()?;
                stat.value(&cycle.measured, cycle.clock.0)
            }),
        });
    }
}

fn missed(frame: &FrameReport, fps: f64) -> Option<u64> {
    let has_deadline = frame.cycle().is_some() && frame.task().is_shown();
    has_deadline.then(|| u64::from(frame.misses_deadline(fps)))
}

fn time(list: &mut List) {
    real(list, Key::FrameTime, "ms", "`frame_interval_ms`, by its name of before.", |f, _| {
        f.frame_time_s().map(|s| s * 1e3)
    });
    real(
        list,
        Key::FrameInterval,
        "ms",
        "Simulated time from one frame to the next where they run back to back; of a trainer, from \
         one step to the next. Rates and deadlines are of it.",
        |f, _| f.frame_time_s().map(|s| s * 1e3),
    );
    real(
        list,
        Key::FrameLatency,
        "ms",
        "Simulated time of a frame from the first record read to the last pixel written: \
         `frame_interval_ms` where a machine has one frame under way, twice that where it has two \
         (`overlap` = \"frames\" of `schedule`, `front`, `attached`; A81), of pairs once and a \
         half.",
        |f, _| f.latency_s().map(|s| s * 1e3),
    );
    real(
        list,
        "achieved_fps",
        "1/s",
        "Frame rate if every frame took as long as this one: 1000 / `frame_time_ms`. The rate of a \
         run is its `throughput_fps`, not the mean of this.",
        |f, _| f.achieved_fps(),
    );
    weighted(
        list,
        Weight::Displayed,
        Key::DisplayedFps,
        "1/s",
        "Frames per second that the display gets: `fps`, or `achieved_fps` where the frame misses \
         the display rate, and of steps, which no display shows; the mean is frames over the time \
         for which they are shown.",
        |f, fps| Some(f.displayed_fps(fps)),
    );
    list.push(Statistic {
        name: Key::DeadlineMissed.name(),
        unit: "1",
        definition: "1 if `frame_interval_ms` is longer than the display period 1 / `fps`, else \
                     0; the mean is the share of missed frames. Absent for steps of training and \
                     tracking, which no display waits for."
            .into(),
        kind: Kind::Count,
        weight: Weight::Frame,
        flows: Vec::new(),
        read: Box::new(|f, fps| missed(f, fps).map(Value::Count)),
    });
    list.push(Statistic {
        name: Key::DisplayPeriods.name(),
        unit: "1",
        definition: "Whole display periods for which the frame is shown where pictures change \
                     between periods alone (vertical synchronisation): `fps` over the mean is the \
                     rate that is seen."
            .into(),
        kind: Kind::Count,
        weight: Weight::Frame,
        flows: Vec::new(),
        read: Box::new(|f, fps| f.display_periods(fps).map(Value::Count)),
    });
    count(list, Key::FrameCycles, "cycles", "Length of the frame in clock cycles.", |f| {
        Some(f.timing()?.frame)
    });
    count(
        list,
        Key::PreprocessingCycles,
        "cycles",
        "Cycles until the last CCU was done and sorting could begin.",
        |f| Some(f.timing()?.preprocessing_end),
    );
}

/// A column of [`StageBytes`]: of all stages, of one, definition, field.
type EntryColumn = (Key, fn(Phase) -> Key, &'static str, fn(&StageBytes) -> u64);

const COLUMNS: [EntryColumn; 3] = [
    (Key::ReadBytes, Key::StageRead, "Bytes read from DRAM", |s| s.read),
    (Key::WriteBytes, Key::StageWrite, "Bytes written to DRAM", |s| s.write),
    (Key::SramBytes, Key::StageSram, "Bytes moved in or out of on-chip buffers", |s| s.sram),
];

/// FLOPs are counted by the `paper` model only; the `cycle` model counts actions.
fn flops(frame: &FrameReport, stages: &[usize]) -> Option<u64> {
    frame.cycle().is_none().then(|| stages.iter().map(|&i| frame.stages[i].flops).sum())
}

fn bytes(list: &mut List) {
    for (all, _, text, field) in COLUMNS {
        let text = format!("{text}, all stages.");
        count(list, all, "B", text, move |f| Some(f.stages.iter().map(field).sum()));
    }
    let text = "Floating-point operations, all stages (`paper` model only).";
    count(list, "flops", "1", text, |f| flops(f, &[0, 1, 2]));
    for (i, stage) in Phase::WORK.into_iter().enumerate() {
        for (_, of, text, field) in COLUMNS {
            let text = format!("{text} by {}.", cost::stage_words(stage));
            count(list, of(stage), "B", text, move |f| Some(field(&f.stages[i])));
        }
        let text =
            format!("Floating-point operations of {} (`paper` only).", cost::stage_words(stage));
        count(list, format!("stages.{}.flops", stage.name()), "1", text, move |f| flops(f, &[i]));
    }
}

/// A workload counter: name, definition, field.
type Counter = (&'static str, &'static str, fn(&Counters) -> u64);

const COUNTERS: [Counter; 10] = [
    ("points", "Gaussians in the scene.", |c| c.points),
    ("survivors", "Gaussians that passed the near-plane cull.", |c| c.survivors),
    ("tile_pairs", "Accepted (splat, tile) pairs.", |c| c.tile_pairs),
    ("intersecting_points", "Splats with at least one accepted tile.", |c| c.intersecting_points),
    ("fetched_points", "Splats loaded by at least one tile.", |c| c.fetched_points),
    (
        "obb_tests",
        "Tiles tested against an oriented box; a splat with one candidate tile needs no test.",
        |c| c.obb_tests,
    ),
    ("obb_prepared", "Splats that needed box tests at all.", |c| c.obb_prepared),
    (
        "tile_loads",
        "List entries loaded, in whole chunks until their tile is done, summed over tiles.",
        |c| c.tile_loads,
    ),
    (
        "alpha_evaluations",
        "Entries that pixels iterate until they stop, the terminating one included (T_bf_term).",
        |c| c.alpha_evaluations,
    ),
    (
        "blends",
        "Entries that reach α ≥ 1/255 before their pixel stops, the terminating one included \
         (T_used).",
        |c| c.blends,
    ),
];

fn counters(list: &mut List) {
    count(
        list,
        "counters.sh_degree",
        "1",
        "Degree of the scene's spherical harmonics, 0 to 3. Decides the bytes and the operations \
         of a colour; a frame whose trace does not say it (format 1) counts as degree 3.",
        |f| f.sh_degree.map(|degree| u64::from(degree.get())),
    );
    for (name, text, field) in COUNTERS {
        count(list, format!("counters.{name}"), "1", text, move |f| Some(field(&f.counters)));
    }
    count(
        list,
        "counters.alpha_evaluations_executed",
        "1",
        "α evaluations that the machine executes: every pixel of every live sub-tile that is not \
         skipped.",
        |f| Some(f.cycle()?.executed_evaluations),
    );
    count(
        list,
        "counters.live_evaluations",
        "1",
        "Those of `counters.alpha_evaluations_executed` whose pixel has not stopped: what the \
         machine executes to some purpose.",
        |f| Some(f.cycle()?.live_evaluations),
    );
}
