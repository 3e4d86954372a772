//! A timeline as Chrome trace events (JSON), for <https://ui.perfetto.dev> and `chrome://tracing`.
//!
//! The Trace Event Format, object form: `traceEvents` with complete events (`"ph": "X"`, times in
//! microseconds), metadata events that name processes (kinds of unit) and threads (instances), and
//! counter events (`"ph": "C"`): the bytes that each share of a buffer holds, where they change.
//! Written as a stream while the frame is simulated; times are rounded to nanoseconds, which is the
//! resolution of the viewers, so that neighbours touch and never overlap.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};

use powergs_core::kernel::timeline::{Level, Observer, Span, State};
use powergs_core::stage::{hardware, stage, stages};
use powergs_energy::action::{BufferId, Phase, StageId};

/// Events beyond this many are counted and left out: viewers fail on longer files.
pub const MOST_EVENTS: u64 = 1_000_000;

/// The process of a stage: they are numbered from 1 in the order of their declaration.
fn process(unit: StageId) -> usize {
    unit.index() + 1
}

/// The process of the buffers, behind those of all stages.
fn of_buffers() -> usize {
    stages().len() + 1
}

/// Writes events while it is told what happens.
pub struct TraceWriter<W: Write> {
    out: W,
    /// Nanoseconds per cycle.
    period_ns: f64,
    tracks: BTreeSet<(StageId, u32)>,
    /// What shares of buffers held last.
    levels: BTreeMap<(BufferId, u32), u64>,
    events: u64,
    dropped: u64,
    failed: Option<io::Error>,
}

impl<W: Write> TraceWriter<W> {
    /// Begins a file. `title` goes into its metadata.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(mut out: W, clock_hz: f64, title: &str) -> io::Result<Self> {
        let title = serde_json::Value::from(title);
        write!(out, "{{\"displayTimeUnit\":\"ns\",\"otherData\":{{\"title\":{title}}},")?;
        writeln!(out, "\"traceEvents\":[")?;
        let (tracks, levels) = (BTreeSet::new(), BTreeMap::new());
        let (period_ns, events, dropped, failed) = (1e9 / clock_hz, 0, 0, None);
        let mut writer = Self { out, period_ns, tracks, levels, events, dropped, failed };
        writer.process(of_buffers(), "buffers")?;
        Ok(writer)
    }

    /// Ends the file and returns how many events were left out.
    ///
    /// # Errors
    /// The first of `out`, also of those while events came in.
    pub fn finish(mut self) -> io::Result<u64> {
        if let Some(e) = self.failed {
            return Err(e);
        }
        if self.dropped > 0 {
            // An instant event over everything, at the end of what is there.
            let text = format!("{} events were left out", self.dropped);
            let end = format!("{{\"name\":\"{text}\",\"ph\":\"i\",\"s\":\"g\",\"ts\":0,");
            write!(self.out, ",\n{end}\"pid\":1,\"tid\":0}}")?;
        }
        writeln!(self.out, "\n]}}")?;
        self.out.flush()?;
        Ok(self.dropped)
    }

    fn process(&mut self, pid: usize, name: &str) -> io::Result<()> {
        self.metadata(pid, 0, "process_name", &format!("{{\"name\":\"{name}\"}}"))?;
        self.metadata(pid, 0, "process_sort_index", &format!("{{\"sort_index\":{}}}", pid - 1))
    }

    fn metadata(&mut self, pid: usize, tid: usize, name: &str, args: &str) -> io::Result<()> {
        let comma = if self.events == 0 { "" } else { ",\n" };
        self.events += 1;
        let place = format!("\"pid\":{pid},\"tid\":{tid}");
        write!(self.out, "{comma}{{\"name\":\"{name}\",\"ph\":\"M\",{place},\"args\":{args}}}")
    }

    /// Microseconds with three decimals, from nanoseconds.
    fn microseconds(ns: u64) -> String {
        format!("{}.{:03}", ns / 1000, ns % 1000)
    }

    fn nanoseconds(&self, cycle: u64) -> u64 {
        (cycle as f64 * self.period_ns).round() as u64
    }

    fn counter(&mut self, level: Level) -> io::Result<()> {
        let Level { buffer, instance, from, bytes } = level;
        if self.levels.insert((buffer, instance), bytes) == Some(bytes) {
            return Ok(());
        }
        if self.events >= MOST_EVENTS {
            self.dropped += 1;
            return Ok(());
        }
        self.events += 1;
        let ts = Self::microseconds(self.nanoseconds(from));
        let (name, pid) = (hardware().buffer(buffer).name, of_buffers());
        write!(
            self.out,
            ",\n{{\"name\":\"{name}{instance}\",\"ph\":\"C\",\"ts\":{ts},\
             \"pid\":{pid},\"tid\":0,\"args\":{{\"bytes\":{bytes}}}}}"
        )
    }

    fn event(&mut self, span: Span) -> io::Result<()> {
        let (pid, unit) = (process(span.unit), stage(span.unit));
        let tid = 100_000 * pid + span.instance as usize;
        let (name, args) = match span.state {
            State::Idle => return Ok(()),
            State::Busy(item) => {
                let is_early = unit.phase == Phase::Preprocessing;
                let what = if is_early { "batch" } else { "tile" };
                (format!("{what} {item}"), format!("{{\"{what}\":{item}}}"))
            }
            State::Stalled(cause) => {
                let cause = cause.name();
                (format!("wait {cause}"), format!("{{\"cause\":\"{cause}\"}}"))
            }
        };
        if !self.tracks.iter().any(|(known, _)| *known == span.unit) {
            self.process(pid, unit.key)?;
        }
        if self.tracks.insert((span.unit, span.instance)) {
            let label = format!("{{\"name\":\"{}{}\"}}", unit.key, span.instance);
            self.metadata(pid, tid, "thread_name", &label)?;
            let order = format!("{{\"sort_index\":{}}}", span.instance);
            self.metadata(pid, tid, "thread_sort_index", &order)?;
        }
        if self.events >= MOST_EVENTS {
            self.dropped += 1;
            return Ok(());
        }
        self.events += 1;
        let (from, to) = (self.nanoseconds(span.from), self.nanoseconds(span.to));
        let category = if matches!(span.state, State::Busy(_)) { "busy" } else { "stall" };
        let (ts, dur) = (Self::microseconds(from), Self::microseconds(to - from));
        write!(
            self.out,
            ",\n{{\"name\":\"{name}\",\"cat\":\"{category}\",\"ph\":\"X\",\"ts\":{ts},\
             \"dur\":{dur},\"pid\":{pid},\"tid\":{tid},\"args\":{args}}}"
        )
    }
}

impl<W: Write> Observer for TraceWriter<W> {
    fn wants_levels(&self) -> bool {
        true
    }

    fn span(&mut self, span: Span) {
        if self.failed.is_none() {
            self.failed = self.event(span).err();
        }
    }
    fn level(&mut self, level: Level) {
        if self.failed.is_none() {
            self.failed = self.counter(level).err();
        }
    }
}
