//! Work of a volume-rendering core.

use super::{Event, Vectors};
use crate::{Outcome, Pixel, Record, Vrc};

const PIXEL: u16 = 0;
const ACCEPTED: u16 = 1;
const STOPPED: u16 = 2;

/// A tile for one core.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoreTile {
    /// Column and row of the first pixel in the tile.
    pub place: [u32; 2],
    /// Pixels that are in the image, from the lowest bit.
    pub mask: u32,
    /// Its splats, front to back.
    pub splats: Vec<Record>,
}

/// The hardware that the tiles are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Core {
    /// Its arithmetic.
    pub vrc: Vrc,
    /// Whether operations have a register inside (`SPLIT`).
    pub split: bool,
    /// Its pixels (`PIXELS`).
    pub pixels: u32,
    /// Pixels of a row (`COLUMNS`).
    pub columns: u32,
}

impl Core {
    /// What the pixels of a tile become, and which splat and pixel leaves none.
    fn tile(&self, tile: &CoreTile) -> (Vec<Vec<u16>>, Option<(u32, u32)>) {
        let open = |i| Pixel::open(self.vrc.format(), tile.mask >> i & 1 == 1);
        let mut pixels: Vec<Pixel> = (0..self.pixels).map(open).collect();
        let mut last = None;
        for (k, splat) in tile.splats.iter().enumerate() {
            for i in 0..self.pixels {
                let x = tile.place[0] + i % self.columns;
                let y = tile.place[1] + i / self.columns;
                if self.vrc.blend(&mut pixels[i as usize], splat, x, y) == Outcome::Stopped {
                    last = Some((k as u32, i));
                }
            }
        }
        let stopped = pixels.iter().all(|pixel| !pixel.live);
        let words = pixels.iter().map(|p| p.colour.into_iter().chain([p.transmittance]).collect());
        (words.collect(), last.filter(|_| stopped))
    }

    /// Events without any stall, as `rtl/README.md` states them.
    fn events(&self, tiles: &[CoreTile]) -> Vec<Event> {
        let depth = if self.split { 2 } else { 1 };
        let latency = 11 * depth;
        let mut events = Vec::new();
        let event = |kind, cycle| Event { kind, cycle, words: Vec::new() };
        let mut open = 0;
        for tile in tiles {
            let count = tile.splats.len() as u32;
            let (pixels, last) = self.tile(tile);
            let close = open + 1 + count * self.pixels;
            events.push(event(ACCEPTED, open));
            events.extend((0..count).map(|k| event(ACCEPTED, open + 1 + k * self.pixels)));
            events.push(event(ACCEPTED, close));
            let stop = match last {
                Some((k, i)) => Some(open + 2 + k * self.pixels + i + 9 * depth + 1),
                None if tile.mask == 0 => Some(open + 1),
                None => None,
            };
            // While the tile is not closed.
            events.extend(stop.filter(|&stop| stop <= close).map(|stop| event(STOPPED, stop)));
            let leave = close + if count == 0 { 2 } else { latency };
            let pixels = pixels.into_iter().zip(leave..);
            events.extend(pixels.map(|(words, cycle)| Event { kind: PIXEL, cycle, words }));
            open = leave + self.pixels;
        }
        events.sort_by_key(|event| (event.cycle, event.kind == ACCEPTED));
        events
    }
}

/// Tiles for `rtl/tb/vrc.cpp`, one after the other.
pub fn vrc(core: &Core, tiles: &[CoreTile]) -> Vectors {
    let mut stimulus = vec![0; super::HEAD];
    for tile in tiles {
        stimulus.extend([0; 10]);
        stimulus.extend([tile.mask as u16, tile.place[0] as u16, tile.place[1] as u16]);
        for splat in &tile.splats {
            stimulus.push(1);
            stimulus.extend(splat.numbers());
            stimulus.extend([0; 3]);
        }
        stimulus.push(2);
        stimulus.extend([0; 12]);
    }
    Vectors { stimulus, expected: core.events(tiles), event_words: 7, timed: true }
}
