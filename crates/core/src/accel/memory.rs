//! The memory as the units see it: requests are issued, and complete in a later cycle.
//!
//! With the `bandwidth` and `window` models the cycle of completion is known when a request is
//! issued. With the `banked` model it is known only when the request completes, because the
//! controller may serve later requests first.

use super::DramUse;
use super::dram::{Channel, Dram};
use super::layout::{AccessPattern, Layout};
use super::machine::{DramModel, Machine};
use super::timeline::Observer;
use super::traffic::Traffic;
use crate::action::Stage;
use crate::dram::{self, Banked, Device, DramCommands, StageCommands, Windowed};
use crate::workload::FrameWorkload;

/// No cycle.
pub(crate) const NEVER: u64 = u64::MAX;

/// A request under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival(u64);

impl Arrival {
    /// Nothing is waited for.
    pub(crate) const NOW: Arrival = Arrival(0);
}

/// A request of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// The agent that issues it, and that its completion wakes.
    pub owner: u32,
    /// The stage that its bytes are charged to.
    pub stage: Stage,
    /// Whether it writes.
    pub write: bool,
    /// Bytes requested.
    pub bytes: u64,
}

/// Marks an arrival whose cycle is not known yet: the other bits are the number of the request.
const UNKNOWN: u64 = 1 << 63;

/// The memory of one frame.
pub struct Memory<'a> {
    workload: &'a FrameWorkload,
    layout: Layout,
    traffic: Traffic,
    timer: Timer,
}

/// The DRAM model.
enum Timer {
    Flat(Channel),
    Window(Box<Windowed>, Clocks),
    Banked(Box<Queued>, Clocks),
}

/// A device with its requests, which it reorders.
struct Queued {
    device: Banked,
    /// Requests by number: addresses, address ranges already taken, agent, cycle of completion.
    requests: Vec<(AccessPattern, u64, u32, u64)>,
}

/// The clock periods of the machine (cycles) and of the device (CK), in femtoseconds.
#[derive(Debug, Clone, Copy)]
struct Clocks {
    cycle_fs: u64,
    ck_fs: u64,
}

impl Clocks {
    fn new(machine: &Machine, device: &Device) -> Clocks {
        let fs = |seconds: f64| (seconds * 1e15).round() as u64;
        Clocks { cycle_fs: fs(machine.clock.0.recip()), ck_fs: fs(device.clock_period.0 * 1e-9) }
    }

    /// The first CK at or after a cycle begins.
    fn ck_from(self, cycle: u64) -> u64 {
        cycle.saturating_mul(self.cycle_fs).div_ceil(self.ck_fs)
    }

    /// The last CK at or before a cycle begins.
    fn ck_until(self, cycle: u64) -> u64 {
        match cycle {
            NEVER => u64::MAX,
            _ => cycle.saturating_mul(self.cycle_fs) / self.ck_fs,
        }
    }

    /// The first cycle that begins at or after a CK.
    fn cycle(self, ck: u64) -> u64 {
        ck.saturating_mul(self.ck_fs).div_ceil(self.cycle_fs)
    }
}

impl<'a> Memory<'a> {
    /// An idle memory.
    ///
    /// # Panics
    /// When the machine's model needs a device and [`Machine::link`] was never called.
    pub(crate) fn new(
        workload: &'a FrameWorkload,
        layout: Layout,
        machine: &Machine,
        flat: Dram,
    ) -> Self {
        let device = || machine.device.as_deref().expect("a machine is linked to its DRAM device");
        let timer = match machine.dram.model {
            DramModel::Bandwidth => Timer::Flat(Channel::new(flat)),
            DramModel::Window => {
                let memory = Box::new(Windowed::new(device()));
                Timer::Window(memory, Clocks::new(machine, device()))
            }
            DramModel::Banked => {
                let queued = Queued { device: Banked::new(device()), requests: Vec::new() };
                Timer::Banked(Box::new(queued), Clocks::new(machine, device()))
            }
        };
        Memory { workload, layout, traffic: Traffic::default(), timer }
    }

    /// Whether the reads of one agent, and its writes of at least a byte, are done in the order in
    /// which they were issued.
    pub(crate) fn keeps_order(&self) -> bool {
        matches!(self.timer, Timer::Flat(_))
    }

    /// Issues a request in cycle `now`; `span` gives its addresses. A request of no bytes does not
    /// reach the memory and is done one cycle later.
    #[inline]
    pub(crate) fn issue<O: Observer>(
        &mut self,
        now: u64,
        request: Request,
        span: impl FnOnce(&Layout) -> AccessPattern,
        observer: &mut O,
    ) -> Arrival {
        if request.bytes == 0 {
            return Arrival(now + 1);
        }
        let stage = &mut self.traffic.stages[request.stage as usize];
        *(if request.write { &mut stage.write } else { &mut stage.read }) += request.bytes;
        match &mut self.timer {
            Timer::Flat(channel) if !O::WANTS_REQUESTS => {
                Arrival(channel.serve(now, request.write, request.bytes))
            }
            Timer::Flat(_) | Timer::Window(..) | Timer::Banked(..) => {
                let span = span(&self.layout);
                self.tell(&request, &span, observer);
                self.issue_at(now, request, span)
            }
        }
    }

    /// Issues a request to a memory that may depend on addresses.
    fn issue_at(&mut self, now: u64, request: Request, span: AccessPattern) -> Arrival {
        let (layout, workload) = (&self.layout, self.workload);
        let class = request.stage as u8;
        match &mut self.timer {
            Timer::Flat(channel) => Arrival(channel.serve(now, request.write, request.bytes)),
            Timer::Window(device, clocks) => {
                let mut cursor = 0;
                let pieces = std::iter::from_fn(|| layout.piece(&span, &mut cursor, workload));
                let done = device.serve(clocks.ck_from(now), request.write, class, pieces);
                Arrival(clocks.cycle(done).max(now + 1))
            }
            Timer::Banked(queued, clocks) => {
                let number = queued.requests.len();
                queued.requests.push((span, 0, request.owner, NEVER));
                queued.device.push(dram::Request {
                    ticket: u32::try_from(number).expect("fewer than 2^32 requests in a frame"),
                    write: request.write,
                    class,
                    arrival: clocks.ck_from(now),
                });
                Arrival(UNKNOWN | number as u64)
            }
        }
    }

    fn tell<O: Observer>(&self, request: &Request, span: &AccessPattern, observer: &mut O) {
        if !O::WANTS_REQUESTS {
            return;
        }
        let mut cursor = 0;
        while let Some(p) = self.layout.piece(span, &mut cursor, self.workload) {
            observer.request(request.write, p.address, p.bytes);
        }
    }

    /// The cycle in which a request is done; [`NEVER`] while that is not known.
    #[inline]
    pub(crate) fn at(&self, arrival: Arrival) -> u64 {
        match &self.timer {
            Timer::Banked(queued, _) if arrival.0 & UNKNOWN != 0 => {
                queued.requests[(arrival.0 & !UNKNOWN) as usize].3
            }
            Timer::Flat(_) | Timer::Window(..) | Timer::Banked(..) => arrival.0,
        }
    }

    /// Cycle in which a request completes, if that is known already; otherwise 0.
    pub(crate) fn known_end(&self, arrival: Arrival) -> u64 {
        match self.at(arrival) {
            NEVER => 0,
            cycle => cycle,
        }
    }

    /// Runs the `banked` model until a request completes, at most until cycle `until`; returns the
    /// cycle of completion and the agent of the request.
    pub(crate) fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        let Timer::Banked(queued, clocks) = &mut self.timer else { return None };
        let (layout, workload) = (&self.layout, self.workload);
        let requests = &mut queued.requests;
        let mut pieces = |number: u32| {
            let (span, cursor, ..) = &mut requests[number as usize];
            layout.piece(span, cursor, workload)
        };
        let (ck, number) = queued.device.advance(clocks.ck_until(until), &mut pieces)?;
        let (_, _, owner, done) = &mut requests[number as usize];
        *done = clocks.cycle(ck);
        Some((*done, *owner))
    }

    /// The channel of the `bandwidth` model, and the bytes asked for; `None` with the others.
    pub(crate) fn flat(&self) -> Option<(&Channel, Traffic)> {
        match &self.timer {
            Timer::Flat(channel) => Some((channel, self.traffic)),
            Timer::Window(..) | Timer::Banked(..) => None,
        }
    }

    /// Continues with the state of another channel of the same rate.
    pub(crate) fn set_flat(&mut self, channel: Channel, traffic: Traffic) {
        self.timer = Timer::Flat(channel);
        self.traffic = traffic;
    }

    /// Bytes asked for, by stage.
    pub(crate) fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// DRAM activity of the frame.
    pub(crate) fn usage(&self) -> DramUse {
        let total = self.traffic.total();
        let usage = match &self.timer {
            Timer::Flat(channel) => channel.usage(),
            Timer::Window(device, clocks) => {
                device_usage(&device.stats(), *clocks, device.burst_bytes())
            }
            Timer::Banked(queued, clocks) => {
                let issued = queued.requests.len() as u64;
                let mut usage =
                    device_usage(&queued.device.stats(), *clocks, queued.device.burst_bytes());
                usage.requests_issued = issued;
                usage
            }
        };
        DramUse { read_bytes: total.read, write_bytes: total.write, ..usage }
    }
}

fn device_usage(stats: &dram::Stats, clocks: Clocks, burst_bytes: u64) -> DramUse {
    let stages = [0, 1, 2].map(|class: usize| {
        let t = &stats.classes[class];
        let activates = t.row_misses + t.row_conflicts;
        StageCommands { reads: t.reads, writes: t.writes, activates }
    });
    DramUse {
        requests_issued: stats.total.requests,
        requests_served: stats.total.requests,
        busy_cycles: clocks.cycle(stats.busy_max),
        commands: Some(DramCommands {
            burst_bytes,
            stages,
            precharges: stats.precharges + stats.precharges_all,
            refreshes: stats.refreshes_all,
            bank_refreshes: stats.refreshes_bank,
        }),
        ..DramUse::default()
    }
}
