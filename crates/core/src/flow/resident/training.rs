//! Training on resident pixels (`training`; A145): what follows a frame.
//!
//! Parts follow each other, each when the one before has ended. **Loss**: units of the front
//! compare the picture with a photo, region by region. **Reverse**: each engine takes the lists of
//! its regions again, from the back: `training.interval` times the steps of before, because lanes
//! share their pixels between transmittance and gradients; nothing stops. What its lanes have added
//! up for an entry is written. **Chain**: units of the front put the parts of a Gaussian together,
//! and find gradients by its parameters. **Update**: they take values, gradients and moments
//! through the memory. Regions and Gaussians are dealt round.

use super::stages::{
    FRONT, GAUSSIANS, PIXELS, RASTER, RECORDS, RESULTS, WAITS_FEATURES, WAITS_RECORDS,
};
use super::work::ResidentFrame;
use super::{Engine, FrontUnit, Layout, Place, Resident, STREAMS};
use crate::flow::steps::{StepEnds, StepPart, SteppedGaussians};
use crate::kernel::blocks::{BlockStream, BlockUnit, MovedBlock};
use crate::kernel::memory::Memory;
use crate::kernel::stream::StreamId;
use crate::kernel::timeline::Observer;
use crate::kernel::{self, drive};
use crate::stage::{DRAM_READ, DRAM_WRITE, sram_read, sram_write, work_id};
use powergs_energy::action::{ActionCounts, ActionId, Phase};

/// What a part of a step reads and writes.
const fn streams(part: StepPart) -> [StreamId; 2] {
    match part {
        StepPart::Loss | StepPart::Reverse => REVERSE,
        StepPart::Chain | StepPart::Update => PARAMETERS,
    }
}

const REVERSE: [StreamId; 2] = [STREAMS.id("reverse-in"), STREAMS.id("gradients")];
const PARAMETERS: [StreamId; 2] = [STREAMS.id("step-in"), STREAMS.id("step-out")];
const OPERATION: ActionId = work_id("simt-operation");
const GRADIENT: ActionId = work_id("gradient-pixel");
const ROW: ActionId = work_id("row");

/// What follows a frame.
#[derive(Debug)]
pub struct Step {
    /// Blocks of each part, unit by unit.
    parts: [Vec<Vec<MovedBlock>>; StepPart::ALL.len()],
    rates: [u64; StepPart::ALL.len()],
    /// Operations of units of the front, and pixels that lanes go through in reverse.
    operations: [u64; StepPart::ALL.len()],
    pixels: u64,
    /// Rows whose ends are found in reverse.
    rows: u64,
    /// Bytes of a pixel while it is worked on.
    pixel_state: u64,
}

impl Step {
    /// Of a frame; `None` on machines that do not train.
    pub fn new(m: &Resident, frame: &ResidentFrame) -> Option<Step> {
        let t = &m.training;
        if t.interval == 0 {
            return None;
        }
        let (fronts, engines) = (m.front.units as usize, m.raster.engines as usize);
        let mut parts = [fronts, engines, fronts, fronts].map(|units| vec![Vec::new(); units]);
        let (g, mut pixels, mut rows) = (&m.gaussian, 0, 0);
        for (i, region) in frame.regions.iter().enumerate() {
            let n = u64::from(region.pixels);
            parts[0][i % fronts].push(MovedBlock {
                items: n * u64::from(t.loss),
                read: 2 * n * g.pixel.0,
                write: n * t.state.0,
            });
            let list = &frame.entries[region.start as usize..][..region.entries as usize];
            let cycles: u64 = list.iter().map(|entry| m.entry_cycles(entry)).sum();
            rows += list.iter().map(|entry| u64::from(entry.rows)).sum::<u64>();
            pixels += list.iter().map(|entry| u64::from(entry.pixels)).sum::<u64>();
            let entries = u64::from(region.entries);
            parts[1][i % engines].push(MovedBlock {
                items: cycles * u64::from(t.interval),
                read: m.chunk_bytes(entries) + n * t.state.0,
                write: entries * t.record.0,
            });
        }
        let gaussians = SteppedGaussians {
            points: frame.counters.points,
            visible: frame.index.len() as u64,
            sums: frame.entries.len() as u64,
            stored: [g.position.0 + g.shape.0, g.position.0 + g.shape.0 + g.colour.0],
            numbers: SteppedGaussians::numbers_of(frame.sh_degree),
        };
        parts[2] = t.chain(&gaussians, fronts);
        parts[3] = t.update(&gaussians, fronts);
        let rate = u64::from(m.front.operations_per_cycle);
        let sum = |part: &Vec<Vec<MovedBlock>>| part.iter().flatten().map(|b| b.items).sum::<u64>();
        let operations = [sum(&parts[0]), 0, sum(&parts[2]), sum(&parts[3])];
        let pixel_state = m.raster.pixel_state.0;
        let rates = [rate, 1, rate, rate];
        Some(Step { parts, rates, operations, pixels, rows, pixel_state })
    }

    /// Takes it through a machine from cycle `begins` on; returns when its parts ended.
    pub fn run<'a, O: Observer>(
        &self,
        begins: u64,
        front: &mut [FrontUnit],
        engines: &mut [Engine],
        memory: &mut Memory<'a, Layout<'a>>,
        observer: &mut O,
    ) -> StepEnds {
        let mut ends = [begins; StepPart::ALL.len()];
        let mut end = begins;
        for (part, ends) in StepPart::ALL.into_iter().zip(&mut ends) {
            let places = memory.layout().step(part);
            let mut offset = places;
            let (stage, waits) = match part {
                StepPart::Reverse => (RASTER, WAITS_FEATURES),
                _ => (FRONT, WAITS_RECORDS),
            };
            let blocks = &self.parts[part as usize];
            let mut streams: Vec<BlockStream> = (0..)
                .zip(blocks)
                .map(|(owner, blocks)| {
                    let unit = BlockUnit {
                        stage,
                        owner,
                        rate: self.rates[part as usize],
                        streams: streams(part),
                        places: offset,
                        waits,
                    };
                    // The blocks of all units are one array, each unit's behind those of the unit
                    // before.
                    let moved = BlockStream::bytes(blocks);
                    offset = [offset[0] + moved[0], offset[1] + moved[1]];
                    // Accounts go on from the frame, so that every cycle of the step is in them,
                    // too.
                    let account = match part {
                        StepPart::Reverse => engines[owner as usize].accounts[0].take(),
                        _ => Some(front[owner as usize].account.clone()),
                    };
                    let account = account.expect("every engine has a raster");
                    BlockStream::resumed(unit, blocks, account, end)
                })
                .collect();
            let count = streams.len();
            drive(&mut StepUnits { streams: &mut streams, memory, observer }, 0..count, end);
            end = streams.iter().map(|stream| stream.end).fold(end, u64::max);
            for (n, mut stream) in streams.into_iter().enumerate() {
                stream.account.up_to(end, observer);
                match part {
                    StepPart::Reverse => engines[n].accounts[0] = Some(stream.account),
                    _ => front[n].account = stream.account,
                }
            }
            *ends = end;
        }
        ends
    }

    /// Charges what it does.
    pub fn charge(&self, all: &mut ActionCounts) {
        for part in StepPart::ALL {
            let [read, write] = BlockStream::bytes(&self.parts[part as usize].concat());
            all.charge(part.phase(), DRAM_READ, read);
            all.charge(part.phase(), DRAM_WRITE, write);
            all.charge(part.phase(), OPERATION, self.operations[part as usize]);
            // What comes from memory and goes there passes through the buffers of its units.
            let (input, output) = match part {
                StepPart::Reverse => (GAUSSIANS, RESULTS),
                _ => (RECORDS, RESULTS),
            };
            for (buffer, bytes) in [(input, read), (output, write)] {
                all.charge(part.phase(), sram_write(buffer), bytes);
                all.charge(part.phase(), sram_read(buffer), bytes);
            }
        }
        all.charge(Phase::Rendering, GRADIENT, self.pixels);
        all.charge(Phase::Rendering, ROW, self.rows);
        // Lanes read a pixel and write it back, as in the frame.
        all.charge(Phase::Rendering, sram_read(PIXELS), self.pixels * self.pixel_state);
        all.charge(Phase::Rendering, sram_write(PIXELS), self.pixels * self.pixel_state);
    }

    /// Bytes that a part reads and writes.
    pub fn bytes(&self, part: StepPart) -> [u64; 2] {
        BlockStream::bytes(&self.parts[part as usize].concat())
    }
}

/// Units in a part of a step.
struct StepUnits<'s, 'a, O> {
    streams: &'s mut [BlockStream],
    memory: &'s mut Memory<'a, Layout<'a>>,
    observer: &'s mut O,
}

impl<O: Observer> kernel::Agents for StepUnits<'_, '_, O> {
    fn step(&mut self, agent: usize, now: u64) -> u64 {
        self.streams[agent].step(now, self.memory, |_, at| Place::Range(at), self.observer)
    }

    fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        self.memory.advance(until)
    }
}
