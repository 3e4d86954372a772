//! Gradients in the layout of the parameters.

use rayon::prelude::*;

use super::Slopes;
use powergs_frame::splat::gradient::{GradientBlock, SHAPE, Stretch};
use powergs_frame::splat::project::LANES;
use powergs_scene::Gaussians;

/// Gaussians whose gradients one task writes.
const PART: usize = 128 * LANES;

/// The gradient of a loss by the raw parameters of [`Gaussians`], in the same layout: one entry per
/// Gaussian and list. Units are those of the loss per unit of the parameter.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gradients {
    /// By the centre, 1/world units.
    pub means: Vec<[f32; 3]>,
    /// By the logarithm of the standard deviations.
    pub log_scales: Vec<[f32; 3]>,
    /// By the quaternion (w, x, y, z) before it is normalised.
    pub rotations: Vec<[f32; 4]>,
    /// By the opacity before the logistic function.
    pub logit_opacities: Vec<f32>,
    /// By the SH coefficients, per Gaussian `[channel][coefficient]`.
    pub sh: Vec<f32>,
    /// Gaussians whose entries may differ from zero.
    written: Vec<bool>,
}

/// Entries of consecutive Gaussians.
struct GradientEntries<'a> {
    means: &'a mut [[f32; 3]],
    log_scales: &'a mut [[f32; 3]],
    rotations: &'a mut [[f32; 4]],
    logit_opacities: &'a mut [f32],
    sh: &'a mut [f32],
    written: &'a mut [bool],
}

impl Gradients {
    /// No gradients yet; [`Tape::backward`](super::Tape::backward) gives them their size.
    pub fn new() -> Gradients {
        Gradients::default()
    }

    /// The five lists as plain numbers, in the order means, log-scales, rotations, opacities, SH.
    pub fn flat(&self) -> [&[f32]; 5] {
        [
            self.means.as_flattened(),
            self.log_scales.as_flattened(),
            self.rotations.as_flattened(),
            &self.logit_opacities,
            &self.sh,
        ]
    }

    /// Writes the gradients of all Gaussians of `scene`. Only those that are seen now or were seen
    /// before are touched.
    pub(super) fn write(&mut self, scene: &Gaussians, slopes: &Slopes<'_>) {
        assert_eq!(slopes.points(), scene.len(), "backward needs the scene of the forward pass");
        if self.written.len() != scene.len() || self.sh.len() != scene.sh.len() {
            *self = Gradients::zeros(scene);
        }
        let n = 3 * scene.sh_coefficients();
        let all = Stretch::all(scene);
        self.means
            .par_chunks_mut(PART)
            .zip(self.log_scales.par_chunks_mut(PART))
            .zip(self.rotations.par_chunks_mut(PART))
            .zip(self.logit_opacities.par_chunks_mut(PART))
            .zip(self.sh.par_chunks_mut(PART * n))
            .zip(self.written.par_chunks_mut(PART))
            .enumerate()
            .for_each(
                |(i, (((((means, log_scales), rotations), logit_opacities), sh), written))| {
                    let to = GradientEntries {
                        means,
                        log_scales,
                        rotations,
                        logit_opacities,
                        sh,
                        written,
                    };
                    to.write(&all, i * PART, slopes);
                },
            );
    }

    fn zeros(scene: &Gaussians) -> Gradients {
        let n = scene.len();
        Gradients {
            means: vec![[0.0; 3]; n],
            log_scales: vec![[0.0; 3]; n],
            rotations: vec![[0.0; 4]; n],
            logit_opacities: vec![0.0; n],
            sh: vec![0.0; scene.sh.len()],
            written: vec![false; n],
        }
    }
}

impl GradientEntries<'_> {
    fn write(mut self, all: &Stretch<'_>, first: usize, slopes: &Slopes<'_>) {
        let mut seen = Vec::with_capacity(self.written.len());
        for place in 0..self.written.len() {
            let is_seen = slopes.is_seen(first + place);
            if is_seen {
                seen.push((first + place) as u32);
            } else if self.written[place] {
                self.set(place, &[0.0; LANES], None);
            }
            self.written[place] = is_seen;
        }
        let mut block = GradientBlock::default();
        for seen in seen.chunks(LANES) {
            slopes.find(all, 0, seen, &mut block);
            for (lane, gaussian) in seen.iter().enumerate() {
                let place = *gaussian as usize - first;
                self.set(place, &block.shape[lane], Some(&block.sh[lane]));
            }
        }
    }

    /// `None`: zeros.
    fn set(&mut self, place: usize, shape: &[f32; LANES], sh: Option<&[f32]>) {
        self.means[place].copy_from_slice(&shape[..3]);
        self.log_scales[place].copy_from_slice(&shape[3..6]);
        self.rotations[place].copy_from_slice(&shape[6..10]);
        self.logit_opacities[place] = shape[SHAPE - 1];
        let n = self.sh.len() / self.written.len();
        let to = &mut self.sh[place * n..(place + 1) * n];
        match sh {
            Some(sh) => to.copy_from_slice(&sh[..n]),
            None => to.fill(0.0),
        }
    }
}
