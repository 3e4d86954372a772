//! Niantic SPZ, versions 1 to 4: attributes one after the other, quantised to bytes.
//!
//! Versions 1 to 3 are one gzip stream; version 4 has a plain header, optional extension records, a
//! table of contents and one zstd stream per attribute. The order is positions, opacities, colours,
//! scales, rotations, SH. Stored axes are right-up-back unless an extension says otherwise; they
//! are turned to those of PLY (right-down-front).
//! Source: the format's own README, github.com/nianticlabs/spz.

mod attributes;
mod axes;
mod write;

use std::io::{BufRead, Read};

use flate2::bufread::GzDecoder;

use super::error::{DAMAGED, REEXPORT, SceneError};
use super::foreign;
use super::input::{Input, check_count, plausible};
use super::read::{Format, Model};
use super::{Gaussians, StoredAxes, Warning};
use attributes::{Attribute, decode};
pub(super) use write::write;

const MAGIC: &[u8; 4] = b"NGSP";
/// Bytes of the header of versions 1 to 3, with which that of version 4 begins.
const SHORT_HEADER: usize = 16;
const LONG_HEADER: usize = 32;
/// Bytes of an entry of the table of contents: compressed and plain size.
const ENTRY: usize = 16;
const FLAG_ANTIALIASED: u8 = 1;
const FLAG_EXTENSIONS: u8 = 2;
/// Most bytes of extension records; known ones take 20.
const MAX_EXTENSIONS: u64 = 1 << 20;

/// What the header says.
struct Header {
    version: u8,
    count: usize,
    degree: u8,
    fractional_bits: u8,
    flags: u8,
    /// Version 4: number of streams.
    n_streams: usize,
}

/// Reads any version; `input` is gzip or starts with `NGSP`. `axes` are those of its numbers,
/// instead of what it says of them.
pub(super) fn read(input: Input<'_>, axes: Option<StoredAxes>) -> Result<Model, SceneError> {
    let SpzFile { header, mut gaussians, extensions } = unpack(input)?;
    let stated: &[u8] = if header.flags & FLAG_EXTENSIONS != 0 { &extensions[..] } else { &[] };
    let stated = axes::stated(stated)?;
    axes.unwrap_or(stated).turn(&mut gaussians);
    let mut warnings = Vec::new();
    if header.degree > 3 {
        warnings.push(Warning::ShReduced { from: header.degree });
    }
    gaussians.antialiased = header.flags & FLAG_ANTIALIASED != 0;
    Ok(Model { gaussians, format: Format::Spz(header.version), warnings })
}

/// A file with its numbers decoded, in the axes that it stores.
struct SpzFile {
    header: Header,
    gaussians: Gaussians,
    /// Records of extensions.
    extensions: Vec<u8>,
}

fn unpack(mut input: Input<'_>) -> Result<SpzFile, SceneError> {
    let start = input.reader.fill_buf().map_err(|e| SceneError::reading("SPZ header", e))?;
    if start.starts_with(&[0x1f, 0x8b]) {
        return read_stream(&mut GzDecoder::new(input.reader), input.len);
    }
    let mut bytes = Vec::with_capacity(SHORT_HEADER);
    let head = input.reader.by_ref().take(SHORT_HEADER as u64).read_to_end(&mut bytes);
    head.map_err(|e| SceneError::reading("SPZ header", e))?;
    if bytes.get(4..8).is_some_and(|v| v == [4, 0, 0, 0]) {
        bytes.reserve(input.len.saturating_sub(SHORT_HEADER as u64) as usize);
        let rest = input.reader.read_to_end(&mut bytes);
        rest.map_err(|e| SceneError::reading("SPZ streams", e))?;
        return read_v4(&bytes);
    }
    read_stream(&mut bytes.as_slice().chain(input.reader), input.len)
}

fn header(bytes: &[u8], file_len: u64) -> Result<Header, SceneError> {
    let bad = |what: String, todo| Err(SceneError::malformed("SPZ header", what, todo));
    if bytes.len() < SHORT_HEADER {
        return Err(SceneError::truncated("SPZ header", format!("{} bytes", bytes.len())));
    }
    if &bytes[..4] != MAGIC {
        return Err(foreign::unpacked(bytes).unwrap_or_else(|| {
            let todo = "give an SPZ file, not another gzip file";
            SceneError::malformed("SPZ header", "no magic NGSP", todo)
        }));
    }
    let version = u32_at(bytes, 4);
    let (count, degree, fractional_bits) = (u32_at(bytes, 8), bytes[12], bytes[13]);
    if !(1..=4).contains(&version) {
        return bad(format!("version {version}; 1 to 4 are known"), REEXPORT);
    }
    if degree > 4 {
        return bad(format!("SH degree {degree}; 0 to 4 are known"), DAMAGED);
    }
    if fractional_bits > 30 {
        return bad(format!("{fractional_bits} fractional bits; at most 30 make sense"), DAMAGED);
    }
    let count = check_count("SPZ header", count.into(), plausible(file_len))?;
    let (flags, n_streams) = (bytes[14], bytes[15] as usize);
    Ok(Header { version: version as u8, count, degree, fractional_bits, flags, n_streams })
}

/// Versions 1 to 3, unpacked.
fn read_stream(stream: &mut impl Read, file_len: u64) -> Result<SpzFile, SceneError> {
    let mut head = Vec::new();
    let read = stream.take(SHORT_HEADER as u64).read_to_end(&mut head);
    read.map_err(|e| SceneError::reading("SPZ header", e))?;
    let header = header(&head, file_len)?;
    if header.version == 4 {
        let what = "version 4 inside gzip";
        return Err(SceneError::malformed("SPZ header", what, DAMAGED));
    }
    let mut scene = Gaussians::with_capacity(header.count, header.degree.min(3));
    for attribute in Attribute::ALL {
        let need = attribute.bytes(header.version, header.degree) * header.count;
        let mut bytes = Vec::with_capacity(need);
        let read = stream.take(need as u64).read_to_end(&mut bytes);
        read.map_err(|e| SceneError::reading(attribute.place(), e))?;
        if bytes.len() < need {
            let what = format!("{} of {need} bytes", bytes.len());
            return Err(SceneError::truncated(attribute.place(), what));
        }
        decode(attribute, &header, &bytes, &mut scene);
    }
    // To the end, so that the checksum of the gzip stream is verified.
    let mut tail = Vec::new();
    let read = stream.take(MAX_EXTENSIONS + 1).read_to_end(&mut tail);
    read.map_err(|e| SceneError::reading("SPZ extensions", e))?;
    if tail.len() as u64 > MAX_EXTENSIONS {
        let what = format!("more than {MAX_EXTENSIONS} bytes after the attributes");
        return Err(SceneError::malformed("SPZ extensions", what, DAMAGED));
    }
    Ok(SpzFile { header, gaussians: scene, extensions: tail })
}

/// Version 4, whole.
fn read_v4(bytes: &[u8]) -> Result<SpzFile, SceneError> {
    let header = header(bytes, bytes.len() as u64)?;
    if bytes.len() < LONG_HEADER {
        return Err(SceneError::truncated("SPZ header", format!("{} of 32 bytes", bytes.len())));
    }
    let toc = u32_at(bytes, 16) as usize;
    let attributes: Vec<_> =
        Attribute::ALL.into_iter().filter(|a| a.bytes(header.version, header.degree) > 0).collect();
    if header.n_streams != attributes.len() {
        let what = format!("{} streams instead of {}", header.n_streams, attributes.len());
        return Err(SceneError::malformed("SPZ header", what, DAMAGED));
    }
    let extensions = bytes.get(LONG_HEADER..toc);
    let entries = toc.checked_add(ENTRY * attributes.len()).and_then(|end| bytes.get(toc..end));
    let (Some(extensions), Some(entries)) = (extensions, entries) else {
        let what = format!("it should be at byte {toc} of {}", bytes.len());
        return Err(SceneError::truncated("SPZ table of contents", what));
    };
    let mut left = &bytes[toc + entries.len()..];
    let mut scene = Gaussians::with_capacity(header.count, header.degree.min(3));
    for (attribute, entry) in attributes.into_iter().zip(entries.chunks_exact(ENTRY)) {
        let plain = inflate(attribute, &header, entry, &mut left)?;
        decode(attribute, &header, &plain, &mut scene);
    }
    Ok(SpzFile { header, gaussians: scene, extensions: extensions.to_vec() })
}

/// The bytes of an attribute, from the front of `left`.
fn inflate(
    attribute: Attribute,
    header: &Header,
    entry: &[u8],
    left: &mut &[u8],
) -> Result<Vec<u8>, SceneError> {
    let place = attribute.place();
    let (packed, plain) = (u64_at(entry, 0), u64_at(entry, 8));
    let need = attribute.bytes(header.version, header.degree) * header.count;
    if plain != need as u64 {
        let what = format!("{plain} bytes instead of {need}");
        return Err(SceneError::malformed(place, what, DAMAGED));
    }
    if packed > left.len() as u64 {
        let what = format!("{} of {packed} compressed bytes", left.len());
        return Err(SceneError::truncated(place, what));
    }
    let (stream, rest) = left.split_at(packed as usize);
    *left = rest;
    let bytes = zstd::bulk::decompress(stream, need)
        .map_err(|e| SceneError::malformed(place, e.to_string(), DAMAGED))?;
    if bytes.len() != need {
        let what = format!("{} bytes instead of {need}", bytes.len());
        return Err(SceneError::malformed(place, what, DAMAGED));
    }
    Ok(bytes)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}
