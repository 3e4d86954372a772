//! A frame with the regions of its levels.

use plotters::style::RGBColor;

use super::Show;
use super::album::Album;
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Align, Canvas, Drawn, GREY, Page, Underlay, ZOOM, legend, palette};
use powergs_frame::fovea::{LEVELS, POOLINGS, REGIONS};
use powergs_pixels::RgbImage;

const NAME: &str = "foveated_levels";
const TITLE: &str = "Levels over a frame";
/// Upper left corner of the image, SVG units.
const CORNER: (i32, i32) = (40, 138);
/// Room for it.
const ROOM: (f64, f64) = (1200.0, 544.0);

pub(super) fn chart(show: &Show<'_>) -> Result<Option<Chart>, ReportError> {
    let Some(album) = &show.album else { return Ok(None) };
    let Some(image) = sheet(album) else { return Ok(None) };
    let [x, y] = album.gaze;
    let what = format!("view {}, gaze {x}, {y}", super::super::shortened(&album.view, 30));
    let underlay = Underlay { left: CORNER.0, top: CORNER.1, image };
    let page = Page { underlay: Some(underlay), ..show.page(NAME, TITLE, &what) };
    let drawing = page.draw(|canvas| key(canvas, album))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn sheet(album: &Album) -> Option<RgbImage> {
    let image = RgbImage::from_bytes(album.width, album.height, album.levels.clone())?;
    let zoom = f64::from(ZOOM.0) / f64::from(ZOOM.1);
    let (w, h) = (f64::from(album.width.max(1)), f64::from(album.height.max(1)));
    let scale = (zoom * ROOM.0 / w).min(zoom * ROOM.1 / h);
    let size = |v: f64| ((v * scale).round() as u32).max(1);
    let image = image.resized(size(w), size(h));
    // In the middle of the page.
    let mut page = RgbImage::filled((zoom * ROOM.0) as u32, image.height(), [255; 3]);
    let left = page.width().saturating_sub(image.width()) / 2;
    page.paste(&image, left, 0);
    Some(page)
}

fn key(canvas: &Canvas, album: &Album) -> Drawn {
    let name = |i: usize| {
        let share = 100.0 * album.shares[i];
        let pooling = POOLINGS[i];
        match (i, album.shares[i] > 0.0) {
            (_, false) => format!("{} not in this view", REGIONS[i]),
            (0, true) => format!("R1, as it is: {share:.0} %"),
            (_, true) => format!("{}, pooling {pooling} px: {share:.0} %", REGIONS[i]),
        }
    };
    let names: [String; LEVELS] = std::array::from_fn(name);
    let tint = |i: usize| match i {
        0 => palette::PALE,
        _ => {
            let [r, g, b] = album.tints[i];
            RGBColor(r, g, b)
        }
    };
    let entries: Vec<(&str, RGBColor)> =
        names.iter().enumerate().map(|(i, n)| (n.as_str(), tint(i))).collect();
    legend(canvas, 40.0, 106.0, &entries)?;
    let note = "cross: gaze; white lines: borders of regions; tints run into each other where two \
                levels are blended";
    canvas.text(note, (40.0, 704.0), Align::Left, GREY)
}
