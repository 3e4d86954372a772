//! Scene files that promise far more than they hold.

use crate::scene_files::{self, Files, gzip, sample};

/// Bytes with the first `from` replaced.
fn replace(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect("it is there");
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

/// Files that promise far more than they hold.
pub fn bombs() -> Vec<(&'static str, Vec<u8>)> {
    let ply = |count: &str| {
        replace(&scene_files::ply(&sample(1, 0)), "vertex 1", &format!("vertex {count}"))
    };
    let mut spz = b"NGSP\x03\0\0\0".to_vec();
    spz.extend(10_000_000_u32.to_le_bytes());
    spz.extend([3, 12, 0, 0]);
    spz.resize(4 << 20, 0);
    let mut four = scene_files::spz(&sample(3, 0), 4, &[]);
    four[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut tail = scene_files::spz(&sample(3, 0), 3, &[]);
    tail = {
        let mut plain = Vec::new();
        std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&tail[..]), &mut plain)
            .unwrap();
        plain.resize(6 << 20, 0);
        gzip(&plain)
    };
    let mut files = scene_files::sog(&sample(3, 0), 2);
    files.insert("meta.json".into(), vec![b' '; 6 << 20]);
    let chunks =
        replace(&scene_files::compressed_ply(&sample(1, 0)), "chunk 1", "chunk 4000000000000");
    let text = replace(&scene_files::ascii_ply(&sample(1, 0)), "vertex 1", "vertex 16000000000");
    vec![
        ("rows by the terabyte", ply("16000000000")),
        ("rows beyond 64 bits", ply("99999999999999999999999")),
        ("rows whose bytes overflow", ply("18446744073709551615")),
        ("rows of text", text),
        ("chunks", chunks),
        ("zeros in gzip", gzip(&spz)),
        ("4 billion in spz 4", four),
        ("a long tail in gzip", tail),
        ("an inflating meta.json", scene_files::zipped(&files)),
        ("a huge image", scene_files::zipped(&planes(&huge_webp()))),
        ("a huge canvas", scene_files::zipped(&planes(&huge_canvas()))),
    ]
}

/// A lossless WebP that claims 16383 x 16383 pixels.
pub fn huge_webp() -> Vec<u8> {
    let mut bytes = scene_files::sog(&sample(3, 0), 2)["means_l.webp"].clone();
    let at = bytes.windows(4).position(|w| w == b"VP8L").unwrap() + 9;
    bytes[at..at + 4].copy_from_slice(&(0x3ffe_u32 | 0x3ffe << 14 | 1 << 28).to_le_bytes());
    bytes
}

/// An extended WebP with a canvas of 100000 x 100000 pixels.
fn huge_canvas() -> Vec<u8> {
    let small = scene_files::sog(&sample(3, 0), 2)["means_l.webp"].clone();
    let side = &99_999_u32.to_le_bytes()[..3];
    let canvas = [b"VP8X\x0a\0\0\0\x10\0\0\0", side, side].concat();
    let length = (small.len() - 8 + canvas.len()) as u32;
    [b"RIFF", &length.to_le_bytes()[..], b"WEBP", &canvas, &small[12..]].concat()
}

/// A SOG whose every image is `plane`.
pub fn planes(plane: &[u8]) -> Files {
    let mut files = scene_files::sog(&sample(3, 0), 2);
    for (name, bytes) in &mut files {
        if name.ends_with(".webp") {
            *bytes = plane.to_vec();
        }
    }
    files
}
