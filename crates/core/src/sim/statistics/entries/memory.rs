//! DRAM activity and buffer occupancy.

use super::of_stages;
use super::{List, count, real};
use crate::kernel::{BufferUse, DramUse, FrameTiming};
use crate::machine::MASTERS;
use crate::sim::statistics::Key;
use crate::sim::{CycleReport, FrameReport};
use crate::stage::hardware;
use powergs_dram::{DramCommands, StageCommands};
use powergs_energy::action::{BufferId, Phase};

fn usage(frame: &FrameReport) -> Option<&DramUse> {
    Some(&frame.timing()?.dram)
}

fn commands(frame: &FrameReport) -> Option<&DramCommands> {
    usage(frame)?.commands.as_ref()
}

pub(super) fn dram(list: &mut List) {
    count(list, "dram.requests", "1", "Requests issued to the DRAM, all served.", |f| {
        Some(usage(f)?.requests_served)
    });
    count(list, "dram.busy_cycles", "cycles", "Cycles in which the data bus moved data.", |f| {
        Some(usage(f)?.busy_cycles)
    });
    real(
        list,
        Key::DramBusy,
        "1",
        "Share of the frame in which the data bus moved data, 0 to 1.",
        |f, _| f.timing().map(FrameTiming::dram_busy_frac),
    );
    real(
        list,
        Key::DramRate,
        "GB/s",
        "DRAM bytes read and written over the whole frame time, in 10⁹ bytes per second.",
        |f, _| f.cycle().map(CycleReport::dram_bandwidth_gb_s),
    );
    count(
        list,
        Key::UnwrittenBytes,
        "B",
        "Bytes that rendering read and that nobody wrote: features, on a machine whose \
         `record.feature-source` is `nobody` because a published count has no writes for them.",
        |f| f.cycle().map(|cycle| cycle.unwritten_bytes),
    );
    (0..MASTERS.len()).for_each(|place| master(list, place));
    moved(list);
    device(list);
}

/// What another master of the memory gets. Of a third and a fourth one nothing is said where there
/// is none.
fn master(list: &mut List, place: usize) {
    let name = MASTERS[place];
    let bytes = move |f: &FrameReport| {
        let bytes = usage(f)?.master_bytes[place];
        (bytes > 0 || place == 0).then_some(bytes)
    };
    count(
        list,
        format!("dram.{name}_master_bytes"),
        "B",
        format!(
            "Bytes that the {name} master (`dram.{name}-master`) asked for in the frame and that \
             were served. They are in `dram.busy_cycles`, and in no other number of bytes and no \
             energy."
        ),
        bytes,
    );
    real(
        list,
        Key::MasterRate(place),
        "GB/s",
        format!(
            "The same over the frame time, in 10⁹ bytes per second: below \
             `dram.{name}-master.rate` where the memory is too slow for all."
        ),
        move |f, _| {
            let seconds = f.frame_time_s().filter(|&s| s > 0.0)?;
            Some(bytes(f)? as f64 * 1e-9 / seconds)
        },
    );
}

fn moved_bytes(frame: &FrameReport) -> Option<u64> {
    commands(frame).map(DramCommands::moved_bytes)
}

fn moved(list: &mut List) {
    count(
        list,
        "dram.requested_bytes",
        "B",
        "Bytes that the units asked for, read and written.",
        |f| usage(f).map(DramUse::requested_bytes),
    );
    count(
        list,
        "dram.moved_bytes",
        "B",
        "Bytes that the bursts of the device moved; only the models that know the device have \
         bursts.",
        moved_bytes,
    );
    real(
        list,
        Key::MovedPerRequested,
        "1",
        "`dram.moved_bytes` over `dram.requested_bytes`: above 1 where records do not fill their \
         bursts.",
        |f, _| Some(moved_bytes(f)? as f64 / usage(f)?.requested_bytes() as f64),
    );
}

/// A command count: name of that of all stages, key of that of one, definition, field.
type MemoryColumn = (&'static str, fn(Phase) -> Key, &'static str, fn(&StageCommands) -> u64);

const COLUMNS: [MemoryColumn; 3] = [
    ("dram.reads", Key::BurstsRead, "Bursts read", |s| s.reads),
    ("dram.writes", Key::BurstsWritten, "Bursts written", |s| s.writes),
    ("dram.activates", Key::RowsOpened, "Rows opened", |s| s.activates),
];

fn device(list: &mut List) {
    for (name, _, text, field) in COLUMNS {
        count(list, name, "1", format!("{text}, all stages."), move |f| {
            Some(commands(f)?.stages.iter().map(field).sum())
        });
    }
    count(list, "dram.precharges", "1", "Rows closed, all stages.", |f| {
        Some(commands(f)?.precharges)
    });
    let text = "Refreshes, of one channel and all its banks each.";
    count(list, "dram.refreshes", "1", text, |f| Some(commands(f)?.refreshes));
    let text = "Share of the bursts that found their row open: 1 - `dram.activates` over bursts.";
    real(list, Key::RowHits, "1", text, |f, _| commands(f)?.total().row_hit_frac());
    for (i, stage) in Phase::WORK.into_iter().enumerate() {
        for (_, of, text, field) in COLUMNS {
            let text = format!("{text} for {}.", super::cost::stage_words(stage));
            count(list, of(stage), "1", text, move |f| Some(field(&commands(f)?.stages[i])));
        }
        let text = format!(
            "Share of the bursts for {} that found their row open.",
            super::cost::stage_words(stage)
        );
        real(list, format!("dram.stages.{}.row_hit_frac", stage.name()), "1", text, move |f, _| {
            commands(f)?.stages[i].row_hit_frac()
        });
    }
}

fn buffer(frame: &FrameReport, which: BufferId) -> Option<&BufferUse> {
    frame.timing()?.buffer(which)
}

/// A count of one buffer: key, definition, field.
type MemoryField = (fn(BufferId) -> Key, &'static str, fn(&BufferUse) -> u64);

const FIELDS: [MemoryField; 5] = [
    (Key::Capacity, "Size of the {} buffer, all shares together", |b| b.capacity),
    (Key::Peak, "The most that the {} buffer held", |b| b.peak),
    (Key::Filled, "Bytes that entered the {} buffer", |b| b.filled),
    (Key::Consumed, "Bytes that left the {} buffer because they had been used", |b| b.consumed),
    (Key::Discarded, "Bytes that left the {} buffer unused", |b| b.discarded),
];

pub(super) fn buffers(list: &mut List) {
    for (which, facts) in hardware().buffers().filter(|(_, facts)| facts.fills) {
        let first = list.len();
        for (of, text, field) in FIELDS {
            let text = format!("{}.", text.replace("{}", facts.name));
            count(list, of(which), "B", text, move |f| Some(field(buffer(f, which)?)));
        }
        let text = format!("What the {} buffer held on average over the frame.", facts.name);
        real(list, Key::Held(which), "B", text, move |f, _| {
            let cycles = f.timing()?.frame as f64;
            Some(buffer(f, which)?.byte_cycles as f64 / cycles)
        });
        of_stages(&mut list[first..], [hardware().stage_of(which)]);
    }
}
