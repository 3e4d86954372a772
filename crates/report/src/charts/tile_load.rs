//! List length per tile as colour, beside a picture of the frame.

use powergs_pixels::RgbImage;
use powergs_study::findings::{Picture, TileLoad};
use powergs_study::run_record::Run;

use super::subtitle;
use crate::format::significant;
use powergs_chart::{Beside, Chart, Colour, Panel, Scale};
use powergs_core::sim::Model;

const NAME: &str = "tile_load";
const TITLE: &str = "List length per tile";

/// The longer side of the map, pixels: tiles keep their edges however large it is shown.
const FINE: u32 = 1600;

pub(super) fn chart(run: &Run) -> Option<Chart> {
    let tiles = run.tiles.as_ref().filter(|t| t.width > 0 && t.height > 0)?;
    let which = match run.facts.model {
        Model::Cycle => "the slowest frame",
        Model::Paper => "the frame with most loads",
    };
    let count = tiles.entries.len().max(1) as f64;
    let mean = tiles.entries.iter().map(|&n| f64::from(n)).sum::<f64>() / count;
    let longest = tiles.entries.iter().copied().max().unwrap_or(0);
    let what = format!(
        "frame {} ({which}), {} px tiles, mean {}, longest {longest}",
        tiles.frame,
        tiles.tile,
        significant(mean)
    );
    let scale = Scale::linear(0.0, f64::from(longest.max(1)));
    let labels = scale.whole_ticks(8).into_iter().map(|t| (scale.share(t), format!("{t:.0}")));
    let title = "Gaussians per list".to_owned();
    let chart = Chart::new(NAME, TITLE, subtitle(run, &what));
    // The picture stands beside the map: colours on a picture could not be read off a scale.
    let chart = match tiles.picture.as_ref().and_then(shown) {
        Some(picture) => chart.panel(Panel::picture(picture, "frame")).columns(2),
        None => chart,
    };
    let chart = chart.panel(Panel::mosaic(heatmap(tiles, longest), title.clone()));
    Some(chart.beside(Beside::Scale { title, labels: labels.collect() }))
}

/// The picture of the frame.
fn shown(picture: &Picture) -> Option<RgbImage> {
    RgbImage::from_bytes(picture.width, picture.height, picture.rgb.clone())
        .filter(|image| !image.bytes().is_empty())
}

/// The frame, every pixel in the colour of its tile.
fn heatmap(tiles: &TileLoad, longest: u32) -> RgbImage {
    let (w, h) = (u64::from(tiles.width), u64::from(tiles.height));
    let side = |length: u64| (u64::from(FINE) * length / w.max(h)).max(1) as u32;
    let (width, height) = (side(w), side(h));
    RgbImage::from_fn(width, height, |x, y| {
        let px = (u64::from(x) * w / u64::from(width)) as u32;
        let py = (u64::from(y) * h / u64::from(height)) as u32;
        let index =
            (py / tiles.tile) as usize * tiles.tiles_x as usize + (px / tiles.tile) as usize;
        let n = tiles.entries.get(index).copied().unwrap_or(0);
        let Colour(r, g, b) = Colour::at(f64::from(n) / f64::from(longest.max(1)));
        [r, g, b]
    })
}
