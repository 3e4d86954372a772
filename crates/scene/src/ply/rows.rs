//! Rows of PLY elements, in any encoding, as numbers.

use std::io::Read;

use super::super::error::{DAMAGED, REEXPORT, SceneError};
use super::Source;
use super::header::{Element, Encoding, Scalar};

/// Longest line of an ASCII row, bytes.
const MAX_LINE: u64 = 1 << 16;
/// Bytes that are read at a time.
const BLOCK: usize = 1 << 18;

/// Calls `row` with the values of the `wanted` columns of each row of `element`. Values pass
/// through f64, which holds every type exactly.
pub(super) fn each(
    source: &mut Source<'_>,
    encoding: Encoding,
    element: &Element,
    wanted: &[usize],
    mut row: impl FnMut(&[f64]),
) -> Result<(), SceneError> {
    if element.has_lists() {
        let what = "list properties are not supported here";
        return Err(SceneError::malformed(
            format!("PLY element `{}`", element.name),
            what,
            REEXPORT,
        ));
    }
    if element.properties.is_empty() {
        let place = format!("PLY element `{}`", element.name);
        return Err(SceneError::malformed(place, "no properties", DAMAGED));
    }
    element.check_fits(encoding, source.left)?;
    match encoding {
        Encoding::Ascii => each_line(source, element, wanted, &mut row),
        Encoding::Little => each_binary(source, element, wanted, &mut row, number::<false>),
        Encoding::Big => each_binary(source, element, wanted, &mut row, number::<true>),
    }
}

fn each_binary(
    source: &mut Source<'_>,
    element: &Element,
    wanted: &[usize],
    row: &mut impl FnMut(&[f64]),
    number: impl Fn(&[u8], Scalar) -> f64,
) -> Result<(), SceneError> {
    let mut offsets = vec![0];
    for property in &element.properties {
        offsets.push(offsets[offsets.len() - 1] + property.scalar.bytes());
    }
    let row_bytes = element.least_row_bytes() as usize;
    let columns: Vec<(usize, Scalar)> =
        wanted.iter().map(|&w| (offsets[w], element.properties[w].scalar)).collect();
    let rows_per_block = (BLOCK / row_bytes.max(1)).max(1) as u64;
    let mut block = Vec::new();
    let mut values = vec![0.0; wanted.len()];
    let mut done = 0;
    while done < element.count {
        let rows = rows_per_block.min(element.count - done);
        block.resize(rows as usize * row_bytes, 0);
        let place = format!("PLY element `{}`, row {done}", element.name);
        source.read_exact(&mut block, &place)?;
        for bytes in block.chunks_exact(row_bytes) {
            for (value, &(offset, scalar)) in values.iter_mut().zip(&columns) {
                *value = number(&bytes[offset..], scalar);
            }
            row(&values);
        }
        done += rows;
    }
    Ok(())
}

/// The number of type `scalar` at the start of `bytes`.
#[inline(always)]
fn number<const BIG: bool>(bytes: &[u8], scalar: Scalar) -> f64 {
    macro_rules! at_start {
        ($t:ty) => {{
            let raw = bytes[..size_of::<$t>()].try_into().expect("the row holds the column");
            f64::from(if BIG { <$t>::from_be_bytes(raw) } else { <$t>::from_le_bytes(raw) })
        }};
    }
    match scalar {
        Scalar::F32 => at_start!(f32),
        Scalar::F64 => at_start!(f64),
        Scalar::I8 => at_start!(i8),
        Scalar::U8 => at_start!(u8),
        Scalar::I16 => at_start!(i16),
        Scalar::U16 => at_start!(u16),
        Scalar::I32 => at_start!(i32),
        Scalar::U32 => at_start!(u32),
    }
}

fn each_line(
    source: &mut Source<'_>,
    element: &Element,
    wanted: &[usize],
    row: &mut impl FnMut(&[f64]),
) -> Result<(), SceneError> {
    let mut all = Vec::new();
    let mut values = vec![0.0; wanted.len()];
    for done in 0..element.count {
        let place = format!("PLY element `{}`, row {done}", element.name);
        let line = source.text_row(&place)?;
        all.clear();
        for word in line.split_ascii_whitespace() {
            match word.parse::<f64>() {
                Ok(value) => all.push(value),
                Err(_) => {
                    let what = format!("{:?} is not a number", super::super::input::clip(word));
                    return Err(SceneError::malformed(place, what, DAMAGED));
                }
            }
        }
        if all.len() != element.properties.len() {
            let what = format!("{} values for {} columns", all.len(), element.properties.len());
            return Err(SceneError::malformed(place, what, DAMAGED));
        }
        values.iter_mut().zip(wanted).for_each(|(value, &w)| *value = all[w]);
        row(&values);
    }
    Ok(())
}

/// Reads past an element that is not wanted.
pub(super) fn skip(
    source: &mut Source<'_>,
    encoding: Encoding,
    element: &Element,
) -> Result<(), SceneError> {
    element.check_fits(encoding, source.left)?;
    let place = format!("PLY element `{}`", element.name);
    if encoding == Encoding::Ascii {
        return (0..element.count).try_for_each(|_| source.text_row(&place).map(drop));
    }
    if !element.has_lists() {
        return source.skip(element.count * element.least_row_bytes(), &place);
    }
    for _ in 0..element.count {
        for property in &element.properties {
            let Some(length) = property.list_length else {
                source.skip(property.scalar.bytes() as u64, &place)?;
                continue;
            };
            let mut raw = [0; 8];
            source.read_exact(&mut raw[..length.bytes()], &place)?;
            let n = match encoding {
                Encoding::Big => number::<true>(&raw, length),
                Encoding::Little | Encoding::Ascii => number::<false>(&raw, length),
            };
            source.skip((n * property.scalar.bytes() as f64) as u64, &place)?;
        }
    }
    Ok(())
}

impl Source<'_> {
    fn read_exact(&mut self, bytes: &mut [u8], place: &str) -> Result<(), SceneError> {
        self.reader.read_exact(bytes).map_err(|e| SceneError::reading(place, e))?;
        self.left = self.left.saturating_sub(bytes.len() as u64);
        Ok(())
    }

    fn skip(&mut self, n: u64, place: &str) -> Result<(), SceneError> {
        let skipped = std::io::copy(&mut self.reader.by_ref().take(n), &mut std::io::sink());
        let skipped = skipped.map_err(|e| SceneError::reading(place, e))?;
        self.left = self.left.saturating_sub(skipped);
        if skipped < n {
            return Err(SceneError::truncated(place, format!("{} bytes are missing", n - skipped)));
        }
        Ok(())
    }

    /// The next line that is not blank.
    fn text_row(&mut self, place: &str) -> Result<String, SceneError> {
        loop {
            let line = self.line(MAX_LINE, place)?;
            match String::from_utf8(line) {
                Ok(line) if line.trim_ascii().is_empty() => {}
                Ok(line) => return Ok(line),
                Err(_) => return Err(SceneError::malformed(place, "not text", DAMAGED)),
            }
        }
    }
}
