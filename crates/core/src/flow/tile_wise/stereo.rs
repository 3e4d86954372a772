//! Two eyes (`stereo.impl`; A132): what the unit between them declares, and what is handed on.
//!
//! With `derived` the first eye of a pair is rendered as any frame. What of a tile blends is
//! re-projected, a record a cycle beside rendering, into a buffer between the eyes; `lag` tiles
//! behind, records of neighbouring tiles are merged by depth, and rendering units take them as the
//! lists of the second eye. Nothing of it is converted, sorted or read from DRAM. With `shared` a
//! Gaussian is converted once for both eyes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{TileWise, VruSpec};
use crate::flow::over::second_eye::{FirstView, NoSecond, StereoSummary, derived, shared};
use crate::flow::{History, Incompatible};
use crate::machine::check::{Found, SIZE_MAX};
use crate::machine::{BufferSpec, Exclusion, KeyValues, Machine, Optional, Ports};
use crate::stage::{
    Bias, Measured, Merge, StageDecl, StatDecl, Value, buffer, buffer_id, counted, omit, part,
    real, share, sram_read, sram_write, work, work_id,
};
use crate::workload::FrameWorkload;
use powergs_base::quantity::Bytes;
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Memory, Phase};
use powergs_frame::scene::Eye;

/// What the unit between two eyes declares.
pub const STEREO: StageDecl = StageDecl {
    units: Some(|m| if is_derived(m) { m.of_type::<VruSpec>().cores } else { 0 }),
    within: Some("vru"),
    works: &[
        work("reproject", 5, "One record that blends moved to its place in the second eye.")
            .a_cycle(|_| 1.0)
            .priced_as("alpha"),
        work("merge", 0, "One record chosen from those of neighbouring tiles, nearest first.")
            .comparing(|m| m.of_type::<StereoSpec>().lag.saturating_sub(1))
            .a_cycle(|_| 1.0)
            .priced_as("pivot-key"),
    ],
    buffers: &[buffer("between_eyes", "stereo.buffer", |m| {
        let memory = m.of_type::<StereoSpec>().buffer.shared(m.of_type::<VruSpec>().cores);
        match is_derived(m) {
            true => memory,
            false => Memory { bank: Bytes(0), banks: 0, ..memory },
        }
    })
    .full()],
    parts: &[part("rows", "Rows that are merged: `stereo.lag`.", |m| {
        f64::from(m.of_type::<StereoSpec>().lag)
    })],
    stats: &[
        &HANDED_ON,
        &KEPT,
        &KEPT_SHARE,
        &LOST_SHARE,
        &CHANGED_SHARE,
        &CUT_OFF_SHARE,
        &DISPARITY,
    ],
    omits: &[omit("a buffer between the eyes that is full", Bias::Optimistic, "A132")
        .by("stereo.impl = \"derived\"", is_derived)],
    behind: &["A132"],
    optional: OPTIONAL,
    excludes: EXCLUDES,
    check: Some(check),
    ..StageDecl::new(
        "stereo",
        "stereo units",
        Phase::Rendering,
        "Between the eyes of a pair: re-projects what blends in the first one, and merges it into \
         the lists of the second one (`stereo.impl = \"derived\"`). Keys: `stereo`.",
    )
};

/// A count of the second view of a pair alone.
const fn of_second(name: &'static str, means: &'static str) -> StatDecl {
    counted(name, means).merged(Merge::Second)
}

const HANDED_ON: StatDecl = of_second(
    "stereo.handed_on",
    "Pairs of splats and tiles that the first eye handed on to the second one.",
);
const KEPT: StatDecl =
    of_second("stereo.kept", "Entries of the lists of the second eye, which are made of these.");
const ENTRIES: StatDecl = of_second("stereo.entries", "");
const BLENDS: StatDecl = of_second("stereo.blends", "");
const LOST: StatDecl = of_second("stereo.lost_blends", "");
const PIXELS: StatDecl = of_second("stereo.pixels", "");
const CHANGED: StatDecl = of_second("stereo.changed_pixels", "");
const CUT_OFF: StatDecl = of_second("stereo.cut_off_pixels", "");

/// Share of the entries of its own lists that the second eye needs.
pub const KEPT_SHARE: StatDecl = share(
    "stereo.kept_frac",
    &KEPT,
    &[&ENTRIES],
    "Share of the entries of its own lists that the second eye needs, 0 to 1.",
);
const LOST_SHARE: StatDecl = share(
    "stereo.lost_blends_frac",
    &LOST,
    &[&BLENDS],
    "Share of the blends of the second eye that it loses, because their splats blend nowhere under \
     them in the first eye, 0 to 1.",
);
/// Share of the pixels of the second eye that may change.
pub const CHANGED_SHARE: StatDecl = share(
    "stereo.changed_pixels_frac",
    &CHANGED,
    &[&PIXELS],
    "Share of the pixels of the second eye whose colour may change by a step of eight bits or more \
     by that, 0 to 1: the weights of what is lost add up to 1/255.",
);
/// The part of them that changes because disparities are beyond the largest.
pub const CUT_OFF_SHARE: StatDecl = share(
    "stereo.cut_off_pixels_frac",
    &CUT_OFF,
    &[&PIXELS],
    "The part of them that changes because disparities are beyond `stereo.lag`, 0 to 1.",
);
const DISPARITY: StatDecl = real(
    "stereo.largest_disparity",
    Merge::Second,
    "Largest disparity of a splat that was handed on, in pixels.",
);

impl StereoSummary {
    /// As it is reported.
    pub fn measured(&self) -> Measured {
        let mut measured = Measured::of(&[
            (&HANDED_ON, self.handed_on),
            (&KEPT, self.kept),
            (&ENTRIES, self.entries),
            (&BLENDS, self.blends),
            (&LOST, self.lost_blends),
            (&PIXELS, self.pixels),
            (&CHANGED, self.changed_pixels),
            (&CUT_OFF, self.cut_off_pixels),
        ]);
        measured.set(&DISPARITY, Value::Real(f64::from(self.largest_disparity)));
        measured
    }
}

fn is_derived(m: &Machine) -> bool {
    m.of_type::<StereoSpec>().implementation == StereoImpl::Derived
}

const REPROJECT: ActionId = work_id("reproject");
const MERGE: ActionId = work_id("merge");
/// Records between the eyes.
const RECORDS: BufferId = buffer_id("between_eyes");

/// The share of the pixels of a second view that may change because disparities are beyond the
/// largest: below it Nebula's eyes differ.
const CUT_OFF_MOST: f64 = 0.01;

/// What a frame of a pair is handed.
#[derive(Debug)]
pub enum EyeWork {
    /// The first eye: records that it hands on.
    First(u64),
    /// The second eye, as the machine makes it.
    Second(Box<FrameWorkload>, Option<StereoSummary>),
    /// A frame that the machine cannot show as half of a pair, and why.
    Refused(Refusal),
}

/// Why a frame cannot be shown as half of a pair.
#[derive(Debug, Clone)]
pub enum Refusal {
    /// It is a single view.
    Single,
    /// Both views are no pair of this kind.
    NoPair(NoSecond),
    /// Too much of the second view lies beyond the largest disparity.
    CutOff(StereoSummary),
}

impl EyeWork {
    /// What a frame of a pair is handed; `None` where views are separate.
    pub(super) fn of(
        tiles: &TileWise,
        workload: &FrameWorkload,
        eye: Option<Eye>,
        history: &mut History,
    ) -> Option<EyeWork> {
        let way = tiles.stereo.implementation;
        let is_derived = match way {
            StereoImpl::Separate => return None,
            StereoImpl::Shared => false,
            StereoImpl::Derived => true,
        };
        Some(match eye {
            None => EyeWork::Refused(Refusal::Single),
            Some(Eye::Left) => {
                let first = FirstView::new(workload, is_derived);
                let records = first.handed_on();
                history.keep(eye, first);
                EyeWork::First(records)
            }
            Some(Eye::Right) => match history.take::<FirstView>(Some(Eye::Left)) {
                None => EyeWork::Refused(Refusal::Single),
                Some(first) => EyeWork::second(tiles, &first, workload),
            },
        })
    }

    fn second(tiles: &TileWise, first: &FirstView, workload: &FrameWorkload) -> EyeWork {
        let (lag, tile) = (tiles.stereo.lag, tiles.geometry.tile);
        let made = match tiles.stereo.implementation {
            StereoImpl::Derived => derived(first, workload, (lag * tile) as f32)
                .map(|(made, summary)| (made, Some(summary))),
            _ => shared(first, workload).map(|made| (made, None)),
        };
        match made {
            Err(why) => EyeWork::Refused(Refusal::NoPair(why)),
            Ok((_, Some(summary))) if summary.cut_off() > CUT_OFF_MOST => {
                EyeWork::Refused(Refusal::CutOff(summary))
            }
            Ok((made, summary)) => EyeWork::Second(Box::new(made), summary),
        }
    }

    /// The refusal of a frame.
    pub(super) fn refusal(&self, machine: &Machine) -> Option<Incompatible> {
        let EyeWork::Refused(why) = self else { return None };
        let spec = &machine.tiles().stereo;
        let because = match why {
            Refusal::Single => {
                "the frame is no half of a pair, left eye first: extract the trace with --stereo"
                    .to_owned()
            }
            Refusal::NoPair(NoSecond::Different) => {
                "the views of the pair have different sizes: extract them with --stereo".to_owned()
            }
            Refusal::NoPair(NoSecond::Rows(rows)) => format!(
                "a splat is {rows:.1} rows lower in one eye than in the other: the eyes do not \
                 look along parallel axes; extract them with --stereo"
            ),
            Refusal::CutOff(summary) => format!(
                "{:.1} % of the pixels of the second eye change, because disparities of more than \
                 `stereo.lag` = {} tiles of `geometry.tile` = {} pixels are not handed on: enlarge \
                 `stereo.lag`, or extract with eyes that are nearer to each other",
                100.0 * summary.cut_off(),
                spec.lag,
                machine.tiles().geometry.tile
            ),
        };
        Some(Incompatible::Stereo {
            machine: machine.name.clone(),
            way: spec.implementation.name(),
            because,
        })
    }

    /// Charges what the unit between the eyes does in a frame.
    pub(super) fn charge(&self, machine: &Machine, actions: &mut ActionCounts) {
        let spec = &machine.tiles().stereo;
        if spec.implementation != StereoImpl::Derived {
            return;
        }
        let word = spec.buffer.word.0.max(1);
        let record = machine.tiles().record.feature.0.next_multiple_of(word);
        match self {
            EyeWork::First(records) => {
                actions.charge(Phase::Rendering, REPROJECT, *records);
                actions.charge(Phase::Rendering, sram_write(RECORDS), records * record);
            }
            EyeWork::Second(made, _) => {
                let records = made.list.len() as u64;
                actions.charge(Phase::Rendering, MERGE, records);
                actions.charge(Phase::Rendering, sram_read(RECORDS), records * record);
            }
            EyeWork::Refused(_) => {}
        }
    }
}

impl StereoSummary {
    /// Share of the pixels that change because of the largest disparity.
    fn cut_off(&self) -> f64 {
        self.cut_off_pixels as f64 / self.pixels.max(1) as f64
    }
}

/// The `[stereo]` table: how the second view of a pair is made. Of no effect on single views.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct StereoSpec {
    /// How much of the first view the second one uses.
    #[serde(rename = "impl")]
    pub implementation: StereoImpl,
    /// Tiles that the second view is behind the first one: the largest disparity that is handed on.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "tiles"))]
    pub lag: u32,
    /// Feature records on their way from the first view to the second one, over all cores.
    pub buffer: BufferSpec,
}

impl Default for StereoSpec {
    /// Separate views; what there is where the file says only another way (A132).
    fn default() -> StereoSpec {
        StereoSpec {
            implementation: StereoImpl::Separate,
            lag: 4,
            buffer: BufferSpec {
                capacity: Bytes(64 << 10),
                word: Bytes(32),
                banks: 4,
                ports: Ports::ReadOrWrite,
            },
        }
    }
}

/// How the second view of a pair is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StereoImpl {
    /// As any other frame.
    Separate,
    /// Position and shape of what both eyes see are found once, colours for each eye.
    Shared,
    /// The first view hands on what blends in it; the second one has no lists besides.
    Derived,
}

impl StereoImpl {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            StereoImpl::Separate => "separate",
            StereoImpl::Shared => "shared",
            StereoImpl::Derived => "derived",
        }
    }
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[Optional {
    what: "`stereo.impl` = \"derived\"",
    switch: "stereo.impl",
    keys: &["stereo.lag", "stereo.buffer"],
    with: &["stereo.impl=derived", "fovea=none"],
    is_there: |m| m.of_type::<StereoSpec>().implementation == StereoImpl::Derived,
}];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Not("stereo.impl", &["separate"]),
        off: "separate",
        other: KeyValues::Not("fovea.accumulators", &["0"]),
        instead: "0",
        because: "how levels are handed on is not known",
    },
    Exclusion {
        choice: KeyValues::Not("stereo.impl", &["separate"]),
        off: "separate",
        other: KeyValues::Is("gsu.impl", &["update", "last", "shared"]),
        instead: "split",
        because: "an order is kept for each eye, and the second one has none",
    },
    Exclusion {
        choice: KeyValues::Not("stereo.impl", &["separate"]),
        off: "separate",
        other: KeyValues::Not("ccu.fetch", &["visible-colour"]),
        instead: "visible-colour",
        because: "both eyes have the colours that were converted before sorting",
    },
];

/// Second views that are made of first ones.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let m = machine.tiles();
    let (way, buffer) = (m.stereo.implementation, &m.stereo.buffer);
    if way == StereoImpl::Separate {
        return;
    }
    let is_wrong = buffer.word == Bytes(0) || buffer.word > buffer.capacity;
    if way == StereoImpl::Derived && is_wrong {
        let message = format!(
            "`stereo.buffer.word` = {} must be from 1 B to the capacity, {}",
            buffer.word, buffer.capacity
        );
        found.add("stereo.buffer.word", message);
    }
    if buffer.capacity > SIZE_MAX {
        let message = format!("`stereo.buffer.capacity` = {} is above {SIZE_MAX}", buffer.capacity);
        found.add("stereo.buffer.capacity", message);
    }
}
