//! A strip of images: the dense model, the optimised one, their difference, and what each channel
//! lost.

use image::{Rgb, RgbImage};

use super::Story;
use crate::report::ReportError;
use crate::report::charts::Chart;
use crate::report::plot::{Align, Canvas, Drawn, GREY, INK, Page, Underlay, ZOOM, palette};

const NAME: &str = "strip";
const TITLE: &str = "Before and after";
/// Differences are shown this many times as large.
const GAIN: f32 = 8.0;
/// Room for the images, SVG units: two above two.
const LEFT: i32 = 40;
const TOP: i32 = 120;
const CELL: (u32, u32) = (590, 262);
const GAP: (i32, i32) = (20, 46);

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

fn zoomed(length: u32) -> u32 {
    length * ZOOM.0 / ZOOM.1
}

/// Size of one image on the sheet, PNG pixels.
fn image_size(strip: &Strip) -> (u32, u32) {
    let (wide, high) = (zoomed(CELL.0), zoomed(CELL.1));
    let by_width = (wide, (wide * strip.height).div_ceil(strip.width.max(1)));
    let by_height = ((high * strip.width).div_ceil(strip.height.max(1)), high);
    if by_width.1 <= high { by_width } else { by_height }
}

/// All four images on white.
fn sheet(strip: &Strip) -> RgbImage {
    let (wide, high) = (zoomed(CELL.0), zoomed(CELL.1));
    let step = (wide + zoomed(GAP.0 as u32), high + zoomed(GAP.1 as u32));
    let mut sheet = RgbImage::from_pixel(wide + step.0, high + step.1, Rgb([255; 3]));
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
    let (w, h) = image_size(strip);
    for (i, look) in looks.iter().enumerate() {
        let pixels: Vec<u8> = strip.pixels().flat_map(|(a, b)| look(a, b)).collect();
        let Some(image) = RgbImage::from_raw(strip.width, strip.height, pixels) else { continue };
        let filter = image::imageops::FilterType::Triangle;
        let image = image::imageops::resize(&image, w, h, filter);
        let (column, line) = (i as u32 % 2, i as u32 / 2);
        let at = (i64::from(column * step.0), i64::from(line * step.1));
        image::imageops::replace(&mut sheet, &image, at.0, at.1);
    }
    sheet
}

fn captions(canvas: &Canvas, strip: &Strip) -> Drawn {
    let change = strip.mean_change();
    let captions = [
        "dense".to_owned(),
        strip.name.clone(),
        format!("difference, largest channel, x{GAIN}"),
        format!("change per channel, grey is none, x{GAIN}"),
    ];
    let (across, down) = (CELL.0 as i32 + GAP.0, CELL.1 as i32 + GAP.1);
    for (i, caption) in captions.iter().enumerate() {
        let (column, line) = (i as i32 % 2, i as i32 / 2);
        let at = (f64::from(LEFT + column * across), f64::from(TOP - 14 + line * down));
        canvas.text(caption, at, Align::Left, INK)?;
    }
    let shown = ["red", "green", "blue"].into_iter().zip(change);
    let colours = [palette::VERMILION, palette::GREEN, palette::BLUE];
    let (w, _) = image_size(strip);
    let image_w = f64::from(w * ZOOM.1 / ZOOM.0);
    let mut x = f64::from(LEFT + across) + image_w + 20.0;
    let mut y = f64::from(TOP + down) + 20.0;
    if x > 1100.0 {
        (x, y) = (f64::from(LEFT + across), f64::from(TOP + 2 * down) - 18.0);
    }
    canvas.text("mean change, of 255", (x, y), Align::Left, GREY)?;
    let stacked = x + 300.0 < 1280.0 && y < 500.0;
    for (i, ((name, value), colour)) in shown.zip(colours).enumerate() {
        let step = 26.0 * (i + 1) as f64;
        let at = if stacked { (x, y + step) } else { (x + 80.0 + 130.0 * (i + 1) as f64, y) };
        canvas.text(&format!("{name} {value:+.2}"), at, Align::Left, colour)?;
    }
    Ok(())
}
