//! What a machine file says of the core of `rtl/`, and what it cannot say.

use std::collections::BTreeMap;

use super::bench::REGION;
use powergs_base::quantity::Bytes;
use powergs_core::machine::Machine;
use powergs_sim::cli::{Exit, Failure, inputs};

/// The machine file of the core.
pub const CHIP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/chip.toml");

/// Keys that the core has parameters for, and those that it does not know: of the units in front
/// of the lists, and of times that only the model is told.
const FREE: [&str; 16] = [
    "geometry.chunk",
    "vru.cores",
    "vru.speculation",
    "vru.subtile-queue",
    "vru.latency",
    "vru.stop-latency",
    "gsu.qsu-latency",
    "gsu.bsu-latency",
    "buffers.sorting.capacity",
    "buffers.feature.capacity",
    "buffers.pixel-out.capacity",
    "buffers.gaussian-in.",
    "buffers.tile-list.",
    "binning.",
    "ccu.",
    "record.projected",
];

/// Entries of a row of the sorting and of the feature buffer.
const ROW: u64 = 16;
/// Pixels of a tile.
const PIXELS: u64 = 256;
/// Chunks in the feature buffer of a core, at most.
const SLOTS: u32 = 8;

/// Parameters of `chip.sv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Design {
    /// Names with values.
    pub parameters: Vec<(&'static str, u32)>,
    /// Entries of a chunk.
    pub chunk: usize,
    /// Entries that the sorting buffer of a core has room for.
    pub entries: usize,
    /// Cores.
    pub cores: u32,
    /// Whether it makes its lists.
    pub front: bool,
    /// Entries of a sub-tile's queue.
    pub queue: usize,
}

impl Design {
    /// The core that is `machine`, with a front or without.
    ///
    /// # Errors
    /// A key that the RTL has no other value of, or a value that it cannot have.
    pub fn of(machine: &Machine, front: bool) -> Result<Design, Failure> {
        let own = inputs::system(CHIP, &[], None)?;
        let (own, theirs) = (keys(own.machine()), keys(machine));
        let fixed = |key: &&String| !FREE.iter().any(|free| key.starts_with(free));
        for key in own.keys().chain(theirs.keys()).filter(fixed) {
            let (own, theirs) = (own.get(key), theirs.get(key));
            if own != theirs {
                let told =
                    |value: Option<&String>| value.map_or("nothing", String::as_str).to_owned();
                return Err(refused(
                    key,
                    &told(theirs),
                    &format!("the RTL has {} only", told(own)),
                ));
            }
        }
        let (tiles, chunk) = (machine.tiles(), machine.tiles().geometry.chunk);
        if chunk == 0 || chunk > 256 || !chunk.is_multiple_of(16) {
            return Err(refused("geometry.chunk", &chunk, "a multiple of 16, at most 256"));
        }
        let share = |key: &str, capacity: Bytes, unit: u64| {
            let all = unit * u64::from(tiles.vru.cores);
            let rows = u32::try_from(capacity.0 / all).unwrap_or(u32::MAX);
            let is_whole = capacity.0.is_multiple_of(all) && (2..=4096).contains(&rows);
            let must = format!("2 to 4096 times {unit} B for each core");
            if is_whole { Ok(rows) } else { Err(refused(key, &capacity, &must)) }
        };
        let buffers = &tiles.buffers;
        let rows =
            share("buffers.sorting.capacity", buffers.sorting.capacity, ROW * tiles.list_entry())?;
        let features = share(
            "buffers.feature.capacity",
            buffers.feature.capacity,
            ROW * tiles.record.feature.0,
        )?;
        let held = share(
            "buffers.pixel-out.capacity",
            buffers.pixel_out.capacity,
            PIXELS * tiles.record.pixel.0,
        )?;
        if !features.is_power_of_two() || features < chunk.div_ceil(16) {
            let must = "a power of two for each core, and room for a chunk";
            return Err(refused("buffers.feature.capacity", &buffers.feature.capacity, must));
        }
        let queue = tiles.vru.subtile_queue;
        if !(2..=64).contains(&queue) {
            return Err(refused("vru.subtile-queue", &queue, "2 to 64"));
        }
        let (cores, ahead) = (tiles.vru.cores, tiles.vru.speculation);
        if !(1..=32).contains(&cores) {
            return Err(refused("vru.cores", &cores, "1 to 32"));
        }
        let units = tiles.ccu.units;
        if front && units != 1 {
            return Err(refused("ccu.units", &units, "a chip has one"));
        }
        // No list is longer than the sorting buffer, and no part is split more than twice.
        let chunks = (4 * rows * ROW as u32).div_ceil(chunk).clamp(8, 64).next_power_of_two();
        Ok(Design {
            parameters: vec![
                ("CORES", cores),
                ("FRONTS", u32::from(front)),
                ("REGION", REGION),
                ("ROWS", rows),
                ("CHUNK", chunk),
                ("CHUNKS", chunks),
                ("FEATURES", features),
                ("SLOTS", SLOTS),
                ("AHEAD", ahead.min(SLOTS)),
                ("QUEUE", queue),
                ("TILES", held),
            ],
            chunk: chunk as usize,
            // A list that is split needs a row more for each of its eight parts.
            entries: (rows as usize).saturating_sub(8).max(1) * ROW as usize,
            cores,
            front,
            queue: queue as usize,
        })
    }
}

fn refused(key: &str, value: &dyn std::fmt::Display, must: &str) -> Failure {
    Failure::new(Exit::Usage, format!("{key} = {value}: {must}"))
}

/// All keys of the tables of a machine, with their values.
fn keys(machine: &Machine) -> BTreeMap<String, String> {
    fn collect(at: &str, value: &toml::Value, into: &mut BTreeMap<String, String>) {
        match value {
            toml::Value::Table(table) => {
                for (key, value) in table {
                    let at = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
                    collect(&at, value, into);
                }
            }
            leaf => {
                into.insert(at.to_owned(), leaf.to_string());
            }
        }
    }
    let mut all = BTreeMap::new();
    collect("", &toml::Value::Table(machine.tables.to_toml()), &mut all);
    all
}
