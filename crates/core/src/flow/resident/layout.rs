//! Where the arrays of a frame lie in memory: one behind the other, each from a multiple of 64
//! bytes on (A35).

use super::Resident;
use super::training::Step;
use super::work::ResidentFrame;
use crate::flow::over::FirstUnit;
use crate::flow::steps::StepPart;
use crate::kernel::memory;
use powergs_dram::AddressRange;

/// The addresses that a request touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// One range.
    Range(AddressRange),
    /// Positions, and shapes where they are read too, of consecutive records.
    Batch {
        /// The first record.
        first: u64,
        /// How many.
        records: u64,
    },
    /// Colours of consecutive splats with a region, in storage order.
    Shades {
        /// The first slot.
        first: u64,
        /// How many.
        splats: u64,
    },
    /// Converted Gaussians of consecutive slots, and list entries.
    Results {
        /// The first slot.
        first: u64,
        /// How many.
        splats: u64,
        /// The first entry.
        entry: u64,
        /// How many.
        entries: u64,
    },
    /// What consecutive entries name: converted Gaussians, or all of their records.
    Named {
        /// The first entry.
        first: u64,
        /// How many.
        entries: u64,
    },
}

/// The arrays of a frame.
#[derive(Debug)]
pub struct Layout<'a> {
    frame: &'a ResidentFrame,
    machine: &'a Resident,
    positions: u64,
    shapes: u64,
    colours: u64,
    features: u64,
    lists: u64,
    passes: u64,
    ordered: u64,
    slices: u64,
    pixels: u64,
    /// What each unit that acts first reads and writes.
    first: Vec<[u64; 2]>,
    /// What is read of pixels that are known, and written of them.
    known: [u64; 2],
    /// What each part of a step of training reads and writes.
    steps: [[u64; 2]; StepPart::ALL.len()],
    end: u64,
}

impl<'a> Layout<'a> {
    /// Those of a frame on a machine with these units that act first, which moves `known`
    /// bytes of pixels that are known.
    pub fn new(
        frame: &'a ResidentFrame,
        machine: &'a Resident,
        first: &[FirstUnit],
        known: [u64; 2],
        step: Option<&Step>,
    ) -> Layout<'a> {
        let mut end = 0;
        let mut array = |items: u64, bytes: u64| {
            let base = end;
            end += (items * bytes).next_multiple_of(64);
            base
        };
        let (g, points) = (&machine.gaussian, frame.counters.points);
        let (entries, splats) = (frame.entries.len() as u64, frame.index.len() as u64);
        let pixels = frame.regions.iter().map(|region| u64::from(region.pixels)).sum();
        let slices = u64::from(machine.region.slices);
        // A single slice is finished in its engine and never written.
        let of_slices = if slices > 1 { pixels * slices } else { 0 };
        Layout {
            positions: array(points, g.position.0),
            shapes: array(points, g.shape.0),
            colours: array(points, g.colour_pitch.0),
            features: array(splats, g.feature_pitch.0),
            lists: array(entries, g.entry.0),
            passes: array(entries, g.entry.0),
            ordered: array(entries, g.entry.0),
            slices: array(of_slices, machine.raster.pixel_state.0),
            pixels: array(pixels, g.pixel.0),
            first: first.iter().map(|unit| unit.bytes().map(|n| array(n, 1))).collect(),
            known: known.map(|bytes| array(bytes, 1)),
            steps: StepPart::ALL.map(|part| {
                step.map_or([0; 2], |step| step.bytes(part)).map(|bytes| array(bytes, 1))
            }),
            frame,
            machine,
            end,
        }
    }

    /// Where what a part of a step reads and writes begins.
    pub fn step(&self, part: StepPart) -> [u64; 2] {
        self.steps[part as usize]
    }

    /// Where what each unit that acts first reads and writes begins.
    pub fn first(&self) -> &[[u64; 2]] {
        &self.first
    }

    /// Where pixels that are known lie, and where they come to.
    pub fn known(&self) -> [u64; 2] {
        self.known
    }

    fn entries(&self, base: u64, first: u64, bytes: u64) -> Place {
        let address = base + first * self.machine.gaussian.entry.0;
        Place::Range(AddressRange { address, bytes })
    }

    /// Entries of a list as the front wrote them.
    pub fn list(&self, first: u64, bytes: u64) -> Place {
        self.entries(self.lists, first, bytes)
    }

    /// Keys between two passes.
    pub fn pass(&self, first: u64, bytes: u64) -> Place {
        self.entries(self.passes, first, bytes)
    }

    /// Sorted entries.
    pub fn ordered(&self, first: u64, bytes: u64) -> Place {
        self.entries(self.ordered, first, bytes)
    }

    /// Pixels of depth slices, from this pixel of this slice on.
    pub fn slices(&self, pixel: u64, bytes: u64) -> Place {
        let address = self.slices + pixel * self.machine.raster.pixel_state.0;
        Place::Range(AddressRange { address, bytes })
    }

    /// Finished pixels.
    pub fn pixels(&self, pixel: u64, bytes: u64) -> Place {
        Place::Range(AddressRange {
            address: self.pixels + pixel * self.machine.gaussian.pixel.0,
            bytes,
        })
    }

    /// The n-th piece of what an entry names.
    fn named(&self, entry: u64, piece: u64) -> AddressRange {
        let (g, rank) = (&self.machine.gaussian, self.frame.entries[entry as usize].rank);
        let slot = u64::from(self.frame.slot[rank as usize]);
        if !self.machine.front.lazy {
            return AddressRange {
                address: self.features + slot * g.feature_pitch.0,
                bytes: g.feature.0,
            };
        }
        let index = u64::from(self.frame.index[slot as usize]);
        let (base, pitch, bytes) = match piece {
            0 => (self.positions, g.position.0, g.position.0),
            1 => (self.shapes, g.shape.0, g.shape.0),
            _ => (self.colours, g.colour_pitch.0, g.colour.0),
        };
        AddressRange { address: base + index * pitch, bytes }
    }
}

impl memory::Layout for Layout<'_> {
    type Pattern = Place;

    fn piece(&self, place: &Place, cursor: &mut u64) -> Option<AddressRange> {
        let g = &self.machine.gaussian;
        loop {
            let n = *cursor;
            *cursor += 1;
            let piece = match *place {
                Place::Range(range) => (n == 0).then_some(range)?,
                Place::Batch { first, records } => match n {
                    0 => AddressRange {
                        address: self.positions + first * g.position.0,
                        bytes: records * g.position.0,
                    },
                    1 if !self.machine.front.lazy => AddressRange {
                        address: self.shapes + first * g.shape.0,
                        bytes: records * g.shape.0,
                    },
                    _ => return None,
                },
                Place::Shades { first, splats } => {
                    let slot = (n < splats).then(|| first + n)?;
                    let index = u64::from(self.frame.index[slot as usize]);
                    AddressRange {
                        address: self.colours + index * g.colour_pitch.0,
                        bytes: g.colour.0,
                    }
                }
                Place::Results { first, splats, entry, entries } => match n {
                    n if n < splats => AddressRange {
                        address: self.features + (first + n) * g.feature_pitch.0,
                        bytes: g.feature.0,
                    },
                    n if n == splats => AddressRange {
                        address: self.lists + entry * g.entry.0,
                        bytes: entries * g.entry.0,
                    },
                    _ => return None,
                },
                Place::Named { first, entries } => {
                    let pieces = if self.machine.front.lazy { 3 } else { 1 };
                    let entry = (n < entries * pieces).then(|| first + n / pieces)?;
                    self.named(entry, n % pieces)
                }
            };
            if piece.bytes > 0 {
                return Some(piece);
            }
        }
    }

    fn end(&self) -> u64 {
        self.end
    }
}
