//! A strip of images: the dense model, the optimised one, their difference, and what each channel
//! lost.

use super::Story;
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Page, Underlay, ZOOM, palette, text_width};
use powergs_pixels::RgbImage;

const NAME: &str = "strip";
const TITLE: &str = "Before and after";
/// Differences are shown this many times as large.
const GAIN: f32 = 8.0;
/// Upper left corner of the images, SVG units.
const LEFT: i32 = 40;
const TOP: i32 = 122;
/// Room for them.
const ROOM: (f64, f64) = (1200.0, 550.0);
/// Between them; captions stand in the lower gap.
const GAP: (f64, f64) = (20.0, 44.0);
/// Room for a caption.
const CAPTION: f64 = 250.0;

/// Pictures of one view, sRGB codes, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strip {
    /// The view.
    pub view: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// The dense model.
    pub dense: Vec<u8>,
    /// The optimised model.
    pub ours: Vec<u8>,
    /// What the optimised model is called.
    pub name: String,
}

impl Strip {
    fn pixels(&self) -> impl Iterator<Item = ([f32; 3], [f32; 3])> {
        let colour = |p: &[u8; 3]| p.map(f32::from);
        let (dense, ours) = (self.dense.as_chunks().0, self.ours.as_chunks().0);
        dense.iter().zip(ours).map(move |(a, b)| (colour(a), colour(b)))
    }

    /// Mean of each channel of the dense model, codes of 8 bits.
    pub fn mean_dense(&self) -> [f64; 3] {
        let pixels = self.dense.as_chunks::<3>().0;
        let mean = |c: usize| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
        std::array::from_fn(|c| mean(c) / pixels.len().max(1) as f64)
    }

    /// Mean change of each channel, codes of 8 bits.
    pub fn mean_change(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let mut count = 0u32;
        for (a, b) in self.pixels() {
            count += 1;
            for c in 0..3 {
                sum[c] += f64::from(b[c] - a[c]);
            }
        }
        sum.map(|s| s / f64::from(count.max(1)))
    }
}

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let Some(strip) = &story.strip else { return Ok(None) };
    let what = format!("view {}", super::shortened(&strip.view, 40));
    let underlay = Underlay { left: LEFT, top: TOP, image: sheet(strip) };
    let page = Page { underlay: Some(underlay), ..story.page(NAME, TITLE, &what) };
    let drawing = page.draw(|canvas| captions(canvas, strip))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// Where the images go, SVG units.
struct Layout {
    columns: u32,
    /// Size of an image.
    image: (f64, f64),
    /// From one image to the next.
    step: (f64, f64),
}

impl Layout {
    /// Two above two, or four in a row: whichever shows them larger.
    fn of(strip: &Strip) -> Layout {
        let aspect = f64::from(strip.width.max(1)) / f64::from(strip.height.max(1));
        let with = |columns: u32| {
            let (across, down) = (f64::from(columns), f64::from(4 / columns));
            let wide = (ROOM.0 - (across - 1.0) * GAP.0) / across;
            let high = (ROOM.1 - (down - 1.0) * GAP.1) / down;
            let width = wide.min(high * aspect);
            let image = (width, width / aspect);
            let step = (width.max(CAPTION) + GAP.0, image.1 + GAP.1);
            Layout { columns, image, step }
        };
        let (square, row) = (with(2), with(4));
        if row.image.0 > square.image.0 { row } else { square }
    }

    /// Upper left corner of an image, from that of the first.
    fn at(&self, i: usize) -> (f64, f64) {
        let (column, line) = (i as u32 % self.columns, i as u32 / self.columns);
        (f64::from(column) * self.step.0, f64::from(line) * self.step.1)
    }

    /// Size of everything.
    fn size(&self) -> (f64, f64) {
        let last = self.at(3);
        (last.0 + self.image.0, last.1 + self.image.1)
    }
}

/// SVG units as PNG pixels.
fn zoomed(length: f64) -> u32 {
    (length * f64::from(ZOOM.0) / f64::from(ZOOM.1)).round() as u32
}

/// All four images on white.
fn sheet(strip: &Strip) -> RgbImage {
    let layout = Layout::of(strip);
    let size = layout.size();
    let mut sheet = RgbImage::filled(zoomed(size.0) + 1, zoomed(size.1) + 1, [255; 3]);
    let code = |v: f32| v.clamp(0.0, 255.0).round() as u8;
    let distance = |a: [f32; 3], b: [f32; 3]| {
        let d = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        [code(GAIN * d); 3]
    };
    let change =
        |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|c| code(128.0 + GAIN * (b[c] - a[c])));
    let whole = |a: [f32; 3]| a.map(code);
    type Look<'a> = Box<dyn Fn([f32; 3], [f32; 3]) -> [u8; 3] + 'a>;
    let looks: [Look<'_>; 4] = [
        Box::new(|a, _| whole(a)),
        Box::new(|_, b| whole(b)),
        Box::new(distance),
        Box::new(change),
    ];
    let (w, h) = (zoomed(layout.image.0).max(1), zoomed(layout.image.1).max(1));
    for (i, look) in looks.iter().enumerate() {
        let pixels: Vec<u8> = strip.pixels().flat_map(|(a, b)| look(a, b)).collect();
        let Some(image) = RgbImage::from_bytes(strip.width, strip.height, pixels) else { continue };
        let image = image.resized(w, h);
        let at = layout.at(i);
        sheet.paste(&image, zoomed(at.0), zoomed(at.1));
    }
    sheet
}

fn captions(canvas: &Canvas, strip: &Strip) -> Drawn {
    let layout = Layout::of(strip);
    let captions = [
        "dense".to_owned(),
        strip.name.clone(),
        format!("largest difference, x{GAIN}"),
        format!("change per channel, x{GAIN}"),
    ];
    let (left, top) = (f64::from(LEFT), f64::from(TOP));
    for (i, caption) in captions.iter().enumerate() {
        let (x, y) = layout.at(i);
        canvas.text(caption, (left + x, top + y - 16.0), Align::Left, INK)?;
    }
    let y = top + layout.size().1 + 24.0;
    let mut x = left;
    let about = "mean change, of 255 (grey above is none):".to_owned();
    let mut parts = vec![(about, GREY)];
    let colours = [palette::VERMILION, palette::GREEN, palette::BLUE];
    let names = ["red", "green", "blue"].into_iter().zip(strip.mean_change());
    parts.extend(names.zip(colours).map(|((name, v), colour)| (format!("{name} {v:+.2}"), colour)));
    for (text, colour) in parts {
        canvas.text(&text, (x, y), Align::Left, colour)?;
        x += text_width(&text) + 24.0;
    }
    Ok(())
}
