//! Blocks of threads over multiprocessors.
//!
//! Blocks are handed out in their order: first one after the other to each multiprocessor until
//! all have as many as they can have at a time, then to the one that ends a block first. The
//! blocks of a multiprocessor share its issue slots evenly, but none is faster than it is alone:
//! its slowest warp goes from one instruction to the next, and waits for its batches.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreadBlock {
    /// Cycles of a whole multiprocessor.
    pub work: f64,
    /// Cycles that it takes alone, at least its work.
    pub alone: f64,
}

/// A block at work.
#[derive(Debug, Clone, Copy)]
struct BlockShare {
    left: f64,
    most: f64,
    rate: f64,
}

#[derive(Debug, Clone, Default)]
struct Multiprocessor {
    now: f64,
    blocks: Vec<BlockShare>,
}

impl Multiprocessor {
    fn take(&mut self, block: &ThreadBlock) {
        // What has no work is there for a moment.
        let work = block.work.max(1e-3);
        self.blocks.push(BlockShare { left: work, most: work / block.alone.max(work), rate: 0.0 });
    }

    /// Shares the issue slots; returns when the next block ends.
    fn share(&mut self) -> f64 {
        // The slowest first: what they leave is for the others.
        self.blocks.sort_by(|a, b| a.most.total_cmp(&b.most));
        let (mut room, mut others) = (1.0, self.blocks.len());
        for block in &mut self.blocks {
            block.rate = block.most.min(room / others as f64);
            room -= block.rate;
            others -= 1;
        }
        let ends = self.blocks.iter().map(|block| self.now + block.left / block.rate);
        ends.fold(f64::INFINITY, f64::min)
    }

    /// Goes on to a time, and lets go of what has ended.
    fn up_to(&mut self, then: f64) {
        let passed = then - self.now;
        self.now = then;
        for block in &mut self.blocks {
            block.left -= block.rate * passed;
        }
        // The one that ends now is among them, whatever rounding left of it.
        let least = self.blocks.iter().map(|b| b.left / b.rate).fold(f64::INFINITY, f64::min);
        self.blocks.retain(|block| block.left / block.rate > least.max(1e-9));
    }
}

/// When something happens on a multiprocessor: earliest first, then by number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BlockEnd(f64, usize);

impl Eq for BlockEnd {}

impl Ord for BlockEnd {
    fn cmp(&self, other: &BlockEnd) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for BlockEnd {
    fn partial_cmp(&self, other: &BlockEnd) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// When each of `units` multiprocessors has ended its last block, cycles: each has `resident`
/// blocks at a time.
pub fn ends(blocks: impl Iterator<Item = ThreadBlock>, units: u32, resident: u32) -> Vec<f64> {
    let mut all = vec![Multiprocessor::default(); units as usize];
    let mut blocks = blocks.peekable();
    for _ in 0..resident {
        for unit in &mut all {
            if let Some(block) = blocks.next() {
                unit.take(&block);
            }
        }
    }
    let mut queue: BinaryHeap<Reverse<BlockEnd>> = BinaryHeap::new();
    for (i, unit) in all.iter_mut().enumerate() {
        queue.push(Reverse(BlockEnd(unit.share(), i)));
    }
    while let Some(Reverse(BlockEnd(then, i))) = queue.pop() {
        if then == f64::INFINITY {
            continue;
        }
        let unit = &mut all[i];
        unit.up_to(then);
        while unit.blocks.len() < resident as usize {
            let Some(block) = blocks.next() else { break };
            unit.take(&block);
        }
        queue.push(Reverse(BlockEnd(unit.share(), i)));
    }
    all.into_iter().map(|unit| unit.now).collect()
}
