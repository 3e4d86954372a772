//! What a training reads: views, photos, points.

use super::{CUBE, POINTS, StartArgs, TrainArgs};
use crate::cli::camera_file::Views;
use crate::cli::optimize::inputs::say_changes;
use crate::cli::optimize::photos::{self, PhotoFolder};
use crate::cli::power_views::fits_memory;
use crate::cli::references::FileReferences;
use crate::cli::{Context, Exit, Failure, out};
use powergs_optimize::references::ReferenceSink;
use powergs_optimize::train::start::scattered;
use powergs_scene::camera::{CameraFile, Frame};
use powergs_scene::files::{open_cameras, open_colmap_points, open_point_ply};
use powergs_scene::{Camera, PointCloud, Split};

use super::Progress;

/// Most Gaussians that a training begins with.
const MOST_POINTS: usize = 100_000_000;
/// Where the camera file names no test views, every eighth by name is held out: the published rule
/// (`llffhold`).
const HELD_OUT: usize = 8;
/// Largest half width of the cube of random points, extents of the cameras.
const WIDEST: f64 = 1e6;

/// The views and their photos.
pub struct TrainViews {
    /// As the photos show them.
    pub cameras: Vec<Camera>,
    /// The photos, over the background.
    pub images: FileReferences,
    /// Indices of those that train.
    pub train: Vec<usize>,
    /// Indices of those that are held out.
    pub held_out: Vec<usize>,
    /// The points of the COLMAP model that the cameras are of.
    points: Option<PointCloud>,
}

impl TrainViews {
    /// Opens all views that have a photo each.
    pub fn open(
        args: &TrainArgs,
        background: [f32; 3],
        context: &Context,
    ) -> Result<TrainViews, Failure> {
        let file = args.views.cameras.clone().or_else(|| photos::camera_file(&args.photos));
        let Some(file) = file else {
            let what = format!(
                "{}: no cameras.json, transforms.json or sparse/0 there or next to it; give \
                 --cameras",
                args.photos.display()
            );
            return Err(Failure::new(Exit::Usage, what));
        };
        let CameraFile { cameras, format, lenses, warnings, doubts, frame } =
            open_cameras(&file, None, None)?;
        let is_colmap = format.starts_with("COLMAP");
        // Points are in the frame of the data, and would have to be placed as the cameras were.
        let is_placed = is_colmap && matches!(frame, Frame::Model);
        let wants = args.start.points.is_none() && args.start.init.is_none();
        let points = match is_colmap && wants && !is_placed {
            true => open_colmap_points(&file)?,
            false => None,
        };
        let views = Views { cameras, format, lenses, warnings, notes: doubts };
        views.warn_of_selection(context);
        let folder = PhotoFolder::open(&args.photos)?;
        let files = folder.of_views(&views.cameras)?;
        folder.note_unused(&files, context);
        let shown = photos::measured(&files, &views.cameras, &views.lenses, args.views.size)?;
        if !context.global.quiet {
            say_changes(&views, &shown);
        }
        let cameras: Vec<Camera> = shown.iter().map(|photo| photo.view.clone()).collect();
        fits_memory(&cameras, context)?;
        let (train, held_out) = held_out(&cameras, args.views.hold_out)?;
        let mut images = FileReferences::new()?;
        let progress = Progress::new(context, cameras.len() as u64, "photos");
        for (file, photo) in files.iter().zip(&shown) {
            images.push(photos::reference(file, photo, background)?)?;
            progress.advance(1);
        }
        Ok(TrainViews { cameras, images, train, held_out, points })
    }
}

/// The views that train, and those that are held out.
fn held_out(cameras: &[Camera], every: Option<usize>) -> Result<(Vec<usize>, Vec<usize>), Failure> {
    let is_named = every.is_none() && cameras.iter().any(|c| c.split == Some(Split::Test));
    let every = every.unwrap_or(HELD_OUT);
    let mut order: Vec<usize> = (0..cameras.len()).collect();
    order.sort_by(|&a, &b| cameras[a].name.cmp(&cameras[b].name).then(a.cmp(&b)));
    let mut is_out = vec![false; cameras.len()];
    for (position, view) in order.into_iter().enumerate() {
        is_out[view] = match is_named {
            true => cameras[view].split == Some(Split::Test),
            false => every > 0 && position.is_multiple_of(every),
        };
    }
    let (out, train): (Vec<usize>, Vec<usize>) = (0..cameras.len()).partition(|v| is_out[*v]);
    if train.is_empty() {
        let what = format!(
            "no view is left for training: all {} are held out; hold out fewer with --hold-out K, \
             or none with --hold-out 0",
            cameras.len()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok((train, out))
}

/// The points that a training starts from.
pub fn points(
    args: &StartArgs,
    views: &TrainViews,
    most: u64,
    seed: u64,
    context: &Context,
) -> Result<PointCloud, Failure> {
    if let Some(path) = &args.init {
        return Ok(open_point_ply(path)?);
    }
    if let Some(points) = &views.points {
        if points.is_empty() {
            let what = "points3D holds no points; give --points N, which draws some";
            return Err(Failure::new(Exit::BadInput, what));
        }
        return Ok(points.clone());
    }
    let cube = args.cube.unwrap_or(CUBE);
    if !(cube > 0.0 && cube <= WIDEST) {
        let what = format!("--cube {cube}: must be above 0, and at most {WIDEST}");
        return Err(Failure::new(Exit::Usage, what));
    }
    let count = args.points.map_or(POINTS.min(most as usize), |n| n.get());
    if count > MOST_POINTS {
        let what = format!("--points {count}: must be at most {MOST_POINTS}");
        return Err(Failure::new(Exit::Usage, what));
    }
    if count as u64 > most {
        let what = format!("--points {count}: --max-points allows {most}");
        return Err(Failure::new(Exit::Usage, what));
    }
    if !context.global.quiet && args.points.is_none() {
        out::complain(format_args!("note: no points to start from: {count} are drawn at random"));
    }
    let train: Vec<Camera> = views.train.iter().map(|v| views.cameras[*v].clone()).collect();
    let (positions, colours) = scattered(&train, count, cube, seed);
    Ok(PointCloud { positions, colours })
}
