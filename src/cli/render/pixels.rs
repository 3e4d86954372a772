//! `render --pixels`: pictures of which not all pixels are rendered.

use powergs_base::picture::Picture;
use powergs_core::flow::over::pixels::PixelOrigin;

/// Pictures that were shown one after the other.
#[derive(Debug, Default)]
pub struct ShownPictures(Vec<Picture>);

/// How many pixels of a picture are rendered, and how many filled in.
#[derive(Debug, Clone, Copy)]
pub struct OriginShares {
    /// Rendered to the end.
    pub rendered: f64,
    /// Filled in from neighbours.
    pub filled: f64,
}

impl ShownPictures {
    /// The picture that is shown, with pixels from where they come from; `exact` has those that are
    /// rendered.
    pub fn next(&mut self, exact: &Picture, origins: &[PixelOrigin]) -> (Picture, OriginShares) {
        let mut picture = exact.clone();
        let mut filled = Vec::new();
        let mut rendered = 0_usize;
        let before = self.0.last();
        for (at, (pixel, origin)) in picture.pixels.iter_mut().zip(origins).enumerate() {
            match (*origin, before) {
                (PixelOrigin::Rendered, _) | (PixelOrigin::Moved(_), None) => rendered += 1,
                (PixelOrigin::Moved(from), Some(before)) => *pixel = before.pixels[from as usize],
                (PixelOrigin::Filled, _) => filled.push(at),
                (PixelOrigin::Known { frame, pixel: from }, _) => {
                    // One of this frame comes in front of it, and is rendered.
                    let of = self.0.get(frame as usize).unwrap_or(exact);
                    *pixel = of.pixels[from as usize];
                }
            }
        }
        let share = |n: usize| n as f64 / origins.len().max(1) as f64;
        let shares = OriginShares { rendered: share(rendered), filled: share(filled.len()) };
        fill(&mut picture, filled);
        self.0.push(picture.clone());
        (picture, shares)
    }
}

/// Fills pixels in from outside to inside: each gets the mean of those beside it that are there.
fn fill(picture: &mut Picture, mut open: Vec<usize>) {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut is_open = vec![false; picture.pixels.len()];
    open.iter().for_each(|&at| is_open[at] = true);
    while !open.is_empty() {
        let mut done = Vec::new();
        open.retain(|&at| {
            let (x, y) = (at % width, at / width);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let near = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
            let there = near.filter(|&near| !is_open[near]);
            let (sum, n) = there.fold(([0.0; 3], 0.0), |(sum, n), near| {
                let pixel = picture.pixels[near];
                (std::array::from_fn(|i| sum[i] + pixel[i]), n + 1.0)
            });
            if n > 0.0 {
                done.push((at, sum.map(|sum: f32| sum / n)));
            }
            n == 0.0
        });
        if done.is_empty() {
            // A picture of which nothing is there stays as it is.
            return;
        }
        for (at, colour) in done {
            picture.pixels[at] = colour;
            is_open[at] = false;
        }
    }
}
