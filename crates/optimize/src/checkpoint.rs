//! Where a run is, in a [`Store`]: outcomes and history so far, the fine-tune in flight, and the
//! models that later jobs start from.
//!
//! A file is `PGSOPT`, a version, a kind, a fingerprint of everything that the numbers of the run
//! depend on, the length of its head, the head (postcard), parameters and moments of models as
//! little-endian floats, steps as little-endian words, and the XXH3 of everything before. All
//! numbers are exact, so a run goes on bit for bit. A reader refuses what is damaged, of another
//! version, of another run, or promises more than it holds. Models are streamed: none is in memory
//! twice.

use std::io::{self, BufReader, BufWriter, Read, Write};

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use xxhash_rust::xxh3::Xxh3;

use super::adam::{Adam, Group};
use super::history::HistoryRow;
use super::lambda::ControllerState;
use super::outcome::Outcome;
use super::train::TrainState;
use super::train::densify::Observed;
use super::tune::{Check, Gauge, Heat, Model, Spent, State, Stride};
use powergs_core::run::{RunError, Store};
use powergs_scene::Gaussians;

/// Raised whenever the layout changes, or a run would go on by other rules than it began with.
const VERSION: u32 = 14;
const MAGIC: &[u8; 6] = b"PGSOPT";
/// Bytes before the body: magic, version, kind, fingerprint, length of the head.
const HEADER: usize = MAGIC.len() + 4 + 4 + 16 + 8;
/// The checkpoint of the run as a whole.
const PROGRESS: &str = "checkpoints/progress.ckpt";
/// Floats that are written or read at a time.
const BLOCK: usize = 4096;

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CheckpointKind {
    Progress = 1,
    Model = 2,
    Training = 3,
}

/// A checkpoint that cannot be used.
#[derive(Debug, thiserror::Error)]
enum CheckpointError {
    #[error("byte 0: this is not a checkpoint of an optimisation; give the folder of a run")]
    Foreign,
    #[error("checkpoint version {0}, this program reads {VERSION}; begin the run anew")]
    Version(u32),
    #[error(
        "the checkpoint belongs to a run with other inputs or settings; repeat the command of \
         that run with --resume, or begin another run in another place"
    )]
    OtherRun,
    #[error("byte {at}: {what}; the file is damaged, begin the run anew")]
    Damaged { at: u64, what: &'static str },
    #[error(transparent)]
    Read(#[from] io::Error),
}

/// Where a run is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Progress {
    /// Jobs that are done.
    pub outcomes: Vec<Outcome>,
    /// Their iterations, and those of the job in flight.
    pub history: Vec<HistoryRow>,
    /// The job in flight.
    pub current: Option<(String, State)>,
}

/// The checkpoints of one run.
#[derive(Clone, Copy)]
pub struct Checkpoints<'a> {
    store: &'a dyn Store,
    fingerprint: u128,
}

impl<'a> Checkpoints<'a> {
    /// Those of the run with this fingerprint.
    pub fn new(store: &'a dyn Store, fingerprint: u128) -> Checkpoints<'a> {
        Checkpoints { store, fingerprint }
    }

    /// Whether there is a run, this or another.
    ///
    /// # Errors
    /// [`RunError::Input`]: the store cannot be read.
    pub fn has_run(&self) -> Result<bool, RunError> {
        Ok(self.store.open(PROGRESS)?.is_some())
    }

    /// Keeps where the run is: what is done, and the job in flight.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be written; the checkpoint of before stays.
    pub fn save(
        &self,
        outcomes: &[Outcome],
        history: &[HistoryRow],
        current: Option<(&str, &State)>,
    ) -> Result<(), RunError> {
        let head = (outcomes, history, current.map(|(name, s)| (name, StateHead::of(s))));
        let kept = current.map_or([None; 2], |(_, s)| [&s.best, &s.spare].map(Option::as_ref));
        let kept = kept.into_iter().flatten().map(|(scene, _)| scene);
        let mean = current.and_then(|(_, s)| s.average.as_ref().map(|mean| &mean.0));
        let model = current.into_iter().flat_map(|(_, s)| parts(&s.model));
        let parts = model.chain(kept.chain(mean).map(CheckpointPart::Values));
        self.write(PROGRESS, CheckpointKind::Progress, &head, parts)
    }

    /// Where the run is; `None` if there is none.
    ///
    /// # Errors
    /// [`RunError::Input`]: a checkpoint that is damaged, or of another run or version.
    pub fn load(&self) -> Result<Option<Progress>, RunError> {
        type Head = (Vec<Outcome>, Vec<HistoryRow>, Option<(String, StateHead)>);
        self.read(PROGRESS, CheckpointKind::Progress, |head: Head, floats| {
            let (outcomes, history, current) = head;
            let current = match current {
                Some((name, head)) => Some((name, head.state(floats)?)),
                None => None,
            };
            Ok(Progress { outcomes, history, current })
        })
    }

    /// Keeps the model of a finished job, with its moments for the job that follows.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be written.
    pub fn save_model(&self, job: &str, model: &Model) -> Result<(), RunError> {
        let head = (ModelHead::of(&model.scene), true);
        self.write(&model_file(job), CheckpointKind::Model, &head, parts(model))
    }

    /// Keeps the parameters of a model alone: a third of the room.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be written.
    pub fn save_scene(&self, job: &str, scene: &Gaussians) -> Result<(), RunError> {
        let head = (ModelHead::of(scene), false);
        self.write(&model_file(job), CheckpointKind::Model, &head, [CheckpointPart::Values(scene)])
    }

    /// Forgets the moments of the model of a finished job, if it has any.
    ///
    /// # Errors
    /// [`RunError::Input`], [`RunError::Output`]: it is damaged, or cannot be written.
    pub fn forget_moments(&self, job: &str) -> Result<(), RunError> {
        type Head = (ModelHead, bool);
        // The moments are passed over: another model with its own may be in memory.
        let scene = self.read(
            &model_file(job),
            CheckpointKind::Model,
            |(head, has_moments): Head, file| {
                let scene = if has_moments { Some(file.part(head)?) } else { None };
                file.pass()?;
                Ok(scene)
            },
        )?;
        scene.flatten().map_or(Ok(()), |scene| self.save_scene(job, &scene))
    }

    /// Removes the model of a job, if it is there.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be written.
    pub fn remove_model(&self, job: &str) -> Result<(), RunError> {
        if self.has_model(job)? { self.store.remove(&model_file(job)) } else { Ok(()) }
    }

    /// Whether the model of a job is kept.
    ///
    /// # Errors
    /// [`RunError::Input`]: the store cannot be read.
    pub fn has_model(&self, job: &str) -> Result<bool, RunError> {
        Ok(self.store.open(&model_file(job))?.is_some())
    }

    /// The model of a finished job; with moments of zero if they were not kept.
    ///
    /// # Errors
    /// [`RunError::Input`]: it is missing or damaged.
    pub fn load_model(&self, job: &str) -> Result<Model, RunError> {
        let missing = || RunError::Input {
            place: self.store.place(&model_file(job)),
            message: "is missing; begin the run anew".into(),
        };
        type Head = (ModelHead, bool);
        let model = self.read(
            &model_file(job),
            CheckpointKind::Model,
            |(head, has_moments): Head, floats| {
                if has_moments {
                    return Ok(head.model(floats)?);
                }
                let scene = floats.part(head)?;
                Ok(Model { adam: Adam::new(&scene), scene })
            },
        )?;
        model.ok_or_else(missing)
    }

    /// Keeps where a training from nothing is, in the file `name`.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be written; the checkpoint of before stays.
    pub fn save_training(&self, name: &str, state: &TrainState) -> Result<(), RunError> {
        let TrainState { model, observed, iteration, is_capped } = state;
        let head = (ModelHead::of(&model.scene), *iteration, *is_capped);
        let observed = [
            CheckpointPart::Floats(&observed.slopes),
            CheckpointPart::Steps(&observed.views),
            CheckpointPart::Floats(&observed.radii),
        ];
        self.write(name, CheckpointKind::Training, &head, parts(model).into_iter().chain(observed))
    }

    /// Where the training in the file `name` is; `None` if there is no such file.
    ///
    /// # Errors
    /// [`RunError::Input`]: a checkpoint that is damaged, or of another training or version.
    pub fn load_training(&self, name: &str) -> Result<Option<TrainState>, RunError> {
        type Head = (ModelHead, u32, bool);
        self.read(name, CheckpointKind::Training, |(head, iteration, is_capped): Head, file| {
            let model = head.model(file)?;
            let n = head.points;
            let slopes = file.floats(n)?;
            let views = file.list(n, u32::from_le_bytes)?;
            let observed = Observed { slopes, views, radii: file.floats(n)? };
            Ok(TrainState { model, observed, iteration, is_capped })
        })
    }

    fn write<'m>(
        &self,
        name: &str,
        kind: CheckpointKind,
        head: &impl Serialize,
        parts: impl IntoIterator<Item = CheckpointPart<'m>>,
    ) -> Result<(), RunError> {
        let head = postcard::to_stdvec(head).map_err(|e| RunError::Internal(e.to_string()))?;
        let parts: Vec<CheckpointPart<'_>> = parts.into_iter().collect();
        let bytes =
            (HEADER + head.len()) as u64 + parts.iter().map(CheckpointPart::bytes).sum::<u64>() + 8;
        let failed = |e: &io::Error| cannot_write(self.store.place(name), bytes, e);
        let mut file = self.store.create(name)?;
        let written = || {
            let mut out = Summed { hash: Xxh3::new(), to: BufWriter::new(&mut file) };
            out.write_all(MAGIC)?;
            out.write_all(&VERSION.to_le_bytes())?;
            out.write_all(&(kind as u32).to_le_bytes())?;
            out.write_all(&self.fingerprint.to_le_bytes())?;
            out.write_all(&(head.len() as u64).to_le_bytes())?;
            out.write_all(&head)?;
            for part in parts {
                part.write(&mut out)?;
            }
            let sum = out.hash.digest();
            out.to.write_all(&sum.to_le_bytes())?;
            out.to.flush()
        };
        let written = written().and_then(|()| file.commit());
        written.map_err(|e| failed(&e))
    }

    /// Reads a file twice: nothing in it is believed before its checksum is.
    fn read<H: DeserializeOwned, T>(
        &self,
        name: &str,
        kind: CheckpointKind,
        body: impl FnOnce(H, &mut Floats<'_>) -> Result<T, CheckpointError>,
    ) -> Result<Option<T>, RunError> {
        let (Some(first), Some(mut second)) = (self.store.open(name)?, self.store.open(name)?)
        else {
            return Ok(None);
        };
        let read = self.parse(&mut BufReader::new(first), &mut second, kind, body);
        read.map(Some).map_err(|e| RunError::input(self.store.place(name), e))
    }

    fn parse<H: DeserializeOwned, T>(
        &self,
        first: &mut dyn Read,
        second: &mut dyn Read,
        kind: CheckpointKind,
        body: impl FnOnce(H, &mut Floats<'_>) -> Result<T, CheckpointError>,
    ) -> Result<T, CheckpointError> {
        let (header, len) = checked(first)?;
        let damaged = |what| CheckpointError::Damaged { at: HEADER as u64, what };
        if header[10..14] != (kind as u32).to_le_bytes() {
            return Err(damaged("it holds something else"));
        }
        if header[14..30] != self.fingerprint.to_le_bytes() {
            return Err(CheckpointError::OtherRun);
        }
        let head_len = u64::from_le_bytes(header[30..].try_into().expect("8 bytes"));
        let left = len.checked_sub(head_len);
        let left = left.ok_or_else(|| damaged("it promises more than it holds"))?;
        io::copy(&mut (&mut *second).take(HEADER as u64), &mut io::sink())?;
        // Not before its length is checked: a damaged one could ask for any amount of memory.
        let mut head = vec![0; head_len as usize];
        second.read_exact(&mut head)?;
        let head = postcard::from_bytes(&head).map_err(|_| damaged("its head makes no sense"))?;
        let mut floats = Floats { from: second, left };
        let value = body(head, &mut floats)?;
        if floats.left == 0 { Ok(value) } else { Err(damaged("bytes are left over")) }
    }
}

/// The parameters of a model in a file, bytes.
pub fn model_bytes(points: usize, sh_degree: u8) -> u64 {
    let values = 3 + 3 + 4 + 1 + 3 * (u64::from(sh_degree) + 1).pow(2);
    4 * values * points as u64
}

fn model_file(job: &str) -> String {
    format!("checkpoints/{job}.ckpt")
}

/// Reads a file to its end. Returns its header and the bytes between that and the checksum, which
/// is right.
fn checked(from: &mut dyn Read) -> Result<([u8; HEADER], u64), CheckpointError> {
    let mut start = Vec::with_capacity(HEADER);
    from.take(HEADER as u64).read_to_end(&mut start)?;
    if !start.starts_with(MAGIC) {
        return Err(CheckpointError::Foreign);
    }
    let damaged = |at, what| CheckpointError::Damaged { at, what };
    let short = start.len() as u64;
    let header: [u8; HEADER] =
        start.try_into().map_err(|_| damaged(short, "it ends within its header"))?;
    let version = u32::from_le_bytes(header[6..10].try_into().expect("4 bytes"));
    if version != VERSION {
        return Err(CheckpointError::Version(version));
    }
    let mut hash = Xxh3::new();
    hash.update(&header);
    // The last eight bytes are the checksum: they are held back until it is known that they are.
    let (mut held, mut bytes, mut len) = (Vec::new(), vec![0; 4 * BLOCK], 0);
    loop {
        let n = from.read(&mut bytes)?;
        if n == 0 {
            break;
        }
        held.extend_from_slice(&bytes[..n]);
        let body = held.len().saturating_sub(8);
        hash.update(&held[..body]);
        held.drain(..body);
        len += body as u64;
    }
    let end = HEADER as u64 + len;
    let sum = held.try_into().map_err(|_| damaged(end, "it ends too early"))?;
    if u64::from_le_bytes(sum) == hash.digest() {
        Ok((header, len))
    } else {
        Err(damaged(end, "the checksum is wrong"))
    }
}

/// A stream, and the hash of what went into it.
struct Summed<W> {
    hash: Xxh3,
    to: W,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.to.write(bytes)?;
        self.hash.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// A list of numbers in a file.
enum CheckpointPart<'a> {
    /// Of the shape of a model.
    Values(&'a Gaussians),
    /// Steps of its Gaussians, or another count of each.
    Steps(&'a [u32]),
    /// A number of each of its Gaussians.
    Floats(&'a [f32]),
}

/// What is written of a model: parameters, both moments, and steps.
fn parts(model: &Model) -> [CheckpointPart<'_>; 4] {
    let Model { scene, adam: Adam { first, second, steps } } = model;
    [
        CheckpointPart::Values(scene),
        CheckpointPart::Values(first),
        CheckpointPart::Values(second),
        CheckpointPart::Steps(steps),
    ]
}

impl CheckpointPart<'_> {
    fn bytes(&self) -> u64 {
        match self {
            CheckpointPart::Values(of) => model_bytes(of.len(), of.sh_degree),
            CheckpointPart::Steps(steps) => 4 * steps.len() as u64,
            CheckpointPart::Floats(floats) => 4 * floats.len() as u64,
        }
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            CheckpointPart::Values(of) => {
                Group::ALL.iter().try_for_each(|g| write_words(out, g.of(of), f32::to_le_bytes))
            }
            CheckpointPart::Steps(steps) => write_words(out, steps, u32::to_le_bytes),
            CheckpointPart::Floats(floats) => write_words(out, floats, f32::to_le_bytes),
        }
    }
}

/// A file of so many bytes that cannot be written. The file of before is still there.
fn cannot_write(place: String, bytes: u64, error: &io::Error) -> RunError {
    let message = match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => format!(
            "the disk is full: this file needs {} MiB beside what is there; the checkpoint before \
             it is whole, so make room and go on with --resume",
            bytes.div_ceil(1 << 20)
        ),
        _ => format!("cannot be written: {error}; the checkpoint before it is whole"),
    };
    RunError::Output { place, message }
}

fn write_words<T: Copy>(
    out: &mut dyn Write,
    list: &[T],
    word: impl Fn(T) -> [u8; 4],
) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(4 * BLOCK);
    for block in list.chunks(BLOCK) {
        bytes.clear();
        block.iter().for_each(|v| bytes.extend_from_slice(&word(*v)));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// The numbers of a file, of which `left` bytes are still to come.
struct Floats<'a> {
    from: &'a mut dyn Read,
    left: u64,
}

impl Floats<'_> {
    fn list<T>(&mut self, count: usize, of: impl Fn([u8; 4]) -> T) -> io::Result<Vec<T>> {
        // Before memory is taken: a head may promise more than the file holds.
        let bytes = (count as u64).checked_mul(4).and_then(|n| self.left.checked_sub(n));
        self.left = bytes.ok_or(io::ErrorKind::UnexpectedEof)?;
        let (mut values, mut bytes) = (Vec::with_capacity(count), [0; 4 * BLOCK]);
        while values.len() < count {
            let block = &mut bytes[..4 * BLOCK.min(count - values.len())];
            self.from.read_exact(block)?;
            values.extend(block.as_chunks().0.iter().map(|b| of(*b)));
        }
        Ok(values)
    }

    /// Passes over what is left.
    fn pass(&mut self) -> io::Result<()> {
        self.left -= io::copy(&mut (&mut *self.from).take(self.left), &mut io::sink())?;
        Ok(())
    }

    fn floats(&mut self, count: usize) -> io::Result<Vec<f32>> {
        self.list(count, f32::from_le_bytes)
    }

    fn part(&mut self, head: ModelHead) -> io::Result<Gaussians> {
        let n = head.points;
        let of = |each: usize| n.checked_mul(each).ok_or(io::ErrorKind::UnexpectedEof);
        Ok(Gaussians {
            means: self.floats(of(3)?)?.as_chunks().0.to_vec(),
            log_scales: self.floats(of(3)?)?.as_chunks().0.to_vec(),
            rotations: self.floats(of(4)?)?.as_chunks().0.to_vec(),
            logit_opacities: self.floats(n)?,
            sh_degree: head.sh_degree,
            sh: self.floats(of(3 * (usize::from(head.sh_degree) + 1).pow(2))?)?,
            antialiased: head.antialiased,
        })
    }
}

/// A model without its floats.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct ModelHead {
    points: usize,
    sh_degree: u8,
    antialiased: bool,
}

impl ModelHead {
    fn of(scene: &Gaussians) -> ModelHead {
        let (sh_degree, antialiased) = (scene.sh_degree, scene.antialiased);
        ModelHead { points: scene.len(), sh_degree, antialiased }
    }

    fn model(self, floats: &mut Floats<'_>) -> io::Result<Model> {
        let scene = floats.part(self)?;
        let (first, second) = (floats.part(self)?, floats.part(self)?);
        let steps = floats.list(self.points, u32::from_le_bytes)?;
        Ok(Model { scene, adam: Adam { first, second, steps } })
    }
}

/// A fine-tune without the floats of its models.
#[derive(Serialize, Deserialize)]
struct StateHead {
    model: ModelHead,
    iteration: u32,
    pruned: u32,
    control: Option<ControllerState>,
    averaged: Option<u32>,
    gauge: Gauge,
    unconfirmed: u32,
    heat: Option<Heat>,
    stride: Stride,
    labels: Vec<u32>,
    best: Option<(ModelHead, Check)>,
    spare: Option<(ModelHead, Check)>,
    last: Option<Check>,
    settled: bool,
    extended: Option<u32>,
    spent: Option<Spent>,
}

impl StateHead {
    fn of(state: &State) -> StateHead {
        let State {
            model,
            iteration,
            pruned,
            control,
            average,
            gauge,
            unconfirmed,
            heat,
            stride,
            labels,
            best,
            spare,
            last,
            settled,
            extended,
            spent,
        } = state;
        StateHead {
            model: ModelHead::of(&model.scene),
            iteration: *iteration,
            pruned: *pruned,
            control: *control,
            averaged: average.as_ref().map(|(_, count)| *count),
            gauge: gauge.clone(),
            unconfirmed: *unconfirmed,
            heat: *heat,
            stride: *stride,
            labels: labels.clone(),
            best: best.as_ref().map(|(scene, check)| (ModelHead::of(scene), *check)),
            spare: spare.as_ref().map(|(scene, check)| (ModelHead::of(scene), *check)),
            last: *last,
            settled: *settled,
            extended: *extended,
            spent: *spent,
        }
    }

    fn state(self, floats: &mut Floats<'_>) -> io::Result<State> {
        let StateHead {
            model: head,
            iteration,
            pruned,
            control,
            averaged,
            gauge,
            unconfirmed,
            heat,
            stride,
            labels,
            best,
            spare,
            last,
            settled,
            extended,
            spent,
        } = self;
        let model = head.model(floats)?;
        let mut other = |kept| match kept {
            Some((head, check)) => Ok::<_, io::Error>(Some((floats.part(head)?, check))),
            None => Ok(None),
        };
        // In the order of `save`: the best, the spare, and then the mean.
        let (best, spare) = (other(best)?, other(spare)?);
        let average = match averaged {
            Some(count) => Some((floats.part(head)?, count)),
            None => None,
        };
        Ok(State {
            model,
            iteration,
            pruned,
            control,
            average,
            gauge,
            unconfirmed,
            heat,
            stride,
            labels,
            best,
            spare,
            last,
            settled,
            extended,
            spent,
        })
    }
}
