//! The regions R1 to R4 of a foveated picture, drawn over it.

use powergs_base::picture::Picture;
use powergs_frame::fovea::{GazeError, ScreenGaze, TileLevels};
use powergs_frame::splat::TileGrid;

/// Tints of R1 (not used: it is shown as it is) to R4, sRGB: apart for all kinds of map.
pub const TINTS: [[f32; 3]; 4] =
    [[0.5, 0.5, 0.5], [0.0, 0.45, 0.70], [0.90, 0.62, 0.0], [0.80, 0.25, 0.55]];
/// How strong they are.
const STRENGTH: f32 = 0.5;
/// Luminance of the channels. What is tinted has no colour of its own, so that the tint can be
/// found in a legend.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// Half the length of the cross at the gaze, of the width of the picture.
const CROSS: f32 = 0.012;

/// The picture with tinted tiles (a mixture where two levels are blended), lines between regions
/// and a cross at the gaze.
///
/// # Errors
/// [`GazeError`]: a gaze outside the picture, or an impossible screen.
pub fn draw(picture: &Picture, gaze: &ScreenGaze) -> Result<Picture, GazeError> {
    let (width, height) = (picture.width, picture.height);
    let map = gaze.eccentricity_map([width, height])?;
    let levels = TileLevels::new(&map, TileGrid::new(width, height, 16));
    let regions = map.regions();
    let mut out = picture.clone();
    let [gaze_x, gaze_y] = [gaze.point[0] * width as f32, gaze.point[1] * height as f32];
    let reach = (CROSS * width as f32).max(3.0);
    for (i, pixel) in out.pixels.iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let tile = levels.tiles[levels.grid.index(x / 16, y / 16)];
        let first = usize::from(tile.first);
        let share = levels.share(x, y) as f32;
        let second = TINTS[(first + 1).min(3)];
        let own = regions[i];
        let right = (x + 1 < width).then(|| regions[i + 1]);
        let below = regions.get(i + width as usize).copied();
        let is_line = [right, below].into_iter().flatten().any(|other| other != own);
        let (dx, dy) = ((x as f32 - gaze_x).abs(), (y as f32 - gaze_y).abs());
        let is_cross = (dx < 1.0 && dy < reach) || (dy < 1.0 && dx < reach);
        let grey: f32 = pixel.iter().zip(LUMINANCE).map(|(value, share)| value * share).sum();
        for (c, value) in pixel.iter_mut().enumerate() {
            // R1 is shown as it is.
            let (tint, strength) = match first {
                0 => (second[c], STRENGTH * share),
                _ => ((1.0 - share) * TINTS[first][c] + share * second[c], STRENGTH),
            };
            let faded = strength / STRENGTH;
            let plain = (1.0 - faded) * *value + faded * grey;
            *value = (1.0 - strength) * plain + strength * tint;
            if is_line || is_cross {
                *value = 1.0;
            }
        }
    }
    Ok(out)
}
