//! A frame with the regions of its levels.

use powergs_pixels::RgbImage;

use super::Show;
use powergs_chart::{Beside, Chart, Colour, Entry, Panel};
use powergs_frame::fovea::{LEVELS, POOLINGS, REGIONS};
use powergs_optimize::pictures::Album;

const NAME: &str = "foveated_levels";
const TITLE: &str = "Levels over a frame";

pub(super) fn chart(show: &Show<'_>) -> Option<Chart> {
    let album = show.album.as_ref()?;
    let image = RgbImage::from_bytes(album.width, album.height, album.levels.clone())?;
    let [x, y] = album.gaze;
    let what = format!("view {}, gaze {x}, {y}", super::super::shortened(&album.view, 30));
    let note = "cross: gaze; white lines: borders of regions; tints run into each other where two \
                levels are blended";
    let chart = show.chart(NAME, TITLE, &what).panel(Panel::picture(image, "")).note(note);
    let entries = entries(album).into();
    Some(chart.beside(Beside::Entries { title: "share of the picture".into(), entries }))
}

fn entries(album: &Album) -> [Entry; LEVELS] {
    std::array::from_fn(|i| {
        let share = 100.0 * album.shares[i];
        let pooling = POOLINGS[i];
        let name = match (i, album.shares[i] > 0.0) {
            (_, false) => format!("{} not in this view", REGIONS[i]),
            (0, true) => format!("R1, as it is: {share:.0} %"),
            (_, true) => format!("{}, pooling {pooling} px: {share:.0} %", REGIONS[i]),
        };
        let [r, g, b] = album.tints[i];
        Entry::fill(name, if i == 0 { Colour::PALE } else { Colour(r, g, b) })
    })
}
