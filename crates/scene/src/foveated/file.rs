//! The file of a foveated model. Described in `docs/foveation.md`.

use std::io::{self, Read, Write};

use super::{Foveated, LevelPaint};
use crate::check::is_usable;
use crate::error::{DAMAGED, SceneError};
use crate::input::{Input, check_count};
use crate::{Gaussians, convert::rest_of};

/// The first eight bytes.
pub const MAGIC: [u8; 8] = *b"\x89PGF\x0D\x0A\x1A\x0A";
/// The version that is written, major and minor; files of this major version are read.
pub const VERSION: (u16, u16) = (1, 0);
/// The last four bytes.
const END: [u8; 4] = *b"END\n";
/// Bytes before the columns.
const HEAD: usize = 32;
/// Values that are read or written together.
const BLOCK: usize = 1 << 14;

/// Bytes of a file with `n` Gaussians of this degree, of which `upper` are in levels 2 to 4, a
/// Gaussian once for each.
fn file_bytes(n: u64, degree: u8, upper: u64) -> u128 {
    let rest = 3 * rest_of(degree) as u128;
    let (n, upper) = (u128::from(n), u128::from(upper));
    let columns = 6 + 4;
    HEAD as u128 + n * (4 * (3 + 3 + 4 + rest + 4) + 1) + upper * 16 + 4 * (columns - 1) + 4
}

impl Foveated {
    /// Writes the file.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let base = &self.base;
        out.write_all(&head(self.len() as u64, base.sh_degree, base.antialiased))?;
        column(out, base.means.as_flattened().iter().copied())?;
        column(out, base.log_scales.as_flattened().iter().copied())?;
        column(out, base.rotations.as_flattened().iter().copied())?;
        let rest = base.sh.chunks_exact(base.sh_coefficients());
        column(out, rest.flat_map(|channel| channel[1..].iter().copied()))?;
        out.write_all(&self.highest)?;
        out.write_all(&crc32fast::hash(&self.highest).to_le_bytes())?;
        for level in 0..Self::LEVELS {
            let is_in = |i: &usize| usize::from(self.highest[*i]) >= level;
            let paints = (0..self.len()).filter(is_in).flat_map(|i| {
                let paint = self.paint(level, i);
                [paint.dc[0], paint.dc[1], paint.dc[2], paint.logit_opacity]
            });
            column(out, paints)?;
        }
        out.write_all(&END)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Another kind of file, another version, a length that is not the promised one, a checksum
    /// that does not hold, values that no model has: each with its column and entry.
    pub fn read(input: Input<'_>) -> Result<Foveated, SceneError> {
        let Input { mut reader, len } = input;
        let FoveatedHead { count, degree, antialiased } = read_head(&mut reader)?;
        // Refused before anything is allocated.
        let least = file_bytes(count, degree, 0);
        let bound = if least <= u128::from(len) { u64::MAX } else { 0 };
        let n = check_count("foveated model", count, bound.max(u64::from(count == 0)))?;
        let rest = 3 * rest_of(degree);
        let means = triples(floats(&mut reader, "means", 3 * n)?);
        let log_scales = triples(floats(&mut reader, "log_scales", 3 * n)?);
        let rotations: Vec<[f32; 4]> =
            floats(&mut reader, "rotations", 4 * n)?.as_chunks().0.to_vec();
        let shared = floats(&mut reader, "sh_rest", rest * n)?;
        let highest = levels(&mut reader, n)?;
        let upper: u64 = highest.iter().map(|&h| u64::from(h)).sum();
        if file_bytes(count, degree, upper) != u128::from(len) {
            let what = format!(
                "{len} bytes, and its levels need {}: the file is cut off or has been changed",
                file_bytes(count, degree, upper)
            );
            return Err(SceneError::truncated("foveated model", what));
        }
        let (first, paints) = read_paints(&mut reader, &highest)?;
        let mut end = [0; 4];
        fill(&mut reader, "end", &mut end)?;
        if end != END {
            return Err(SceneError::malformed("end", "not the end of a model", DAMAGED));
        }
        let sh = interleaved(&first, &shared, rest / 3);
        let logit_opacities = first.iter().map(|p| p.logit_opacity).collect();
        let base = Gaussians {
            means,
            log_scales,
            rotations,
            logit_opacities,
            sh_degree: degree,
            sh,
            antialiased,
        };
        let model = Foveated { base, highest, paints };
        model.check()?;
        Ok(model)
    }

    /// Every value can be rendered.
    fn check(&self) -> Result<(), SceneError> {
        let bad = |i: usize, what: &str| {
            let what = format!("{what}; was it composed of trained models?");
            Err(SceneError::malformed(format!("Gaussian {i}"), what, DAMAGED))
        };
        let zero = |q: &[f32; 4]| q.iter().map(|c| c * c).sum::<f32>() < 1e-30;
        for i in 0..self.len() {
            if !is_usable(&self.base, i) {
                return bad(i, "a parameter is NaN, infinite or absurdly large");
            }
            if zero(&self.base.rotations[i]) {
                return bad(i, "the rotation is a quaternion of length zero");
            }
            let sane = |p: &LevelPaint| {
                p.dc.iter().all(|v| v.abs() <= 1e15) && p.logit_opacity.is_finite()
            };
            if !self.paints[i].iter().all(sane) {
                return bad(i, "a colour or opacity of level 2 to 4 is NaN, infinite or absurd");
            }
        }
        Ok(())
    }
}

/// What stands before the columns.
struct FoveatedHead {
    count: u64,
    degree: u8,
    antialiased: bool,
}

fn head(count: u64, degree: u8, antialiased: bool) -> [u8; HEAD] {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MAGIC);
    head[8..10].copy_from_slice(&VERSION.0.to_le_bytes());
    head[10..12].copy_from_slice(&VERSION.1.to_le_bytes());
    head[12..20].copy_from_slice(&count.to_le_bytes());
    head[20] = degree;
    head[21] = Foveated::LEVELS as u8;
    head[22] = u8::from(antialiased);
    let crc = crc32fast::hash(&head[..28]);
    head[28..].copy_from_slice(&crc.to_le_bytes());
    head
}

fn read_head(reader: &mut impl Read) -> Result<FoveatedHead, SceneError> {
    let mut bytes = [0; HEAD];
    fill(reader, "header of the foveated model", &mut bytes)?;
    let malformed =
        |what: String, todo| Err(SceneError::malformed("header of the foveated model", what, todo));
    if bytes[..8] != MAGIC {
        return malformed(
            "this is not a foveated model".into(),
            "make one with `powergs-sim scene compose`",
        );
    }
    let major = u16::from_le_bytes([bytes[8], bytes[9]]);
    if major != VERSION.0 {
        let what = format!("version {major}, and version {} is known", VERSION.0);
        return malformed(what, "use the program that wrote it, or compose the model again");
    }
    let crc = bytes[28..].try_into().map_or(0, u32::from_le_bytes);
    if crc32fast::hash(&bytes[..28]) != crc {
        return malformed("its checksum is wrong".into(), DAMAGED);
    }
    let count = bytes[12..20].try_into().map_or(0, u64::from_le_bytes);
    let (degree, levels, antialiased) = (bytes[20], bytes[21], bytes[22]);
    if degree > 3 || usize::from(levels) != Foveated::LEVELS {
        let what = format!("SH degree {degree} and {levels} levels; 0 to 3 and 4 are known");
        return malformed(what, DAMAGED);
    }
    if antialiased > 1 || bytes[23..28].iter().any(|&b| b != 0) {
        return malformed("it has features that are not known".into(), DAMAGED);
    }
    Ok(FoveatedHead { count, degree, antialiased: antialiased == 1 })
}

/// Writes floats and their checksum.
fn column(out: &mut impl Write, values: impl Iterator<Item = f32>) -> io::Result<()> {
    let mut hasher = crc32fast::Hasher::new();
    let mut block = Vec::with_capacity(4 * BLOCK);
    let mut flush = |block: &mut Vec<u8>| {
        hasher.update(block);
        let written = out.write_all(block);
        block.clear();
        written
    };
    for value in values {
        block.extend_from_slice(&value.to_le_bytes());
        if block.len() == 4 * BLOCK {
            flush(&mut block)?;
        }
    }
    flush(&mut block)?;
    out.write_all(&hasher.finalize().to_le_bytes())
}

fn fill(reader: &mut impl Read, place: &str, bytes: &mut [u8]) -> Result<(), SceneError> {
    reader.read_exact(bytes).map_err(|e| SceneError::reading(place, e))
}

/// Bytes, and their checksum behind them. The buffer grows as bytes arrive.
fn checked(reader: &mut impl Read, place: &str, len: usize) -> Result<Vec<u8>, SceneError> {
    let mut bytes = Vec::new();
    let read = reader.by_ref().take(len as u64).read_to_end(&mut bytes);
    read.map_err(|e| SceneError::reading(place, e))?;
    if bytes.len() < len {
        let what = format!("{} bytes of {len}", bytes.len());
        return Err(SceneError::truncated(format!("column `{place}`"), what));
    }
    let mut crc = [0; 4];
    fill(reader, place, &mut crc)?;
    if crc32fast::hash(&bytes) != u32::from_le_bytes(crc) {
        let place = format!("column `{place}`");
        return Err(SceneError::malformed(place, "its checksum is wrong", DAMAGED));
    }
    Ok(bytes)
}

fn floats(reader: &mut impl Read, place: &str, count: usize) -> Result<Vec<f32>, SceneError> {
    let bytes = checked(reader, place, 4 * count)?;
    Ok(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
}

fn triples(values: Vec<f32>) -> Vec<[f32; 3]> {
    values.as_chunks().0.to_vec()
}

fn levels(reader: &mut impl Read, n: usize) -> Result<Vec<u8>, SceneError> {
    let highest = checked(reader, "highest_level", n)?;
    if let Some(i) = highest.iter().position(|&h| usize::from(h) >= Foveated::LEVELS) {
        let place = format!("column `highest_level`, entry {i}");
        let what = format!("{} is above 3", highest[i]);
        return Err(SceneError::malformed(place, what, DAMAGED));
    }
    Ok(highest)
}

/// The paints of level 1 and of levels 2 to 4; those that a level does not have are of the one
/// before.
fn read_paints(
    reader: &mut impl Read,
    highest: &[u8],
) -> Result<(Vec<LevelPaint>, Vec<[LevelPaint; 3]>), SceneError> {
    let mut first = vec![LevelPaint::default(); highest.len()];
    let mut upper = vec![[LevelPaint::default(); 3]; highest.len()];
    for (level, name) in ["level_1", "level_2", "level_3", "level_4"].into_iter().enumerate() {
        let inside = |i: &usize| usize::from(highest[*i]) >= level;
        let count = (0..highest.len()).filter(inside).count();
        let values = floats(reader, name, 4 * count)?;
        let owners = (0..highest.len()).filter(inside);
        for (i, &[r, g, b, logit_opacity]) in owners.zip(values.as_chunks().0) {
            let paint = LevelPaint { dc: [r, g, b], logit_opacity };
            match level {
                0 => (first[i], upper[i]) = (paint, [paint; 3]),
                _ => upper[i][level - 1..].fill(paint),
            }
        }
    }
    Ok((first, upper))
}

/// SH coefficients `[channel][coefficient]` of DC colours and the others.
fn interleaved(first: &[LevelPaint], shared: &[f32], rest: usize) -> Vec<f32> {
    let mut sh = Vec::with_capacity(3 * first.len() + shared.len());
    for (i, paint) in first.iter().enumerate() {
        for (channel, dc) in paint.dc.into_iter().enumerate() {
            let start = (3 * i + channel) * rest;
            sh.push(dc);
            sh.extend_from_slice(&shared[start..start + rest]);
        }
    }
    sh
}
