//! PLY: INRIA's layout of raw parameters, and PlayCanvas' compressed one.
//!
//! The header decides which: a `chunk` element beside packed vertices is the compressed layout.

mod compressed;
mod header;
mod inria;
mod points;
mod rows;
mod write;

use std::io::BufRead;

use super::Warning;
use super::error::{DAMAGED, SceneError};
use super::input::Input;
use super::read::{Format, Model};
use header::{Element, Encoding, PlyHeader, PlyMode};

pub(super) use compressed::write as write_compressed;
pub(super) use points::read_points;
pub use write::write;

/// Bytes with their position, for bounds and messages.
struct Source<'a> {
    reader: Box<dyn BufRead + 'a>,
    /// Bytes not yet read, if the length was right.
    left: u64,
}

/// Reads either layout.
pub(super) fn read(input: Input<'_>) -> Result<Model, SceneError> {
    let mut source = Source { reader: input.reader, left: input.len };
    let header = header::read(&mut source)?;
    let (mut gaussians, format, mut warnings) = if header.elements.iter().any(|e| e.name == "chunk")
    {
        (compressed::read(&mut source, &header)?, Format::CompressedPly, Vec::new())
    } else {
        let (gaussians, warnings) = inria::read(&mut source, &header)?;
        (gaussians, Format::Ply, warnings)
    };
    // What the columns say weighs more than a comment.
    let is_flat = warnings.contains(&Warning::Flat);
    if header.mode == PlyMode::Flat && !is_flat {
        warnings.push(Warning::Flat);
    }
    gaussians.antialiased = header.mode == PlyMode::Antialiased && !is_flat;
    Ok(Model { gaussians, format, warnings })
}

impl PlyHeader {
    /// The element called `name`, after skipping those before it.
    fn advance(
        &self,
        source: &mut Source<'_>,
        next: &mut usize,
        name: &str,
    ) -> Result<&Element, SceneError> {
        while let Some(element) = self.elements.get(*next) {
            *next += 1;
            if element.name == name {
                return Ok(element);
            }
            rows::skip(source, self.encoding, element)?;
        }
        let names: Vec<_> = self.elements.iter().map(|e| e.name.as_str()).collect();
        let what = format!("no element `{name}` where it should be (there is {names:?})");
        Err(SceneError::malformed("PLY header", what, DAMAGED))
    }
}

impl Element {
    /// Refuses more rows than the rest of the file can hold, before anything is allocated.
    fn check_fits(&self, encoding: Encoding, left: u64) -> Result<(), SceneError> {
        let row = match encoding {
            // A value and its separator; the last line may lack its newline.
            Encoding::Ascii => 2 * self.properties.len().max(1) as u64,
            Encoding::Little | Encoding::Big => self.least_row_bytes(),
        };
        let slack = u64::from(encoding == Encoding::Ascii);
        match self.count.checked_mul(row) {
            Some(need) if need <= left + slack => Ok(()),
            _ => {
                let what = format!(
                    "the header promises {} rows of at least {row} bytes, and {left} bytes follow",
                    self.count
                );
                Err(SceneError::truncated(format!("PLY element `{}`", self.name), what))
            }
        }
    }
}
