//! Gradient units: one behind each core, and what follows the frame.

use super::{Agents, Shared};
use crate::flow::steps::{StepEnds, StepPart};
use crate::flow::tile_wise::gradients::{GRU, GradientWork, streams};
use crate::flow::tile_wise::layout::{AccessPattern, Layout};
use crate::flow::tile_wise::vru::FEATURES;
use crate::kernel::blocks::{BlockStream, BlockUnit};
use crate::kernel::ledger::Account;
use crate::kernel::timeline::{Observer, State};
use crate::stage::Stall;

/// Tiles between rendering units and gradient units.
#[derive(Debug)]
pub(super) struct HandedTiles {
    /// Those that no gradient unit knows of, core by core.
    handed: Vec<Vec<u32>>,
    /// Those that are not done.
    waiting: Vec<usize>,
    /// Tiles of the frame, and those that are done.
    all: usize,
    done: usize,
    /// Who has to look again.
    changed: Option<LooksAgain>,
}

/// Who has to look again at tiles that were handed on, or are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LooksAgain {
    /// The gradient unit of a core, which has one more tile.
    Unit(usize),
    /// A core that may have been held.
    Core(usize),
}

/// Tiles of a core that are kept at a time: one that is rendered, one whose gradients are found.
const KEPT_TILES: usize = 2;

impl HandedTiles {
    /// For a frame of so many tiles.
    pub(super) fn new(cores: usize, all: usize) -> HandedTiles {
        let (handed, waiting) = (vec![Vec::new(); cores], vec![0; cores]);
        HandedTiles { handed, waiting, all, done: 0, changed: None }
    }

    /// Whether a core may begin a tile.
    pub(super) fn admits(&self, core: u32) -> bool {
        self.waiting[core as usize] < KEPT_TILES
    }

    /// A core has rendered a tile.
    pub(super) fn hand(&mut self, core: u32, tile: u32) {
        self.handed[core as usize].push(tile);
        self.waiting[core as usize] += 1;
        self.changed = Some(LooksAgain::Unit(core as usize));
    }

    /// Whether all tiles of the frame are done.
    pub(super) fn is_over(&self) -> bool {
        self.done == self.all
    }

    /// Who has to look again; asks once. No other agent is woken: a core that is woken without need
    /// would be taken to work until then.
    pub(super) fn take_change(&mut self) -> Option<LooksAgain> {
        self.changed.take()
    }
}

/// The gradient unit of a core.
#[derive(Debug)]
pub(super) struct GradientUnit {
    core: u32,
    owner: u32,
    stream: BlockStream,
    /// The tiles of its blocks.
    tiles: Vec<u32>,
}

impl GradientUnit {
    /// One that waits for tiles.
    pub(super) fn new(work: &GradientWork, core: u32, owner: u32, layout: &Layout) -> GradientUnit {
        let own = StreamParts { work, layout, core, owner };
        let account = Account::new(GRU, core);
        let stream = own.stream(StepPart::Reverse, account, 0);
        GradientUnit { core, owner, stream, tiles: Vec::new() }
    }

    pub(super) fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.stream.account.up_to(now, observer);
    }

    /// Its account.
    pub(super) fn booked(&self) -> &Account {
        &self.stream.account
    }

    /// When what it had to do was done.
    pub(super) fn end(&self) -> u64 {
        self.stream.end
    }

    pub(super) fn step<O: Observer>(
        &mut self,
        now: u64,
        work: &GradientWork,
        shared: &mut Shared<O>,
    ) -> u64 {
        let Shared { memory, observer, handed, .. } = shared;
        let core = self.core as usize;
        if let Some(handed) = handed {
            for tile in handed.handed[core].drain(..) {
                self.stream.push(work.tile(tile));
                self.tiles.push(tile);
            }
        }
        let tiles = &self.tiles;
        let next = self.stream.step(
            now,
            memory,
            |ask, at| match tiles.get(ask.block) {
                Some(&tile) => work.pattern(tile, ask, at),
                None => AccessPattern::Run(at),
            },
            *observer,
        );
        if let Some(handed) = handed {
            let left = self.stream.left();
            handed.done += handed.waiting[core].saturating_sub(left);
            if left == 0 && handed.done < handed.all {
                // Its core has not rendered the next one.
                self.stream.account.is(State::Stalled(Stall::INPUT));
            }
            if left < KEPT_TILES && handed.waiting[core] >= KEPT_TILES {
                handed.changed = Some(LooksAgain::Core(core));
            }
            handed.waiting[core] = left;
        }
        next
    }

    /// No tile will come any more: whoever waits for one has no work.
    pub(super) fn rest(&mut self, now: u64, observer: &mut impl Observer) {
        if self.stream.left() == 0 {
            self.stream.account.up_to(now, observer);
            self.stream.account.is(State::Idle);
        }
    }

    /// Takes up a part of a step.
    fn begin(&mut self, part: StepPart, work: &GradientWork, layout: &Layout, now: u64) {
        let own = StreamParts { work, layout, core: self.core, owner: self.owner };
        self.stream = own.stream(part, self.stream.account.clone(), now);
        self.tiles.clear();
        if part == StepPart::Reverse {
            let tiles = layout.tiles().iter().skip(self.core as usize).step_by(work.cores());
            for &tile in tiles {
                self.stream.push(work.tile(tile));
                self.tiles.push(tile);
            }
        }
    }
}

/// What follows a frame that ended in cycle `frame`; returns when its parts ended.
pub(super) fn follow<'a, O: Observer>(
    agents: &mut Agents<'a>,
    frame: u64,
    shared: &mut Shared<'a, O>,
) -> StepEnds {
    // Rendering is over, and what comes now are no tiles.
    shared.handed = None;
    let which = agents.of_frame()..agents.all();
    let mut end = frame;
    StepPart::ALL.map(|part| {
        let Agents { gradients, work: Some(work), .. } = &mut *agents else { return end };
        // With `behind` the loss and the gradients of a tile were found while the frame was
        // rendered.
        let is_done = work.is_behind() && matches!(part, StepPart::Loss | StepPart::Reverse);
        if !is_done {
            for unit in gradients.iter_mut() {
                unit.account(end, shared.observer);
                unit.begin(part, work, shared.memory.layout(), end);
            }
            agents.drive(which.clone(), end, shared);
        }
        // Units that worked during the frame may end after it: that is time of the reverse part,
        // and none of the loss.
        if part != StepPart::Loss || !is_done {
            end = agents.gradients.iter().map(GradientUnit::end).fold(end, u64::max);
        }
        end
    })
}

/// What a stream of a unit is made of.
struct StreamParts<'a> {
    work: &'a GradientWork<'a>,
    layout: &'a Layout<'a>,
    core: u32,
    owner: u32,
}

impl StreamParts<'_> {
    /// Of a part of a step, from cycle `begins` on.
    fn stream(&self, part: StepPart, account: Account, begins: u64) -> BlockStream {
        let (bytes, places) = (self.work.bytes(part), self.layout.step(part));
        // Where an even share would begin: a core that takes more runs into what the layout has
        // spare.
        let share = |way: usize| bytes[way] / self.work.cores() as u64 * u64::from(self.core);
        let unit = BlockUnit {
            stage: GRU,
            owner: self.owner,
            rate: self.work.rate(part),
            streams: streams(part),
            places: [places[0] + share(0), places[1] + share(1)],
            waits: FEATURES,
        };
        let blocks = self.work.blocks(part);
        BlockStream::resumed(unit, &blocks[self.core as usize], account, begins)
    }
}
