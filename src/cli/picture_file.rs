//! Pictures from PNG, JPEG and WebP files.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::background::Background;
use super::{Context, Exit, Failure, OrExit};
use powergs_base::picture::Picture;
use powergs_pixels::{DecodeError, Decoded, Limits};

/// A picture on a panel.
#[derive(Debug, clap::Args)]
pub struct PictureArgs {
    /// The picture: PNG, JPEG or WebP
    pub image: PathBuf,
    /// The panel: a name of `arch list`, or a TOML file
    #[arg(
        long,
        visible_alias = "display",
        value_name = "NAME|FILE",
        default_value = "oled-powergs"
    )]
    pub preset: String,
    /// What transparent pixels show: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
}

impl PictureArgs {
    /// See [`read`].
    ///
    /// # Errors
    /// As [`read`].
    pub fn read(&self, more: u64, context: &Context) -> Result<Picture, Failure> {
        read(&self.image, self.background, more, context)
    }
}

/// The longest side of a picture that is read, pixels.
const SIDE: u32 = 32_768;
/// Memory for a pixel while it is decoded and converted, bytes.
const PIXEL: u64 = 20;
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
        let what = format!("longer than {FILE_MAX} bytes: this is not a picture");
        return Err(io::Error::new(io::ErrorKind::InvalidData, what));
    }
    Ok(bytes)
}

/// Reads a picture; its format is told from its content. Transparent pixels show `background`.
/// What is done with it takes `more` bytes a pixel.
///
/// # Errors
/// Exit code 3: the file cannot be read, is no picture, broken, or too large.
pub fn read(
    path: &Path,
    background: Background,
    more: u64,
    context: &Context,
) -> Result<Picture, Failure> {
    let name = path.display();
    let file = File::open(path).or_exit(Exit::BadInput, &name)?;
    let bytes = read_all(file).or_exit(Exit::BadInput, &name)?;
    let limits = limits(&bytes, PIXEL + more, context).or_exit(Exit::BadInput, &name)?;
    let image = match powergs_pixels::decode(&bytes, limits) {
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

/// What may be decoded, after a look at the size of the picture; a file without one is left to the
/// decoder.
fn limits(bytes: &[u8], pixel: u64, context: &Context) -> Result<Limits, anyhow::Error> {
    if let Ok((width, height)) = powergs_pixels::size(bytes) {
        let needed = u64::from(width) * u64::from(height) * pixel;
        let over = context.global.memory.check(needed);
        over.map_err(|over| anyhow::anyhow!("a picture of {width}x{height} pixels {over}"))?;
    }
    Ok(Limits { side: SIDE, bytes: context.global.memory.0.0 })
}

/// Reads two pictures of one size.
///
/// # Errors
/// As [`read`]; exit code 3 if the sizes differ.
pub fn read_pair(
    first: &Path,
    second: &Path,
    background: Background,
    more: u64,
    context: &Context,
) -> Result<(Picture, Picture), Failure> {
    // The other picture is there as well.
    let more = more + PIXEL;
    let (a, b) =
        (read(first, background, more, context)?, read(second, background, more, context)?);
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
