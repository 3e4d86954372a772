//! What a machine file says of the core of `rtl/`, and what it cannot say.

use std::collections::BTreeMap;

use powergs_base::quantity::Bytes;
use powergs_core::flow::tile_wise::TileWise;
use powergs_core::machine::Machine;
use powergs_sim::cli::{Exit, Failure, inputs};

/// The machine file of the core.
pub const CHIP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/chip.toml");

/// Keys that the core has parameters for, and those that it does not know: times that only the
/// model is told.
const FREE: [&str; 11] = [
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
];

/// The same of a front.
const FREE_OF_FRONT: [&str; 9] = [
    "ccu.units",
    "buffers.gaussian-in.capacity",
    "ccu.latency",
    "ccu.operations",
    "ccu.operations-per-cycle",
    "ccu.cull-operations-per-cycle",
    "ccu.colour-operations-per-cycle",
    "binning.combining.capacity",
    "binning.block",
];

/// Tables of which cores alone know nothing.
const FREE_OF_CORES: [&str; 5] =
    ["buffers.gaussian-in.", "buffers.tile-list.", "binning.", "ccu.", "record.projected"];

/// Operators of a front, those of culling, projection and colours, and cycles that a Gaussian holds
/// each of them: what programs there are in `rtl/ccu_program_pkg.sv`.
const ENGINES: [([u32; 3], [u32; 3]); 4] = [
    ([2, 4, 2], [6, 52, 59]),
    ([2, 8, 4], [6, 26, 30]),
    ([3, 16, 8], [3, 12, 15]),
    ([5, 32, 16], [2, 6, 9]),
];

/// Entries of a row of the sorting and of the feature buffer.
const ROW: u64 = 16;
/// Pixels of a tile.
const PIXELS: u64 = 256;
/// The logarithm of the bytes of a list where no front writes any.
const REGION: u32 = 8;
/// Cores, at most: with the converters, fewer than the 32 ports that a chip has wires for.
const CORES: u32 = 16;
/// Converters of a front, at most.
const UNITS: u32 = 8;
/// Bytes of what a converter has asked for: 16 requests of seven means, 32 shapes, 32 colours.
const INPUT: u64 = 4848;
/// Rows of the share of a sorting buffer from which on lists without room are spilled.
const SPILLS: u32 = 64;
/// Bytes of what a core spills.
pub const SPILL: u64 = 256 << 10;
/// Chunks in the feature buffer of a core, at most.
const SLOTS: u32 = 8;

/// Parameters of `chip.sv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Design {
    /// Names with values.
    pub parameters: Vec<(&'static str, u32)>,
    /// Entries of a chunk.
    pub chunk: usize,
    /// Entries that a list may have: what two splits make chunks of, or, in a small buffer, what
    /// there is room for; and the place where a front writes it has room.
    pub entries: usize,
    /// Cores.
    pub cores: u32,
    /// Converters of its front, which make its lists; 0: there is none.
    pub units: u32,
    /// A front writes lists 2^`region` bytes apart.
    pub region: u32,
    /// Whether all memory ports are behind one.
    pub one_port: bool,
    /// Entries of a sub-tile's queue.
    pub queue: usize,
}

impl Design {
    /// The same, with an arbiter between its memory ports and one, if `one_port`.
    pub fn with_one_port(mut self, one_port: bool) -> Design {
        self.one_port = one_port;
        self.parameters.push(("ONE_PORT", u32::from(one_port)));
        self
    }

    /// The core that is `machine`, with a front or without.
    ///
    /// # Errors
    /// A key that the RTL has no other value of, or a value that it cannot have.
    pub fn of(machine: &Machine, front: bool) -> Result<Design, Failure> {
        let own = inputs::system(CHIP, &[], None)?;
        let (own, theirs) = (keys(own.machine()), keys(machine));
        let other: &[&str] = if front { &FREE_OF_FRONT } else { &FREE_OF_CORES };
        let fixed = |key: &&String| !FREE.iter().chain(other).any(|free| key.starts_with(free));
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
        let (cores, ahead) = (tiles.vru.cores, tiles.vru.speculation);
        if !(1..=CORES).contains(&cores) {
            return Err(refused("vru.cores", &cores, &format!("1 to {CORES}")));
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
        let [ops, lines, region] = if front { front_of(tiles)? } else { [16, 2, REGION] };
        // Parts are split twice at most.
        let chunks = 64;
        let units = if front { tiles.ccu.units } else { 0 };
        // A list that is split needs a row more for each of its eight parts.
        let entries = match rows >= SPILLS {
            true => (chunks * chunk) as usize,
            false => (rows as usize).saturating_sub(8).max(1) * ROW as usize,
        };
        let listed = if front { (1 << region) / tiles.list_entry() as usize } else { usize::MAX };
        Ok(Design {
            parameters: vec![
                ("CORES", cores),
                ("FRONTS", units),
                ("OPS", ops),
                ("LINES", lines),
                ("REGION", region),
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
            entries: entries.min(listed),
            region,
            one_port: false,
            cores,
            units,
            queue: queue as usize,
        })
    }
}

/// Operators of the projection, lines, and the logarithm of the bytes of a list of the front of
/// `tiles`.
fn front_of(tiles: &TileWise) -> Result<[u32; 3], Failure> {
    let (ccu, o) = (&tiles.ccu, &tiles.ccu.operations);
    let rates =
        [ccu.cull_operations_per_cycle, ccu.operations_per_cycle, ccu.colour_operations_per_cycle];
    let Some((_, intervals)) = ENGINES.iter().find(|(operators, _)| *operators == rates) else {
        let all: Vec<String> = ENGINES.iter().map(|(rates, _)| format!("{rates:?}")).collect();
        let key = "ccu: cull-operations-per-cycle, operations-per-cycle and \
                   colour-operations-per-cycle";
        let must = format!("there are programs for {}", all.join(", "));
        return Err(refused(key, &format!("{rates:?}"), &must));
    };
    let slots = [0, 1, 2].map(|i| rates[i] * intervals[i]);
    let told = [o.cull, o.project + o.obb_prepare, o.sh_colour];
    if told != slots {
        let must = format!(
            "cull, project with obb-prepare, and sh-colour take operators times interval: {slots:?}"
        );
        return Err(refused("ccu.operations", &format!("{told:?}"), &must));
    }
    if !(1..=UNITS).contains(&ccu.units) {
        return Err(refused("ccu.units", &ccu.units, &format!("1 to {UNITS}")));
    }
    let input = &tiles.buffers.gaussian_in.capacity;
    if input.0 != INPUT * u64::from(ccu.units) {
        let must = format!("{INPUT} B for each converter");
        return Err(refused("buffers.gaussian-in.capacity", input, &must));
    }
    let combining = &tiles.binning.combining.capacity;
    let lines = combining.0 / tiles.binning.line.0;
    if !combining.0.is_multiple_of(tiles.binning.line.0)
        || !lines.is_power_of_two()
        || !(2..=4096).contains(&lines)
    {
        return Err(refused(
            "binning.combining.capacity",
            combining,
            "2 to 4096 lines, a power of two",
        ));
    }
    let block = &tiles.binning.block;
    if !block.0.is_power_of_two() || !(1 << 8..=1 << 19).contains(&block.0) {
        return Err(refused("binning.block", block, "256 B to 512 KiB, a power of two"));
    }
    Ok([rates[1], lines as u32, block.0.ilog2()])
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
