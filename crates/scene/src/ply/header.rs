//! The text header of a PLY file.

use std::io::{BufRead, Read};

use super::super::error::{DAMAGED, REEXPORT, SceneError};
use super::super::input::clip;
use super::Source;

/// Longest line and most lines of a header; real ones have 70 lines of 30 bytes.
const MAX_LINE: u64 = 4096;
const MAX_LINES: usize = 4096;

/// How rows are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Size in bytes.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A column. A list has the type of its length too.
#[derive(Debug, Clone)]
pub(super) struct Property {
    pub name: String,
    pub list_length: Option<Scalar>,
    pub scalar: Scalar,
}

/// A table.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The column called `name`.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }

    /// Whether a row's size depends on its content.
    pub(crate) fn has_lists(&self) -> bool {
        self.properties.iter().any(|p| p.list_length.is_some())
    }

    /// Bytes of a binary row whose lists are all empty.
    pub(crate) fn least_row_bytes(&self) -> u64 {
        self.properties.iter().map(|p| p.list_length.unwrap_or(p.scalar).bytes() as u64).sum()
    }
}

/// How a comment says that a model is to be shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum PlyMode {
    #[default]
    Plain,
    /// Mip-Splatting.
    Antialiased,
    /// 2D Gaussian Splatting.
    Flat,
}

impl PlyMode {
    /// Brush writes `SplatRenderMode: mip`, and so do the converters; Postshot `antialiased 1`.
    fn parse(comment: &[&str]) -> Option<Self> {
        let words: Vec<String> = comment.iter().map(|word| word.to_ascii_lowercase()).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match words.as_slice() {
            ["splatrendermode:", "mip"] | ["antialiased", "1"] => Some(Self::Antialiased),
            ["splatrendermode:", "2dgs"] => Some(Self::Flat),
            ["splatrendermode:", _] | ["antialiased", "0"] => Some(Self::Plain),
            _ => None,
        }
    }
}

/// The comment that [`PlyMode::parse`] takes for an anti-aliased model.
pub(super) const ANTIALIASED: &str = "comment SplatRenderMode: mip";

/// The whole header.
#[derive(Debug, Clone)]
pub(super) struct PlyHeader {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// What the last comment says that says it.
    pub mode: PlyMode,
}

/// Reads up to and including the `end_header` line.
pub(super) fn read(source: &mut Source<'_>) -> Result<PlyHeader, SceneError> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut mode = PlyMode::default();
    for number in 1..=MAX_LINES {
        let line = header_line(source, number)?;
        let wrong = |what: String| {
            Err(SceneError::malformed(format!("PLY header line {number}"), what, DAMAGED))
        };
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["comment", comment @ ..] => mode = PlyMode::parse(comment).unwrap_or(mode),
            [] | ["ply"] | ["obj_info", ..] => {}
            ["format", name, "1.0"] => match parse_encoding(name) {
                Some(known) => encoding = Some(known),
                None => return wrong(format!("unknown format {:?}", clip(name))),
            },
            ["element", name, count] => match count.parse() {
                Ok(count) => {
                    elements.push(Element { name: clip(name), count, properties: Vec::new() });
                }
                Err(_) => return wrong(format!("{:?} is not a count", clip(count))),
            },
            ["property", rest @ ..] => match (parse_property(rest), elements.last_mut()) {
                (Some(property), Some(element)) => element.properties.push(property),
                _ => return wrong(format!("{:?} is not a property of an element", clip(&line))),
            },
            ["end_header"] => return finish(encoding, elements, mode),
            _ => return wrong(format!("{:?} is not understood", clip(&line))),
        }
    }
    let what = format!("no end_header within {MAX_LINES} lines");
    Err(SceneError::malformed("PLY header", what, DAMAGED))
}

fn finish(
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    mode: PlyMode,
) -> Result<PlyHeader, SceneError> {
    match encoding {
        Some(encoding) => Ok(PlyHeader { encoding, elements, mode }),
        None => Err(SceneError::malformed("PLY header", "no format line", DAMAGED)),
    }
}

fn parse_encoding(name: &str) -> Option<Encoding> {
    match name {
        "ascii" => Some(Encoding::Ascii),
        "binary_little_endian" => Some(Encoding::Little),
        "binary_big_endian" => Some(Encoding::Big),
        _ => None,
    }
}

fn parse_property(words: &[&str]) -> Option<Property> {
    let (length, scalar, name) = match words {
        ["list", length, scalar, name] => (Some(Scalar::parse(length)?), scalar, name),
        [scalar, name] => (None, scalar, name),
        _ => return None,
    };
    let scalar = Scalar::parse(scalar)?;
    Some(Property { name: clip(name), list_length: length, scalar })
}

fn header_line(source: &mut Source<'_>, number: usize) -> Result<String, SceneError> {
    let place = format!("PLY header line {number}");
    let line = source.line(MAX_LINE, &place)?;
    match String::from_utf8(line) {
        Ok(line) => Ok(line),
        Err(_) => Err(SceneError::malformed(place, "not text", DAMAGED)),
    }
}

impl Source<'_> {
    /// The next line without its end. Lines above `limit` bytes and a missing end are errors.
    pub(super) fn line(&mut self, limit: u64, place: &str) -> Result<Vec<u8>, SceneError> {
        let mut line = Vec::new();
        let read = self.reader.by_ref().take(limit).read_until(b'\n', &mut line);
        let read = read.map_err(|e| SceneError::reading(place, e))? as u64;
        self.left = self.left.saturating_sub(read);
        match line.pop() {
            Some(b'\n') => {
                line.pop_if(|last| *last == b'\r');
                Ok(line)
            }
            Some(_) if read == limit => {
                let what = format!("a line of more than {limit} bytes");
                Err(SceneError::malformed(place, what, REEXPORT))
            }
            _ => Err(SceneError::truncated(place, "the line does not end")),
        }
    }
}
