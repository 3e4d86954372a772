//! PlayCanvas compressed PLY: chunks of 256 Gaussians with their bounds, four packed words each.
//!
//! Position and scale are 11-10-11 bits between the chunk's bounds, rotation is the largest
//! component's place (2 bits) and the other three in 10 bits, colour and opacity are bytes; colours
//! lie between the chunk's bounds where it has them (18 properties instead of 12). A third element,
//! `sh`, holds `f_rest_*` as bytes, -4 to 4.

mod write;

use std::f64::consts::SQRT_2;

use super::super::Gaussians;
use super::super::convert::{dc, degree_of, logit, quaternion};
use super::super::error::{DAMAGED, REEXPORT, SceneError};
use super::super::input::check_count;
use super::header::{Element, PlyHeader};
use super::{Source, rows};

pub(in super::super) use write::write;

/// Gaussians per chunk.
const CHUNK: usize = 256;
const BOUNDS: [&str; 18] = [
    "min_x",
    "min_y",
    "min_z",
    "max_x",
    "max_y",
    "max_z",
    "min_scale_x",
    "min_scale_y",
    "min_scale_z",
    "max_scale_x",
    "max_scale_y",
    "max_scale_z",
    "min_r",
    "min_g",
    "min_b",
    "max_r",
    "max_g",
    "max_b",
];
/// The bounds without those of colours.
const WITHOUT_COLOUR: usize = 12;
const PACKED: [&str; 4] = ["packed_position", "packed_rotation", "packed_scale", "packed_color"];

/// Bounds of a chunk, in the order of [`BOUNDS`].
type CompressedChunk = [f32; 18];

/// Reads the `chunk`, `vertex` and, if there is one, `sh` elements.
pub(super) fn read(source: &mut Source<'_>, header: &PlyHeader) -> Result<Gaussians, SceneError> {
    let mut next = 0;
    let element = header.advance(source, &mut next, "chunk")?;
    let chunks = read_chunks(source, header, element)?;
    let vertex = header.advance(source, &mut next, "vertex")?;
    let packed = find(vertex, &PACKED)?;
    vertex.check_fits(header.encoding, source.left)?;
    let count = check_count("PLY element `vertex`", vertex.count, u64::MAX)?;
    if chunks.len() != count.div_ceil(CHUNK) {
        let what = format!("{} chunks for {count} Gaussians, 256 in each", chunks.len());
        return Err(SceneError::malformed("PLY element `chunk`", what, DAMAGED));
    }
    let sh = header.elements[next..].iter().find(|e| e.name == "sh");
    let degree = sh.map_or(Ok(0), sh_degree)?;
    let mut scene = Gaussians::with_capacity(count, degree);
    rows::each(source, header.encoding, vertex, &packed, |v| {
        let chunk = &chunks[scene.len() / CHUNK];
        unpack(&mut scene, chunk, [v[0], v[1], v[2], v[3]].map(|word| word as u32));
    })?;
    if sh.is_some() {
        let element = header.advance(source, &mut next, "sh")?;
        read_sh(source, header, element, &mut scene)?;
    }
    Ok(scene)
}

fn find(element: &Element, names: &[&str]) -> Result<Vec<usize>, SceneError> {
    let find = |name: &&str| {
        element.column(name).ok_or_else(|| {
            let place = format!("PLY element `{}`", element.name);
            SceneError::malformed(place, format!("no property `{name}`"), DAMAGED)
        })
    };
    names.iter().map(find).collect()
}

fn read_chunks(
    source: &mut Source<'_>,
    header: &PlyHeader,
    element: &Element,
) -> Result<Vec<CompressedChunk>, SceneError> {
    let coloured = element.column("min_r").is_some();
    let names = if coloured { &BOUNDS[..] } else { &BOUNDS[..WITHOUT_COLOUR] };
    let wanted = find(element, names)?;
    let mut chunks = Vec::new();
    rows::each(source, header.encoding, element, &wanted, |v| {
        // Without bounds, colours are 0 to 1.
        let mut chunk: CompressedChunk = [0.0; 18];
        chunk[15..].fill(1.0);
        chunk.iter_mut().zip(v).for_each(|(bound, value)| *bound = *value as f32);
        chunks.push(chunk);
    })?;
    Ok(chunks)
}

/// Appends the Gaussian of four packed words.
fn unpack(scene: &mut Gaussians, chunk: &CompressedChunk, words: [u32; 4]) {
    let [position, rotation, scale, colour] = words;
    scene.means.push(between(three(position), &chunk[0..6]));
    scene.log_scales.push(between(three(scale), &chunk[6..12]));
    let small = [20, 10, 0].map(|shift| component(rotation >> shift));
    scene.rotations.push(quaternion(small, (rotation >> 30) as usize));
    let rgb = between([24, 16, 8].map(|shift| unit(colour >> shift, 8)), &chunk[12..18]);
    scene.logit_opacities.push(logit(unit(colour, 8)));
    for channel in rgb {
        scene.sh.push(dc(f64::from(channel)));
        scene.sh.extend((1..scene.sh_coefficients()).map(|_| 0.0));
    }
}

/// A component of a quaternion from the lowest 10 bits of `word`.
fn component(word: u32) -> f64 {
    (unit(word, 10) - 0.5) * SQRT_2
}

/// The lowest `bits` bits of `word`, 0 to 1.
fn unit(word: u32, bits: u32) -> f64 {
    let largest = (1_u32 << bits) - 1;
    f64::from(word & largest) / f64::from(largest)
}

fn three(word: u32) -> [f64; 3] {
    [unit(word >> 21, 11), unit(word >> 11, 10), unit(word, 11)]
}

/// Interpolates three values between three minima and three maxima.
fn between(t: [f64; 3], bounds: &[f32]) -> [f32; 3] {
    std::array::from_fn(|i| {
        let (min, max) = (f64::from(bounds[i]), f64::from(bounds[i + 3]));
        (min * (1.0 - t[i]) + max * t[i]) as f32
    })
}

fn sh_degree(element: &Element) -> Result<u8, SceneError> {
    let n = element.properties.len();
    match n.is_multiple_of(3).then(|| degree_of(n / 3)).flatten() {
        Some(degree) if (1..=3).contains(&degree) => Ok(degree),
        _ => {
            let what = format!("{n} properties; 9, 24 or 45 are known");
            Err(SceneError::malformed("PLY element `sh`", what, REEXPORT))
        }
    }
}

fn read_sh(
    source: &mut Source<'_>,
    header: &PlyHeader,
    element: &Element,
    scene: &mut Gaussians,
) -> Result<(), SceneError> {
    if element.count != scene.len() as u64 {
        let what = format!("{} rows for {} Gaussians", element.count, scene.len());
        return Err(SceneError::malformed("PLY element `sh`", what, DAMAGED));
    }
    let names: Vec<String> = (0..element.properties.len()).map(|i| format!("f_rest_{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let wanted = find(element, &names)?;
    let per_channel = scene.sh_coefficients();
    let mut slots = scene.sh.chunks_exact_mut(per_channel);
    rows::each(source, header.encoding, element, &wanted, |v| {
        for coefficients in v.chunks_exact(per_channel - 1) {
            let slot = slots.next().expect("one row per Gaussian, three channels each");
            slot[1..].iter_mut().zip(coefficients).for_each(|(s, c)| *s = sh_value(*c));
        }
    })
}

/// Bytes are the middles of 256 steps from -4 to 4; the first and the last are the ends.
fn sh_value(byte: f64) -> f32 {
    let t = match byte {
        b if b <= 0.0 => 0.0,
        b if b >= 255.0 => 1.0,
        b => (b + 0.5) / 256.0,
    };
    ((t - 0.5) * 8.0) as f32
}
