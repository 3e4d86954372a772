//! Bytes that are no good trace: always an error, never a panic, no large allocation.

use std::io::Cursor;

use powergs_frame::trace::{Frame, Reader, TraceError, Writer, verify};
use powergs_testkit::traces::{SMALL, Shape, frame, read_all, seeds, written};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::seal::seal;

fn small() -> Vec<u8> {
    written(&[frame(1, SMALL), frame(2, Shape { foveated: false, ..SMALL })])
}

/// A block header as documented; the checksum is right.
pub fn block(tag: &[u8; 4], codec: u8, transform: u8, raw: u64, stored: &[u8]) -> Vec<u8> {
    let mut out = tag.to_vec();
    out.extend([1, codec, transform, 0]);
    out.extend(raw.to_le_bytes());
    out.extend((stored.len() as u64).to_le_bytes());
    out.extend(crc32fast::hash(stored).to_le_bytes());
    out.extend(crc32fast::hash(&out).to_le_bytes());
    out.extend(stored);
    out
}

/// The file with the header checksum of the block at `at` made right again.
fn reseal(bytes: &mut [u8], at: usize) {
    let crc = crc32fast::hash(&bytes[at..at + 28]);
    bytes[at + 28..at + 32].copy_from_slice(&crc.to_le_bytes());
}

fn find(bytes: &[u8], tag: &[u8; 4]) -> usize {
    bytes.windows(4).position(|w| w == tag).unwrap()
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = small();
    for n in 0..bytes.len() {
        let error = read_all(&bytes[..n]).expect_err("a truncated trace was read");
        match error {
            TraceError::NotATrace { .. } => assert_eq!(n, 0),
            TraceError::Incomplete { .. } => {}
            other => panic!("{n} bytes: {other}"),
        }
        match verify(&bytes[..n]) {
            Ok(report) => assert!(!report.is_good() && !report.complete, "{n} bytes: {report:?}"),
            Err(error) => assert!(n < 80, "{n} bytes: {error}"),
        }
    }
}

#[test]
fn recovered_frames_are_counted() {
    let bytes = small();
    let second = bytes.windows(4).rposition(|w| w == b"FRAM").unwrap();
    let foot = find(&bytes, b"FOOT");
    for (n, whole) in [(second - 1, 0), (second, 1), (foot - 1, 1), (foot, 2), (bytes.len() - 1, 2)]
    {
        let error = Reader::open(Cursor::new(&bytes[..n])).unwrap_err();
        assert!(
            matches!(error, TraceError::Incomplete { frames, .. } if frames == whole),
            "{n} bytes: {error}"
        );
        assert!(error.to_string().starts_with("INCOMPLETE"), "{error}");
        assert_eq!(verify(&bytes[..n]).unwrap().intact, whole);
    }
}

#[test]
fn every_flipped_bit_is_found() {
    let good = written(&[frame(1, Shape { points: 3, splats: 2, width: 2, height: 1, ..SMALL })]);
    assert!(read_all(&good).is_ok());
    (0..8 * good.len()).into_par_iter().for_each(|bit| {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(read_all(&bytes).is_err(), "bit {bit}: read");
        if let Ok(report) = verify(bytes.as_slice()) {
            assert!(!report.is_good(), "bit {bit}: verified");
            let place = report.damage[0].offset;
            assert!(place <= bit as u64 / 8, "bit {bit}: placed at {place}");
        }
    });
}

#[test]
fn verify_goes_on_after_damage() {
    let frames: Vec<Frame> = (0..4).map(|k| frame(k, SMALL)).collect();
    let good = written(&frames);
    let fram: Vec<usize> = (0..good.len()).filter(|&i| good[i..].starts_with(b"FRAM")).collect();
    // In the facts of frame 1: its columns cannot be told from other bytes, frame 2 is found.
    // In a block header of a column; in the content of a column.
    for at in
        [fram[1] + 8, fram[1] + 50, fram[2] - 1, find(&good[fram[1]..], b"SDEP") + fram[1] + 9]
    {
        let mut bytes = good.clone();
        bytes[at] ^= 4;
        let report = verify(bytes.as_slice()).unwrap();
        assert_eq!((report.intact, report.listed, report.complete), (3, Some(4), true), "{at}");
        let place = report.damage[0].offset;
        assert!(place <= at as u64 && place + 600 > at as u64, "byte {at}: {report:?}");
    }
    // Bytes that are missing in the middle cost at most the frame they are in and the next.
    let mut shorter = good.clone();
    shorter.drain(fram[1] + 400..fram[1] + 410);
    let report = verify(shorter.as_slice()).unwrap();
    assert!(!report.is_good() && report.intact >= 2, "{report:?}");
}

#[test]
fn damage_under_right_checksums_is_an_error_or_a_frame() {
    let good: Vec<Vec<u8>> = seeds().into_iter().map(|(_, _, bytes)| bytes).collect();
    let outcomes: Vec<bool> = (0..3000u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = Pcg64Mcg::seed_from_u64(seed);
            let mut bytes = good[seed as usize % good.len()].clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                match rng.random_range(0..4) {
                    0 => bytes[at] ^= 1 << rng.random_range(0..8),
                    1 => bytes[at] = [0, 1, 127, 128, 255][rng.random_range(0..5)],
                    2 => drop(bytes.remove(at)),
                    _ => bytes.insert(at, rng.random()),
                }
            }
            seal(&mut bytes);
            let _ = verify(bytes.as_slice());
            read_all(&bytes).is_ok()
        })
        .collect();
    assert!(outcomes.contains(&true) && outcomes.contains(&false), "both sides are reached");
}

#[test]
fn other_files() {
    for bytes in [&b""[..], b"ply\nformat ascii 1.0\n", b"\x89PNG\r\n\x1a\n", &[0; 4096]] {
        let error = read_all(bytes).unwrap_err();
        assert!(matches!(error, TraceError::NotATrace { .. }), "{error}");
    }
    let dos = small().into_iter().flat_map(|b| if b == b'\n' { vec![13, 10] } else { vec![b] });
    assert!(read_all(&dos.collect::<Vec<u8>>()).is_err());
}

#[test]
fn other_versions() {
    let versioned = |major: u16, minor: u16| {
        let mut bytes = small();
        bytes[8..10].copy_from_slice(&major.to_le_bytes());
        bytes[10..12].copy_from_slice(&minor.to_le_bytes());
        let crc = crc32fast::hash(&bytes[..12]);
        bytes[12..16].copy_from_slice(&crc.to_le_bytes());
        bytes
    };
    assert_eq!(read_all(&versioned(2, 9)).unwrap().len(), 2, "newer minor versions are read");
    let error = read_all(&versioned(3, 3)).unwrap_err().to_string();
    assert!(error.contains("version 3.3") && error.contains("up to 2.x"), "{error}");
}

/// The position of the SH degree of the first frame.
fn degree_at(bytes: &[u8]) -> usize {
    find(bytes, b"FRAM") + 32 + 221
}

#[test]
fn files_of_format_1_have_no_sh_degree() {
    let mut bytes = small();
    bytes[8] = 1;
    let mut at = 0;
    while let Some(next) = bytes[at..].windows(4).position(|w| w == b"FRAM") {
        at += next + 4;
        bytes[at - 4 + 32 + 221] = 0;
    }
    seal(&mut bytes);
    let mut reader = Reader::open(Cursor::new(&bytes)).unwrap();
    assert_eq!(reader.version(), (1, 2));
    for frame in [reader.frame(0).unwrap(), reader.frame(1).unwrap()] {
        assert_eq!(frame.facts.sh_degree, None);
        assert_eq!(frame.facts.colour_degree().get(), 3);
    }
    // Copied into a new file, the degree stays unknown.
    let mut writer = Writer::new(Vec::new(), reader.header()).unwrap();
    writer.write_encoded(reader.read_block(0).unwrap()).unwrap();
    let copy = writer.finish().unwrap();
    assert_eq!((copy[8], copy[degree_at(&copy)]), (2, 0));
    assert_eq!(read_all(&copy).unwrap()[0].facts.sh_degree, None);
}

#[test]
fn sh_degrees_up_to_three() {
    for (byte, degree) in [(0, None), (1, Some(0)), (2, Some(1)), (3, Some(2)), (4, Some(3))] {
        let mut bytes = small();
        let at = degree_at(&bytes);
        bytes[at] = byte;
        seal(&mut bytes);
        let frame = &read_all(&bytes).unwrap()[0];
        assert_eq!(frame.facts.sh_degree.map(|degree| degree.get()), degree);
    }
    for byte in [5, 255] {
        let mut bytes = small();
        let at = degree_at(&bytes);
        bytes[at] = byte;
        seal(&mut bytes);
        let error = read_all(&bytes).unwrap_err().to_string();
        assert!(error.contains(&format!("SH degree {}; 0 to 3", byte - 1)), "{error}");
    }
}

#[test]
fn unknown_blocks() {
    let good = small();
    let with = |tag: &[u8; 4]| {
        // Between the trace header and the first frame: later offsets move.
        let at = find(&good, b"FRAM");
        let extra = block(tag, 0, 9, 3, b"abc");
        let mut bytes = [&good[..at], &extra, &good[at..]].concat();
        let foot = find(&bytes, b"FOOT");
        for entry in [foot + 32, foot + 48] {
            let old = u64::from_le_bytes(bytes[entry..entry + 8].try_into().unwrap());
            let new = old + extra.len() as u64;
            bytes[entry..entry + 8].copy_from_slice(&new.to_le_bytes());
        }
        let crc = crc32fast::hash(&bytes[foot + 32..foot + 64]);
        bytes[foot + 24..foot + 28].copy_from_slice(&crc.to_le_bytes());
        reseal(&mut bytes, foot);
        let tail = bytes.len() - 16;
        bytes[tail..tail + 8].copy_from_slice(&(foot as u64).to_le_bytes());
        let crc = crc32fast::hash(&bytes[tail..tail + 8]);
        bytes[tail + 8..tail + 12].copy_from_slice(&crc.to_le_bytes());
        bytes
    };
    let optional = with(b"note");
    assert_eq!(read_all(&optional).unwrap().len(), 2);
    assert!(verify(optional.as_slice()).unwrap().is_good());
    let report = verify(with(b"NOTE").as_slice()).unwrap();
    assert!(report.damage[0].what.contains("`NOTE` is not known"), "{report:?}");
}

/// Bytes of a file in which the content of the first block `tag` is another one.
fn with_column(tag: &[u8; 4], replacement: &[u8]) -> Vec<u8> {
    let good = written(&[frame(1, SMALL)]);
    let at = find(&good, tag);
    let stored = u64::from_le_bytes(good[at + 16..at + 24].try_into().unwrap()) as usize;
    let mut bytes = [&good[..at], replacement, &good[at + 32 + stored..]].concat();
    // The facts say how long the columns are: field `bytes`, 8 bytes into the record.
    let fram = find(&bytes, b"FRAM");
    let old = u64::from_le_bytes(bytes[fram + 40..fram + 48].try_into().unwrap());
    let new = old + replacement.len() as u64 - 32 - stored as u64;
    bytes[fram + 40..fram + 48].copy_from_slice(&new.to_le_bytes());
    let record = u64::from_le_bytes(bytes[fram + 16..fram + 24].try_into().unwrap()) as usize;
    let crc = crc32fast::hash(&bytes[fram + 32..fram + 32 + record]);
    bytes[fram + 24..fram + 28].copy_from_slice(&crc.to_le_bytes());
    reseal(&mut bytes, fram);
    bytes
}

/// The first complaint of `verify` about a file with this block in place of `tag`.
#[track_caller]
fn check(tag: &[u8; 4], replacement: &[u8], expected: &str) {
    let report = verify(with_column(tag, replacement).as_slice()).unwrap();
    assert_eq!(report.intact, 0);
    assert!(report.damage[0].what.contains(expected), "{}", report.damage[0].what);
}

#[test]
fn absurd_promises() {
    // 20 stored bytes promise 4 GiB, and then as much as can be written.
    check(b"PSTP", &block(b"PSTP", 1, 0, 4 << 30, &[0; 20]), "promises 4294967296 bytes from 20");
    check(b"PSTP", &block(b"PSTP", 1, 0, u64::MAX, &[0; 20]), "promises");
    let mut endless = block(b"PSTP", 0, 0, u64::MAX, &[]);
    endless[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
    reseal(&mut endless, 0);
    check(b"PSTP", &endless, "is longer than its frame");
    // A real zip bomb: 9 MiB of zeros in one frame.
    let bomb = zstd::bulk::compress(&vec![0; 9 << 20], 1).unwrap();
    check(b"PSTP", &block(b"PSTP", 1, 0, 9 << 20, &bomb), "promises 9437184 bytes");
    check(b"PSTP", &block(b"PSTP", 1, 0, 60, &bomb), "cannot be decompressed");
    check(b"prev", &block(b"prev", 0, 0, 7, &[1; 7]), "preview is shorter");
    let wide = [&[255; 8][..], &[0; 30]].concat();
    check(b"prev", &block(b"prev", 0, 0, 38, &wide), "a side of the preview");
}

#[test]
fn contradictory_columns() {
    check(b"SDEP", &block(b"SDEP", 0, 0, 32, &[0; 32]), "`depth`: 32 bytes where 36 are due");
    check(b"SDEP", &block(b"SDEP", 7, 0, 36, &[0; 36]), "codec 7 is not known");
    check(b"SDEP", &block(b"SDEP", 0, 5, 36, &[0; 36]), "transform 5 is not known here");
    check(b"SDEP", &block(b"SDEP", 0, 6, 36, &[0; 36]), "transform 6 is not known here");
    check(b"FLEV", &block(b"FLEV", 0, 1, 9, &[0; 9]), "transform 1 is not known here");
    check(b"SDEP", &block(b"SIDX", 0, 0, 36, &[0; 36]), "`index` appears twice");
    check(b"SDEP", &block(b"sdep", 0, 0, 36, &[0; 36]), "`depth` is missing");
    check(b"SDEP", &block(b"XDEP", 0, 0, 36, &[0; 36]), "block `XDEP` is not known");
    check(b"SDEP", &[], "column blocks where 17 were promised");
    check(b"SDEP", &block(b"SDEP", 0, 0, 36, &[255; 36]), "NaN is not positive");
    check(b"SDEP", &block(b"SDEP", 0, 0, 36, &[0; 36]), "0 is not positive");
    // Splats need no column of their own where none is left out: an optional one may go.
    let report = verify(with_column(b"surv", &block(b"what", 0, 0, 0, &[])).as_slice()).unwrap();
    assert_eq!(report.intact, 1, "{report:?}");
}
