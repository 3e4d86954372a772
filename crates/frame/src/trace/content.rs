//! Columns to bytes and back.

use rayon::prelude::*;

use super::block::{BlockHeader, HEADER};
use super::codec::{compress, decompress};
use super::column::{Column, Id};
use super::head::FrameHead;
use super::transform::Transform;
use super::{Fovea, Frame, PixelColumns, Preview};
use crate::fovea::Screen;
use crate::splat::Splat;

/// The content of a column.
pub(super) enum Content {
    Words(Vec<u32>),
    Bytes(Vec<u8>),
}

/// The content of a column of `frame`, if it has that column.
pub(super) fn content(frame: &Frame, id: Id) -> Option<Content> {
    let splats =
        |get: fn(&Splat) -> u32| Some(Content::Words(frame.splats.iter().map(get).collect()));
    let words = |column: &[u32]| Some(Content::Words(column.to_vec()));
    let fovea = frame.fovea.as_ref();
    match id {
        Id::Index => splats(|s| s.index),
        Id::Depth => splats(|s| s.depth.to_bits()),
        Id::MeanX => splats(|s| s.mean[0].to_bits()),
        Id::MeanY => splats(|s| s.mean[1].to_bits()),
        Id::CovA => splats(|s| s.cov[0].to_bits()),
        Id::CovB => splats(|s| s.cov[1].to_bits()),
        Id::CovD => splats(|s| s.cov[2].to_bits()),
        Id::Opacity => splats(|s| s.opacity.to_bits()),
        Id::StopRank => words(&frame.pixels.stop_rank),
        Id::Blended => words(&frame.pixels.blended),
        Id::HighestLevel => fovea.map(|f| Content::Bytes(f.highest_level.clone())),
        Id::StopRank2 => fovea.and_then(|f| words(&f.stop_rank_2)),
        Id::ExtraAlpha => fovea.and_then(|f| words(&f.extra_alpha)),
        Id::Blended2 => fovea.and_then(|f| words(&f.blended_2)),
        Id::Screen => fovea.map(|f| f.screen).filter(|s| *s != Screen::PUBLISHED).map(|s| {
            let numbers = [s.fov_deg, s.pooling_rate].map(f64::to_le_bytes);
            Content::Bytes(numbers.concat())
        }),
        Id::SurvivorBits => frame.survivor_bits.clone().map(Content::Bytes),
        Id::FrustumBits => frame.frustum_bits.clone().map(Content::Bytes),
        Id::Preview => frame.preview.as_ref().map(|p| {
            let sizes = [p.width.to_le_bytes(), p.height.to_le_bytes()];
            Content::Bytes([sizes.as_flattened(), &p.rgb].concat())
        }),
    }
}

pub(super) fn encode_column(id: Id, content: Content) -> Vec<u8> {
    let column = id.column();
    let raw = match content {
        Content::Words(words) => column.transform.apply(words),
        Content::Bytes(bytes) => column.transform.apply_bytes(bytes),
    };
    let raw_bytes = raw.len() as u64;
    let (codec, stored) = compress(raw, column.transform);
    let header = BlockHeader::of(column.tag, codec, column.transform, raw_bytes, &stored);
    let mut block = Vec::with_capacity(HEADER + stored.len());
    block.extend(header.to_bytes());
    block.extend(stored);
    block
}

/// `due`: bytes before compression, where the counts of the frame determine them.
pub(super) fn decode_column(
    column: &Column,
    due: Option<u64>,
    header: &BlockHeader,
    stored: &[u8],
) -> Result<Content, String> {
    if let Some(due) = due.filter(|&due| due != header.raw) {
        return Err(format!("{} bytes where {due} are due", header.raw));
    }
    let transform = Transform::from_code(header.transform)
        .filter(|t| if column.has_words() { t.suits_words() } else { t.suits_bytes() })
        .ok_or_else(|| format!("transform {} is not known here", header.transform))?;
    let bytes = decompress(header.codec, stored, header.raw)?;
    if column.has_words() {
        return Ok(Content::Words(transform.undo(&bytes)));
    }
    Ok(Content::Bytes(transform.undo_bytes(bytes)))
}

fn preview_of(bytes: &[u8]) -> Option<Preview> {
    let (width, rest) = bytes.split_first_chunk()?;
    let (height, rgb) = rest.split_first_chunk()?;
    let (width, height) = (u32::from_le_bytes(*width), u32::from_le_bytes(*height));
    Some(Preview { width, height, rgb: rgb.to_vec() })
}

fn screen_of(bytes: &[u8]) -> Option<Screen> {
    let (fov, rest) = bytes.split_first_chunk()?;
    let (rate, rest) = rest.split_first_chunk()?;
    let (fov_deg, pooling_rate) = (f64::from_le_bytes(*fov), f64::from_le_bytes(*rate));
    rest.is_empty().then_some(Screen { fov_deg, pooling_rate })
}

/// The frame of decoded columns, by [`Id`]. The caller has checked which columns are there.
pub(super) fn assemble(
    head: &FrameHead,
    contents: Vec<Option<Content>>,
) -> Result<Frame, &'static str> {
    let mut contents = TraceContents(contents);
    let splats = contents.splats();
    let pixels = PixelColumns {
        stop_rank: contents.words(Id::StopRank),
        blended: contents.words(Id::Blended),
    };
    let screen = match contents.bytes(Id::Screen) {
        Some(bytes) => screen_of(&bytes).ok_or("the screen is not 16 bytes long")?,
        None => Screen::PUBLISHED,
    };
    let fovea = head.gaze.map(|gaze| Fovea {
        gaze,
        screen,
        highest_level: contents.bytes(Id::HighestLevel).unwrap_or_default(),
        stop_rank_2: contents.words(Id::StopRank2),
        extra_alpha: contents.words(Id::ExtraAlpha),
        blended_2: contents.words(Id::Blended2),
    });
    let survivor_bits = contents.bytes(Id::SurvivorBits);
    let frustum_bits = contents.bytes(Id::FrustumBits);
    let preview = match contents.bytes(Id::Preview) {
        Some(bytes) => {
            let short = "the preview is shorter than its own header";
            Some(preview_of(&bytes).ok_or(short)?)
        }
        None => None,
    };
    let facts = head.facts.clone();
    Ok(Frame { facts, splats, survivor_bits, frustum_bits, pixels, fovea, preview })
}

/// Decoded columns by [`Id`]; taken once each.
struct TraceContents(Vec<Option<Content>>);

impl TraceContents {
    fn words(&mut self, id: Id) -> Vec<u32> {
        match self.0[id as usize].take() {
            Some(Content::Words(words)) => words,
            Some(Content::Bytes(_)) | None => Vec::new(),
        }
    }

    fn bytes(&mut self, id: Id) -> Option<Vec<u8>> {
        match self.0[id as usize].take() {
            Some(Content::Bytes(bytes)) => Some(bytes),
            Some(Content::Words(_)) | None => None,
        }
    }

    fn splats(&mut self) -> Vec<Splat> {
        let index = self.words(Id::Index);
        let [depth, x, y, a, b, d, opacity] =
            [Id::Depth, Id::MeanX, Id::MeanY, Id::CovA, Id::CovB, Id::CovD, Id::Opacity]
                .map(|id| self.words(id));
        let float = f32::from_bits;
        (0..index.len())
            .into_par_iter()
            .map(|i| Splat {
                index: index[i],
                depth: float(depth[i]),
                mean: [float(x[i]), float(y[i])],
                cov: [float(a[i]), float(b[i]), float(d[i])],
                opacity: float(opacity[i]),
            })
            .collect()
    }
}
