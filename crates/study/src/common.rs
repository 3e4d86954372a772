//! One memory for machines that are compared: that of the first, at its price and with its PHY.

use powergs_core::run::files::Files;
use powergs_core::run::{FileKind, RunError, System};
use toml::{Table, Value};

/// Tables of a machine file, and of an energy table, that are of the memory.
const OF_MEMORY: [(FileKind, &[&str]); 2] =
    [(FileKind::Machine, &["dram"]), (FileKind::Energy, &["dram", "phy"])];

/// A machine that keeps its own memory.
#[derive(Debug)]
pub struct KeptMemory {
    /// Its name.
    pub machine: String,
    /// Why it cannot have the other one.
    pub why: RunError,
}

/// Gives all machines the memory of the first: device, channels, model, second master, prices, PHY
/// and controllers. Those that cannot have it keep theirs, and are named.
///
/// # Errors
/// [`RunError::Request`]: the first has a mere rate in place of a device, which says nothing of
/// prices.
pub fn one_memory(
    systems: Vec<System>,
    files: &dyn Files,
) -> Result<(Vec<System>, Vec<KeptMemory>), RunError> {
    let first = systems.first().cloned();
    let Some(first) = first else { return Ok((systems, Vec::new())) };
    if !first.machine().dram.has_device() {
        return Err(RunError::Request(format!(
            "machine `{}` has a mere rate for a memory (`dram.device` = \"none\"): begin with a \
             machine that has a device, or name one in all with --set dram.device=NAME",
            first.label()
        )));
    }
    let (mut all, mut kept) = (Vec::with_capacity(systems.len()), Vec::new());
    for system in systems {
        match with_memory_of(&system, &first, files) {
            Ok(same) => all.push(same),
            Err(why) => {
                kept.push(KeptMemory { machine: system.label(), why });
                all.push(system);
            }
        }
    }
    Ok((all, kept))
}

/// A machine with the memory of another one.
fn with_memory_of(system: &System, first: &System, files: &dyn Files) -> Result<System, RunError> {
    let mut system = system.clone();
    // Prices first: a device has no price in a table of a mere rate.
    for (kind, tables) in OF_MEMORY.into_iter().rev() {
        let (Some(theirs), Some(own)) = (first.table(kind), system.table(kind)) else { continue };
        let changed = replaced(own, &theirs, tables);
        system = system.with_table(kind, &changed, files)?;
    }
    Ok(system)
}

/// A file with some of its tables as another one has them.
fn replaced(mut own: Table, theirs: &Table, tables: &[&str]) -> Table {
    for &name in tables {
        match theirs.get(name) {
            Some(Value::Table(table)) => _ = own.insert(name.to_owned(), table.clone().into()),
            _ => _ = own.remove(name),
        }
    }
    own
}
