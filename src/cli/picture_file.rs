//! Pictures from PNG, JPEG and WebP files.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::background::Background;
use super::{Exit, Failure, OrExit};
use powergs_base::picture::Picture;
use powergs_pixels::{DecodeError, Decoded, Limits};

/// The largest picture that is read.
const LIMITS: Limits = Limits { side: 32_768, bytes: 2 << 30 };
/// The longest file that is read, bytes.
const FILE_MAX: u64 = 2 << 30;

/// The bytes of a picture file.
///
/// # Errors
/// The file cannot be read, or is longer than any picture.
pub fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    read_all(File::open(path)?)
}

fn read_all(file: File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(FILE_MAX + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > FILE_MAX {
        let what = format!("longer than {FILE_MAX} bytes: this is no picture");
        return Err(io::Error::new(io::ErrorKind::InvalidData, what));
    }
    Ok(bytes)
}

/// Reads a picture; its format is told from its content. Transparent pixels show `background`.
///
/// # Errors
/// Exit code 2: the file cannot be opened. Exit code 3: it is no picture, broken, or too large.
pub fn read(path: &Path, background: Background) -> Result<Picture, Failure> {
    let name = path.display();
    let file = File::open(path).or_exit(Exit::Usage, &name)?;
    let bytes = read_all(file).or_exit(Exit::BadInput, &name)?;
    let image = match powergs_pixels::decode(&bytes, LIMITS) {
        Err(e @ DecodeError::Unknown) => {
            return Err(Failure::new(Exit::BadInput, format!("{name}: {e}")));
        }
        image => image.or_exit(Exit::BadInput, format!("{name}: the picture cannot be decoded"))?,
    };
    if image.width == 0 || image.height == 0 {
        return Err(Failure::new(Exit::BadInput, format!("{name}: the picture has no pixels")));
    }
    Ok(picture(&image, background))
}

/// Reads two pictures of one size.
///
/// # Errors
/// As [`read`]; exit code 3 if the sizes differ.
pub fn read_pair(
    first: &Path,
    second: &Path,
    background: Background,
) -> Result<(Picture, Picture), Failure> {
    let (a, b) = (read(first, background)?, read(second, background)?);
    if (a.width, a.height) != (b.width, b.height) {
        let what = format!(
            "{} has {} x {} pixels, {} has {} x {}: only pictures of one size can be compared; \
             resize one of them",
            first.display(),
            a.width,
            a.height,
            second.display(),
            b.width,
            b.height
        );
        return Err(Failure::new(Exit::BadInput, what));
    }
    Ok((a, b))
}

/// Values from 0 to 1, at the depth that the file has.
fn picture(image: &Decoded, Background(background): Background) -> Picture {
    let over = |rgba: [f32; 4]| {
        let a = rgba[3];
        std::array::from_fn(|c| {
            if a == 1.0 { rgba[c] } else { rgba[c] * a + background[c] * (1.0 - a) }
        })
    };
    let pixels = image.rgba().map(over).collect();
    Picture { width: image.width, height: image.height, pixels }
}
