//! A pair of views is one frame: what its right eye adds to the report of the left one.
//!
//! A display shows both eyes in one period, and the machine renders them one after the other.
//! Times, counts, bytes and joules add up; what a buffer held at most is the larger of the two.

use super::{
    CycleReport, FoveaSummary, Foveal, FrameReport, ModelReport, PaperReport, RegionReport,
    StageBytes,
};
use crate::kernel::{BufferUse, DramUse, FrameTiming};
use powergs_energy::Standby;
use powergs_frame::scene::Eye;

/// What something and what follows it are together.
trait Then {
    fn then(&mut self, next: Self);
}

impl Then for u64 {
    fn then(&mut self, next: u64) {
        *self += next;
    }
}

impl<T: Then, const N: usize> Then for [T; N] {
    fn then(&mut self, next: [T; N]) {
        self.iter_mut().zip(next).for_each(|(a, b)| a.then(b));
    }
}

/// Only where both have it.
impl<T: Then> Then for Option<T> {
    fn then(&mut self, next: Option<T>) {
        *self = self.take().zip(next).map(|(mut a, b)| {
            a.then(b);
            a
        });
    }
}

impl FrameReport {
    /// The pair of this left eye and its right one, a frame of the display.
    #[must_use]
    pub fn with_right(mut self, right: FrameReport) -> FrameReport {
        let seconds = [&self, &right].map(|eye| eye.frame_time_s().unwrap_or(1.0));
        if let Some(name) = Eye::Left.strip(&self.name) {
            self.name = name.to_owned();
        }
        self.eye = None;
        self.eyes += right.eyes;
        self.counters.add(&right.counters);
        self.stages.then(right.stages);
        self.actions.add(&right.actions);
        self.energy.add_all(&right.energy);
        self.standby = Standby {
            running_w: std::array::from_fn(|i| {
                let [a, b] = [self.standby.running_w[i], right.standby.running_w[i]];
                // Equal powers stay what they are, in rounding too.
                let mean = (a * seconds[0] + b * seconds[1]) / (seconds[0] + seconds[1]);
                if a == b { a } else { mean }
            }),
            idle_w: self.standby.idle_w,
        };
        // One panel each.
        self.display_w = self.display_w.zip(right.display_w).map(|(a, b)| a + b);
        match (&mut self.model, right.model) {
            (ModelReport::Cycle(left), ModelReport::Cycle(right)) => left.then(*right),
            (ModelReport::Paper(left), ModelReport::Paper(right)) => left.then(right),
            _ => unreachable!("both eyes are simulated with one model"),
        }
        self
    }
}

impl Then for StageBytes {
    fn then(&mut self, next: StageBytes) {
        let StageBytes { read, write, sram, flops } = next;
        self.read += read;
        self.write += write;
        self.sram += sram;
        self.flops += flops;
    }
}

impl Then for PaperReport {
    fn then(&mut self, next: PaperReport) {
        self.fovea.then(next.fovea);
    }
}

impl Then for CycleReport {
    fn then(&mut self, next: CycleReport) {
        let CycleReport {
            timing,
            clock: _,
            task: _,
            latency,
            executed_evaluations,
            live_evaluations,
            unwritten_bytes,
            measured,
            fovea,
        } = next;
        // The second view begins when the first one makes room for it.
        self.latency = self.timing.frame + latency;
        self.timing.then(timing);
        self.executed_evaluations += executed_evaluations;
        self.live_evaluations += live_evaluations;
        self.unwritten_bytes += unwritten_bytes;
        self.measured = std::mem::take(&mut self.measured).with_second(&measured);
        self.fovea.then(fovea);
    }
}

impl Then for FrameTiming {
    fn then(&mut self, next: FrameTiming) {
        let FrameTiming { frame, preprocessing_end, units, dram, buffers, tile_cycles } = next;
        self.frame += frame;
        self.preprocessing_end += preprocessing_end;
        for (unit, next) in self.units.iter_mut().zip(units) {
            unit.busy += next.busy;
            unit.stalls.then(next.stalls);
            unit.idle += next.idle;
        }
        self.dram.then(dram);
        self.buffers.iter_mut().zip(buffers).for_each(|(a, b)| a.then(b));
        self.tile_cycles.add(&tile_cycles);
    }
}

impl Then for DramUse {
    fn then(&mut self, next: DramUse) {
        let DramUse {
            read_bytes,
            write_bytes,
            requests_issued,
            requests_served,
            busy_cycles,
            master_bytes,
            commands,
        } = next;
        self.read_bytes += read_bytes;
        self.write_bytes += write_bytes;
        self.requests_issued += requests_issued;
        self.requests_served += requests_served;
        self.busy_cycles += busy_cycles;
        self.master_bytes.iter_mut().zip(master_bytes).for_each(|(a, b)| *a += b);
        if let Some((all, commands)) = self.commands.as_mut().zip(commands) {
            all.stages.iter_mut().zip(commands.stages).for_each(|(a, b)| a.add(b));
            all.precharges += commands.precharges;
            all.refreshes += commands.refreshes;
            all.bank_refreshes += commands.bank_refreshes;
        }
    }
}

impl Then for BufferUse {
    fn then(&mut self, next: BufferUse) {
        let BufferUse { buffer: _, capacity: _, peak, byte_cycles, filled, consumed, discarded } =
            next;
        self.peak = self.peak.max(peak);
        self.byte_cycles += byte_cycles;
        self.filled += filled;
        self.consumed += consumed;
        self.discarded += discarded;
    }
}

impl Then for FoveaSummary {
    /// The gaze stays that of the left eye.
    fn then(&mut self, next: FoveaSummary) {
        self.tiles += next.tiles;
        self.blending_tiles += next.blending_tiles;
        self.counters.add(&next.counters);
    }
}

impl Then for Foveal<RegionReport> {
    fn then(&mut self, next: Foveal<RegionReport>) {
        self.summary.then(next.summary);
        self.regions.then(next.regions);
    }
}

impl Then for RegionReport {
    fn then(&mut self, next: RegionReport) {
        let RegionReport { tiles, entries, cycles, energy_pj } = next;
        self.tiles += tiles;
        self.entries += entries;
        self.cycles += cycles;
        self.energy_pj += energy_pj;
    }
}

/// Puts the frames of a display together from the reports of their views, which come in order.
#[derive(Debug, Clone, Default)]
pub struct Periods {
    left: Option<Box<FrameReport>>,
}

impl Periods {
    /// Takes the report of the next view; returns that of the frame which it completes. An eye
    /// whose other one is not simulated is a frame of its own.
    pub fn add(&mut self, report: FrameReport, views: usize) -> Option<FrameReport> {
        if views < 2 {
            return Some(report);
        }
        match (report.eye, self.left.take()) {
            (Some(Eye::Left), _) => {
                self.left = Some(Box::new(report));
                None
            }
            (_, Some(left)) => Some(left.with_right(report)),
            (_, None) => Some(report),
        }
    }
}
