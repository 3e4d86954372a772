//! A unit of the oracles that takes blocks through the memory, counting down (A141, A146): each is
//! read, worked on and written, while those behind it are read.

use std::collections::VecDeque;

use powergs_core::flow::over::levels::LevelsSpec;
use powergs_core::kernel::memory::Layout;
use powergs_dram::AddressRange;

use crate::oracle_memory::{Memory, Ticket};

/// Blocks that are read behind the one at work, and that may be on their way out before the next
/// one begins.
const AHEAD: usize = 4;

/// A block: what there is to do, and what is moved for it.
pub struct Block<P> {
    pub items: u64,
    pub read: (u64, P),
    pub write: (u64, P),
}

/// The unit.
pub struct Mover<P> {
    /// What it reads and writes.
    streams: [&'static str; 2],
    /// Items a cycle.
    rate: u64,
    /// What it waits for where its bytes are on their way.
    waits: char,
    blocks: Vec<Block<P>>,
    asked: usize,
    done: usize,
    /// Reads under way, oldest first; `None` where there was nothing to read.
    reads: VecDeque<Option<Ticket>>,
    /// What is left of the block at work.
    left: Option<u64>,
    writes: VecDeque<Ticket>,
}

/// The unit that traverses levels, where a machine has one: what it looks at for `points`
/// Gaussians, from the words of the rule (A152).
pub fn levels<P: Copy>(
    spec: &LevelsSpec,
    points: u64,
    mut places: [u64; 2],
    range: impl Fn(AddressRange) -> P,
) -> Option<Mover<P>> {
    if spec.gaussians == 0 {
        return None;
    }
    let mut unit = Mover::new(["levels-in", "levels-out"], spec.operations_per_cycle.into());
    unit.waits = 'r';
    let cut = points.div_ceil(spec.gaussians.into());
    let mut left = cut.div_ceil(spec.period.into());
    // A fifth of the buffer for the one at work, and for each of four that are read ahead.
    let most = (spec.buffer.capacity.0 / 5 / (spec.record.0 + spec.entry.0)).max(1);
    while left > 0 {
        let own = most.min(left);
        let nodes = own + own.div_ceil(spec.children.into());
        let bytes = [nodes * spec.record.0 + own * spec.entry.0, own * spec.entry.0];
        let [read, write] = [0, 1].map(|way| {
            let address = places[way];
            places[way] += bytes[way];
            (bytes[way], range(AddressRange { address, bytes: bytes[way] }))
        });
        unit.push(Block { items: nodes * u64::from(spec.operations), read, write });
        left -= own;
    }
    Some(unit)
}

impl<P: Copy> Mover<P> {
    pub fn new(streams: [&'static str; 2], rate: u64) -> Mover<P> {
        Mover {
            streams,
            rate,
            waits: 'f',
            blocks: Vec::new(),
            asked: 0,
            done: 0,
            reads: VecDeque::new(),
            left: None,
            writes: VecDeque::new(),
        }
    }

    pub fn push(&mut self, block: Block<P>) {
        self.blocks.push(block);
    }

    /// Blocks that are not done.
    pub fn left(&self) -> usize {
        self.blocks.len() - self.done
    }

    /// Blocks that are.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Whether all is done and written.
    pub fn is_done(&self) -> bool {
        self.left() == 0 && self.writes.is_empty()
    }

    pub fn step<L: Layout<Pattern = P>>(&mut self, now: u64, memory: &mut Memory<L>) {
        // Room behind it is given back in order.
        while self.writes.front().is_some_and(|&write| memory.is_done(write, now)) {
            self.writes.pop_front();
        }
        if self.left == Some(0) {
            self.left = None;
            let (bytes, place) = self.blocks[self.done].write;
            if bytes > 0 {
                self.writes.push_back(memory.write(now, self.streams[1], bytes, place));
            }
            self.done += 1;
        }
        while self.asked < self.blocks.len() && self.asked < self.done + 1 + AHEAD {
            let (bytes, place) = self.blocks[self.asked].read;
            let read = (bytes > 0).then(|| memory.read(now, self.streams[0], bytes, place));
            self.reads.push_back(read);
            self.asked += 1;
        }
        if self.left.is_none() && self.has_room() {
            let is_here = |read: &mut Option<Ticket>| read.is_none_or(|r| memory.is_done(r, now));
            if self.reads.pop_front_if(is_here).is_some() {
                let mut cycles = 1;
                while cycles * self.rate < self.blocks[self.done].items {
                    cycles += 1;
                }
                self.left = Some(cycles);
            }
        }
    }

    fn has_room(&self) -> bool {
        self.writes.len() < AHEAD
    }

    pub fn symbol(&self) -> char {
        match (self.left, self.reads.is_empty()) {
            (Some(_), _) => char::from(b'0' + (self.done % 10) as u8),
            (None, true) => '.',
            (None, false) if !self.has_room() => 'o',
            (None, false) => self.waits,
        }
    }

    pub fn tick(&mut self) {
        if let Some(left) = &mut self.left {
            *left -= 1;
        }
    }
}
