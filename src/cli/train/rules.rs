//! The published rules as flags.

use std::num::NonZeroU32;

use crate::cli::{Exit, Failure};
use powergs_optimize::invalid::Invalid;
use powergs_optimize::train::{PUBLISHED_ITERATIONS, TrainRules};

/// The flags. Iterations count from 1.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Rules")]
pub struct RuleArgs {
    /// Iterations; with fewer or more than 30000, all intervals below are in proportion where they
    /// are not given
    #[arg(long, value_name = "N", default_value_t = published())]
    iterations: NonZeroU32,
    /// Seed: the same one gives the same bytes
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Most Gaussians: nothing is added that would make more
    #[arg(long, value_name = "N", default_value_t = TrainRules::published(1).max_points)]
    max_points: u64,
    /// Degree of the spherical harmonics at the end, 0 to 3 [default: 3]
    #[arg(hide_short_help = true, long, value_name = "D")]
    sh_degree: Option<u8>,
    /// Iterations after which the degree rises by one [default: 1000]
    #[arg(hide_short_help = true, long, value_name = "N")]
    sh_every: Option<u32>,
    /// Learning rate of centres at the beginning, in extents of the cameras [default: 1.6e-4]
    #[arg(hide_short_help = true, long, value_name = "RATE")]
    position_rate: Option<f64>,
    /// The same at the end [default: 1.6e-6]
    #[arg(hide_short_help = true, long, value_name = "RATE")]
    position_rate_end: Option<f64>,
    /// Learning rate of constant SH coefficients, a twentieth for the others [default: 2.5e-3]
    #[arg(hide_short_help = true, long, value_name = "RATE")]
    sh_rate: Option<f64>,
    /// Learning rate of opacities; later versions of the published code have 0.025 [default: 0.05]
    #[arg(hide_short_help = true, long, value_name = "RATE")]
    opacity_rate: Option<f64>,
    /// Learning rate of scales [default: 5e-3]
    #[arg(hide_short_help = true, long, value_name = "RATE")]
    scale_rate: Option<f64>,
    /// Learning rate of rotations [default: 1e-3]
    #[arg(hide_short_help = true, long, value_name = "RATE")]
    rotation_rate: Option<f64>,
    /// Gaussians are densified after this iteration [default: 500]
    #[arg(hide_short_help = true, long, value_name = "N")]
    densify_from: Option<u32>,
    /// They are densified before this iteration; 0 for never [default: 15000]
    #[arg(hide_short_help = true, long, value_name = "N")]
    densify_until: Option<u32>,
    /// Iterations between two densifications [default: 100]
    #[arg(hide_short_help = true, long, value_name = "N")]
    densify_every: Option<u32>,
    /// Least mean gradient by the centre of what is densified, the loss by half widths of the
    /// picture [default: 2e-4]
    #[arg(hide_short_help = true, long, value_name = "SLOPE")]
    densify_slope: Option<f64>,
    /// What is larger is split, not cloned; extents of the cameras [default: 0.01]
    #[arg(hide_short_help = true, long, value_name = "EXTENTS")]
    split_scale: Option<f64>,
    /// What has less opacity is pruned [default: 0.005]
    #[arg(hide_short_help = true, long, value_name = "OPACITY")]
    prune_opacity: Option<f64>,
    /// What is larger is pruned after the first reset; extents of the cameras [default: 0.1]
    #[arg(hide_short_help = true, long, value_name = "EXTENTS")]
    prune_scale: Option<f64>,
    /// What has a larger radius in a picture is pruned after the first reset, pixels; 0 for none
    /// [default: 0, which is what the published 20 come to]
    #[arg(hide_short_help = true, long, value_name = "PIXELS")]
    prune_radius: Option<f64>,
    /// Iterations between resets of the opacities to 0.01 [default: 3000]
    #[arg(hide_short_help = true, long, value_name = "N")]
    reset_every: Option<u32>,
}

fn published() -> NonZeroU32 {
    NonZeroU32::new(PUBLISHED_ITERATIONS).unwrap_or(NonZeroU32::MIN)
}

/// Fewer iterations leave opacities no time between resets that are scaled with them.
const RECOVERS: u32 = 1000;

impl RuleArgs {
    /// What is doubtful about short trainings whose intervals are scaled; `None` for others.
    pub fn doubt(&self, rules: &TrainRules) -> Option<String> {
        let is_short = rules.iterations < RECOVERS && self.reset_every.is_none();
        is_short.then(|| {
            format!(
                "note: in {} iterations opacities are reset each {}, faster than they recover: \
                 most Gaussians will be pruned; give --reset-every and --densify-every, or more \
                 iterations",
                rules.iterations, rules.reset_every
            )
        })
    }

    /// The rules, checked.
    ///
    /// # Errors
    /// Exit code 2: a number out of its range.
    pub fn rules(&self) -> Result<TrainRules, Failure> {
        let p = TrainRules::published(self.iterations.get());
        let rules = TrainRules {
            iterations: p.iterations,
            seed: self.seed,
            position_rate: self.position_rate.unwrap_or(p.position_rate),
            position_rate_end: self.position_rate_end.unwrap_or(p.position_rate_end),
            sh_rate: self.sh_rate.unwrap_or(p.sh_rate),
            opacity_rate: self.opacity_rate.unwrap_or(p.opacity_rate),
            scale_rate: self.scale_rate.unwrap_or(p.scale_rate),
            rotation_rate: self.rotation_rate.unwrap_or(p.rotation_rate),
            sh_degree: self.sh_degree.unwrap_or(p.sh_degree),
            sh_every: self.sh_every.unwrap_or(p.sh_every),
            densify_from: self.densify_from.unwrap_or(p.densify_from),
            densify_until: self.densify_until.unwrap_or(p.densify_until),
            densify_every: self.densify_every.unwrap_or(p.densify_every),
            densify_slope: self.densify_slope.unwrap_or(p.densify_slope),
            split_scale: self.split_scale.unwrap_or(p.split_scale),
            prune_opacity: self.prune_opacity.unwrap_or(p.prune_opacity),
            prune_scale: self.prune_scale.unwrap_or(p.prune_scale),
            prune_radius: self.prune_radius.unwrap_or(p.prune_radius),
            reset_every: self.reset_every.unwrap_or(p.reset_every),
            max_points: self.max_points,
        };
        rules.check().map_err(usage)?;
        Ok(rules)
    }
}

/// Flags have the names of the keys, with dashes.
fn usage(error: Invalid) -> Failure {
    let what = match error {
        Invalid::Range { key, value, low, high } => {
            format!("--{} {value}: must be {low} to {high}", key.replace('_', "-"))
        }
        other => other.to_string(),
    };
    Failure::new(Exit::Usage, what)
}
