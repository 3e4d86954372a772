//! Gradient units and the parts of a step behind its frame (A146), block by block: what tiles and
//! batches of Gaussians take, from the assumptions in words.

use powergs_core::flow::steps::{StepPart, Updated};
use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::flow::tile_wise::gradients::FrameSums;
use powergs_core::flow::tile_wise::layout::{AccessPattern, Layout};
use powergs_core::flow::tile_wise::schedule::Plan;
use powergs_core::kernel::memory::answers_in;
use powergs_core::machine::{Machine, Ports};
use powergs_core::workload::{FrameWorkload, TileWork};
use powergs_dram::AddressRange;

use super::Memory;
use crate::oracle_blocks::{Block, Mover};

/// Gaussians of a batch.
const BATCH: u64 = 256;

/// Tiles between rendering units and gradient units of a core.
const KEPT: usize = 2;

/// What a piece of work takes: items, bytes in and out.
#[derive(Clone, Copy, Default)]
struct Piece {
    items: u64,
    read: u64,
    write: u64,
}

/// A step of training.
pub struct Step<'a> {
    machine: &'a Machine,
    design: &'a ResolvedUnits,
    workload: &'a FrameWorkload,
    plan: &'a Plan,
    sums: &'a FrameSums,
}

/// The gradient unit of a core.
pub struct Gru<'a> {
    step: &'a Step<'a>,
    core: usize,
    /// Tiles that it does not know of yet.
    handed: Vec<usize>,
    mover: Mover<AccessPattern>,
    /// Whether there are tiles, as far as it knows, that no gradient unit has done.
    pub waits_for_tiles: bool,
    /// Bytes of blocks so far, in and out.
    moved: [u64; 2],
    /// Where those of the part lie.
    places: [u64; 2],
}

fn ceil(n: u64, of: u64) -> u64 {
    n.div_ceil(of)
}

impl<'a> Step<'a> {
    /// `None` on machines that do not train.
    pub fn new(
        machine: &'a Machine,
        design: &'a ResolvedUnits,
        workload: &'a FrameWorkload,
        plan: &'a Plan,
        sums: Option<&'a FrameSums>,
    ) -> Option<Step<'a>> {
        let trains = machine.tiles().training.interval > 0;
        let step = |sums| Step { machine, design, workload, plan, sums };
        sums.filter(|_| trains).map(step)
    }

    pub fn is_behind(&self) -> bool {
        self.machine.tiles().gradients.behind
    }

    fn cores(&self) -> usize {
        self.machine.tiles().vru.cores as usize
    }

    /// Blends with a gradient: what stops a pixel has none.
    fn pairs(tile: &TileWork) -> u64 {
        tile.blends - u64::from(tile.stopped)
    }

    /// Bytes that are kept of the blends of a tile beyond what the buffer holds: a core has room
    /// for two groups of pixels, one that is rendered and one that goes back.
    fn spilled(&self, tile: &TileWork) -> u64 {
        let g = &self.machine.tiles().gradients;
        let group = g.buffer.capacity.0 / self.cores() as u64 / 2;
        let groups = ceil(tile.pixels.into(), g.pixels.into()).max(1);
        (Step::pairs(tile) * g.kept.0).saturating_sub(group * groups)
    }

    /// Bytes of sums that a tile fetches, and of those that leave for them.
    fn sum_bytes(&self, tile: usize) -> [u64; 2] {
        let moved = &self.sums.tiles[tile].moved;
        [0, 1].map(|way: usize| moved[way].len() as u64 * self.machine.tiles().training.record.0)
    }

    /// Bytes of features that a tile reads once more.
    fn features(&self, tile: &TileWork) -> (u64, u64) {
        let entries = if self.is_behind() { 0 } else { tile.loaded.into() };
        (entries, entries * self.design.ccu.record.feature.0)
    }

    /// A tile in reverse: cycles, and what it moves.
    fn reversed(&self, index: usize) -> Piece {
        let (t, g) = (&self.machine.tiles().training, &self.machine.tiles().gradients);
        let (tile, met) = (&self.workload.tiles[index], self.sums.tiles[index].met);
        let (pixels, record) = (u64::from(tile.pixels), t.record.0);
        let [fetched, left] = self.sum_bytes(index);
        let mut waits = Vec::new();
        let pairs = if self.is_behind() { Step::pairs(tile) } else { tile.alpha_evaluations };
        waits.push(ceil(pairs * u64::from(t.interval), g.lanes.into()));
        waits.push(met * u64::from(g.sum_cycles));
        if g.cache.capacity.0 > 0 {
            // A sum is read and written back, and all cores have the same part of the banks.
            let ways = if g.cache.ports == Ports::ReadOrWrite { 2 } else { 1 };
            let words = met * ceil(record, g.cache.word.0) * ways;
            waits.push(ceil(words * self.cores() as u64, g.cache.banks.into()));
        }
        waits.push(ceil(fetched / record * answers_in(&self.machine.memory()), g.misses.into()));
        let spilled = if self.is_behind() { self.spilled(tile) } else { 0 };
        let mut piece = Piece { read: fetched, write: left, ..Piece::default() };
        if self.is_behind() {
            waits.push(ceil(pixels * u64::from(t.loss), g.operations_per_cycle.into()));
            piece.read += pixels * self.design.ccu.record.pixel.0 + spilled;
            piece.write += spilled;
        } else {
            piece.read += u64::from(tile.loaded) * self.design.ccu.entry;
            piece.read += pixels * t.state.0 + self.features(tile).1;
        }
        piece.items = waits.into_iter().max().unwrap_or(0);
        piece
    }

    /// Batches of so many Gaussians, in turn: the core, the first and the one behind the last.
    fn batches(&self, all: u64) -> Vec<(usize, u64, u64)> {
        let mut batches = Vec::new();
        let (mut core, mut first) = (0, 0);
        while first < all {
            let end = all.min(first + BATCH);
            batches.push((core, first, end));
            (core, first) = ((core + 1) % self.cores(), end);
        }
        batches
    }

    /// What the cores do in a part, core by core.
    fn pieces(&self, part: StepPart) -> Vec<Vec<Piece>> {
        let mut all = vec![Vec::new(); self.cores()];
        let (t, record) = (&self.machine.tiles().training, &self.design.ccu.record);
        let geometry = record.position.0 + record.geometry.0;
        let stored = geometry + record.colour.0;
        let degree = u64::from(self.workload.sh_degree.get());
        let numbers = 11 + 3 * (degree + 1).pow(2);
        let points = self.workload.counters.points;
        // Those with a tile.
        let visible = self.workload.slot.iter().filter(|slot| **slot != u32::MAX).count() as u64;
        match part {
            StepPart::Loss if self.is_behind() => {}
            StepPart::Loss => {
                for (i, tile) in self.workload.tiles.iter().enumerate() {
                    let pixels = u64::from(tile.pixels);
                    all[i % self.cores()].push(Piece {
                        items: pixels * u64::from(t.loss),
                        read: 2 * pixels * record.pixel.0,
                        write: pixels * t.state.0,
                    });
                }
            }
            StepPart::Reverse => {
                for (i, &tile) in self.plan.tiles.iter().enumerate() {
                    all[i % self.cores()].push(self.reversed(tile as usize));
                }
            }
            StepPart::Chain => {
                // What is left in the cache goes out first.
                let write = self.sums.left * t.record.0;
                all[0].push(Piece { write, ..Piece::default() });
                let is_pose = t.update == Updated::Pose;
                let (read, write) = match is_pose {
                    true => (geometry, 0),
                    false => (stored, numbers * t.widths.gradient.0),
                };
                for (core, first, end) in self.batches(visible) {
                    let until = |n: u64| self.sums.touched * n / visible;
                    let (own, sums) = (end - first, until(end) - until(first));
                    all[core].push(Piece {
                        items: own * u64::from(t.chain) + sums * ceil(t.record.0, 4),
                        read: sums * t.record.0 + own * read,
                        write: own * write,
                    });
                }
            }
            StepPart::Update => {
                let updated = match t.update {
                    Updated::All => points,
                    Updated::Visible => visible,
                    Updated::None | Updated::Pose => 0,
                };
                let (values, moments) = (t.widths.parameter.0, 2 * t.widths.moment.0);
                let copy = if numbers * values == stored { 0 } else { stored };
                for (core, first, end) in self.batches(updated) {
                    let own = end - first;
                    all[core].push(Piece {
                        items: own * numbers * u64::from(t.step),
                        read: own * numbers * (values + t.widths.gradient.0 + moments),
                        write: own * (numbers * (values + moments) + copy),
                    });
                }
                if t.densify > 0 {
                    // Two numbers of what is visible, and a part of moving all there is.
                    let arrays = if moments > 0 { 3 } else { 1 };
                    let part = |all: u64| ceil(all * points, t.densify.into());
                    let whole = 2 * visible + part(numbers * arrays);
                    let bytes = 8 * visible + part(numbers * (values + moments));
                    for (core, first, end) in self.batches(points) {
                        let of = |all: u64| ceil(all * end, points) - ceil(all * first, points);
                        let (items, bytes) = (of(whole), of(bytes));
                        all[core].push(Piece { items, read: bytes, write: bytes });
                    }
                }
            }
        }
        all
    }

    /// Where what a core moves in a part begins: its even share of what all of them move.
    fn places(&self, part: StepPart, core: usize, layout: &Layout) -> [u64; 2] {
        let all: Vec<Piece> = self.pieces(part).concat();
        let sums = [all.iter().map(|p| p.read).sum(), all.iter().map(|p| p.write).sum::<u64>()];
        let sums: [u64; 2] = sums;
        [0, 1].map(|way| layout.step(part)[way] + sums[way] / self.cores() as u64 * core as u64)
    }
}

impl<'a> Gru<'a> {
    /// One that waits for tiles of its core.
    pub fn new(step: &'a Step<'a>, core: usize, layout: &Layout) -> Gru<'a> {
        Gru {
            step,
            core,
            handed: Vec::new(),
            mover: Mover::new(["reverse-in", "gradients"], 1),
            waits_for_tiles: false,
            moved: [0; 2],
            places: step.places(StepPart::Reverse, core, layout),
        }
    }

    /// Takes up a part of a step behind the frame.
    pub fn begin(&mut self, part: StepPart, layout: &Layout) {
        let step = self.step;
        let operations = u64::from(step.machine.tiles().gradients.operations_per_cycle);
        let (streams, rate) = match part {
            StepPart::Loss => (["reverse-in", "gradients"], operations),
            StepPart::Reverse => (["reverse-in", "gradients"], 1),
            StepPart::Chain | StepPart::Update => (["step-in", "step-out"], operations),
        };
        (self.mover, self.waits_for_tiles) = (Mover::new(streams, rate), false);
        (self.moved, self.places) = ([0; 2], step.places(part, self.core, layout));
        if part == StepPart::Reverse {
            let cores = step.cores();
            let own = step.plan.tiles.iter().skip(self.core).step_by(cores);
            own.for_each(|&tile| self.push_tile(tile as usize));
            return;
        }
        for piece in step.pieces(part).swap_remove(self.core) {
            let [read, write] = self.ranges(piece).map(AccessPattern::Run);
            let (read, write) = ((piece.read, read), (piece.write, write));
            self.mover.push(Block { items: piece.items, read, write });
        }
    }

    /// The bytes behind those of the blocks before.
    fn ranges(&mut self, piece: Piece) -> [AddressRange; 2] {
        let bytes = [piece.read, piece.write];
        [0, 1].map(|way| {
            let address = self.places[way] + self.moved[way];
            self.moved[way] += bytes[way];
            AddressRange { address, bytes: bytes[way] }
        })
    }

    fn push_tile(&mut self, index: usize) {
        let (step, tile) = (self.step, &self.step.workload.tiles[index]);
        let piece = step.reversed(index);
        let (entries, features) = step.features(tile);
        let apart = step.sum_bytes(index);
        let ranges = self.ranges(piece);
        let of = |way: usize| {
            let sums = &step.sums.tiles[index].moved[way];
            let (entries, features) = if way == 0 { (entries, features) } else { (0, 0) };
            let AddressRange { address, bytes } = ranges[way];
            AccessPattern::Gradients {
                run: AddressRange { address, bytes: bytes - features - apart[way] },
                list: (tile.list_start.into(), entries),
                way,
                sums: (sums.start, sums.end),
            }
        };
        let (read, write) = ((piece.read, of(0)), (piece.write, of(1)));
        self.mover.push(Block { items: piece.items, read, write });
    }

    /// Its core has rendered a tile.
    pub fn hand(&mut self, tile: usize) {
        self.handed.push(tile);
    }

    /// Whether its core may begin another tile.
    pub fn admits(&self) -> bool {
        self.handed.len() + self.mover.left() < KEPT
    }

    pub fn step(&mut self, now: u64, memory: &mut Memory) {
        for tile in std::mem::take(&mut self.handed) {
            self.push_tile(tile);
        }
        self.mover.step(now, memory);
    }

    pub fn is_done(&self) -> bool {
        self.handed.is_empty() && self.mover.is_done()
    }

    /// Tiles that it has taken up and done.
    pub fn done(&self) -> usize {
        self.mover.done()
    }

    pub fn symbol(&self) -> char {
        match self.mover.left() {
            0 if self.waits_for_tiles => 'i',
            _ => self.mover.symbol(),
        }
    }

    pub fn tick(&mut self) {
        self.mover.tick();
    }
}
