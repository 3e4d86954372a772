//! A run again, with a memory that takes its time.
//!
//! The run has a clock of its own, which stands still while it waits: for a request that is needed
//! in the next cycle, and for the oldest request under way where as many as `recorded.outstanding`
//! are (A125). Within a cycle of the run waits come before requests, which go in the order of the
//! file. Behind its last cycle it waits until everything is written and read.

use std::collections::VecDeque;
use std::sync::Arc;

use super::{RecordedFrame, RecordedSpec, STREAMS};
use crate::flow::{FlowOutcome, FrameTask};
use crate::kernel::calibration::{CalibrationRecorder, Recording};
use crate::kernel::ledger::{Account, cycles};
use crate::kernel::memory::{Arrival, Memory, NEVER, Ranges, Request};
use crate::kernel::timeline::{Observer, State};
use crate::kernel::{self, Calibration, FrameTiming, Halt, Histogram, Memo, UnitCycles, drive};
use crate::machine::{Machine, Reference};
use crate::stage::{DRAM_READ, DRAM_WRITE, Stall, hardware, stage};
use powergs_energy::action::{ActionCounts, StageId};

/// What happens in a cycle of the run, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum RunEvent {
    /// A request must be done.
    Needs(u32),
    /// A request is made.
    Asks(u32),
    /// The run ends.
    Ends,
}

/// The run, with the units of its machine.
struct RunReplay<'a, O> {
    frame: &'a RecordedFrame,
    memory: Memory<'a, Ranges>,
    /// Those to come, the next one last.
    events: Vec<(u64, RunEvent)>,
    arrivals: Vec<Arrival>,
    /// Requests under way, the oldest first.
    window: VecDeque<u32>,
    outstanding: usize,
    /// For how many cycles it has stood still.
    delay: u64,
    end: u64,
    /// Of the units of each kind, with what they say when they wait for the memory.
    accounts: Vec<(Account, Stall)>,
    observer: &'a mut O,
    halt: Halt<'a>,
}

impl<O: Observer> RunReplay<'_, O> {
    fn is(&mut self, state: Option<State>) {
        for (account, waits) in &mut self.accounts {
            account.is(state.unwrap_or(State::Stalled(*waits)));
        }
    }

    fn up_to(&mut self, now: u64) {
        self.accounts.iter_mut().for_each(|(account, _)| account.up_to(now, self.observer));
    }

    /// When a request is done, if that is later than now.
    fn late(&self, request: u32, now: u64) -> Option<u64> {
        let done = self.memory.at(self.arrivals[request as usize]);
        (done > now).then_some(done)
    }

    /// Forgets the oldest requests until fewer than `most` are under way: when the oldest of the
    /// others is done.
    fn room(&mut self, most: usize, now: u64) -> Option<u64> {
        while self.window.len() >= most {
            let oldest = *self.window.front()?;
            if let Some(done) = self.late(oldest, now) {
                return Some(done);
            }
            self.window.pop_front();
        }
        None
    }
}

impl<O: Observer> kernel::Agents for RunReplay<'_, O> {
    fn step(&mut self, _: usize, now: u64) -> u64 {
        self.up_to(now);
        while let Some((cycle, event)) = self.events.last().copied() {
            let at = cycle + self.delay;
            if at > now {
                self.is(Some(State::Busy(0)));
                return at;
            }
            let (state, until) = match event {
                RunEvent::Needs(i) => (None, self.late(i, now)),
                RunEvent::Asks(_) => (None, self.room(self.outstanding, now)),
                RunEvent::Ends => (Some(State::Stalled(Stall::OUTPUT)), self.room(1, now)),
            };
            if let Some(until) = until {
                self.is(state);
                return until;
            }
            self.events.pop();
            self.delay = now - cycle;
            match event {
                RunEvent::Needs(_) => {}
                RunEvent::Asks(i) => {
                    let asked = self.frame.requests[i as usize];
                    let place = [asked.address, u64::from(asked.bytes)];
                    let request = Request { owner: 0, stream: asked.stream, bytes: place[1] };
                    self.arrivals[i as usize] =
                        self.memory.issue(now, request, |_| place, self.observer);
                    self.window.push_back(i);
                }
                RunEvent::Ends => self.end = now,
            }
        }
        NEVER
    }

    fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        self.memory.advance(until)
    }

    fn halt(&self) -> Halt<'_> {
        self.halt
    }
}

/// What a run on its device says of a machine's memory, where that is `calibrated`.
pub fn calibration(
    machine: &Machine,
    frame: &RecordedFrame,
    memo: &Memo,
    halt: Halt<'_>,
) -> Option<Arc<Calibration>> {
    let run = |reference: &Machine, recorder: &mut CalibrationRecorder| {
        through(reference, frame, None, halt, recorder).1
    };
    Reference::calibration(machine, memo, |_| {}, run, &STREAMS)
}

/// Takes a frame through a machine.
pub(super) fn run<O: Observer>(
    task: &FrameTask<'_>,
    frame: &RecordedFrame,
    observer: &mut O,
) -> FlowOutcome {
    let FrameTask { machine, memo, halt, .. } = *task;
    let calibration = calibration(machine, frame, memo, halt);
    through(machine, frame, calibration.as_deref(), halt, observer).0
}

/// What units of a kind say when they wait for the memory.
fn waits(unit: StageId) -> Stall {
    stage(unit).stalls().find(|cause| cause.is_dram()).unwrap_or(Stall::INPUT)
}

fn through<O: Observer>(
    machine: &Machine,
    frame: &RecordedFrame,
    calibration: Option<&Calibration>,
    halt: Halt<'_>,
    observer: &mut O,
) -> (FlowOutcome, Option<Recording>) {
    let spec: &RecordedSpec = machine.of_type();
    let requests = &frame.requests;
    let end = requests.iter().map(|r| r.address + u64::from(r.bytes)).max().unwrap_or(0);
    let numbered = || requests.iter().zip(0..);
    let needs = numbered().filter(|(request, _)| request.needed != NEVER);
    let needs = needs.map(|(request, i)| (request.needed, RunEvent::Needs(i)));
    let asks = numbered().map(|(request, i)| (request.cycle, RunEvent::Asks(i)));
    let mut events: Vec<(u64, RunEvent)> =
        needs.chain(asks).chain([(frame.cycles, RunEvent::Ends)]).collect();
    events.sort_unstable();
    events.reverse();
    let units: Vec<(StageId, u32)> = hardware()
        .units()
        .map(|(id, unit)| (id, spec.count(unit.key)))
        .filter(|(_, count)| *count > 0)
        .collect();
    let mut replay = RunReplay {
        frame,
        memory: Memory::new(Ranges { end }, &STREAMS, machine.memory(), calibration),
        events,
        arrivals: vec![Arrival::NOW; requests.len()],
        window: VecDeque::new(),
        outstanding: spec.outstanding as usize,
        delay: 0,
        end: 0,
        accounts: units.iter().map(|(id, _)| (Account::new(*id, 0), waits(*id))).collect(),
        observer,
        halt,
    };
    drive(&mut replay, 0..1, 0);
    let end = replay.end;
    replay.memory.close(end);
    let of_kind = |((id, count), (account, _)): (&(StageId, u32), &(Account, Stall))| {
        let all = cycles(*id, *count, std::iter::once(&account.ledger));
        let awake = all.busy;
        let busy = frame.busy.get(id).copied().unwrap_or(awake);
        UnitCycles { busy, idle: all.idle + awake - busy, ..all }
    };
    let timing = FrameTiming {
        frame: end,
        preprocessing_end: 0,
        units: units.iter().zip(&replay.accounts).map(of_kind).collect(),
        dram: replay.memory.usage(),
        buffers: Vec::new(),
        tile_cycles: Histogram::EMPTY,
    };
    let mut actions = ActionCounts::default();
    for (&(phase, action), &n) in &frame.counts {
        actions.charge(phase, action, n);
    }
    for request in requests {
        let action = if STREAMS.is_write(request.stream) { DRAM_WRITE } else { DRAM_READ };
        actions.charge(STREAMS.phase(request.stream), action, u64::from(request.bytes));
    }
    let alpha = hardware().action_called("alpha").map_or(0, |action| actions.total(action));
    let outcome = FlowOutcome::plain(timing, actions, replay.memory.traffic(), alpha);
    (outcome, replay.memory.recording())
}
