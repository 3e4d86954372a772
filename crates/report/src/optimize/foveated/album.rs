//! Pictures of one view side by side: the frame, what is at the gaze, and a piece of the periphery.

use plotters::style::RGBColor;

use super::Show;
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Page, Underlay, ZOOM, palette};
use powergs_frame::fovea::LEVELS;
use powergs_pixels::RgbImage;

const NAME: &str = "foveated_pictures";
const TITLE: &str = "The same view and gaze, method by method";
/// Upper left corner of the images, SVG units.
const CORNER: (i32, i32) = (40, 122);
/// Room for them.
const ROOM: (f64, f64) = (1200.0, 562.0);
/// Between them.
const GAP: f64 = 14.0;
/// A frame is at most this high.
const FRAME_MOST: f64 = 250.0;
/// Width of a crop, of that of the frame.
const CROP: f64 = 0.2;
/// Pieces of the periphery are at least this far from the gaze, of the farthest corner.
const FAR: f64 = 0.5;
/// Places that are looked at for one, across and down.
const PLACES: u32 = 12;
/// Lines around what is enlarged.
const FOVEA: RGBColor = palette::YELLOW;
const PERIPHERY: RGBColor = palette::SKY;

/// Pictures of one view.
#[derive(Debug, Clone, PartialEq)]
pub struct Album {
    /// The view.
    pub view: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Where somebody looks, shares of width and height.
    pub gaze: [f64; 2],
    /// Pictures, first the reference.
    pub shots: Vec<Shot>,
    /// Our frame with tinted levels, sRGB codes, row-major.
    pub levels: Vec<u8>,
    /// The tints of R1 to R4.
    pub tints: [[u8; 3]; LEVELS],
    /// The share of the pixels in each region.
    pub shares: [f64; LEVELS],
}

/// A picture of an album.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shot {
    /// What it shows.
    pub name: String,
    /// sRGB codes, row-major.
    pub rgb: Vec<u8>,
}

/// A rectangle of a picture: left, top, width, height, pixels.
type Piece = [u32; 4];

/// Where everything goes, SVG units from [`CORNER`].
struct Layout {
    column: f64,
    frame: (f64, f64),
    crop: (f64, f64),
}

impl Layout {
    fn of(album: &Album) -> Layout {
        let n = album.shots.len().max(1) as f64;
        let column = (ROOM.0 - (n - 1.0) * GAP) / n;
        let aspect = f64::from(album.width.max(1)) / f64::from(album.height.max(1));
        let high = (column / aspect).min(FRAME_MOST);
        let crop = (column, (ROOM.1 - high - 2.0 * GAP) / 2.0);
        Layout { column, frame: (high * aspect, high), crop }
    }

    fn left(&self, i: usize) -> f64 {
        i as f64 * (self.column + GAP)
    }

    /// Left edge of the frame, in the middle of its column.
    fn frame_left(&self, i: usize) -> f64 {
        self.left(i) + (self.column - self.frame.0) / 2.0
    }

    /// Top of the crops, at the gaze and in the periphery.
    fn tops(&self) -> [f64; 2] {
        let first = self.frame.1 + GAP;
        [first, first + self.crop.1 + GAP]
    }
}

impl Album {
    /// What is enlarged: the piece at the gaze, and the richest far from it.
    fn pieces(&self, layout: &Layout) -> [Piece; 2] {
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let wide = (CROP * w).clamp(1.0, w);
        let high = (wide * layout.crop.1 / layout.crop.0).clamp(1.0, h);
        let piece = |x: f64, y: f64| {
            let left = (x - wide / 2.0).clamp(0.0, w - wide);
            let top = (y - high / 2.0).clamp(0.0, h - high);
            [left as u32, top as u32, wide as u32, high as u32]
        };
        let gaze = (self.gaze[0] * w, self.gaze[1] * h);
        let distance = |x: f64, y: f64| (x - gaze.0).hypot(y - gaze.1);
        let corners = [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)];
        let farthest = corners.map(|(x, y)| distance(x, y)).into_iter().fold(0.0, f64::max);
        let share = |i: u32| (f64::from(i) + 0.5) / f64::from(PLACES);
        let places = (0..PLACES).flat_map(|j| (0..PLACES).map(move |i| (i, j)));
        let mut best = (piece(0.0, 0.0), f64::NEG_INFINITY);
        for (x, y) in places.map(|(i, j)| (share(i) * w, share(j) * h)) {
            let candidate = piece(x, y);
            let [left, top, ..] = candidate.map(f64::from);
            let is_far = distance(left + wide / 2.0, top + high / 2.0) >= FAR * farthest;
            let found = self.richness(candidate);
            if is_far && found > best.1 {
                best = (candidate, found);
            }
        }
        [piece(gaze.0, gaze.1), best.0]
    }

    /// How much the reference varies in a piece.
    fn richness(&self, [left, top, wide, high]: Piece) -> f64 {
        let Some(shot) = self.shots.first() else { return 0.0 };
        let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
        for y in top..top + high {
            for x in left..left + wide {
                let start = 3 * (y as usize * self.width as usize + x as usize);
                let pixel = shot.rgb.get(start..start + 3).unwrap_or(&[0; 3]);
                let v: f64 = pixel.iter().map(|&c| f64::from(c)).sum();
                (sum, squares, n) = (sum + v, squares + v * v, n + 1.0);
            }
        }
        squares / n - (sum / n).powi(2)
    }
}

pub(super) fn chart(show: &Show<'_>) -> Result<Option<Chart>, ReportError> {
    let Some(album) = show.album.as_ref().filter(|a| a.shots.len() > 1) else { return Ok(None) };
    let layout = Layout::of(album);
    let pieces = album.pieces(&layout);
    let underlay = Underlay { left: CORNER.0, top: CORNER.1, image: sheet(album, &layout, pieces) };
    let what =
        format!("variant {}, view {}", show.variant(), super::super::shortened(&album.view, 30));
    let page = Page { underlay: Some(underlay), ..show.page(NAME, TITLE, &what) };
    let drawing = page.draw(|canvas| captions(canvas, album, &layout, pieces))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// SVG units as PNG pixels.
fn zoomed(length: f64) -> u32 {
    (length * f64::from(ZOOM.0) / f64::from(ZOOM.1)).round() as u32
}

fn sheet(album: &Album, layout: &Layout, pieces: [Piece; 2]) -> RgbImage {
    let mut sheet = RgbImage::filled(zoomed(ROOM.0), zoomed(ROOM.1), [255; 3]);
    let mut put = |image: &RgbImage, (left, top): (f64, f64), (wide, high): (f64, f64)| {
        let image = image.resized(zoomed(wide).max(1), zoomed(high).max(1));
        sheet.paste(&image, zoomed(left), zoomed(top));
    };
    for (i, shot) in album.shots.iter().enumerate() {
        let raw = RgbImage::from_bytes(album.width, album.height, shot.rgb.clone());
        let Some(frame) = raw else { continue };
        put(&frame, (layout.frame_left(i), 0.0), layout.frame);
        for ([x, y, w, h], top) in pieces.into_iter().zip(layout.tops()) {
            let crop = frame.cropped(x, y, w, h);
            put(&crop, (layout.left(i), top), layout.crop);
        }
    }
    sheet
}

fn captions(canvas: &Canvas, album: &Album, layout: &Layout, pieces: [Piece; 2]) -> Drawn {
    let (left, top) = (f64::from(CORNER.0), f64::from(CORNER.1));
    let scale = layout.frame.0 / f64::from(album.width.max(1));
    let colours = [FOVEA, PERIPHERY];
    for (i, shot) in album.shots.iter().enumerate() {
        let middle = left + layout.left(i) + layout.column / 2.0;
        let name = super::super::shortened(&shot.name, 28);
        canvas.text(&name, (middle, top - 16.0), Align::Centre, INK)?;
        let corner = (left + layout.frame_left(i), top);
        for ([x, y, w, h], colour) in pieces.into_iter().zip(colours) {
            let [x, y, w, h] = [x, y, w, h].map(|v| scale * f64::from(v));
            frame(canvas, (corner.0 + x, corner.1 + y), (w, h), colour)?;
        }
        let gaze =
            (corner.0 + album.gaze[0] * layout.frame.0, corner.1 + album.gaze[1] * layout.frame.1);
        cross(canvas, gaze)?;
        for (crop_top, colour) in layout.tops().into_iter().zip(colours) {
            frame(canvas, (left + layout.left(i), top + crop_top), layout.crop, colour)?;
        }
    }
    let zoom = layout.crop.0 / (CROP * layout.frame.0);
    let note = format!(
        "cross: gaze; middle row: at the gaze, lower row: periphery, both {zoom:.1} times the frame"
    );
    canvas.text(&note, (left, top + ROOM.1 + 20.0), Align::Left, GREY)
}

fn frame(canvas: &Canvas, (x, y): (f64, f64), (w, h): (f64, f64), colour: RGBColor) -> Drawn {
    let corners = [(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)];
    canvas.line(&corners, colour, 3)
}

/// White in dark, to be seen on everything.
fn cross(canvas: &Canvas, (x, y): (f64, f64)) -> Drawn {
    for (colour, width, reach) in [(INK, 5, 10.0), (RGBColor(255, 255, 255), 2, 9.0)] {
        canvas.line(&[(x - reach, y), (x + reach, y)], colour, width)?;
        canvas.line(&[(x, y - reach), (x, y + reach)], colour, width)?;
    }
    Ok(())
}
