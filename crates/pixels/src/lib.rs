//! 8-bit images in memory, and picture files: PNG, JPEG and WebP are read, PNG and lossless
//! WebP are written.
//!
//! Pixels are what the file holds: no colour profile, gamma chunk or EXIF orientation is applied.

mod decode;
mod rgb;
mod webp;

pub use decode::{DecodeError, Decoded, Format, Limits, Samples, decode, size};
pub use rgb::{RgbImage, write_png};
pub use webp::{WEBP_SIDE, webp};
