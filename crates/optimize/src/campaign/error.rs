//! Why a campaign ended early.

use powergs_core::run::RunError;
use powergs_core::sim::SimError;
use powergs_quality::LpipsError;

use crate::foveated::FovealError;
use crate::invalid::Invalid;
use crate::tune::TuneError;

/// Why a campaign ended early. What was asked for and cannot be done, what is wrong with an input,
/// and a defect of the simulator are different variants.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The request is out of range or contradicts itself.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The cameras are not of this scene.
    #[error("no view sees anything of the model: are these the cameras of this scene?")]
    NothingSeen,
    /// A test view that LPIPS is not defined for.
    #[error("lpips: test view {view}: {error}")]
    Lpips {
        /// Name of the view.
        view: String,
        /// What is wrong.
        error: LpipsError,
    },
    /// A panel cannot be scaled for black images.
    #[error("display_ratio: the dense model's images cost no display power")]
    NoDisplayPower,
    /// The store has no run to go on with.
    #[error("no run to go on with")]
    NoRun,
    /// The store has a run already.
    #[error("holds a run already; go on with that, or give another place")]
    HoldsRun,
    /// Numbers that are not finite, or views that HVSQ is not defined for.
    #[error("job {job}: {error}")]
    Tune {
        /// The job.
        job: String,
        /// What happened.
        error: TuneError,
    },
    /// A machine that cannot run a frame, or a defect of the simulator.
    #[error("internal error in {what}: {error}")]
    Sim {
        /// What was measured.
        what: String,
        /// What happened.
        error: SimError,
    },
    /// The same in a foveated frame.
    #[error("internal error in a foveated frame: {0}")]
    Foveated(#[from] FovealError),
    /// The store fails, or something that cannot happen did.
    #[error(transparent)]
    Run(#[from] RunError),
}
