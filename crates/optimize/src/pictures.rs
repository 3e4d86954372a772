//! Pictures of a finished run: the first test view before and after, and as foveated models show
//! it.

use powergs_base::picture::Picture;
use powergs_frame::fovea::{GazeError, LEVELS, ScreenGaze};
use powergs_raster::regions::{self, TINTS};
use powergs_raster::{Detail, Options, render, render_foveated};
use powergs_scene::{Foveated, Gaussians};

use super::foveated::{Method, Viewer};
use super::setup::Setup;

/// Longer side of the pictures before and after, pixels.
const SIDE: u32 = 800;
/// Where somebody looks in the pictures of foveated models.
const GAZE: [f32; 2] = [0.5, 0.5];

/// A view of the dense and the final model, sRGB codes, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct BeforeAfter {
    /// The view.
    pub view: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// The dense model.
    pub dense: Vec<u8>,
    /// The final model.
    pub ours: Vec<u8>,
    /// What the final model is called.
    pub name: String,
}

impl BeforeAfter {
    /// The first test view; `name` is what the model is called.
    pub fn of(setup: &Setup<'_>, scene: &Gaussians, name: String) -> BeforeAfter {
        let camera = &setup.cameras[setup.split.test[0]];
        let options = Options { background: setup.background, ..Options::reference(Detail::Image) };
        let shown = |scene| {
            let picture = render(scene, camera, &options).picture;
            let is_large = picture.width.max(picture.height) > SIDE;
            if is_large { picture.shrunk(SIDE) } else { picture }
        };
        let (dense, ours) = (shown(setup.dense), shown(scene));
        BeforeAfter {
            view: camera.name.clone(),
            width: dense.width,
            height: dense.height,
            dense: dense.to_rgb8(),
            ours: ours.to_rgb8(),
            name,
        }
    }

    /// Mean of each channel of the dense model, codes of 8 bits.
    pub(crate) fn mean_dense(&self) -> [f64; 3] {
        let pixels = self.dense.as_chunks::<3>().0;
        let mean = |c: usize| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
        std::array::from_fn(|c| mean(c) / pixels.len().max(1) as f64)
    }

    /// Mean change of each channel, codes of 8 bits.
    pub fn mean_change(&self) -> [f64; 3] {
        let (dense, ours) = (self.dense.as_chunks::<3>().0, self.ours.as_chunks::<3>().0);
        let mut sum = [0.0; 3];
        for (a, b) in dense.iter().zip(ours) {
            for c in 0..3 {
                sum[c] += f64::from(b[c]) - f64::from(a[c]);
            }
        }
        sum.map(|s| s / dense.len().max(1) as f64)
    }
}

/// A view as foveated models show it, somebody looking at its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct Album {
    /// The view.
    pub view: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Where somebody looks, shares of width and height.
    pub gaze: [f64; 2],
    /// Pictures, first the reference.
    pub shots: Vec<Shot>,
    /// Our frame with tinted levels, sRGB codes, row-major.
    pub levels: Vec<u8>,
    /// The tints of R1 to R4.
    pub tints: [[u8; 3]; LEVELS],
    /// The share of the pixels in each region.
    pub shares: [f64; LEVELS],
    /// Mean change of red, green and blue against the dense model in each region, codes of 8 bits;
    /// `None` for regions that the view does not have.
    pub change: [Option<[f64; 3]>; LEVELS],
}

/// A picture of an album.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shot {
    /// What it shows.
    pub name: String,
    /// sRGB codes, row-major.
    pub rgb: Vec<u8>,
}

impl Album {
    /// The first test view: the reference, the pruned model of FR-Render without and with the
    /// colour filter, and ours. `is_own`: the references are renders of the dense model.
    pub(crate) fn of(
        viewer: &Viewer<'_>,
        ours: &Foveated,
        pruned: Option<&Foveated>,
        is_own: bool,
    ) -> Result<Album, GazeError> {
        let setup = viewer.setup;
        let view = setup.split.test[0];
        let camera = &setup.cameras[view];
        let looking = ScreenGaze { point: GAZE, screen: viewer.screens.of(camera) };
        let options = Options { background: setup.background, ..Options::reference(Detail::Image) };
        let shown = |model: &Foveated| -> Result<Picture, GazeError> {
            Ok(render_foveated(model, camera, &looking, &options)?.picture)
        };
        let mut reference = Picture::default();
        setup.references.write_to(view, &mut reference);
        let shot =
            |name: &str, picture: &Picture| Shot { name: name.into(), rgb: picture.to_rgb8() };
        let mut shots = vec![shot(if is_own { "dense (reference)" } else { "photo" }, &reference)];
        if let Some(pruned) = pruned {
            let picture = shown(pruned)?;
            shots.push(shot(Method::FrRender.name(), &picture));
            shots.push(shot(Method::RtgsD22.name(), &viewer.filtered(&picture, &looking)?));
        }
        let picture = shown(ours)?;
        shots.push(shot(Method::PowerGs.name(), &picture));
        let of_pixel = looking.eccentricity_map([camera.width, camera.height])?.regions();
        let pixels = of_pixel.len().max(1) as f64;
        let share = |i: usize| of_pixel.iter().filter(|r| usize::from(**r) == i).count() as f64;
        let dense = render(setup.dense, camera, &options).picture;
        Ok(Album {
            view: camera.name.clone(),
            width: camera.width,
            height: camera.height,
            gaze: GAZE.map(f64::from),
            shots,
            levels: regions::draw(&picture, &looking)?.to_rgb8(),
            tints: TINTS.map(|tint| tint.map(|v| (255.0 * v).round() as u8)),
            shares: std::array::from_fn(|i| share(i) / pixels),
            change: change(&dense, &picture, &of_pixel),
        })
    }
}

fn change(dense: &Picture, ours: &Picture, of_pixel: &[u8]) -> [Option<[f64; 3]>; LEVELS] {
    let mut sums = [([0.0; 3], 0u64); LEVELS];
    let (before, after) = (dense.to_rgb8(), ours.to_rgb8());
    let (before, after) = (before.as_chunks::<3>().0, after.as_chunks::<3>().0);
    for ((a, b), region) in before.iter().zip(after).zip(of_pixel) {
        let (sum, n) = &mut sums[usize::from(*region)];
        *n += 1;
        for c in 0..3 {
            sum[c] += f64::from(b[c]) - f64::from(a[c]);
        }
    }
    sums.map(|(sum, n)| (n > 0).then(|| sum.map(|s| s / n as f64)))
}
