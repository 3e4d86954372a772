//! Work of a rendering unit.

use super::{Event, Vectors};
use crate::{Entry, Vru};

const PIXELS: u16 = 0;
const ACCEPTED: u16 = 1;

/// A tile: its pixels in the image, columns and rows, and its list.
pub type Tile = ([u32; 2], Vec<Entry>);

/// Tiles for `rtl/tb/vru.cpp`, one after the other. A beat is accepted in the cycle in which the
/// one before leaves the head.
pub fn vru(unit: &Vru, tiles: &[Tile]) -> Vectors {
    let mut stimulus = vec![0; super::HEAD];
    let accepted = |cycle: u64| Event { kind: ACCEPTED, cycle: cycle as u32, words: Vec::new() };
    let mut expected = vec![accepted(0)];
    let mut open = 1;
    for (size, entries) in tiles {
        stimulus.extend([0; 11]);
        stimulus.extend(size.map(|side| side as u16));
        for Entry { splat, bitmap } in entries {
            stimulus.push(1);
            stimulus.extend(splat.numbers());
            stimulus.extend([u16::from(*bitmap), 0, 0]);
        }
        stimulus.push(2);
        stimulus.extend([0; 12]);
        let run = unit.tile(entries, *size);
        expected.push(accepted(open));
        expected.extend(run.left.iter().map(|left| accepted(open + left)));
        expected.push(accepted(open + run.close));
        for i in 0..16 {
            let cycle = (open + run.first_pixels + i as u64) as u32;
            let words = (0..16).flat_map(|core| {
                let pixel = run.pixels[16 * core + i];
                pixel.colour.into_iter().chain([pixel.transmittance])
            });
            expected.push(Event { kind: PIXELS, cycle, words: words.collect() });
        }
        open += run.first_pixels + 16;
    }
    // The last beat that leaves lets nobody in.
    let last = expected.iter().rposition(|event| event.kind == ACCEPTED);
    last.map(|last| expected.remove(last));
    Vectors { stimulus, expected, event_words: 67, timed: true }
}
