//! Steps of training: what comes behind the gradients of a frame's lists, on every machine that is
//! no GPU (`training`; A145, A146).
//!
//! **Chain**: gradients of a Gaussian by mean, conic, opacity and colour become those by its
//! parameters. **Update**: values, gradients and moments pass through the memory. Units take
//! batches of Gaussians in turn.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::kernel::blocks::MovedBlock;
use crate::machine::Optional;
use crate::stage::{Measured, StatDecl, timed};
use powergs_base::quantity::Bytes;
use powergs_energy::action::Phase;
use powergs_frame::scene::ShDegree;
use std::num::NonZeroU64;

/// The `[training]` table: a frame is a step of training, with the loss, the lists in reverse and
/// the update behind it.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct TrainingSpec {
    /// Cycles of a lane for the gradients of a pixel by a Gaussian; on resident machines how often
    /// as many as a step of the lanes takes. 0 for no training.
    #[schemars(range(min = 0, max = 64), extend("x-unit" = "cycles"))]
    pub interval: u32,
    /// What is kept of a pixel between the frame and its gradients: gradient by its colour,
    /// transmittance, colour.
    pub state: Bytes,
    /// What is added up for a Gaussian: gradients by mean, conic, opacity and colour.
    pub record: Bytes,
    /// Operations of the loss of a pixel, its gradient included.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "operations"))]
    pub loss: u32,
    /// Operations of a Gaussian with a region or tile: from these gradients to those by its
    /// parameters.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "operations"))]
    pub chain: u32,
    /// Which Gaussians are updated.
    pub update: Updated,
    /// Bytes of the numbers that the update takes through the memory.
    pub widths: StepWidths,
    /// Operations of the update of a number.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "operations"))]
    pub step: u32,
    /// Steps from one densification to the next, 0 for none: gradients by the screen are added up
    /// in each, and all arrays move once in so many.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "steps"))]
    pub densify: u32,
}

impl Default for TrainingSpec {
    /// No training; what there is where the file says only the interval (A145).
    fn default() -> TrainingSpec {
        TrainingSpec {
            interval: 0,
            state: Bytes(28),
            record: Bytes(36),
            loss: 450,
            chain: 420,
            update: Updated::All,
            widths: StepWidths::default(),
            step: 12,
            densify: 0,
        }
    }
}

/// Which Gaussians are updated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Updated {
    /// Every one: moments change without a gradient too.
    All,
    /// Those with a tile or region, whether a pixel blends them or not.
    Visible,
    /// None: gradients alone are found.
    None,
    /// None, and their gradients become those by the pose of the camera (tracking).
    Pose,
}

impl Updated {
    /// How many of all Gaussians, of which some are visible.
    pub fn of(self, all: u64, visible: u64) -> u64 {
        match self {
            Updated::All => all,
            Updated::Visible => visible,
            Updated::None | Updated::Pose => 0,
        }
    }
}

/// The keys of a step, of every dataflow that has them.
pub(super) const TRAINING: Optional = Optional {
    what: "training",
    switch: "training.interval",
    keys: &[
        "training.state",
        "training.record",
        "training.loss",
        "training.chain",
        "training.update",
        "training.widths",
        "training.step",
        "training.densify",
    ],
    with: &["training.interval=2"],
    is_there: |m| m.of_type::<TrainingSpec>().interval > 0,
};

/// A part of a step behind its frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepPart {
    /// The picture is compared with a photo.
    Loss,
    /// Lists are gone through in reverse.
    Reverse,
    /// Gradients by parameters.
    Chain,
    /// Parameters are updated.
    Update,
}

impl StepPart {
    /// All of them, in their order.
    pub const ALL: [StepPart; 4] =
        [StepPart::Loss, StepPart::Reverse, StepPart::Chain, StepPart::Update];

    /// What it is called in tables.
    pub const fn words(self) -> &'static str {
        match self {
            StepPart::Loss => "loss",
            StepPart::Reverse => "reverse",
            StepPart::Chain => "chain rule",
            StepPart::Update => "update",
        }
    }

    /// Its time.
    pub const fn time(self) -> &'static StatDecl {
        match self {
            StepPart::Loss => &LOSS,
            StepPart::Reverse => &REVERSE,
            StepPart::Chain => &CHAIN,
            StepPart::Update => &UPDATE,
        }
    }

    /// The phase that its bytes and its energy are of.
    pub const fn phase(self) -> Phase {
        match self {
            StepPart::Loss | StepPart::Reverse => Phase::Rendering,
            StepPart::Chain | StepPart::Update => Phase::Preprocessing,
        }
    }
}

/// Time of the loss.
pub const LOSS: StatDecl =
    timed("step.loss_ms", "Time in which the picture is compared with the photo.");
/// Time of the gradients by what was blended.
pub const REVERSE: StatDecl =
    timed("step.reverse_ms", "Time in which lists are gone through in reverse.");
/// Time of the gradients by parameters.
pub const CHAIN: StatDecl =
    timed("step.chain_ms", "Time in which gradients by parameters are found.");
/// Time of the update.
pub const UPDATE: StatDecl = timed("step.update_ms", "Time in which parameters are updated.");

/// When the parts of a step ended.
pub type StepEnds = [u64; StepPart::ALL.len()];

/// Cycles of the parts of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StepCycles(pub [u64; StepPart::ALL.len()]);

impl StepCycles {
    /// Of the parts behind a frame that ended when they did.
    pub fn between(frame: u64, ends: StepEnds) -> StepCycles {
        let begins = [frame, ends[0], ends[1], ends[2]];
        StepCycles(std::array::from_fn(|i| ends[i] - begins[i]))
    }

    /// Of one part.
    pub fn of(&self, part: StepPart) -> u64 {
        self.0[part as usize]
    }

    /// Of all of them.
    pub fn all(&self) -> u64 {
        self.0.iter().sum()
    }

    /// As they are reported.
    pub fn measured(&self) -> Measured {
        Measured::of(&StepPart::ALL.map(|part| (part.time(), self.of(part))))
    }

    /// Those of a frame that was measured; `None` where it is no step.
    pub fn find(measured: &Measured) -> Option<StepCycles> {
        let cycles = StepPart::ALL.map(|part| measured.count(part.time()));
        cycles[0]?;
        Some(StepCycles(cycles.map(Option::unwrap_or_default)))
    }
}

/// Blocks of Gaussians of which a unit takes one after the other.
const BATCH: u64 = 256;

/// A number in single precision.
const WIDTH: Bytes = Bytes(4);

/// Gaussians of a step.
#[derive(Debug, Clone, Copy)]
pub struct SteppedGaussians {
    /// All of the scene.
    pub points: u64,
    /// Those with a tile or region, whether a pixel of it blends them or not: for those the
    /// published code finds gradients, and those are what `visible` updates.
    pub visible: u64,
    /// What of their gradients is in memory, records.
    pub sums: u64,
    /// Bytes of the geometry of one in its record, and of all of it.
    pub stored: [u64; 2],
    /// Numbers of one: position, scale, rotation, opacity and colour.
    pub numbers: u64,
}

/// Numbers of position, scale, rotation and opacity.
const GEOMETRY: u64 = 3 + 3 + 4 + 1;

impl SteppedGaussians {
    /// Numbers of a Gaussian of a scene of this degree.
    pub fn numbers_of(degree: ShDegree) -> u64 {
        GEOMETRY + 3 * degree.coefficients()
    }
}

/// Bytes of the numbers of a Gaussian in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct StepWidths {
    /// A number of a parameter, as the update reads and writes it. Records of other bytes are
    /// written as well, as a copy.
    pub parameter: Bytes,
    /// A number of a gradient by a parameter.
    pub gradient: Bytes,
    /// A number of each of the two moments of Adam; 0 B for none.
    pub moment: Bytes,
}

impl Default for StepWidths {
    /// Single precision.
    fn default() -> StepWidths {
        StepWidths { parameter: WIDTH, gradient: WIDTH, moment: WIDTH }
    }
}

impl StepWidths {
    /// Bytes that the update of a Gaussian reads and writes: values, gradients and moments in, all
    /// but gradients out, and its record where that is of other bytes than the values.
    pub fn updated(&self, gaussians: &SteppedGaussians) -> [u64; 2] {
        let n = gaussians.numbers;
        let (values, moments) = (n * self.parameter.0, 2 * n * self.moment.0);
        let copy = if values == gaussians.stored[1] { 0 } else { gaussians.stored[1] };
        [values + n * self.gradient.0 + moments, values + moments + copy]
    }

    /// Numbers of a Gaussian that densification moves, and their bytes: values and moments.
    fn moved(&self, gaussians: &SteppedGaussians) -> [u64; 2] {
        let moments = if self.moment.0 > 0 { 2 } else { 0 };
        let n = gaussians.numbers;
        [n * (1 + moments), n * (self.parameter.0 + moments * self.moment.0)]
    }

    /// What densification does in a step of `every` from one to the next: two numbers of each
    /// visible Gaussian, and the part of a step of moving values and moments of all of them.
    pub fn densifying(&self, every: u32, gaussians: &SteppedGaussians) -> Densified {
        let Some(every) = NonZeroU64::new(every.into()) else { return Densified::default() };
        let [numbers, bytes] = self.moved(gaussians).map(|n| n * gaussians.points);
        let visible = gaussians.visible;
        Densified {
            numbers: DENSITY_NUMBERS * visible + numbers.div_ceil(every.get()),
            bytes: DENSITY_NUMBERS * WIDTH.0 * visible + bytes.div_ceil(every.get()),
        }
    }
}

/// What densification reads and writes in a step: as much out as in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Densified {
    /// Numbers.
    pub numbers: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// The gradient by the screen, added up, and of how often.
const DENSITY_NUMBERS: u64 = 2;

impl TrainingSpec {
    /// What units do for the gradients by parameters, block by block.
    pub fn chain(&self, gaussians: &SteppedGaussians, units: usize) -> Vec<Vec<MovedBlock>> {
        let SteppedGaussians { visible, sums, stored: [geometry, all], numbers, .. } = *gaussians;
        let is_pose = self.update == Updated::Pose;
        let found = numbers * self.widths.gradient.0;
        let (read, written) = if is_pose { (geometry, 0) } else { (all, found) };
        let until = |n: u64| (u128::from(sums) * u128::from(n) / u128::from(visible)) as u64;
        dealt(visible, units, |first, end| {
            // What comes to a batch of what is spread over all.
            let (own, sums) = (end - first, until(end) - until(first));
            MovedBlock {
                items: own * u64::from(self.chain) + sums * self.record.0.div_ceil(4),
                read: sums * self.record.0 + own * read,
                write: own * written,
            }
        })
    }

    /// What units do for the update, block by block.
    pub fn update(&self, gaussians: &SteppedGaussians, units: usize) -> Vec<Vec<MovedBlock>> {
        let updated = self.update.of(gaussians.points, gaussians.visible);
        let [read, write] = self.widths.updated(gaussians);
        let mut all = dealt(updated, units, |first, end| {
            let own = end - first;
            MovedBlock {
                items: own * gaussians.numbers * u64::from(self.step),
                read: own * read,
                write: own * write,
            }
        });
        let Densified { numbers, bytes } = self.widths.densifying(self.densify, gaussians);
        let densified = dealt(gaussians.points, units, |first, end| {
            let part = |whole: u64| {
                let until = |n: u64| {
                    (u128::from(whole) * u128::from(n)).div_ceil(u128::from(gaussians.points))
                        as u64
                };
                until(end) - until(first)
            };
            // A number is compared and moved.
            MovedBlock { items: part(numbers), read: part(bytes), write: part(bytes) }
        });
        if self.densify > 0 {
            all.iter_mut().zip(densified).for_each(|(unit, more)| unit.extend(more));
        }
        all
    }
}

/// Blocks of so many Gaussians, dealt round over units.
fn dealt(all: u64, units: usize, block: impl Fn(u64, u64) -> MovedBlock) -> Vec<Vec<MovedBlock>> {
    let mut dealt = vec![Vec::new(); units];
    for (i, first) in (0..all).step_by(BATCH as usize).enumerate() {
        dealt[i % units].push(block(first, (first + BATCH).min(all)));
    }
    dealt
}
