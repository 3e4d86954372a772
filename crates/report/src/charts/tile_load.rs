//! List length per tile, as colour over a grey picture of the frame.

use plotters::style::colors::colormaps::ViridisRGB;
use plotters::style::{RGBColor, colors::colormaps::ColorMap};

use super::{Chart, subtitle};
use crate::ReportError;
use crate::format::significant;
use crate::plot::{Align, Canvas, Drawn, GREY, HEIGHT, INK, Page, Scale, Underlay, WIDTH, ZOOM};
use powergs_core::sim::Model;
use powergs_pixels::RgbImage;
use powergs_study::findings::{Picture, TileLoad};
use powergs_study::run_record::Run;

const NAME: &str = "tile_load";
const TITLE: &str = "List length per tile";

/// How much of the colour of a tile covers the picture.
const COVER: f32 = 0.78;

/// Room for the picture: left, top, width, height.
const ROOM: (i32, i32, i32, i32) = (40, 100, WIDTH - 240, HEIGHT - 140);

pub(super) fn chart(run: &Run) -> Result<Option<Chart>, ReportError> {
    let Some(tiles) = run.tiles.as_ref().filter(|t| t.width > 0 && t.height > 0) else {
        return Ok(None);
    };
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
    let underlay = heatmap(tiles, longest);
    let right = f64::from(underlay.left)
        + f64::from(underlay.image.width()) * f64::from(ZOOM.1) / f64::from(ZOOM.0);
    let page = Page {
        name: NAME,
        title: TITLE.into(),
        subtitle: subtitle(run, &what),
        underlay: Some(underlay),
    };
    let drawing = page.draw(|canvas| colour_bar(canvas, right + 40.0, longest))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn colour(share: f64) -> RGBColor {
    ViridisRGB.get_color(share as f32)
}

/// The frame fitted into [`ROOM`], every pixel in the colour of its tile over the grey picture.
fn heatmap(tiles: &TileLoad, longest: u32) -> Underlay {
    let zoomed = |length: i32| length as u32 * ZOOM.0 / ZOOM.1;
    let (room_x, room_y) = (zoomed(ROOM.2), zoomed(ROOM.3));
    let (w, h) = (u64::from(tiles.width), u64::from(tiles.height));
    let by_width = u64::from(room_x) * h <= u64::from(room_y) * w;
    let (width, height) = if by_width {
        (room_x, (u64::from(room_x) * h / w).max(1) as u32)
    } else {
        ((u64::from(room_y) * w / h).max(1) as u32, room_y)
    };
    let image = RgbImage::from_fn(width, height, |x, y| {
        let px = (u64::from(x) * w / u64::from(width)) as u32;
        let py = (u64::from(y) * h / u64::from(height)) as u32;
        let index =
            (py / tiles.tile) as usize * tiles.tiles_x as usize + (px / tiles.tile) as usize;
        let n = tiles.entries.get(index).copied().unwrap_or(0);
        let RGBColor(r, g, b) = colour(f64::from(n) / f64::from(longest.max(1)));
        let at = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let Some(grey) = tiles.picture.as_ref().and_then(|p| luma(p, at)) else {
            return [r, g, b];
        };
        [r, g, b].map(|c| (COVER * f32::from(c) + (1.0 - COVER) * grey) as u8)
    });
    // Even, so that it falls on whole pixels of the PNG.
    let spare = ROOM.2 - (width * ZOOM.1 / ZOOM.0) as i32;
    Underlay { left: ROOM.0 + spare / 4 * 2, top: ROOM.1, image }
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

fn colour_bar(canvas: &Canvas, left: f64, longest: u32) -> Drawn {
    let (top, bottom) = (150.0, f64::from(HEIGHT) - 60.0);
    let scale = Scale::exact(0.0, f64::from(longest.max(1)), (bottom, top));
    canvas.text("Gaussians", (left, top - 40.0), Align::Left, INK)?;
    canvas.text("per list", (left, top - 18.0), Align::Left, INK)?;
    let steps = 128;
    // From the top down, each over the rest: no seams between steps at any zoom.
    for i in (0..steps).rev() {
        let upper = bottom - (bottom - top) * f64::from(i + 1) / f64::from(steps);
        let share = (f64::from(i) + 0.5) / f64::from(steps);
        canvas.fill((left, upper), (left + 24.0, bottom), colour(share))?;
    }
    for tick in scale.whole_ticks(8) {
        let y = scale.at(tick);
        canvas.line(&[(left + 24.0, y), (left + 30.0, y)], GREY, 1)?;
        canvas.text(&format!("{tick:.0}"), (left + 38.0, y), Align::Left, GREY)?;
    }
    Ok(())
}
