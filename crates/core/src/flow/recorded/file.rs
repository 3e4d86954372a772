//! The file of a run: comma-separated values, a row for each thing that is said of a frame.
//!
//! Columns: `frame`, its [`id`](powergs_frame::trace::Frame::id) in hexadecimal; `what`; `count`;
//! and where they are needed `cycle`, `needed`, `address`, `phase`. `what` is
//!
//! - `cycles`: how long the frame takes with a memory that answers at once; each frame has it;
//! - `busy.UNIT`: cycles with work, of all units of a kind together, where they are not busy all
//!   the time;
//! - `dram-read`, `dram-write`: a request of `count` bytes at `address`, made in `cycle`; the run
//!   cannot go beyond the cycle `needed` before it is done;
//! - any other action, by its key in energy tables: `alpha`, `sram-read.feature`. It counts for the
//!   phase of its stage, or for `phase`.
//!
//! Rows may end where nothing else is said, and those of one frame need not stand together. Cycles
//! are counted from 0, as if the memory answered at once. Texts may have quotes, whole numbers may
//! be written as `10.0` or `1e+05`, and `NA` or `NaN` is a cell without a value: so tables of R and
//! pandas have them.

use std::collections::{BTreeMap, HashMap};
use std::io::Read;

use csv::StringRecord;
use xxhash_rust::xxh3::Xxh3;

use super::{RecordedSpec, STREAMS, unknown};
use crate::kernel::memory::NEVER;
use crate::kernel::stream::StreamId;
use crate::stage::hardware;
use powergs_energy::action::{ActionId, Phase, StageId};
use powergs_energy::hardware::Does;

/// The longest frame that is believed, cycles.
pub const CYCLES_MAX: u64 = 1 << 40;

/// The largest count that is accepted: up to here numbers in results are exact, and no sum of
/// them is too large.
pub const COUNT_MAX: u64 = 1 << 53;

/// First byte behind all addresses that are believed.
pub const ADDRESS_END: u64 = 1 << 40;

/// The largest request, bytes.
pub const REQUEST_MAX: u64 = 1 << 24;

/// The most requests of a file: what they take in memory is about half a gibibyte.
pub const REQUESTS_MAX: usize = 1 << 24;

/// The most frames of a file.
pub const FRAMES_MAX: usize = 1 << 20;

/// The longest line of a file, bytes.
pub const LINE_MAX: usize = 1 << 12;

/// The columns of a file: the first three are in every one.
pub const COLUMNS: [&str; 7] = ["frame", "what", "count", "cycle", "needed", "address", "phase"];

const NEEDED: usize = 3;

/// A request to the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedRequest {
    /// When it is made, cycles of the run.
    pub cycle: u64,
    /// The cycle of the run that does not come before it is done; [`NEVER`] where nothing waits for
    /// it.
    pub needed: u64,
    /// Where.
    pub address: u64,
    /// How many bytes.
    pub bytes: u32,
    /// Whether it reads or writes, and for which phase.
    pub stream: StreamId,
}

/// A frame of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordedFrame {
    /// Its cycles with a memory that answers at once.
    pub cycles: u64,
    /// How often everything happened.
    pub counts: BTreeMap<(Phase, ActionId), u64>,
    /// Cycles with work, of all units of a kind; of those that are not here: all.
    pub busy: BTreeMap<StageId, u64>,
    /// In the order of their cycles.
    pub requests: Vec<RecordedRequest>,
}

/// A run.
#[derive(Debug, PartialEq)]
pub struct RecordedRun {
    /// Its frames, by what is in them.
    pub frames: BTreeMap<u64, RecordedFrame>,
    /// Hash of the file.
    pub xxh3: u128,
}

/// Said a row says something of.
#[derive(Debug, Clone, Copy)]
enum Said {
    Cycles,
    Busy(StageId),
    Request {
        is_write: bool,
    },
    Action(ActionId),
    /// Said follows from the cycles.
    Clock,
}

fn all_names() -> HashMap<String, Said> {
    let hardware = hardware();
    let actions = hardware.actions().map(|(id, does)| {
        let what = match does {
            Does::Clock(_) | Does::IdleClock(_) => Said::Clock,
            Does::DramRead => Said::Request { is_write: false },
            Does::DramWrite => Said::Request { is_write: true },
            Does::Work(..) | Does::SramRead(_) | Does::SramWrite(_) => Said::Action(id),
        };
        (hardware.key(id), what)
    });
    let busy = hardware.units().map(|(id, unit)| (format!("busy.{}", unit.key), Said::Busy(id)));
    [("cycles".to_owned(), Said::Cycles)].into_iter().chain(busy).chain(actions).collect()
}

/// The phase that an action counts for where its row does not say.
fn phase_of(action: ActionId) -> Phase {
    let hardware = hardware();
    let stage = match hardware.does(action) {
        Does::Work(stage, _) | Does::Clock(stage) | Does::IdleClock(stage) => stage,
        Does::SramRead(buffer) | Does::SramWrite(buffer) => hardware.stage_of(buffer),
        Does::DramRead | Does::DramWrite => return Phase::Rendering,
    };
    hardware.stage(stage).phase
}

/// The stream of requests of a phase.
fn stream(phase: Phase, is_write: bool) -> StreamId {
    let wanted = |id: &StreamId| STREAMS.phase(*id) == phase && STREAMS.is_write(*id) == is_write;
    STREAMS.all().find(wanted).expect("each phase of work has both")
}

/// Everything that is read, on its way through a hash, row by row.
struct HashedReader<R> {
    from: R,
    hash: Xxh3,
    /// Bytes since the last end of a row.
    row: usize,
    /// Whether a text in quotes goes on, in which no row ends.
    is_quoted: bool,
}

impl<R: Read> Read for HashedReader<R> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let n = self.from.read(to)?;
        self.hash.update(&to[..n]);
        for byte in &to[..n] {
            self.row += 1;
            if self.row > LINE_MAX {
                let what = format!(
                    "a line of more than {LINE_MAX} bytes, or a text whose quotes do not end: this \
                     is no run"
                );
                return Err(std::io::Error::other(what));
            }
            match byte {
                b'"' => self.is_quoted = !self.is_quoted,
                b'\n' if !self.is_quoted => self.row = 0,
                _ => {}
            }
        }
        Ok(n)
    }
}

/// A row, with the places of the columns.
struct RunRow<'a> {
    cells: &'a StringRecord,
    columns: &'a [Option<usize>; COLUMNS.len()],
}

impl<'a> RunRow<'a> {
    /// A cell; empty where the file has no such column, or says that it has no value.
    fn cell(&self, column: usize) -> &'a str {
        let cell = self.columns[column].and_then(|at| self.cells.get(at)).unwrap_or("").trim();
        if ["NA", "NaN", "nan"].contains(&cell) { "" } else { cell }
    }

    fn number(&self, column: usize, most: u64) -> Result<u64, String> {
        let (cell, name) = (self.cell(column), COLUMNS[column]);
        let given = if cell.is_empty() { "nothing".to_owned() } else { format!("`{cell}`") };
        let number = cell.parse().ok().or_else(|| whole_number(cell)).filter(|n| *n <= most);
        number.ok_or_else(|| format!("`{name}` must be a whole number up to {most}, not {given}"))
    }

    /// A number that may be left out.
    fn maybe(&self, column: usize, most: u64) -> Result<Option<u64>, String> {
        if self.cell(column).is_empty() { Ok(None) } else { self.number(column, most).map(Some) }
    }

    fn phase(&self) -> Result<Option<Phase>, String> {
        let cell = self.cell(6);
        let names = Phase::WORK.map(Phase::name);
        match Phase::WORK.into_iter().find(|phase| phase.name() == cell) {
            None if !cell.is_empty() => Err(unknown("phase", cell, &names)),
            phase => Ok(phase),
        }
    }
}

/// A whole number that is written as others are: `10.0`, `1e+05`; exact up to [`COUNT_MAX`].
fn whole_number(cell: &str) -> Option<u64> {
    let number: f64 = cell.parse().ok()?;
    let is_whole = number.fract() == 0.0 && (0.0..=COUNT_MAX as f64).contains(&number);
    is_whole.then_some(number as u64)
}

impl RecordedRun {
    /// Reads a run.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line.
    pub fn read(from: impl Read) -> Result<RecordedRun, String> {
        let hashed = HashedReader { from, hash: Xxh3::new(), row: 0, is_quoted: false };
        let mut table = csv::ReaderBuilder::new().flexible(true).from_reader(hashed);
        let head = table.headers().map_err(|e| e.to_string())?;
        let (width, columns) = (head.len(), columns(head)?);
        let names = all_names();
        let mut frames: BTreeMap<u64, RecordedFrame> = BTreeMap::new();
        let mut cells = StringRecord::new();
        let mut requests = 0;
        while table.read_record(&mut cells).map_err(|e| e.to_string())? {
            let line = cells.position().map_or(0, csv::Position::line);
            if cells.len() > width {
                let more = cells.len();
                return Err(format!("line {line}: {more} cells under a head of {width}"));
            }
            let row = RunRow { cells: &cells, columns: &columns };
            add(&mut frames, &row, &names, &mut requests)
                .map_err(|e| format!("line {line}: {e}"))?;
        }
        if frames.is_empty() {
            return Err("it has no frames: is it complete?".into());
        }
        for (id, frame) in &mut frames {
            whole(frame).map_err(|e| format!("frame {id:016x}: {e}"))?;
        }
        Ok(RecordedRun { frames, xxh3: table.into_inner().hash.digest128() })
    }

    /// Whether a machine has what the run uses.
    ///
    /// # Errors
    /// The first thing that it has not.
    pub fn fits(&self, machine: &RecordedSpec) -> Result<(), String> {
        let hardware = hardware();
        for (id, frame) in &self.frames {
            let has = |stage: StageId| machine.count(hardware.stage(stage).key) > 0;
            for (_, action) in frame.counts.keys() {
                let (key, lacks) = (hardware.key(*action), |what: String| {
                    format!(
                        "frame {id:016x} has `{}`, and the machine no {what}",
                        hardware.key(*action)
                    )
                });
                match hardware.does(*action) {
                    Does::Work(stage, _) if !hardware.doers(stage, &key).any(has) => {
                        let doers = hardware.doers(stage, &key);
                        let keys: Vec<&str> = doers.map(|id| hardware.stage(id).key).collect();
                        return Err(lacks(format!(
                            "units that do it: add one of {} to [recorded.units]",
                            keys.join(", ")
                        )));
                    }
                    Does::SramRead(buffer) | Does::SramWrite(buffer)
                        if !machine.buffers.contains_key(&hardware.buffer(buffer).key()) =>
                    {
                        return Err(lacks("such buffer: add it to [recorded.buffers]".into()));
                    }
                    _ => {}
                }
            }
            for (stage, busy) in &frame.busy {
                let (key, most) = (hardware.stage(*stage).key, {
                    u64::from(machine.count(hardware.stage(*stage).key)) * frame.cycles
                });
                if *busy > most {
                    let count = machine.count(key);
                    return Err(format!(
                        "frame {id:016x} has `busy.{key}` = {busy}, and {count} units have {most} \
                         cycles in its {}",
                        frame.cycles
                    ));
                }
            }
        }
        Ok(())
    }

    /// Its frames, for messages.
    pub(super) fn told_frames(&self) -> String {
        const SHOWN: usize = 3;
        let ids: Vec<String> =
            self.frames.keys().take(SHOWN).map(|id| format!("{id:016x}")).collect();
        match self.frames.len() {
            n if n > SHOWN => format!("{} and {} more", ids.join(", "), n - SHOWN),
            _ => ids.join(", "),
        }
    }
}

/// Where each column is.
fn columns(head: &StringRecord) -> Result<[Option<usize>; COLUMNS.len()], String> {
    let mut places = [None; COLUMNS.len()];
    for (at, name) in head.iter().enumerate() {
        let name = name.trim_start_matches('\u{feff}').trim();
        let Some(column) = COLUMNS.iter().position(|known| *known == name) else {
            let known = COLUMNS.join(", ");
            let rows = if name.is_empty() { " (numbers of rows? leave them out)" } else { "" };
            return Err(format!("line 1: no column `{name}`{rows} in the file of a run: {known}"));
        };
        if places[column].replace(at).is_some() {
            return Err(format!("line 1: the column `{name}` is there twice"));
        }
    }
    match (0..NEEDED).find(|column| places[*column].is_none()) {
        Some(missing) => Err(format!("line 1: the column `{}` is missing", COLUMNS[missing])),
        None => Ok(places),
    }
}

/// Takes in a row.
fn add(
    frames: &mut BTreeMap<u64, RecordedFrame>,
    row: &RunRow<'_>,
    names: &HashMap<String, Said>,
    requests: &mut usize,
) -> Result<(), String> {
    let id = row.cell(0);
    let id = u64::from_str_radix(id, 16).ok().filter(|_| id.len() == 16).ok_or_else(|| {
        format!("`frame` must be the `id` of a frame, 16 hexadecimal digits, not `{id}`")
    })?;
    if frames.len() == FRAMES_MAX && !frames.contains_key(&id) {
        return Err(format!("more than {FRAMES_MAX} frames: put fewer into a file"));
    }
    let frame = frames.entry(id).or_default();
    let what = row.cell(1);
    let twice = || format!("`{what}` of frame {id:016x} is there twice");
    match names.get(what) {
        Some(Said::Cycles) => {
            let cycles = row.number(2, CYCLES_MAX)?;
            if cycles == 0 {
                return Err("`cycles` must be above 0".into());
            }
            if std::mem::replace(&mut frame.cycles, cycles) != 0 {
                return Err(twice());
            }
        }
        Some(Said::Busy(stage)) => {
            if frame.busy.insert(*stage, row.number(2, COUNT_MAX)?).is_some() {
                return Err(twice());
            }
        }
        Some(Said::Action(action)) => {
            let phase = row.phase()?.unwrap_or_else(|| phase_of(*action));
            if frame.counts.insert((phase, *action), row.number(2, COUNT_MAX)?).is_some() {
                return Err(twice());
            }
        }
        Some(Said::Request { is_write }) => {
            *requests += 1;
            if *requests > REQUESTS_MAX {
                return Err(format!(
                    "more than {REQUESTS_MAX} requests: make them larger, or put fewer frames \
                     into a file"
                ));
            }
            let bytes = row.number(2, REQUEST_MAX)?;
            if bytes == 0 {
                return Err("a request of 0 bytes".into());
            }
            let (cycle, address) =
                (row.number(3, CYCLES_MAX)?, row.number(5, ADDRESS_END - bytes)?);
            let needed = row.maybe(4, CYCLES_MAX)?.unwrap_or(NEVER);
            if needed <= cycle {
                return Err(format!("it is needed in cycle {needed}, and made in cycle {cycle}"));
            }
            frame.requests.push(RecordedRequest {
                cycle,
                needed,
                address,
                bytes: bytes as u32,
                stream: stream(row.phase()?.unwrap_or(Phase::Rendering), *is_write),
            });
        }
        Some(Said::Clock) => {
            return Err(format!("`{what}` follows from `cycles` and `busy.UNIT`: leave it out"));
        }
        None => {
            let known = names.keys().map(String::as_str);
            let near = powergs_base::config::suggest::nearest(what, known);
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            return Err(format!(
                "no action `{what}`{near} (docs/elsewhere.md lists what there is)"
            ));
        }
    }
    Ok(())
}

/// Said can be said of a frame only when all of it has been read.
fn whole(frame: &mut RecordedFrame) -> Result<(), String> {
    if frame.cycles == 0 {
        return Err("it has no `cycles`".into());
    }
    frame.requests.sort_by_key(|request| request.cycle);
    let late = frame.requests.iter().find(|request| {
        request.cycle > frame.cycles || (request.needed > frame.cycles && request.needed != NEVER)
    });
    match late {
        None => Ok(()),
        Some(request) => Err(format!(
            "a request of cycle {} lies behind its end, or is needed behind it: it has {} cycles",
            request.cycle, frame.cycles
        )),
    }
}
