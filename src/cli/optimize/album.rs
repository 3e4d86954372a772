//! Pictures of a foveated run: the first test view, somebody looking at its middle.

use powergs_base::picture::Picture;
use powergs_frame::fovea::{GazeError, LEVELS, ScreenGaze};
use powergs_optimize::foveated::Viewer;
use powergs_raster::regions::{self, TINTS};
use powergs_raster::{Detail, Options, render, render_foveated};
use powergs_report::optimize::foveated::{Album, Shot};
use powergs_scene::Foveated;

/// Where somebody looks.
const GAZE: [f32; 2] = [0.5, 0.5];

/// Mean change of red, green and blue in each region, codes of 8 bits; `None` where the view does
/// not have it.
type Change = [Option<[f64; 3]>; LEVELS];

/// The reference, FR-Render without and with the colour filter, and ours; and what the colours of
/// ours lost against the dense model, region by region.
///
/// # Errors
/// A screen that cannot be.
pub fn album(
    viewer: &Viewer<'_>,
    ours: &Foveated,
    pruned: Option<&Foveated>,
    is_self: bool,
) -> Result<(Album, Change), GazeError> {
    let setup = viewer.setup;
    let view = setup.split.test[0];
    let camera = &setup.cameras[view];
    let looking = ScreenGaze { point: GAZE, screen: viewer.screen };
    let options = Options { background: setup.background, ..Options::reference(Detail::Image) };
    let shown = |model: &Foveated| -> Result<Picture, GazeError> {
        Ok(render_foveated(model, camera, &looking, &options)?.picture)
    };
    let mut reference = Picture::default();
    setup.references.write_to(view, &mut reference);
    let shot = |name: &str, picture: &Picture| Shot { name: name.into(), rgb: picture.to_rgb8() };
    let mut shots = vec![shot(if is_self { "dense (reference)" } else { "photo" }, &reference)];
    if let Some(pruned) = pruned {
        let picture = shown(pruned)?;
        shots.push(shot("FR-Render", &picture));
        shots.push(shot("RTGS+D22", &viewer.filtered(&picture, &looking)?));
    }
    let picture = shown(ours)?;
    shots.push(shot("PowerGS", &picture));
    let size = [camera.width, camera.height];
    let of_pixel = looking.eccentricity_map(size)?.regions();
    let pixels = of_pixel.len().max(1) as f64;
    let share = |i: usize| of_pixel.iter().filter(|r| usize::from(**r) == i).count() as f64;
    let dense = render(setup.dense, camera, &options).picture;
    let album = Album {
        view: camera.name.clone(),
        width: camera.width,
        height: camera.height,
        gaze: GAZE.map(f64::from),
        levels: regions::draw(&picture, &looking)?.to_rgb8(),
        tints: TINTS.map(|tint| tint.map(|v| (255.0 * v).round() as u8)),
        shares: std::array::from_fn(|i| share(i) / pixels),
        shots,
    };
    Ok((album, change(&dense, &picture, &of_pixel)))
}

fn change(dense: &Picture, ours: &Picture, of_pixel: &[u8]) -> Change {
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
