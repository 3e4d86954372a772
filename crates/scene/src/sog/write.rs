//! Writes SOG version 2: `meta.json` and lossless WebP pictures with a pixel for each Gaussian.
//!
//! Positions have 16 bits between their extremes in the logarithmic space, rotations three bytes,
//! opacities one. Scales and DC colours each have a codebook of 256 numbers, exact where there are
//! no more different ones. The other SH coefficients have a palette.

mod codebook;
mod palette;
mod vectors;

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::io::{self, Cursor, Write};

use rayon::prelude::*;
use serde_json::{Value, json};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::super::Gaussians;
use super::super::convert::{opacities_beyond_bytes, opacity_byte, rest_of};
use super::super::export::Clamped;
use super::super::smallest_three::{SmallestThree, encode};
use super::decode::{FIRST_LARGEST, component};
use super::plane::ENTRIES_PER_ROW;
use codebook::Codebook;
use palette::SogPalette;

/// Files by name.
type SogFiles = BTreeMap<String, Vec<u8>>;
/// A picture's pixels: red, green, blue, alpha.
type SogPixels = Vec<[u8; 4]>;

const INDEX: &str = "meta.json";
const MEANS: [&str; 2] = ["means_l.webp", "means_u.webp"];
const SCALES: &str = "scales.webp";
const QUATERNIONS: &str = "quats.webp";
const SH0: &str = "sh0.webp";
const SH_N: [&str; 2] = ["shN_centroids.webp", "shN_labels.webp"];
/// Sides of pictures are multiples of so many pixels, as other writers have it.
const BLOCK: usize = 4;
const OPAQUE: u8 = 255;

/// The names of all files that a folder may have.
pub(in super::super) const FILE_NAMES: [&str; 8] =
    [INDEX, MEANS[0], MEANS[1], SCALES, QUATERNIONS, SH0, SH_N[0], SH_N[1]];

/// The files of a folder, and what was cut off.
///
/// # Errors
/// Those of the encoder of pictures.
pub(in super::super) fn write(scene: &Gaussians) -> io::Result<(SogFiles, Clamped)> {
    let n = scene.sh_coefficients();
    let (bounds, low, high) = means(scene);
    let scales = Codebook::of(scene.log_scales.as_flattened().to_vec());
    let dc = Codebook::of(scene.sh.iter().step_by(n).copied().collect());
    let scale = |s: &[f32; 3]| {
        let [a, b, c] = s.map(|v| scales.code(v));
        [a, b, c, OPAQUE]
    };
    let mut meta = json!({
        "version": 2,
        "asset": { "generator": concat!("powergs-sim ", env!("CARGO_PKG_VERSION")) },
        "count": scene.len(),
        "means": { "mins": bounds[0], "maxs": bounds[1], "files": MEANS },
        "scales": { "codebook": scales.json(), "files": [SCALES] },
        "quats": { "files": [QUATERNIONS] },
        "sh0": { "codebook": dc.json(), "files": [SH0] },
    });
    if scene.antialiased {
        meta["model"] = json!("antialiased");
    }
    let mut pictures = vec![
        picture(MEANS[0], low),
        picture(MEANS[1], high),
        picture(SCALES, scene.log_scales.par_iter().map(scale).collect()),
        picture(QUATERNIONS, scene.rotations.par_iter().map(|q| rotation(*q)).collect()),
        picture(SH0, (0..scene.len()).into_par_iter().map(|i| sh0(scene, i, &dc)).collect()),
    ];
    if scene.sh_degree > 0 {
        pictures.extend(harmonics(scene, &mut meta));
    }
    let encode = |(name, width, pixels): (&str, usize, SogPixels)| {
        let height = pixels.len() / width;
        let bytes = powergs_pixels::webp(width as u32, height as u32, pixels.as_flattened())?;
        Ok((name.to_owned(), bytes))
    };
    let mut files: SogFiles = pictures.into_par_iter().map(encode).collect::<io::Result<_>>()?;
    files.insert(INDEX.into(), meta.to_string().into_bytes());
    let opacity = opacities_beyond_bytes(&scene.logit_opacities);
    Ok((files, Clamped { opacity, ..Clamped::default() }))
}

/// Files as a zip archive. They are stored as they are: pictures do not deflate.
///
/// # Errors
/// An archive that its format cannot hold.
pub(in super::super) fn zipped(files: &SogFiles) -> io::Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o644);
    for (name, bytes) in files {
        archive.start_file(name.as_str(), options.large_file(bytes.len() >= 1 << 32))?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// A nearly square picture of a pixel for each Gaussian: its name, its width and its pixels,
/// filled up with zeros.
fn picture(name: &'static str, pixels: SogPixels) -> (&'static str, usize, SogPixels) {
    let side = (pixels.len() as f64).sqrt().ceil() as usize;
    of_width(name, side.next_multiple_of(BLOCK), BLOCK, pixels)
}

fn of_width(
    name: &'static str,
    width: usize,
    rows: usize,
    mut pixels: SogPixels,
) -> (&'static str, usize, SogPixels) {
    let height = pixels.len().div_ceil(width).next_multiple_of(rows);
    pixels.resize(width * height, [0; 4]);
    (name, width, pixels)
}

/// The bounds of the positions in the logarithmic space, and the low and high bytes of the 16 bits
/// between them.
fn means(scene: &Gaussians) -> ([[f64; 3]; 2], SogPixels, SogPixels) {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for mean in &scene.means {
        let place = mean.map(logarithmic);
        for axis in 0..3 {
            bounds[0][axis] = bounds[0][axis].min(place[axis]);
            bounds[1][axis] = bounds[1][axis].max(place[axis]);
        }
    }
    let code = |mean: &[f32; 3]| -> [u16; 3] {
        std::array::from_fn(|axis| {
            let (min, max) = (bounds[0][axis], bounds[1][axis]);
            let t = (logarithmic(mean[axis]) - min) / (max - min);
            // Without a width there is no step.
            if max > min { (t * 65535.0).round() as u16 } else { 0 }
        })
    };
    let codes: Vec<[u16; 3]> = scene.means.par_iter().map(code).collect();
    let half = |shift: u32| {
        let pixel = |code: &[u16; 3]| {
            let [x, y, z] = code.map(|c| (c >> shift) as u8);
            [x, y, z, OPAQUE]
        };
        codes.iter().map(pixel).collect()
    };
    (bounds, half(0), half(8))
}

/// `sign(x) ln(1 + |x|)`.
fn logarithmic(x: f32) -> f64 {
    let x = f64::from(x);
    x.abs().ln_1p() * x.signum()
}

/// The three smaller components, and the place of the largest.
fn rotation(q: [f32; 4]) -> [u8; 4] {
    let byte = |c: f64| ((c * FRAC_1_SQRT_2 + 0.5) * 255.0).round().clamp(0.0, 255.0) as u32;
    let SmallestThree { place, codes } = encode(q, byte, |code| component(code as u8));
    let [a, b, c] = codes.map(|code| code as u8);
    [a, b, c, FIRST_LARGEST + place as u8]
}

/// DC colour and opacity.
fn sh0(scene: &Gaussians, i: usize, dc: &Codebook) -> [u8; 4] {
    let (sh, n) = (scene.sh_of(i), scene.sh_coefficients());
    let [r, g, b] = [sh[0], sh[n], sh[2 * n]].map(|v| dc.code(v));
    [r, g, b, opacity_byte(scene.logit_opacities[i])]
}

/// The pictures of the palette and of the labels, and their table in `meta`.
fn harmonics(scene: &Gaussians, meta: &mut Value) -> [(&'static str, usize, SogPixels); 2] {
    let rest = rest_of(scene.sh_degree);
    let palette = SogPalette::of(scene);
    let book = Codebook::of(palette.values.clone());
    meta["shN"] = json!({
        "count": palette.values.len() / (3 * rest),
        "bands": scene.sh_degree,
        "codebook": book.json(),
        "files": SH_N,
    });
    let texels = |entry: &[f32]| -> SogPixels {
        let code = |i: usize| book.code(entry[i]);
        (0..rest).map(|c| [code(c), code(rest + c), code(2 * rest + c), OPAQUE]).collect()
    };
    let texels = palette.values.par_chunks_exact(3 * rest).flat_map_iter(texels).collect();
    let label = |label: &u16| {
        let [low, high] = label.to_le_bytes();
        [low, high, 0, OPAQUE]
    };
    [
        of_width(SH_N[0], ENTRIES_PER_ROW * rest, 1, texels),
        picture(SH_N[1], palette.labels.iter().map(label).collect()),
    ]
}
