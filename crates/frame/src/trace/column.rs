//! The columns of a frame: tag, meaning, length, transform.

use super::transform::Transform;

/// A column of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Column {
    /// Four ASCII letters; a small first letter means that readers may leave the block out.
    pub tag: [u8; 4],
    /// Name in messages, tables and CSV headers.
    pub name: &'static str,
    /// What it is charged to in statistics.
    pub group: ColumnGroup,
    /// How many bytes it has before compression.
    pub per: Per,
    /// The transform that this program writes; every transform is read.
    pub transform: Transform,
    /// When it must be there.
    pub presence: Presence,
}

/// What a column is charged to in statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ColumnGroup {
    /// Per visible splat.
    Splat,
    /// Per pixel.
    Pixel,
    /// Neither: bits of points, preview.
    Other,
}

/// How many bytes a column has before compression.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Per {
    /// A 32-bit word a splat.
    SplatWord,
    /// A byte a splat.
    SplatByte,
    /// A 32-bit word a pixel.
    PixelWord,
    /// A bit a scene point, in whole bytes.
    PointBit,
    /// What its content says.
    Content,
}

/// When a column must be there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Presence {
    /// In every frame.
    Always,
    /// In foveated frames, and only there.
    Foveated,
    /// Only in foveated frames, as the writer likes.
    OptionalFoveated,
    /// As the writer likes.
    Optional,
}

macro_rules! columns {
    ($($id:ident $tag:literal $name:literal
        $group:ident $per:ident $transform:ident $presence:ident;)*) => {
        /// Position of each column in [`COLUMNS`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Id { $($id),* }

        /// All columns in the order in which they are written.
        pub const COLUMNS: &[Column] = &[$(Column {
            tag: *$tag,
            name: $name,
            group: ColumnGroup::$group,
            per: Per::$per,
            transform: Transform::$transform,
            presence: Presence::$presence,
        }),*];

        /// Every [`Id`], in order.
        pub(super) const IDS: &[Id] = &[$(Id::$id),*];
    };
}

// Transforms were chosen by measurement; `docs/trace-format.md` has the table.
columns! {
    Index        b"SIDX" "index"         Splat SplatWord Planes            Always;
    Depth        b"SDEP" "depth"         Splat SplatWord DeltaPlanes       Always;
    MeanX        b"SMNX" "mean_x"        Splat SplatWord RotatedPlanes     Always;
    MeanY        b"SMNY" "mean_y"        Splat SplatWord RotatedPlanes     Always;
    CovA         b"SCVA" "cov_a"         Splat SplatWord RotatedPlanes     Always;
    CovB         b"SCVB" "cov_b"         Splat SplatWord RotatedPlanes     Always;
    CovD         b"SCVD" "cov_d"         Splat SplatWord RotatedPlanes     Always;
    Opacity      b"SOPA" "opacity"       Splat SplatWord RotatedPlanes     Always;
    StopRank     b"PSTP" "stop_rank"     Pixel PixelWord Plain             Always;
    Blended      b"PBLD" "blended"       Pixel PixelWord FoldedDeltaPlanes Always;
    HighestLevel b"FLEV" "highest_level" Splat SplatByte Plain             Foveated;
    StopRank2    b"FST2" "stop_rank_2"   Pixel PixelWord Plain             Foveated;
    ExtraAlpha   b"FEXA" "extra_alpha"   Pixel PixelWord FoldedDeltaPlanes Foveated;
    Blended2     b"FBL2" "blended_2"     Pixel PixelWord FoldedDeltaPlanes Foveated;
    Screen       b"FSCR" "screen"        Other Content   Plain             OptionalFoveated;
    SurvivorBits b"surv" "survivor_bits" Other PointBit  Plain             Optional;
    FrustumBits  b"frus" "frustum_bits"  Other PointBit  Plain             Optional;
    Preview      b"prev" "preview"       Other Content   RgbDelta             Optional;
}

impl Id {
    /// The column of this id.
    pub(super) fn column(self) -> &'static Column {
        &COLUMNS[self as usize]
    }

    /// The column with this tag.
    pub(super) fn from_tag(tag: [u8; 4]) -> Option<Id> {
        IDS.iter().copied().find(|id| id.column().tag == tag)
    }
}

/// The numbers from which column lengths follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ColumnCounts {
    /// Visible splats.
    pub splats: u64,
    /// Pixels.
    pub pixels: u64,
    /// Gaussians in the scene.
    pub points: u64,
}

impl Column {
    /// Bytes before compression, where they follow from the counts.
    pub(super) fn raw_bytes(&self, counts: ColumnCounts) -> Option<u64> {
        match self.per {
            Per::SplatWord => Some(4 * counts.splats),
            Per::SplatByte => Some(counts.splats),
            Per::PixelWord => Some(4 * counts.pixels),
            Per::PointBit => Some(counts.points.div_ceil(8)),
            Per::Content => None,
        }
    }

    /// Whether its entries are 32-bit words, and not bytes.
    pub(super) fn has_words(&self) -> bool {
        matches!(self.per, Per::SplatWord | Per::PixelWord)
    }
}
