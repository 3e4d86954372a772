//! Photos as references: scaled, and without the bends of their lenses.
//!
//! A photo may be smaller or larger than its camera says, as long as it has its aspect: trainers
//! are fed photos that were made smaller. A view never has more pixels than its photo.

use powergs_base::picture::Picture;
use powergs_scene::Camera;
use powergs_scene::camera::edit::stretched;
use powergs_scene::camera::lens::{LEAST_SHARE, Lens, without_lens};
use rayon::prelude::*;

use super::references::Reference;

/// How far a size may be off the aspect of its camera, pixels: both sides are rounded.
const ROUNDING: f64 = 1.0;

/// A photo that is no reference for its camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PhotoError {
    /// The photo has another aspect than its camera.
    #[error(
        "is {}x{}, its camera is {}x{}: another aspect{}; give the photos that the poses were made \
         for, whole", photo.0, photo.1, camera.0, camera.1,
        if *is_turned { " (turned? Pixels are taken as the file holds them)" } else { "" }
    )]
    Aspect {
        /// Width and height of the photo, pixels.
        photo: (u32, u32),
        /// Those of its camera.
        camera: (u32, u32),
        /// Whether the photo would fit if it were turned by a right angle.
        is_turned: bool,
    },
    /// The wanted size is larger than the photo, or of another aspect.
    #[error(
        "the view is at most {}x{}, {}x{} is wanted; give a smaller size of its aspect, for this \
         height {fitting}x{}", most.0, most.1, wanted.0, wanted.1, wanted.1
    )]
    Size {
        /// The most that the photo shows, pixels.
        most: (u32, u32),
        /// What is wanted.
        wanted: (u32, u32),
        /// The width that fits the wanted height.
        fitting: u32,
    },
    /// Hardly anything is left without the lens.
    #[error(
        "its lens leaves less than {:.0} % of the width and height of a pinhole view: the \
         coefficients of its camera cannot be right; undistort the photos with the program that \
         made the poses, and give its new cameras",
        100.0 * LEAST_SHARE
    )]
    Lens,
}

/// A photo and the view that it is the reference of.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Its width and height, pixels.
    pub size: (u32, u32),
    /// The pinhole camera and the lens that it was taken with.
    lens: Option<(Camera, Lens)>,
    /// What it shows, pinhole: as many pixels as it has there.
    whole: Camera,
    /// The view that models are compared in.
    pub view: Camera,
}

impl Photo {
    /// A photo of `size` that was taken with `camera` through `lens`. The view has the `wanted`
    /// width and height; without one it has those of the camera, or of the photo if that is
    /// smaller.
    ///
    /// # Errors
    /// [`PhotoError`]: another aspect, a view larger than the photo, a lens that cannot be.
    pub fn new(
        size: (u32, u32),
        camera: &Camera,
        lens: Option<&Lens>,
        wanted: Option<(u32, u32)>,
    ) -> Result<Photo, PhotoError> {
        let told = (camera.width, camera.height);
        if !fits(size, told) {
            let is_turned = fits((size.1, size.0), told);
            return Err(PhotoError::Aspect { photo: size, camera: told, is_turned });
        }
        let taken = stretched(camera, size.0, size.1);
        let shown = |camera: &Camera| match lens {
            Some(lens) => without_lens(camera, lens).ok_or(PhotoError::Lens),
            None => Ok(camera.clone()),
        };
        let whole = shown(&taken)?;
        let most = (whole.width, whole.height);
        let view = match wanted {
            Some(wanted) => {
                let is_larger = wanted.0 > most.0 || wanted.1 > most.1;
                if is_larger || !fits(wanted, most) {
                    let fitting = f64::from(most.0) * f64::from(wanted.1) / f64::from(most.1);
                    let fitting = fitting.round() as u32;
                    return Err(PhotoError::Size { most, wanted, fitting });
                }
                stretched(&whole, wanted.0, wanted.1)
            }
            None if size.0 <= camera.width => whole.clone(),
            None => {
                let size = shown(camera)?;
                stretched(&whole, size.width, size.height)
            }
        };
        let lens = lens.map(|lens| (taken, *lens));
        Ok(Photo { size, lens, whole, view })
    }

    /// The same photo for a view in the size of `camera`, which shows the same: of its height where
    /// it has another aspect, and never larger than the photo.
    pub fn in_size_of(&self, camera: &Camera) -> Photo {
        let most = (self.whole.width, self.whole.height);
        let wanted = (camera.width, camera.height);
        let is_larger = wanted.0 > most.0 || wanted.1 > most.1;
        let (width, height) = match !is_larger && fits(wanted, most) {
            true => wanted,
            false => {
                let share = (f64::from(wanted.1) / f64::from(most.1)).min(1.0);
                let side = |pixels: u32| ((share * f64::from(pixels)).round() as u32).max(1);
                (side(most.0), side(most.1))
            }
        };
        Photo { view: stretched(&self.whole, width, height), ..self.clone() }
    }

    /// The reference image of the view. `photo` has the size that was given.
    pub fn reference(&self, photo: &Picture) -> Reference {
        debug_assert_eq!((photo.width, photo.height), self.size);
        match &self.lens {
            Some((taken, lens)) => self.scaled(&straightened(photo, taken, lens, &self.whole)),
            None => self.scaled(photo),
        }
    }

    fn scaled(&self, photo: &Picture) -> Reference {
        let size = (self.view.width, self.view.height);
        if (photo.width, photo.height) == size {
            return Reference::new(photo);
        }
        Reference::new(&averaged(photo, size.0, size.1))
    }
}

/// Whether a size is another, made smaller or larger and rounded.
fn fits(a: (u32, u32), b: (u32, u32)) -> bool {
    let (a, b) = ([a.0, a.1].map(f64::from), [b.0, b.1].map(f64::from));
    // The smaller one was rounded.
    let (small, large) = if a[0] <= b[0] { (a, b) } else { (b, a) };
    let off = |i: usize, j: usize| (small[i] - large[i] * small[j] / large[j]).abs();
    off(0, 1) <= ROUNDING || off(1, 0) <= ROUNDING
}

/// What the pinhole camera `view` sees of a photo that was taken with `taken` through `lens`.
/// Between pixels a cubic is taken (Catmull-Rom), which keeps what is sharp.
fn straightened(photo: &Picture, taken: &Camera, lens: &Lens, view: &Camera) -> Picture {
    let (width, height) = (view.width, view.height);
    let at = |x: u32, y: u32| {
        let ray =
            [(f64::from(x) + 0.5 - view.cx) / view.fx, (f64::from(y) + 0.5 - view.cy) / view.fy];
        let [x, y] = lens.bent(ray);
        cubic(photo, x * taken.fx + taken.cx - 0.5, y * taken.fy + taken.cy - 0.5)
    };
    let row = |y: u32| (0..width).map(move |x| at(x, y));
    let pixels = (0..height).into_par_iter().flat_map_iter(row).collect();
    Picture { width, height, pixels }
}

/// The value between pixels, in 0..1 and no brighter or darker than any picture can be; pixels
/// beyond the border are those at it.
fn cubic(photo: &Picture, x: f64, y: f64) -> [f32; 3] {
    let last = |side: u32| i64::from(side) - 1;
    let pixel = |i: i64, j: i64| {
        let (i, j) = (i.clamp(0, last(photo.width)), j.clamp(0, last(photo.height)));
        photo.pixels[j as usize * photo.width as usize + i as usize]
    };
    let (columns, rows) = (shares(x - x.floor()), shares(y - y.floor()));
    let (left, top) = (x.floor() as i64 - 1, y.floor() as i64 - 1);
    let mut sum = [0.0; 3];
    for (j, row) in (top..).zip(rows) {
        for (i, column) in (left..).zip(columns) {
            let value = pixel(i, j);
            for (s, v) in sum.iter_mut().zip(value) {
                *s += row * column * v;
            }
        }
    }
    sum.map(|v: f32| v.clamp(0.0, 1.0))
}

/// The shares of four pixels in a value that lies `t` behind the second.
fn shares(t: f64) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        -0.5 * t + t2 - 0.5 * t3,
        1.0 - 2.5 * t2 + 1.5 * t3,
        0.5 * t + 2.0 * t2 - 1.5 * t3,
        -0.5 * t2 + 0.5 * t3,
    ]
    .map(|v| v as f32)
}

/// A smaller picture: every pixel is the mean over the area that it covers.
pub fn averaged(picture: &Picture, width: u32, height: u32) -> Picture {
    let columns = weights(picture.width, width);
    let rows = weights(picture.height, height);
    let stride = picture.width as usize;
    // One side after the other, which takes far fewer products than an area for each pixel.
    let mut narrow = Vec::with_capacity(width as usize * picture.height as usize);
    for line in picture.pixels.chunks_exact(stride.max(1)) {
        narrow.extend(columns.iter().map(|(first, w)| mean(w, |i| line[first + i])));
    }
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for (first, w) in &rows {
        for x in 0..width as usize {
            pixels.push(mean(w, |i| narrow[(first + i) * width as usize + x]));
        }
    }
    Picture { width, height, pixels }
}

fn mean(weights: &[f32], at: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (i, weight) in weights.iter().enumerate() {
        for (s, v) in sum.iter_mut().zip(at(i)) {
            *s += weight * v;
        }
    }
    sum
}

/// For each new pixel along a side: the first old one that it covers, and the share of each.
fn weights(old: u32, new: u32) -> Vec<(usize, Vec<f32>)> {
    let step = f64::from(old) / f64::from(new);
    (0..new)
        .map(|i| {
            let (from, to) = (f64::from(i) * step, f64::from(i + 1) * step);
            let first = from.floor() as u32;
            let last = (to.ceil() as u32).min(old).max(first + 1);
            let covered = |k: u32| (to.min(f64::from(k + 1)) - from.max(f64::from(k))).max(0.0);
            let shares: Vec<f64> = (first..last).map(covered).collect();
            let total: f64 = shares.iter().sum();
            (first as usize, shares.iter().map(|s| (s / total) as f32).collect())
        })
        .collect()
}
