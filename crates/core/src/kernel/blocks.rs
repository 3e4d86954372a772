//! A unit that takes something through the memory block by block: each block is read, worked on,
//! and written, while the next ones are read.

use std::collections::VecDeque;

use super::ledger::Account;
use super::memory::{Arrival, Layout, Memory, NEVER, Request};
use super::stream::StreamId;
use super::timeline::{Observer, State};
use crate::kernel::Stall;
use powergs_dram::AddressRange;
use powergs_energy::action::StageId;

/// A block.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MovedBlock {
    /// Items that are worked on one after the other.
    pub items: u64,
    /// Bytes that are read for it.
    pub read: u64,
    /// Bytes that are written of it.
    pub write: u64,
}

/// The unit that works on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockUnit {
    /// Its stage.
    pub stage: StageId,
    /// The agent that it is.
    pub owner: u32,
    /// Items a cycle.
    pub rate: u64,
    /// What it reads and writes.
    pub streams: [StreamId; 2],
    /// Where these begin.
    pub places: [u64; 2],
    /// What it waits for where its bytes are on their way.
    pub waits: Stall,
}

/// Blocks that are read ahead of the one at work, and written behind it (A141).
pub const AHEAD: usize = 4;

/// What a unit asks for: this block, read (0) or written (1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockMove {
    /// Which one.
    pub block: usize,
    /// Which way.
    pub way: usize,
}

/// Blocks on their way.
#[derive(Debug)]
pub struct BlockStream {
    unit: BlockUnit,
    blocks: Vec<MovedBlock>,
    /// What it did when.
    pub account: Account,
    /// Blocks that were asked for.
    asked: usize,
    /// Bytes of blocks that were asked for, and written.
    moved: [u64; 2],
    reading: VecDeque<Arrival>,
    /// Blocks that are done.
    done: usize,
    /// When the one at work is.
    working: Option<u64>,
    writing: VecDeque<Arrival>,
    /// When the last write was complete.
    pub end: u64,
}

impl BlockStream {
    /// Before its first block.
    pub fn new(unit: BlockUnit, blocks: &[MovedBlock]) -> BlockStream {
        BlockStream {
            unit,
            blocks: blocks.to_vec(),
            account: Account::new(unit.stage, 0),
            asked: 0,
            moved: [0; 2],
            reading: VecDeque::new(),
            done: 0,
            working: None,
            writing: VecDeque::new(),
            end: 0,
        }
    }

    /// As [`BlockStream::new`], of a unit with this account, from cycle `begins` on.
    pub fn resumed(
        unit: BlockUnit,
        blocks: &[MovedBlock],
        account: Account,
        begins: u64,
    ) -> BlockStream {
        BlockStream { account, end: begins, ..BlockStream::new(unit, blocks) }
    }

    /// Its stage.
    pub const fn stage(&self) -> StageId {
        self.unit.stage
    }

    /// One more block, behind all others.
    pub fn push(&mut self, block: MovedBlock) {
        self.blocks.push(block);
    }

    /// Blocks that are not done.
    pub fn left(&self) -> usize {
        self.blocks.len() - self.done
    }

    /// Bytes that the blocks read and write.
    pub fn bytes(blocks: &[MovedBlock]) -> [u64; 2] {
        blocks.iter().fold([0; 2], |[read, write], block| [read + block.read, write + block.write])
    }

    /// Acts in cycle `now`; returns when it does so next.
    pub fn step<L: Layout>(
        &mut self,
        now: u64,
        memory: &mut Memory<'_, L>,
        span: impl Fn(BlockMove, AddressRange) -> L::Pattern,
        observer: &mut impl Observer,
    ) -> u64 {
        self.account.up_to(now, observer);
        let retired = |memory: &Memory<'_, L>, write: &Arrival| memory.at(*write) <= now;
        while self.writing.front().is_some_and(|write| retired(memory, write)) {
            self.writing.pop_front();
            self.end = now;
        }
        if self.working.is_some_and(|end| end <= now) {
            self.working = None;
            let bytes = self.blocks[self.done].write;
            self.done += 1;
            self.end = now;
            if bytes > 0 {
                let ask = BlockMove { block: self.done - 1, way: 1 };
                let write = self.ask(now, ask, bytes, memory, &span, observer);
                self.writing.push_back(write);
            }
        }
        while self.asked < self.blocks.len() && self.asked <= self.done + AHEAD {
            let bytes = self.blocks[self.asked].read;
            let ask = BlockMove { block: self.asked, way: 0 };
            self.asked += 1;
            let read = match bytes {
                0 => Arrival::NOW,
                bytes => self.ask(now, ask, bytes, memory, &span, observer),
            };
            self.reading.push_back(read);
        }
        let next = self.reading.front().copied();
        let has_room = self.writing.len() < AHEAD;
        if let (None, Some(read), true) = (self.working, next, has_room)
            && memory.at(read) <= now
        {
            self.reading.pop_front();
            let cycles = self.blocks[self.done].items.div_ceil(self.unit.rate.max(1));
            self.working = Some(now + cycles.max(1));
        }
        self.account.is(match (self.working, self.reading.front()) {
            (Some(_), _) => State::Busy(self.done as u32),
            (None, None) => State::Idle,
            (None, Some(_)) if !has_room => State::Stalled(Stall::OUTPUT),
            (None, Some(_)) => State::Stalled(self.unit.waits),
        });
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let read = self.reading.front().map_or(NEVER, |read| later(memory.at(*read)));
        let write = self.writing.front().map_or(NEVER, |write| later(memory.at(*write)));
        self.working.unwrap_or(read).min(write)
    }

    fn ask<L: Layout>(
        &mut self,
        now: u64,
        ask: BlockMove,
        bytes: u64,
        memory: &mut Memory<'_, L>,
        span: impl Fn(BlockMove, AddressRange) -> L::Pattern,
        observer: &mut impl Observer,
    ) -> Arrival {
        let BlockMove { way, .. } = ask;
        let address = self.unit.places[way] + self.moved[way];
        self.moved[way] += bytes;
        let request = Request { owner: self.unit.owner, stream: self.unit.streams[way], bytes };
        memory.issue(now, request, |_| span(ask, AddressRange { address, bytes }), observer)
    }
}
