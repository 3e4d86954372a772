//! Requests that cannot be met: which key, what it says, and what it may say.

/// A request that is out of range or contradicts itself. Keys are the names of the fields of
/// [`Request`](crate::request::Request) and [`Settings`](crate::settings::Settings).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Invalid {
    /// A number out of its range.
    #[error("{key} {value}: must be {low} to {high}")]
    Range {
        /// The key.
        key: &'static str,
        /// What it says.
        value: f64,
        /// The least that it may say.
        low: f64,
        /// The most.
        high: f64,
    },
    /// A value of another kind than its setting has.
    #[error("{key}: {wanted}")]
    Kind {
        /// The key.
        key: &'static str,
        /// What it can be.
        wanted: String,
    },
    /// Ratios that cannot be sampled.
    #[error("rhos: at most {most} ratios, ascending, from 0 to below 1: 0,0.2,0.4")]
    Rhos {
        /// The most ratios.
        most: usize,
    },
    /// A share of the dense model's quality against its own renders.
    #[error(
        "quality: against its own renders the dense model is perfect, so a share of its PSNR says \
         nothing; give decibels or a level"
    )]
    ShareOfPerfect,
    /// A share that is none.
    #[error("quality {0}: a share, such as 0.99")]
    Share(f64),
    /// PSNR or SSIM that no picture has.
    #[error("quality_db must be 1 to 120 dB, quality_ssim 0 to 1")]
    Likeness,
    /// A model of the user with the name of a job.
    #[error("external model {0}: the name is taken; use another")]
    NameTaken(String),
    /// A model of the user with a name that may become that of a job.
    #[error("external model {0}-…: names that begin so belong to variant {0}")]
    VariantName(String),
    /// A path without frames or views.
    #[error("path_frames: a path needs 1 to 100000 frames and at least two views")]
    Path,
    /// Power over the test views of cameras of which none is one.
    #[error("power_views: the cameras of power have no test views; take all of them")]
    NoTestViews,
    /// Levels of the periphery at another size than they are trained at.
    #[error(
        "power_cameras: levels of the periphery are for the size that they are trained at, so \
         their power is counted with views of that size"
    )]
    LevelsAtOtherSize,
    /// A virtual screen that cannot be.
    #[error("screen: {0}")]
    Screen(#[from] powergs_frame::fovea::GazeError),
    /// A machine that shows no foveated frames.
    #[error(
        "foveation: the machine {0} cannot show foveated frames (fovea.accumulators is 0); set \
         fovea.accumulators to 1 or 2, or take another machine"
    )]
    NoFovea(String),
    /// A machine whose frames are steps of training.
    #[error(
        "the machine {0} trains: a frame of it is a step of training, and no picture that is \
         shown; take another one (gscore), and name this one with --train-on"
    )]
    Trains(String),
    /// A machine that shows nothing in a frame that stands alone.
    #[error("{0}; views are rendered one by one here")]
    Alone(String),
    /// A machine that has no frames of models that are made here.
    #[error(
        "the machine {machine} has `dataflow = \"{flow}\"`: it has the frames that were run \
         elsewhere, and none of the models that are made here; take another one (gscore)"
    )]
    OnlyRecorded {
        /// Its name.
        machine: String,
        /// Its dataflow.
        flow: &'static str,
    },
    /// A machine whose dataflow shows no levels.
    #[error(
        "foveation: the machine {machine} cannot show foveated frames: no machine with \
         `dataflow = \"{flow}\"` does; take another one (gscore)"
    )]
    NoLevels {
        /// Its name.
        machine: String,
        /// Its dataflow.
        flow: &'static str,
    },
}

/// Checks that a number lies in its range.
pub(crate) fn in_range(key: &'static str, value: f64, low: f64, high: f64) -> Result<(), Invalid> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(Invalid::Range { key, value, low, high })
    }
}
