//! From SVG to PNG, and raster images below a drawing.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::{HEIGHT, WIDTH, ZOOM};
use powergs_pixels::RgbImage;

/// A raster image that lies below the drawing. Its pixels are those of the PNG: [`ZOOM`] per SVG
/// unit.
#[derive(Debug, Clone)]
pub struct Underlay {
    /// Left edge, SVG units, even.
    pub left: i32,
    /// Top edge, SVG units, even.
    pub top: i32,
    /// The image.
    pub image: RgbImage,
}

/// The PNG of `svg` over `underlay` over white.
pub(super) fn png(svg: &str, underlay: Option<&Underlay>) -> Result<Vec<u8>, String> {
    static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.load_font_data(dejavu::sans::bold().to_vec());
        Arc::new(fonts)
    });
    let options = Options { fontdb: Arc::clone(&FONTS), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|e| e.to_string())?;
    let zoomed = |length: i32| length as u32 * ZOOM.0 / ZOOM.1;
    let (width, height) = (zoomed(WIDTH), zoomed(HEIGHT));
    let mut page = Pixmap::new(width, height).ok_or("no page")?;
    page.data_mut().fill(255);
    if let Some(underlay) = underlay {
        let (left, top) = (zoomed(underlay.left), zoomed(underlay.top));
        let image = &underlay.image;
        for y in 0..image.height().min(height.saturating_sub(top)) {
            for x in 0..image.width().min(width.saturating_sub(left)) {
                let start = 4 * ((y + top) * width + x + left) as usize;
                page.data_mut()[start..start + 3].copy_from_slice(&image.pixel(x, y));
            }
        }
    }
    let zoom = ZOOM.0 as f32 / ZOOM.1 as f32;
    resvg::render(&tree, Transform::from_scale(zoom, zoom), &mut page.as_mut());
    // Every pixel is opaque, so colours are not premultiplied by anything.
    let rgb: Vec<u8> = page.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    encoded(&RgbImage::from_bytes(width, height, rgb).ok_or("no page")?)
}

fn encoded(image: &RgbImage) -> Result<Vec<u8>, String> {
    image.png().map_err(|e| e.to_string())
}

/// `svg` with a white page and the underlay in it, for viewers.
pub(super) fn with_background(svg: &str, underlay: Option<&Underlay>) -> Result<String, String> {
    let mut background = format!("<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n");
    if let Some(underlay) = underlay {
        let unzoomed = |n: u32| f64::from(n) * f64::from(ZOOM.1) / f64::from(ZOOM.0);
        background += &format!(
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{}\"/>\n",
            underlay.left,
            underlay.top,
            unzoomed(underlay.image.width()),
            unzoomed(underlay.image.height()),
            base64(&encoded(&underlay.image)?),
        );
    }
    let start = svg.find("<svg").ok_or("no svg element")?;
    let end = start + svg[start..].find('>').ok_or("no svg element")? + 1;
    Ok(format!("{}\n{background}{}", &svg[..end], svg[end..].trim_start_matches('\n')))
}

/// Base64 with padding (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let mut group = [0; 3];
        group[..chunk.len()].copy_from_slice(chunk);
        let bits = u32::from_be_bytes([0, group[0], group[1], group[2]]);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= chunk.len() { digit as char } else { '=' });
        }
    }
    text
}
