//! Gate views that no camera file has, where the model is its own reference and a view more costs a
//! render: between neighbouring views.
//!
//! How like two models are differs by decibels from one side of a scene to the other, and a mean
//! over three or four views says little of the mean over all. Views between the others see the
//! scene from as near and in the same directions as people do who were given those.

use std::collections::BTreeSet;

use powergs_scene::Camera;
use powergs_scene::camera::path::Path;

/// Two views that look in directions this far apart have nothing between them that is like both,
/// cosine of the angle.
const APART: f64 = 0.5;
/// Neighbours of a view that are tried.
const NEIGHBOURS: usize = 3;
/// Where between two views, in this order, as a share of the way.
const SHARES: [f64; 3] = [0.5, 0.25, 0.75];

/// `count` views at most, each between a view and one of its nearest neighbours: half way first,
/// and where all of these are taken, nearer to one of them. They are evenly spaced in the order of
/// `cameras`. With each, the positions of its neighbours.
pub(crate) fn between(cameras: &[Camera], count: usize) -> Vec<(Camera, [usize; 2])> {
    let mut made = Vec::new();
    let n = cameras.len();
    let near: Vec<Vec<usize>> = (0..n).map(|of| neighbours(cameras, of)).collect();
    for share in SHARES {
        let mut taken = BTreeSet::new();
        let missing = count - made.len();
        // A view may give its place to the next where all of its pairs are taken.
        let spread = (0..missing).map(|i| i * n / missing.max(1));
        for first in spread.chain(0..n) {
            if made.len() == count {
                return made;
            }
            let mut pairs = near[first].iter().map(|second| pair(first, *second));
            if let Some(free) = pairs.find(|pair| taken.insert(*pair)) {
                made.extend(at(cameras, free, share));
            }
        }
    }
    made
}

fn pair(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// The nearest views that look in about the same direction from another place, nearest first.
fn neighbours(cameras: &[Camera], of: usize) -> Vec<usize> {
    let here = &cameras[of];
    let far = |other: usize| here.centre.distance_squared(cameras[other].centre);
    // Two views from one place have nothing between them.
    let is_like = |other: &usize| {
        let camera = &cameras[*other];
        far(*other) > 0.0
            && here.forward().dot(camera.forward()) >= APART
            && (here.width, here.height) == (camera.width, camera.height)
    };
    let mut others: Vec<usize> = (0..cameras.len()).filter(is_like).collect();
    others.sort_by(|a, b| far(*a).total_cmp(&far(*b)).then(a.cmp(b)));
    others.truncate(NEIGHBOURS);
    others
}

fn at(cameras: &[Camera], [a, b]: [usize; 2], share: f64) -> Option<(Camera, [usize; 2])> {
    let path = Path::through(&[cameras[a].clone(), cameras[b].clone()])?;
    let place = share * path.knots().last()?;
    let name = format!("between_{share}_{}_{}", cameras[a].name, cameras[b].name);
    Some((Camera { name, ..path.at(place) }, [a, b]))
}
