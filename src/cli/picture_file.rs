//! Pictures from PNG, JPEG and WebP files.

use std::path::Path;

use image::{DynamicImage, ImageReader, Limits};

use super::background::Background;
use super::{Exit, Failure, OrExit};
use powergs_base::picture::Picture;

/// The longest side of a picture, pixels.
const SIDE_MAX: u32 = 32_768;
/// Most memory that a decoder may ask for.
const DECODER_BYTES_MAX: u64 = 2 << 30;

/// Reads a picture; its format is told from its content. Transparent pixels show `background`.
///
/// # Errors
/// Exit code 2: the file cannot be opened. Exit code 3: it is no picture, broken, or too large.
pub fn read(path: &Path, background: Background) -> Result<Picture, Failure> {
    let name = path.display();
    let reader = ImageReader::open(path).or_exit(Exit::Usage, &name)?;
    let mut reader = reader.with_guessed_format().or_exit(Exit::BadInput, &name)?;
    if reader.format().is_none() {
        let what = format!("{name}: this is no PNG, JPEG or WebP picture");
        return Err(Failure::new(Exit::BadInput, what));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(SIDE_MAX);
    limits.max_image_height = Some(SIDE_MAX);
    limits.max_alloc = Some(DECODER_BYTES_MAX);
    reader.limits(limits);
    let what = format!("{name}: the picture cannot be decoded");
    let image = reader.decode().or_exit(Exit::BadInput, what)?;
    if image.width() == 0 || image.height() == 0 {
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
fn picture(image: &DynamicImage, Background(background): Background) -> Picture {
    let over = |rgba: [f32; 4]| {
        let a = rgba[3];
        std::array::from_fn(|c| {
            if a == 1.0 { rgba[c] } else { rgba[c] * a + background[c] * (1.0 - a) }
        })
    };
    let bytes = u32::from(image.color().bytes_per_pixel() / image.color().channel_count());
    let pixels = if bytes == 1 {
        let rgba = image.to_rgba8();
        rgba.pixels().map(|p| over(p.0.map(|v| f32::from(v) / 255.0))).collect()
    } else {
        let rgba = image.to_rgba16();
        rgba.pixels().map(|p| over(p.0.map(|v| f32::from(v) / 65535.0))).collect()
    };
    Picture { width: image.width(), height: image.height(), pixels }
}
