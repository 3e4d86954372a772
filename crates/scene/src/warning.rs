//! Oddities of a scene that do not prevent its use.

use std::fmt;

use powergs_base::format::counted;
use powergs_frame::splat::NEAR;

/// An oddity of a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// Gaussians with NaN, infinite or absurdly large parameters were dropped.
    Dropped {
        /// How many.
        count: u64,
        /// Index of the first, as in the file.
        first: u64,
    },
    /// Quaternions of length zero were replaced by the identity.
    ZeroQuaternions {
        /// How many.
        count: u64,
        /// Index of the first, among those that were kept.
        first: u64,
    },
    /// Scales of zero or less were raised to `1e-12`.
    NonPositiveScales {
        /// How many Gaussians.
        count: u64,
    },
    /// SH coefficients beyond degree 3 were left out.
    ShReduced {
        /// The degree in the file.
        from: u8,
    },
    /// The file says that the model was trained with anti-aliasing (Mip-Splatting).
    Antialiased,
    /// The 3D filter of Mip-Splatting is a column of the file, and was applied.
    Filter3d,
    /// A model of 2D Gaussian Splatting.
    Flat,
    /// Nearly all numbers look as if the activations had been applied already.
    Activated,
    /// Opacities look as if the activation had been applied already, or as if there had been
    /// another; scales do not.
    ActivatedOpacities,
    /// Scales look as if the activation had been applied already; opacities do not.
    ActivatedScales,
    /// glTF with logarithms in place of scales.
    LogarithmicScales,
    /// glTF with logits in place of opacities.
    LogitOpacities,
    /// glTF without spherical harmonics: its vertex colours are shown.
    VertexColours,
    /// Single precision cannot tell places apart that are closer than Gaussians are large.
    CoarsePositions {
        /// How many Gaussians.
        count: u64,
        /// The distance of two numbers there, world units.
        step: f64,
        /// A round place near the middle of the model, world units.
        origin: [f64; 3],
    },
    /// All is closer together than the near plane is to the camera.
    SmallScene {
        /// The diagonal of the middle nine tenths of the centres, world units.
        diagonal: f64,
    },
    /// Colours are linear, and are shown as if they were sRGB.
    LinearColours,
    /// Columns that mean something to somebody and were not read.
    IgnoredColumns {
        /// Their names.
        names: Vec<String>,
    },
    /// Quaternions whose length is not 1 within 1 %. Usual for INRIA files.
    Unnormalised {
        /// How many.
        count: u64,
    },
    /// Gaussians whose longest axis is larger than the diagonal of the scene's bounds.
    AbsurdScales {
        /// How many.
        count: u64,
    },
    /// Gaussians with an opacity below 1/255, which no pixel can see.
    Invisible {
        /// How many.
        count: u64,
    },
}

impl Warning {
    /// The stable name of the kind, as in JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Dropped { .. } => "dropped",
            Self::ZeroQuaternions { .. } => "zero_quaternions",
            Self::NonPositiveScales { .. } => "non_positive_scales",
            Self::ShReduced { .. } => "sh_reduced",
            Self::Antialiased => "antialiased",
            Self::Filter3d => "filter_3d",
            Self::Flat => "flat",
            Self::Activated => "activated",
            Self::ActivatedOpacities => "activated_opacities",
            Self::ActivatedScales => "activated_scales",
            Self::LogarithmicScales => "logarithmic_scales",
            Self::LogitOpacities => "logit_opacities",
            Self::VertexColours => "vertex_colours",
            Self::CoarsePositions { .. } => "coarse_positions",
            Self::SmallScene { .. } => "small_scene",
            Self::LinearColours => "linear_colours",
            Self::IgnoredColumns { .. } => "ignored_columns",
            Self::Unnormalised { .. } => "unnormalised_quaternions",
            Self::AbsurdScales { .. } => "absurd_scales",
            Self::Invisible { .. } => "invisible",
        }
    }

    /// How many Gaussians it is about, where it is about some and not about the whole file.
    pub fn count(&self) -> Option<u64> {
        match *self {
            Self::Dropped { count, .. }
            | Self::ZeroQuaternions { count, .. }
            | Self::NonPositiveScales { count }
            | Self::CoarsePositions { count, .. }
            | Self::Unnormalised { count }
            | Self::AbsurdScales { count }
            | Self::Invisible { count } => Some(count),
            Self::ShReduced { .. }
            | Self::Antialiased
            | Self::Filter3d
            | Self::Flat
            | Self::Activated
            | Self::ActivatedOpacities
            | Self::ActivatedScales
            | Self::LogarithmicScales
            | Self::LogitOpacities
            | Self::VertexColours
            | Self::SmallScene { .. }
            | Self::LinearColours
            | Self::IgnoredColumns { .. } => None,
        }
    }
}

/// `1 Gaussian is`, `2 Gaussians are`.
fn are(count: u64) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("{} {verb}", counted(count, "Gaussian"))
}

/// A distance, as short as it can be said.
fn distance(units: f64) -> String {
    if units < 1e-3 { format!("{units:.1e}") } else { units.to_string() }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dropped { count, first } => {
                write!(
                    f,
                    "{} dropped: NaN, infinite or absurd (first: {first})",
                    counted(count, "Gaussian")
                )
            }
            Self::ZeroQuaternions { count, first } => {
                write!(
                    f,
                    "{} of length zero became identity (first: {first})",
                    counted(count, "quaternion")
                )
            }
            Self::NonPositiveScales { count } => {
                write!(
                    f,
                    "{} had scales of zero or less; raised to 1e-12",
                    counted(count, "Gaussian")
                )
            }
            Self::ShReduced { from } => {
                write!(f, "SH degree {from} in the file; only degrees 0 to 3 are used")
            }
            Self::Antialiased => {
                write!(
                    f,
                    "an anti-aliased model (Mip-Splatting): opacities are compensated for the \
                     low-pass of each view"
                )
            }
            Self::Filter3d => write!(
                f,
                "the 3D filter of Mip-Splatting (`filter_3D`) is applied to scales and opacities; \
                 if the model was trained with its 2D filter, too, write `comment SplatRenderMode: \
                 mip` into the header"
            ),
            Self::Flat => write!(
                f,
                "a model of 2D Gaussian Splatting (2DGS), which has two scales: shown as flat 3D \
                 Gaussians; its own rasteriser makes another picture"
            ),
            Self::Activated => write!(
                f,
                "nearly all opacities are 0 to 1 and scales above 0, as if their activations had \
                 been applied: this model is probably wrong; export it again with opacity \
                 ln(p / (1 - p)) and scale ln(s)"
            ),
            Self::ActivatedOpacities => write!(
                f,
                "nearly all raw opacities are -1 to 1, and those of trained models go far beyond: \
                 as if they were stored after the sigmoid, or trained with an absolute value in \
                 its place; pictures are probably wrong; export logits, ln(p / (1 - p))"
            ),
            Self::ActivatedScales => write!(
                f,
                "nearly all raw scales are 0 to 1, so that Gaussians are all 1 to 2.7 world units \
                 large: as if they were stored after their activation; export logarithms, ln(s)"
            ),
            Self::LogarithmicScales => write!(
                f,
                "scales are below 0, and are read as logarithms, as drafts of glTF's extension \
                 have them"
            ),
            Self::LogitOpacities => write!(
                f,
                "opacities are beyond 0 and 1, and are read as logits, as PLY has them; the \
                 standard of glTF's extension has 0 to 1"
            ),
            Self::VertexColours => write!(
                f,
                "no spherical harmonics or no opacities: those of COLOR_0 are shown, the same from \
                 all sides"
            ),
            Self::CoarsePositions { count, step, origin: [x, y, z] } => write!(
                f,
                "positions are resolved to {} world units only, as single precision does at such \
                 coordinates (of a map?), and {} no larger than twice that: pictures are wrong; \
                 subtract an origin, such as {x} {y} {z}, from model and cameras before they are \
                 exported",
                distance(*step),
                are(*count)
            ),
            Self::SmallScene { diagonal } => write!(
                f,
                "the scene is {diagonal:.2e} world units across, and nothing within {NEAR} of a \
                 camera is drawn (the near plane of 3DGS): scale model and cameras up, to some \
                 units across"
            ),
            Self::LinearColours => write!(
                f,
                "trained on linear colours (`lin_...`), which are shown as sRGB: pictures are dark"
            ),
            Self::IgnoredColumns { names } => {
                const SHOWN: usize = 8;
                let more = if names.len() > SHOWN { ", ..." } else { "" };
                write!(
                    f,
                    "{} not read: {}{more}; a moving scene stands still without them",
                    counted(names.len() as u64, "column"),
                    names[..names.len().min(SHOWN)].join(", "),
                )
            }
            Self::Unnormalised { count } => {
                write!(
                    f,
                    "{} of length other than 1; projection normalises them",
                    counted(count, "quaternion")
                )
            }
            Self::AbsurdScales { count } => {
                write!(f, "{} longer than the scene's diagonal", counted(count, "Gaussian"))
            }
            Self::Invisible { count } => {
                write!(f, "{} with an opacity below 1/255, never seen", counted(count, "Gaussian"))
            }
        }
    }
}
