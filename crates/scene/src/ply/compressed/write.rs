//! Writes PlayCanvas compressed PLY, with bounds of colours and, above degree 0, an `sh` element.
//!
//! Bounds are those of the chunk, so that positions, scales and colours lose half a step of their
//! chunk's range at most and nothing is cut off. SH coefficients beyond -4 and 4 are.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use super::super::super::Gaussians;
use super::super::super::convert::{colour, opacities_beyond_bytes, opacity_byte, rest_of};
use super::super::super::export::Clamped;
use super::super::super::smallest_three::{SmallestThree, encode};
use super::super::header::ANTIALIASED;
use super::{BOUNDS, CHUNK, CompressedChunk, PACKED, component, sh_value};

/// SH coefficients are held up to this magnitude.
const MOST_SH: f32 = 4.0;

/// The file, and what was cut off.
pub(in super::super::super) fn write(scene: &Gaussians) -> (Vec<u8>, Clamped) {
    let mut file = header(scene).into_bytes();
    let n = scene.len();
    let chunks = (0..n).step_by(CHUNK).map(|start| start..n.min(start + CHUNK));
    let mut rows = Vec::with_capacity(16 * n);
    for range in chunks {
        let chunk = bounds(scene, range.clone());
        chunk.iter().for_each(|bound| file.extend_from_slice(&bound.to_le_bytes()));
        for i in range {
            pack(scene, i, &chunk).iter().for_each(|word| rows.extend(word.to_le_bytes()));
        }
    }
    file.append(&mut rows);
    let channels = scene.sh.chunks_exact(scene.sh_coefficients());
    let rest = channels.flat_map(|channel| &channel[1..]);
    file.extend(rest.clone().map(|&value| sh_byte(value)));
    let clamped = Clamped {
        opacity: opacities_beyond_bytes(&scene.logit_opacities),
        colour_rest: rest.filter(|value| value.abs() > MOST_SH).count() as u64,
        ..Clamped::default()
    };
    (file, clamped)
}

fn header(scene: &Gaussians) -> String {
    let chunks = scene.len().div_ceil(CHUNK);
    let comment = if scene.antialiased { format!("{ANTIALIASED}\n") } else { String::new() };
    let mut text =
        format!("ply\nformat binary_little_endian 1.0\n{comment}element chunk {chunks}\n");
    BOUNDS.iter().for_each(|name| text += &format!("property float {name}\n"));
    text += &format!("element vertex {}\n", scene.len());
    PACKED.iter().for_each(|name| text += &format!("property uint {name}\n"));
    let rest = 3 * rest_of(scene.sh_degree);
    if rest > 0 {
        text += &format!("element sh {}\n", scene.len());
        (0..rest).for_each(|i| text += &format!("property uchar f_rest_{i}\n"));
    }
    text + "end_header\n"
}

/// The colour of Gaussian `i`, red, green, blue.
fn rgb(scene: &Gaussians, i: usize) -> [f32; 3] {
    let n = scene.sh_coefficients();
    let sh = scene.sh_of(i);
    [sh[0], sh[n], sh[2 * n]].map(|dc| colour(dc) as f32)
}

/// The bounds of a chunk.
fn bounds(scene: &Gaussians, range: Range<usize>) -> CompressedChunk {
    let mut chunk: CompressedChunk = [0.0; 18];
    for half in 0..6 {
        let (start, pick): (f32, fn(f32, f32) -> f32) =
            if half % 2 == 0 { (f32::MAX, f32::min) } else { (f32::MIN, f32::max) };
        let mut bound = [start; 3];
        for i in range.clone() {
            let values = match half / 2 {
                0 => scene.means[i],
                1 => scene.log_scales[i],
                _ => rgb(scene, i),
            };
            bound = std::array::from_fn(|axis| pick(bound[axis], values[axis]));
        }
        chunk[3 * half..3 * half + 3].copy_from_slice(&bound);
    }
    chunk
}

/// The four words of Gaussian `i`.
fn pack(scene: &Gaussians, i: usize, chunk: &CompressedChunk) -> [u32; 4] {
    let three = |values: [f32; 3], at: usize, steps: [f64; 3]| -> [u32; 3] {
        std::array::from_fn(|axis| {
            let (min, max) = (chunk[at + axis], chunk[at + axis + 3]);
            step(values[axis], min, max, steps[axis])
        })
    };
    let fine = [2047.0, 1023.0, 2047.0];
    let [x, y, z] = three(scene.means[i], 0, fine);
    let [a, b, c] = three(scene.log_scales[i], 6, fine);
    let [red, green, blue] = three(rgb(scene, i), 12, [255.0; 3]);
    let ten_bits = |c: f64| ((c * FRAC_1_SQRT_2 + 0.5) * 1023.0).round().clamp(0.0, 1023.0) as u32;
    let SmallestThree { place, codes } = encode(scene.rotations[i], ten_bits, component);
    [
        x << 21 | y << 11 | z,
        codes.iter().fold(place, |word, code| word << 10 | code),
        a << 21 | b << 11 | c,
        red << 24 | green << 16 | blue << 8 | u32::from(opacity_byte(scene.logit_opacities[i])),
    ]
}

/// The step of `value`, which lies between the bounds.
fn step(value: f32, min: f32, max: f32, steps: f64) -> u32 {
    let [value, min, max] = [value, min, max].map(f64::from);
    if max > min { ((value - min) / (max - min) * steps).round() as u32 } else { 0 }
}

/// The byte that is read back as the coefficient closest to `value`.
fn sh_byte(value: f32) -> u8 {
    let guess = ((f64::from(value) / 8.0 + 0.5) * 256.0).floor() as u8;
    let error = |byte: &u8| (sh_value(f64::from(*byte)) - value).abs();
    let near = guess.saturating_sub(1)..=guess.saturating_add(1);
    near.min_by(|a, b| error(a).total_cmp(&error(b))).expect("three or two bytes")
}
