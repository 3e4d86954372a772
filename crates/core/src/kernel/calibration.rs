//! The `calibrated` model: one server, as in `bandwidth`, whose rates, latencies and commands come
//! from a run of the same frame on the device (`banked`).
//!
//! The run is that of a *reference machine*: the machine itself as far as it decides which requests
//! there are (records, fetch, batches, geometry, cache, schedule, clock, device, second master),
//! with units and buffers that keep the memory busy, always the same ones. So machines that differ
//! in numbers of units, in sizes of buffers or in anything else that only moves requests in time
//! have one calibration a frame between them, and it does not depend on who else is simulated.
//!
//! Timing rule, for each stream of requests ([`StreamId`]), in the order in which requests are
//! made:
//!
//! * **Bus time.** A burst of a stream takes the longer of its data and of its share of activates
//!   on the buses of all channels. These are stretched, by one factor for all streams of a phase
//!   (preprocessing; sorting and rendering; one phase if the schedule overlaps them), so that they
//!   add up to the time for which the reference had requests of the phase under way, the latency of
//!   an idle memory taken off. The stretch is what conflicts of banks, turnarounds of the bus,
//!   uneven channels and refreshes cost. Requests of contiguous bytes pay for the
//!   bursts that they only touch once each.
//! * **Latency.** A read has its data a row cycle (precharge, activate, read) and the controller's
//!   latency after its bus time, a write is done a row cycle and two turnarounds after it. In front
//!   of a loaded memory both take longer: reads pass each other in the queues of the channels,
//!   writes wait until their queues fill. How much longer is the mean that the reference saw, at
//!   most the time that full read queues take, or half of the time in which write queues fill; it
//!   grows in proportion to the queue in front of the request, up to half of the read queues.
//! * **Commands** per byte of each stream, refreshes per cycle.
//!
//! With a second master there is no such run: units that keep the memory busy would take from
//! that master what slower ones leave it, so the machine is timed as with `banked`
//! ([`DramSpec::timed`](crate::kernel::spec::DramSpec::timed)).
//!
//! What it does not know: rows that are open or closed because other units are faster or slower
//! than those of the reference, and machines whose few writes under way wait for reads to pause.

use crate::kernel::dram::{Channel, Dram, StreamCost};
use crate::kernel::stream::{StreamId, Streams};
use crate::kernel::timeline::{Observer, Span};
use powergs_dram::stats::Traffic;
use powergs_dram::{Device, DramCommands, StageCommands, Stats};
use powergs_energy::action::Phase;

/// A request of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CalibrationSample {
    pub(super) stream: StreamId,
    pub(super) bytes: u64,
    /// The cycle in which it was made, and that in which it was done.
    pub(super) issued: u64,
    pub(super) done: u64,
}

/// The requests of a run, and what the device did.
#[derive(Debug)]
pub struct Recording {
    pub(super) samples: Vec<CalibrationSample>,
    pub(super) stats: Stats,
    pub(super) cycles_per_ck: f64,
    pub(super) frame: u64,
}

/// Wants the times of requests.
#[derive(Debug)]
pub struct CalibrationRecorder;

impl Observer for CalibrationRecorder {
    fn wants_times(&self) -> bool {
        true
    }

    fn span(&mut self, _: Span) {}
}

/// Commands per byte of a stream.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct PerByte {
    reads: f64,
    writes: f64,
    activates: f64,
}

/// What a run of the device says about the streams of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    streams: &'static Streams,
    dram: Dram,
    burst_bytes: u64,
    commands: [PerByte; Streams::MOST],
    /// Precharges of an activate.
    precharges: f64,
    /// Refreshes of all banks and of one bank, per cycle.
    refreshes: [f64; 2],
    /// Cycles for which the bus with the most traffic moves data, per burst of the machine.
    busy: f64,
}

impl Calibration {
    /// What a run on a device says of the memory; `is_apart` where preprocessing is over before
    /// anything else begins.
    pub fn of(
        recording: &Recording,
        streams: &'static Streams,
        device: &Device,
        is_apart: bool,
    ) -> Calibration {
        CalibrationFit::new(recording, streams, device, is_apart).calibration()
    }

    /// The memory.
    pub fn dram(&self) -> Dram {
        self.dram
    }

    /// The commands for so many bytes of each stream in a frame of so many cycles.
    pub(super) fn commands(&self, bytes: &[u64; Streams::MOST], frame: u64) -> DramCommands {
        let mut stages = [StageCommands::default(); 3];
        for stream in self.streams.all() {
            let (per, bytes) = (&self.commands[stream.index()], bytes[stream.index()] as f64);
            let of = |per: f64| (per * bytes).round() as u64;
            stages[self.streams.phase(stream) as usize].add(StageCommands {
                reads: of(per.reads),
                writes: of(per.writes),
                activates: of(per.activates),
            });
        }
        let activates: u64 = stages.iter().map(|s| s.activates).sum();
        let [all, bank] = self.refreshes.map(|per| (per * frame as f64).round() as u64);
        DramCommands {
            burst_bytes: self.burst_bytes,
            stages,
            precharges: (self.precharges * activates as f64).round() as u64,
            refreshes: all,
            bank_refreshes: bank,
        }
    }

    /// Cycles of a frame for which the bus with the most traffic moves data.
    pub(super) fn busy_cycles(&self, bytes: &[u64; Streams::MOST], frame: u64) -> u64 {
        let bursts = |(bytes, per): (&u64, &PerByte)| (per.reads + per.writes) * *bytes as f64;
        let own: f64 = bytes.iter().zip(&self.commands).map(bursts).sum();
        ((own * self.busy).ceil() as u64).min(frame)
    }
}

/// What a recording says about one stream.
#[derive(Debug, Clone, Copy, Default)]
struct CalibrationSeen {
    requests: f64,
    bytes: f64,
    /// Read and write commands.
    reads: f64,
    writes: f64,
    activates: f64,
}

impl CalibrationSeen {
    fn new(traffic: &Traffic) -> CalibrationSeen {
        CalibrationSeen {
            reads: traffic.reads as f64,
            writes: traffic.writes as f64,
            activates: (traffic.row_misses + traffic.row_conflicts) as f64,
            ..CalibrationSeen::default()
        }
    }

    fn bursts(&self) -> f64 {
        self.reads + self.writes
    }
}

/// Phases of a frame in which the memory is loaded differently.
const PHASES: usize = 2;

/// A calibration on its way.
struct CalibrationFit<'a> {
    recording: &'a Recording,
    streams: &'static Streams,
    device: &'a Device,
    is_apart: bool,
    seen: [CalibrationSeen; Streams::MOST],
    /// Data buses.
    buses: f64,
}

impl<'a> CalibrationFit<'a> {
    fn new(
        recording: &'a Recording,
        streams: &'static Streams,
        device: &'a Device,
        is_apart: bool,
    ) -> CalibrationFit<'a> {
        let classes = &recording.stats.classes;
        let mut seen = std::array::from_fn(|stream| CalibrationSeen::new(&classes[stream]));
        for sample in &recording.samples {
            let seen = &mut seen[sample.stream.index()];
            seen.requests += 1.0;
            seen.bytes += sample.bytes as f64;
        }
        let organisation = &device.organisation;
        let buses = f64::from(organisation.channels * organisation.pseudo_channels);
        CalibrationFit { recording, streams, device, is_apart, seen, buses }
    }

    /// Something of each stream; nothing behind the last.
    fn each<T: Copy + Default>(&self, of: impl Fn(StreamId) -> T) -> [T; Streams::MOST] {
        let mut all = [T::default(); Streams::MOST];
        self.streams.all().for_each(|stream| all[stream.index()] = of(stream));
        all
    }

    fn cycles(&self, ck: u32) -> f64 {
        f64::from(ck) * self.recording.cycles_per_ck
    }

    fn phase(&self, stream: StreamId) -> usize {
        let is_apart = self.is_apart && self.streams.phase(stream) != Phase::Preprocessing;
        usize::from(is_apart)
    }

    fn of_phase(&self, phase: usize) -> impl Iterator<Item = StreamId> {
        self.streams.all().filter(move |&stream| self.phase(stream) == phase)
    }

    /// Bus time of a stream without stretch: its data, or its activates.
    fn bus_time(&self, stream: StreamId) -> f64 {
        let (timing, seen) = (&self.device.timing, &self.seen[stream.index()]);
        let activate =
            self.cycles(timing.activate_short).max(self.cycles(timing.four_activates) / 4.0);
        (seen.bursts() * self.cycles(timing.burst)).max(seen.activates * activate) / self.buses
    }

    /// Cycles from the bus time of a request to its end in an idle memory.
    fn latency(&self, stream: StreamId) -> f64 {
        let timing = &self.device.timing;
        let row = timing.precharge_to_activate + timing.activate_to_read;
        if self.streams.is_write(stream) {
            return self.cycles(row + timing.read_to_write + timing.write_to_read_long);
        }
        let controller = self.device.ck(self.device.controller.latency) as f64;
        self.cycles(row + timing.read_data) + controller * self.recording.cycles_per_ck
    }

    /// Cycles of a phase for which requests of it are under way, without their latency.
    fn time_at_work(&self, phase: usize) -> f64 {
        let of_phase = |s: &&CalibrationSample| self.phase(s.stream) == phase;
        let mut spans: Vec<(f64, f64)> = self
            .recording
            .samples
            .iter()
            .filter(of_phase)
            .map(|s| (s.issued as f64, s.done as f64 - self.latency(s.stream)))
            .collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut sum, mut end) = (0.0, 0.0_f64);
        for (from, to) in spans {
            sum += (to - from.max(end)).max(0.0);
            end = end.max(to);
        }
        sum
    }

    fn calibration(&self) -> Calibration {
        let work: [f64; PHASES] = std::array::from_fn(|phase| self.time_at_work(phase));
        let stretch: [f64; PHASES] = std::array::from_fn(|phase| {
            let least: f64 = self.of_phase(phase).map(|stream| self.bus_time(stream)).sum();
            if least > 0.0 { (work[phase] / least).max(1.0) } else { 1.0 }
        });
        let unloaded = self.each(|stream| self.unloaded(stream, stretch[self.phase(stream)]));
        let queues: [f64; PHASES] =
            std::array::from_fn(|phase| self.read_queues(phase, stretch[phase]));
        let later = self.later(&unloaded, queues.map(|cycles| 2.0 * cycles));
        let costs = self.each(|stream| {
            let (cost, phase) = (unloaded[stream.index()], self.phase(stream));
            let most = match self.streams.is_write(stream) {
                true => self.filling(phase, work[phase]) / 2.0,
                false => queues[phase],
            };
            let loaded = (later[stream.index()] - cost.latency).clamp(0.0, most);
            StreamCost { loaded, full: queues[phase] / 2.0, ..cost }
        });
        self.with_costs(costs)
    }

    /// Time in which full read queues of all channels are served.
    fn read_queues(&self, phase: usize, stretch: f64) -> f64 {
        let bursts: f64 = self.of_phase(phase).map(|s| self.seen[s.index()].bursts()).sum();
        let time: f64 = self.of_phase(phase).map(|stream| self.bus_time(stream)).sum();
        let each = if bursts > 0.0 { time * stretch / bursts } else { 0.0 };
        let channels = f64::from(self.device.organisation.channels);
        f64::from(self.device.controller.read_queue) * channels * each
    }

    /// Time in which the writes of a phase fill the write queues of all channels.
    fn filling(&self, phase: usize, work: f64) -> f64 {
        let written: f64 = self.of_phase(phase).map(|s| self.seen[s.index()].writes).sum();
        let controller = &self.device.controller;
        let channels = f64::from(self.device.organisation.channels);
        let bursts = controller.write_high * f64::from(controller.write_queue) * channels;
        if written > 0.0 { bursts * work / written } else { 0.0 }
    }

    /// What a stream costs in an idle memory.
    fn unloaded(&self, stream: StreamId, stretch: f64) -> StreamCost {
        let seen = &self.seen[stream.index()];
        let latency = self.latency(stream);
        if seen.bursts() == 0.0 || seen.bytes == 0.0 {
            return StreamCost { latency, ..StreamCost::default() };
        }
        let burst = self.bus_time(stream) * stretch / seen.bursts();
        let filled = seen.bytes / self.device.organisation.burst.0 as f64;
        let touched = match self.streams.is_contiguous(stream) {
            true => ((seen.bursts() - filled) / seen.requests).clamp(0.0, 1.0),
            false => 0.0,
        };
        let byte = (seen.bursts() - touched * seen.requests) * burst / seen.bytes;
        StreamCost { byte, request: touched * burst, latency, ..StreamCost::default() }
    }

    /// Mean cycles from bus time to end of the requests that find a queue of at most `longest`
    /// cycles of their phase in front of them; without bound for streams that never found the
    /// memory that empty, so that its full queues bound it.
    fn later(
        &self,
        costs: &[StreamCost; Streams::MOST],
        longest: [f64; PHASES],
    ) -> [f64; Streams::MOST] {
        let mut channel = Channel::new(Dram::of_streams(*costs));
        let mut sums = [(0.0, 0.0); Streams::MOST];
        for sample in &self.recording.samples {
            let queue = channel.free_cycles() - sample.issued as f64;
            channel.serve(sample.issued, sample.stream, sample.bytes);
            if queue > 0.0 && queue <= longest[self.phase(sample.stream)] {
                let (sum, n) = &mut sums[sample.stream.index()];
                *sum += sample.done as f64 - channel.free_cycles();
                *n += 1.0;
            }
        }
        sums.map(|(sum, n)| if n > 0.0 { sum / n } else { f64::INFINITY })
    }

    /// Commands per byte of a stream that the run had.
    fn per_byte(&self, stream: StreamId) -> PerByte {
        let seen = &self.seen[stream.index()];
        PerByte {
            reads: seen.reads / seen.bytes,
            writes: seen.writes / seen.bytes,
            activates: seen.activates / seen.bytes,
        }
    }

    /// The calibration with these costs. A stream that the run did not have is like one that it
    /// had, or whole bursts at the peak rate.
    fn with_costs(&self, costs: [StreamCost; Streams::MOST]) -> Calibration {
        let Recording { stats, cycles_per_ck, frame, .. } = self.recording;
        let organisation = &self.device.organisation;
        let had = |stream: &StreamId| self.seen[stream.index()].bursts() > 0.0;
        let burst_bytes = organisation.burst.0;
        let per_burst = 1.0 / burst_bytes as f64;
        let of = |stream: StreamId| match self.streams.and_similar(stream).into_iter().find(had) {
            Some(similar) => (costs[similar.index()], self.per_byte(similar)),
            None => {
                let byte = self.cycles(self.device.timing.burst) / self.buses * per_burst;
                let latency = self.latency(stream);
                let (reads, writes) =
                    if self.streams.is_write(stream) { (0.0, per_burst) } else { (per_burst, 0.0) };
                let cost = StreamCost { byte, latency, ..StreamCost::default() };
                (cost, PerByte { reads, writes, activates: 0.0 })
            }
        };
        let all = (stats.reads + stats.writes).max(1) as f64;
        let frame = (*frame).max(1) as f64;
        let busy = stats.busy_max as f64 * cycles_per_ck / all;
        let precharges = (stats.precharges + stats.precharges_all) as f64;
        Calibration {
            streams: self.streams,
            dram: Dram::of_streams(self.each(|stream| of(stream).0)),
            burst_bytes,
            commands: self.each(|stream| of(stream).1),
            precharges: precharges / stats.activates.max(1) as f64,
            refreshes: [stats.refreshes_all, stats.refreshes_bank].map(|n| n as f64 / frame),
            busy,
        }
    }
}
