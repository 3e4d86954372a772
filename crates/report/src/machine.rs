//! A machine as a picture: its units with what each has, their buffers, and what they move from and
//! to DRAM. All of it is read off what its stages declare.

use std::collections::BTreeSet;

use powergs_chart::{Chart, Colour, Diagram, DiagramBlock, Words};
use powergs_core::kernel::stream::StreamDecl;
use powergs_core::machine::Machine;
use powergs_core::stage::{self, StageDecl, hardware};
use powergs_energy::action::{Inventory, Memory, Phase};

/// The picture of a machine that is linked to its DRAM device.
pub fn chart(machine: &Machine) -> Chart {
    let stages = ordered(there(machine));
    let subtitle = format!("{} dataflow, {}", machine.flow().key(), machine.clock);
    let mut chart = Chart::new("machine", machine.name.as_str(), subtitle);
    chart.diagram = Some(Diagram {
        memory: [Words::bold("DRAM"), Words::from(memory(machine))],
        blocks: stages.iter().map(|there| block(there, &stages, machine)).collect(),
    });
    chart.note("Of reads and writes, a frame has those that its features need.")
}

/// A stage that a machine has something of.
struct StageThere {
    decl: &'static StageDecl,
    units: u32,
    /// Names and sizes of its buffers.
    buffers: Vec<(&'static str, Memory)>,
    /// What one unit has: keys and amounts.
    parts: Vec<(&'static str, f64)>,
}

/// What a machine has, in report order. A machine may have units of other dataflows, where its
/// tables say so.
fn there(machine: &Machine) -> Vec<StageThere> {
    let (hardware, Inventory { memories, units, parts }) = (hardware(), machine.inventory());
    let all = hardware.stages().map(|(id, _)| {
        let decl = stage::stage(id);
        let own = hardware.buffers().filter(|(buffer, _)| hardware.stage_of(*buffer) == id);
        let buffers = own.map(|(buffer, facts)| (facts.name, memories[buffer.index()]));
        let amounts = hardware.parts().filter(|(_, of, _)| *of == id);
        let amounts = amounts.map(|(part, _, facts)| (facts.key, parts[part.index()]));
        StageThere {
            decl,
            units: units[id.index()],
            buffers: buffers.filter(|(_, memory)| memory.banks > 0).collect(),
            parts: amounts.filter(|(_, amount)| *amount > 0.0).collect(),
        }
    });
    // What is no unit may still have requests.
    let asks = |s: &StageThere| {
        let no_unit = s.decl.units.is_none() && machine.has_stage(s.decl.key);
        no_unit && !s.decl.streams.is_empty()
    };
    all.filter(|s| s.units > 0 || !s.buffers.is_empty() || asks(s)).collect()
}

/// The nearest stage before another that is there.
fn before(decl: &StageDecl, there: &[StageThere]) -> Option<&'static str> {
    let mut key = decl.within.or(decl.after)?;
    // A chain that comes back to itself ends somewhere, too.
    for _ in 0..=stage::stages().len() {
        if there.iter().any(|other| other.decl.key == key) {
            return Some(key);
        }
        key = stage::stages().iter().find(|other| other.key == key)?.after?;
    }
    None
}

/// Stages so that each is later than the one that it works on. Of what follows one stage, its parts
/// come first, then the shortest branch.
fn ordered(mut there: Vec<StageThere>) -> Vec<StageThere> {
    let parents: Vec<Option<&str>> = there.iter().map(|s| before(s.decl, &there)).collect();
    let keys: Vec<&str> = there.iter().map(|s| s.decl.key).collect();
    let parts: Vec<bool> = there.iter().map(|s| s.decl.within.is_some()).collect();
    let mut order = Vec::new();
    for (at, parent) in parents.iter().enumerate() {
        if parent.is_none() {
            let below = subtree(at, &keys, &parents, &parts);
            order.extend(below);
        }
    }
    let place = |s: &StageThere| keys.iter().position(|key| *key == s.decl.key);
    let rank = |s: &StageThere| order.iter().position(|at| Some(*at) == place(s));
    // Those of a circle have no rank and come first.
    there.sort_by_key(rank);
    there
}

fn subtree(at: usize, keys: &[&str], parents: &[Option<&str>], parts: &[bool]) -> Vec<usize> {
    let children = (0..keys.len()).filter(|child| parents[*child] == Some(keys[at]));
    let mut below: Vec<Vec<usize>> =
        children.map(|child| subtree(child, keys, parents, parts)).collect();
    below.sort_by_key(|branch| (!parts[branch[0]], branch.len()));
    std::iter::once(at).chain(below.into_iter().flatten()).collect()
}

fn block(there: &StageThere, stages: &[StageThere], machine: &Machine) -> DiagramBlock {
    let decl = there.decl;
    let is_part = decl.within.is_some();
    let after = before(decl, stages).filter(|_| !is_part);
    let counted = match (there.units, decl.has_lanes) {
        (0, _) if decl.units.is_none() => String::new(),
        (0, _) => "no units, their buffers alone".to_owned(),
        (1, false) => "1 unit".to_owned(),
        (n, false) => format!("{n} units"),
        (1, true) => "1 lane".to_owned(),
        (n, true) => format!("{n} lanes"),
    };
    // A space at which no line ends.
    let amount = |(key, amount): &(&str, f64)| {
        let amount = (amount * 1e3).round() / 1e3;
        format!("{key}\u{a0}{amount}")
    };
    let parts: Vec<String> = there.parts.iter().map(amount).collect();
    let parts = match parts.is_empty() {
        true => String::new(),
        false => format!("each: {}", parts.join(", ")),
    };
    let asks = machine.has_stage(decl.key);
    let moved = |is_write: bool| {
        let own = decl.streams.iter().filter(|stream| asks && stream.is_write == is_write);
        let own = own.filter(|stream| is_written(stream, stages));
        // A stream may be declared once for each phase.
        let keys: BTreeSet<&str> = own.clone().map(|stream| stream.key).collect();
        let mut left = keys;
        own.map(|stream| stream.key).filter(|key| left.remove(key)).collect::<Vec<_>>().join(", ")
    };
    DiagramBlock {
        title: decl.words.to_owned(),
        lines: vec![counted, parts, decl.phase.name().to_owned()],
        colour: colour(decl.phase),
        is_part,
        after: stages.iter().position(|other| Some(other.decl.key) == after),
        reads: moved(false),
        writes: moved(true),
        stores: there.buffers.iter().map(|(name, m)| [(*name).to_owned(), size(m)]).collect(),
    }
}

/// Whether what a stream reads was there before the frame, or a stage of the machine writes it.
fn is_written(stream: &StreamDecl, stages: &[StageThere]) -> bool {
    let written = stages.iter().flat_map(|there| there.decl.streams).filter(|s| s.is_write);
    let written: BTreeSet<&str> = written.map(|stream| stream.key).collect();
    stream.written_by.is_empty() || stream.written_by.iter().any(|key| written.contains(key))
}

/// `4 x 16 KiB`.
fn size(memory: &Memory) -> String {
    match memory.banks {
        1 => memory.bank.to_string(),
        banks => format!("{banks} x {}", memory.bank),
    }
}

/// `lpddr4x-3200, 4 channels, 25.6 GB/s`.
fn memory(machine: &Machine) -> String {
    let device = machine.device.as_ref().map(|device| format!("{}, ", device.name));
    let channels = match machine.dram.channels {
        1 => "1 channel".to_owned(),
        n => format!("{n} channels"),
    };
    format!("{}{channels}, {}", device.unwrap_or_default(), machine.dram_peak())
}

/// The colour of a phase; its name is in every block, for whoever sees no colours.
fn colour(phase: Phase) -> Colour {
    match phase {
        Phase::Preprocessing => Colour::SKY,
        Phase::Sorting => Colour::ORANGE,
        Phase::Rendering => Colour::GREEN,
        Phase::Standby => Colour::GREY,
    }
}
