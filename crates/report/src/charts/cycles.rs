//! Where the cycles go: per kind of unit, busy, stalls by cause, idle.

use super::{frames, subtitle};
use crate::format::{percent, significant};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_core::accel::Stall;
use powergs_energy::action::UnitKind;
use powergs_study::findings::{Key, Record};
use powergs_study::run_record::Run;

const NAME: &str = "cycles";
const TITLE: &str = "Where the cycles go";
/// Title of the axis.
const SHARE: &str = "share of the unit's cycles, %";

/// Colours of [`Record::UNIT_PARTS`]: waits for DRAM are blues and purple, other waits are warm.
pub(crate) const COLOURS: [Colour; Record::UNIT_PARTS.len()] = [
    Colour::GREEN,
    Colour::NAVY,
    Colour::BLUE,
    Colour::PURPLE,
    Colour::SKY,
    Colour::ORANGE,
    Colour::VERMILION,
    Colour::GREY,
    Colour::PALE,
];

/// The legend of [`COLOURS`].
pub(crate) fn entries() -> impl Iterator<Item = Entry> {
    let waits = Stall::ALL.map(waits);
    let names = ["busy"].into_iter().chain(waits).chain(["no work"]);
    names.zip(COLOURS).map(|(name, colour)| Entry::fill(name, colour))
}

/// What a unit waits for, in words.
pub(crate) fn waits(cause: Stall) -> &'static str {
    match cause {
        Stall::Records => "waits: records from DRAM",
        Stall::List => "waits: list of the tile",
        Stall::Spill => "waits: spilled keys",
        Stall::Features => "waits: features from DRAM",
        Stall::Input => "waits: unit before it",
        Stall::Output => "waits: room behind it",
        Stall::Bank => "waits: buffer bank",
    }
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
pub(crate) fn unit(record: &Record, kind: UnitKind) -> String {
    format!("{} x{}", kind.name(), record.value(Key::Instances(kind)))
}

pub(super) fn chart(run: &Run, record: &Record) -> Option<Chart> {
    let busy = record.mean(Key::DramBusy)?;
    let mut names: Vec<String> = UnitKind::ALL.map(|kind| unit(record, kind)).into();
    let mut bars = Vec::new();
    let mut right = Vec::new();
    for (i, kind) in UnitKind::ALL.into_iter().enumerate() {
        bars.push(bar(i, record.unit_shares(kind).into_iter().zip(COLOURS)));
        let busy = record.value(Key::Busy(kind));
        let busy = format!("{} M cycles busy", significant(busy / 1e6));
        right.push((i as f64 + 0.5, vec![Words::note(busy)]));
    }
    // The data bus has a bar of its own: busy or not.
    let i = names.len();
    names.push("dram bus".into());
    let idle = COLOURS[COLOURS.len() - 1];
    bars.push(bar(i, [(busy, COLOURS[0]), (1.0 - busy, idle)]));
    right.push((i as f64 + 0.5, rates(run, record)));
    let mut panel = Panel::new(axis(), Axis::names(names)).mark(Mark::Bars(bars));
    panel.right = right;
    let chart = Chart::new(NAME, TITLE, subtitle(run, &frames(run)));
    Some(chart.legend(entries()).panel(panel))
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
