//! Pictures of one view side by side: the frame, what is at the gaze, and a piece of the periphery.

use powergs_pixels::RgbImage;

use super::Show;
use powergs_chart::{Chart, Colour, Line, Mark, Panel, Words};
use powergs_optimize::pictures::{Album, Shot};

const NAME: &str = "foveated_pictures";
const TITLE: &str = "The same view and gaze, method by method";
/// Width over height of the room for pictures.
const ROOM: f64 = 2.3;
/// A frame is at most this high, of that room.
const FRAME_MOST: f64 = 0.44;
/// Width of a crop, of that of the frame.
const CROP: f64 = 0.2;
/// Pieces of the periphery are at least this far from the gaze, of the farthest corner.
const FAR: f64 = 0.5;
/// Places that are looked at for one, across and down.
const PLACES: u32 = 12;
/// Lines around what is enlarged: at the gaze, in the periphery.
const COLOURS: [Colour; 2] = [Colour::YELLOW, Colour::SKY];

/// A rectangle of a picture: left, top, width, height, pixels.
type Piece = [u32; 4];

/// Width over height of a crop, so that a frame and two crops below each other fill the page.
fn crop_aspect(album: &Album) -> f64 {
    let column = ROOM / album.shots.len().max(1) as f64;
    let frame = column * f64::from(album.height.max(1)) / f64::from(album.width.max(1));
    2.0 * column / (1.0 - frame.min(FRAME_MOST))
}

/// What is enlarged: the piece at the gaze, and the richest far from it.
fn pieces(album: &Album) -> [Piece; 2] {
    let (w, h) = (f64::from(album.width), f64::from(album.height));
    let wide = (CROP * w).clamp(1.0, w);
    let high = (wide / crop_aspect(album)).clamp(1.0, h);
    let piece = |x: f64, y: f64| {
        let left = (x - wide / 2.0).clamp(0.0, w - wide);
        let top = (y - high / 2.0).clamp(0.0, h - high);
        [left as u32, top as u32, wide as u32, high as u32]
    };
    let gaze = (album.gaze[0] * w, album.gaze[1] * h);
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
        let found = richness(album, candidate);
        if is_far && found > best.1 {
            best = (candidate, found);
        }
    }
    [piece(gaze.0, gaze.1), best.0]
}

/// How much the reference varies in a piece.
fn richness(album: &Album, [left, top, wide, high]: Piece) -> f64 {
    let Some(shot) = album.shots.first() else { return 0.0 };
    let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
    for y in top..top + high {
        for x in left..left + wide {
            let start = 3 * (y as usize * album.width as usize + x as usize);
            let pixel = shot.rgb.get(start..start + 3).unwrap_or(&[0; 3]);
            let v: f64 = pixel.iter().map(|&c| f64::from(c)).sum();
            (sum, squares, n) = (sum + v, squares + v * v, n + 1.0);
        }
    }
    squares / n - (sum / n).powi(2)
}

pub(super) fn chart(show: &Show<'_>) -> Option<Chart> {
    let album = show.album.as_ref().filter(|a| a.shots.len() > 1)?;
    let pieces = pieces(album);
    let frames: Vec<(&Shot, RgbImage)> = album
        .shots
        .iter()
        .filter_map(|s| Some((s, RgbImage::from_bytes(album.width, album.height, s.rgb.clone())?)))
        .collect();
    let what = format!(
        "variant {}, view {} of {}x{}",
        show.variant(),
        super::super::shortened(&album.view, 30),
        album.width,
        album.height
    );
    let mut chart = show.chart(NAME, TITLE, &what).columns(frames.len());
    for (shot, frame) in &frames {
        let name = super::super::shortened(&shot.name, 28);
        let panel = Panel::picture(frame.clone(), name);
        let panel =
            pieces.into_iter().zip(COLOURS).fold(panel, |p, (piece, c)| border(p, piece, c));
        let [x, y] = album.gaze;
        let gaze = (x * f64::from(album.width), y * f64::from(album.height));
        chart = chart.panel(panel.mark(Mark::Cross(gaze)));
    }
    for ([x, y, w, h], colour) in pieces.into_iter().zip(COLOURS) {
        for (_, frame) in &frames {
            let crop = frame.cropped(x, y, w, h);
            chart =
                chart.panel(border(Panel::picture(crop, Words::from("")), [0, 0, w, h], colour));
        }
    }
    let note =
        "cross: gaze; middle row: enlarged at the gaze, lower row: enlarged in the periphery";
    Some(chart.note(note))
}

/// A frame around a piece of a picture.
fn border(panel: Panel, piece: Piece, colour: Colour) -> Panel {
    let [x, y, w, h] = piece.map(f64::from);
    let corners = vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)];
    panel.line(Line::curve(corners, colour))
}
