//! Where the cycles go: per kind of unit, busy, stalls by cause, idle.

use super::{frames, subtitle};
use crate::format::{percent, significant};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_core::sim::statistics::UnitPart;
use powergs_core::stage::{From, Stall, stage};
use powergs_energy::action::StageId;
use powergs_study::findings::{Key, Record};
use powergs_study::run_record::Run;

const NAME: &str = "cycles";
const TITLE: &str = "Where the cycles go";
/// Title of the axis.
const SHARE: &str = "share of the unit's cycles, %";

/// Colours of waits for the memory, in their order: no machine has both the second and the last.
const OF_MEMORY: [Colour; 6] =
    [Colour::NAVY, Colour::BLUE, Colour::PURPLE, Colour::SKY, Colour::INK, Colour::BLUE];

/// Colours of waits for other units: those of tail units, late conversion and depth slices exclude
/// each other.
const OF_UNITS: [Colour; 2] = [Colour::YELLOW, Colour::INDIGO];

/// Colours of [`UnitPart::all`]: waits for the memory are blues, purple and black, others warm.
pub(crate) fn colours() -> Vec<Colour> {
    let (mut memory, mut units) = (OF_MEMORY.into_iter().cycle(), OF_UNITS.into_iter().cycle());
    let wait = |cause: Stall| match (cause, cause.words().from) {
        (Stall::INPUT, _) => Some(Colour::ORANGE),
        (Stall::OUTPUT, _) => Some(Colour::VERMILION),
        (_, From::Memory) => memory.next(),
        (_, From::Stage(_)) => units.next(),
        (Stall::BANK, _) => Some(Colour::GREY),
        (_, From::Neighbour) => Some(Colour::YELLOW),
    };
    let mut wait = wait;
    let of = |part| match part {
        UnitPart::Busy => Colour::GREEN,
        UnitPart::Stalled(cause) => wait(cause).unwrap_or(Colour::GREY),
        UnitPart::Idle => Colour::PALE,
    };
    UnitPart::all().map(of).collect()
}

/// The legend of [`colours`], without waits that nothing is drawn of.
pub(crate) fn entries(is_drawn: impl Fn(Stall) -> bool) -> impl Iterator<Item = Entry> {
    let entry = move |(part, colour)| {
        let name = match part {
            UnitPart::Busy => "busy".to_owned(),
            UnitPart::Stalled(cause) if is_drawn(cause) => waits(cause),
            UnitPart::Stalled(_) => return None,
            UnitPart::Idle => "no work".to_owned(),
        };
        Some(Entry::fill(name, colour))
    };
    UnitPart::all().zip(colours()).filter_map(entry)
}

/// What a unit waits for, in words.
pub(crate) fn waits(cause: Stall) -> String {
    format!("waits: {}", cause.words().short)
}

/// The axis of shares.
pub(crate) fn axis() -> Axis {
    Axis::new(SHARE, Scale::linear(0.0, 100.0)).ticks(10)
}

/// A bar of shares, each with its percentage where it has room.
pub(crate) fn bar(row: usize, shares: impl IntoIterator<Item = (f64, Colour)>) -> Bar {
    let part = |(share, colour): (f64, Colour)| {
        let value = share * 100.0;
        Part { value, colour, label: percent(share) }
    };
    Bar::new(row, shares.into_iter().map(part).collect())
}

/// What rows of a kind of unit are called: with the number of them.
pub(crate) fn unit(record: &Record, kind: StageId) -> String {
    format!("{} x{}", stage(kind).key, record.value(Key::Instances(kind)))
}

pub(super) fn chart(run: &Run, record: &Record) -> Option<Chart> {
    let busy = record.mean(Key::DramBusy)?;
    let colours = colours();
    let mut names: Vec<String> = record.units().map(|kind| unit(record, kind)).collect();
    let mut bars = Vec::new();
    let mut right = Vec::new();
    for (i, kind) in record.units().enumerate() {
        bars.push(bar(i, record.unit_shares(kind).into_iter().zip(colours.iter().copied())));
        let busy = record.value(Key::Busy(kind));
        let busy = format!("{} M cycles busy", significant(busy / 1e6));
        right.push((i as f64 + 0.5, vec![Words::note(busy)]));
    }
    // The data bus has a bar of its own: busy or not.
    let i = names.len();
    names.push("dram bus".into());
    let (at_work, idle) = (colours[0], colours[colours.len() - 1]);
    bars.push(bar(i, [(busy, at_work), (1.0 - busy, idle)]));
    right.push((i as f64 + 0.5, rates(run, record)));
    let mut panel = Panel::new(axis(), Axis::names(names)).mark(Mark::Bars(bars));
    panel.right = right;
    let chart = Chart::new(NAME, TITLE, subtitle(run, &frames(run)));
    Some(chart.legend(entries(|cause| record.has_cause(cause))).panel(panel))
}

/// The rate of the data bus, and its peak.
fn rates(run: &Run, record: &Record) -> Vec<Words> {
    let rate = record.mean(Key::DramRate).map(|r| format!("{} GB/s", significant(r)));
    let peak = run.facts.machine.dram_peak_gb_s;
    let peak = peak.map(|p| format!("of {} GB/s", significant(p)));
    rate.into_iter()
        .flat_map(|rate| [Some(rate), peak.clone()])
        .flatten()
        .map(Words::note)
        .collect()
}
