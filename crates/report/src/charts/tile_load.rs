//! List length per tile, as colour over a grey picture of the frame.

use powergs_pixels::RgbImage;
use powergs_study::findings::{Picture, TileLoad};
use powergs_study::run_record::Run;

use super::subtitle;
use crate::format::significant;
use powergs_chart::{Beside, Chart, Colour, Panel, Scale};
use powergs_core::sim::Model;

const NAME: &str = "tile_load";
const TITLE: &str = "List length per tile";

/// How much of the colour of a tile covers the picture.
const COVER: f32 = 0.78;

/// The longer side of the picture, pixels.
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
    let chart = chart.panel(Panel::picture(heatmap(tiles, longest), ""));
    Some(chart.beside(Beside::Scale { title, labels: labels.collect() }))
}

/// The frame, every pixel in the colour of its tile over the grey picture.
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
        let at = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let Some(grey) = tiles.picture.as_ref().and_then(|p| luma(p, at)) else {
            return [r, g, b];
        };
        [r, g, b].map(|c| (COVER * f32::from(c) + (1.0 - COVER) * grey) as u8)
    })
}

/// Grey value of the picture at a relative position, bilinear.
fn luma(picture: &Picture, (u, v): (f32, f32)) -> Option<f32> {
    let (w, h) = (picture.width as usize, picture.height as usize);
    if w == 0 || h == 0 || picture.rgb.len() < 3 * w * h {
        return None;
    }
    let at = |x: usize, y: usize| {
        let i = 3 * (y.min(h - 1) * w + x.min(w - 1));
        let [r, g, b] = [0, 1, 2].map(|k| f32::from(picture.rgb[i + k]));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (x, y) = ((u * w as f32 - 0.5).max(0.0), (v * h as f32 - 0.5).max(0.0));
    let (x0, y0) = (x as usize, y as usize);
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let upper = at(x0, y0) * (1.0 - fx) + at(x0 + 1, y0) * fx;
    let lower = at(x0, y0 + 1) * (1.0 - fx) + at(x0 + 1, y0 + 1) * fx;
    Some(upper * (1.0 - fy) + lower * fy)
}
