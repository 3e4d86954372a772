//! Where a run is, as bytes: outcomes so far, the fine-tune in flight, models with their moments.
//!
//! `PGSOPT`, a version, a kind, a fingerprint of inputs and settings, the body, and the XXH3 of
//! everything before. Numbers are little-endian and exact, so a run goes on bit for bit. A reader
//! refuses what is damaged, of another version, of another run, or promises more than it holds.

mod codec;

use std::io::{self, Read, Seek, SeekFrom, Write};

use codec::{In, Out};

use super::adam::Adam;
use super::lambda::Memory;
use super::oracle::{Parts, Watts};
use super::plan::{Baseline, Outcome, Place, Role};
use super::setup::Seen;
use super::target::Quality;
use super::tune::{Check, Model, State};
use powergs_scene::Gaussians;

/// Raised whenever the layout changes.
pub const VERSION: u32 = 3;
const MAGIC: &[u8; 6] = b"PGSOPT";

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Progress = 1,
    Model = 2,
}

/// A checkpoint that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// Not one of ours.
    #[error("byte 0: this is no checkpoint of an optimisation; give the folder of a run")]
    Foreign,
    /// From another version of the program.
    #[error("checkpoint version {found}, this program reads {VERSION}; begin the run anew")]
    Version {
        /// The version in the file.
        found: u32,
    },
    /// Another run.
    #[error(
        "the checkpoint belongs to a run with other inputs or settings; repeat the command of \
         that run with --resume, or give another --out"
    )]
    OtherRun,
    /// The file cannot be read.
    #[error("{0}")]
    Read(String),
    /// Damaged or cut short.
    #[error("byte {at}: {what}; the file is damaged, begin the run anew")]
    Damaged {
        /// Where, bytes from the beginning.
        at: usize,
        /// What is wrong.
        what: &'static str,
    },
}

impl From<io::Error> for CheckpointError {
    fn from(error: io::Error) -> Self {
        Self::Read(error.to_string())
    }
}

/// Where a run is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Progress {
    /// Jobs that are done.
    pub outcomes: Vec<Outcome>,
    /// Bytes of `history.csv` that belong to this state.
    pub history_bytes: u64,
    /// The job in flight.
    pub current: Option<(String, State)>,
}

/// Writes where a run is: its outcomes, the length of its history, the job in flight. Streams: a
/// model is never in memory a second time.
///
/// # Errors
/// Those of `to`.
pub fn write_progress(
    to: &mut dyn Write,
    fingerprint: u128,
    outcomes: &[Outcome],
    history_bytes: u64,
    current: Option<(&str, &State)>,
) -> io::Result<()> {
    let mut out = begin(to, Kind::Progress, fingerprint);
    out.u64(history_bytes);
    out.u64(outcomes.len() as u64);
    outcomes.iter().for_each(|o| write_outcome(&mut out, o));
    out.option(current.as_ref(), |out, (name, state)| {
        out.text(name);
        write_state(out, state);
    });
    out.finish()
}

impl Progress {
    /// From a stream, which is read twice: no number is believed before the checksum is.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn read(
        from: &mut (impl Read + Seek),
        fingerprint: u128,
    ) -> Result<Progress, CheckpointError> {
        let mut input = open(from, Kind::Progress, fingerprint)?;
        let history_bytes = input.u64()?;
        // An outcome takes more than 100 bytes.
        let count = input.count(100)?;
        let outcomes =
            (0..count).map(|_| read_outcome(&mut input)).collect::<Result<Vec<_>, _>>()?;
        let current = input.option(|input| Ok((input.text()?, read_state(input)?)))?;
        input.finish()?;
        Ok(Progress { outcomes, history_bytes, current })
    }
}

/// Writes a model with its moments.
///
/// # Errors
/// Those of `to`.
pub fn write_whole_model(to: &mut dyn Write, fingerprint: u128, model: &Model) -> io::Result<()> {
    let mut out = begin(to, Kind::Model, fingerprint);
    write_model(&mut out, model);
    out.finish()
}

/// A model with its moments, from a stream; see [`Progress::read`].
///
/// # Errors
/// [`CheckpointError`].
pub fn read_whole_model(
    from: &mut (impl Read + Seek),
    fingerprint: u128,
) -> Result<Model, CheckpointError> {
    let mut input = open(from, Kind::Model, fingerprint)?;
    let model = read_model(&mut input)?;
    input.finish()?;
    Ok(model)
}

fn begin(to: &mut dyn Write, kind: Kind, fingerprint: u128) -> Out<'_> {
    let mut out = Out::new(to);
    out.raw(MAGIC);
    out.u32(VERSION);
    out.u32(kind as u32);
    out.u64(fingerprint as u64);
    out.u64((fingerprint >> 64) as u64);
    out
}

fn open<R: Read + Seek>(
    from: &mut R,
    kind: Kind,
    fingerprint: u128,
) -> Result<In<'_>, CheckpointError> {
    let len = from.seek(SeekFrom::End(0))? as usize;
    from.rewind()?;
    let damaged = |what| CheckpointError::Damaged { at: len, what };
    let mut magic = [0; MAGIC.len()];
    if len < magic.len() {
        return Err(CheckpointError::Foreign);
    }
    from.read_exact(&mut magic)?;
    if magic != *MAGIC {
        return Err(CheckpointError::Foreign);
    }
    let body = len.checked_sub(MAGIC.len() + 4 + 8);
    let body = body.ok_or_else(|| damaged("it ends within its head"))? + MAGIC.len() + 4;
    let version = In::new(from, 4).u32()?;
    if version != VERSION {
        return Err(CheckpointError::Version { found: version });
    }
    from.rewind()?;
    let hash = codec::hash(from, body)?;
    if hash != In::new(from, 8).u64()? {
        return Err(damaged("the checksum is wrong"));
    }
    from.rewind()?;
    let mut input = In::new(from, body);
    input.skip(MAGIC.len() + 4)?;
    if input.u32()? != kind as u32 {
        return Err(damaged("it holds something else"));
    }
    let found = u128::from(input.u64()?) | u128::from(input.u64()?) << 64;
    if found == fingerprint { Ok(input) } else { Err(CheckpointError::OtherRun) }
}

fn write_model(out: &mut Out<'_>, model: &Model) {
    let scene = &model.scene;
    out.u32(u32::from(scene.sh_degree));
    out.u64(scene.len() as u64);
    out.u64(model.adam.steps);
    for part in [scene, &model.adam.first, &model.adam.second] {
        out.floats(part.means.as_flattened());
        out.floats(part.log_scales.as_flattened());
        out.floats(part.rotations.as_flattened());
        out.floats(&part.logit_opacities);
        out.floats(&part.sh);
    }
}

fn read_model(input: &mut In<'_>) -> Result<Model, CheckpointError> {
    let degree = input.u32()?;
    if degree > 3 {
        return Err(input.wrong("an SH degree above 3"));
    }
    let coefficients = 3 * (degree as usize + 1).pow(2);
    let count = input.count(3 * 4 * (11 + coefficients))?;
    let steps = input.u64()?;
    let mut part = || -> Result<Gaussians, CheckpointError> {
        Ok(Gaussians {
            means: input.floats(3 * count)?.as_chunks().0.to_vec(),
            log_scales: input.floats(3 * count)?.as_chunks().0.to_vec(),
            rotations: input.floats(4 * count)?.as_chunks().0.to_vec(),
            logit_opacities: input.floats(count)?,
            sh_degree: degree as u8,
            sh: input.floats(count * coefficients)?,
        })
    };
    let (scene, first, second) = (part()?, part()?, part()?);
    Ok(Model { scene, adam: Adam { first, second, steps } })
}

fn write_state(out: &mut Out<'_>, state: &State) {
    write_model(out, &state.model);
    out.u32(state.iteration);
    out.u32(state.pruned);
    out.option(state.control.as_ref(), |out, memory| {
        out.f64(memory.lambda);
        out.option(memory.passing.as_ref(), |out, p| out.f64(*p));
        out.option(memory.margin_db.as_ref(), |out, m| out.f64(*m));
        out.u32(memory.calm);
    });
    out.option(state.best.as_ref(), |out, (model, check)| {
        write_model(out, model);
        write_check(out, check);
    });
    out.option(state.last.as_ref(), write_check);
    out.flag(state.settled);
}

fn read_state(input: &mut In<'_>) -> Result<State, CheckpointError> {
    Ok(State {
        model: read_model(input)?,
        iteration: input.u32()?,
        pruned: input.u32()?,
        control: input.option(|i| {
            Ok(Memory {
                lambda: i.f64()?,
                passing: i.option(In::f64)?,
                margin_db: i.option(In::f64)?,
                calm: i.u32()?,
            })
        })?,
        best: input.option(|i| Ok((read_model(i)?, read_check(i)?)))?,
        last: input.option(read_check)?,
        settled: input.flag()?,
    })
}

fn write_seen(out: &mut Out<'_>, seen: &Seen) {
    out.f64(seen.quality.psnr_db);
    out.f64(seen.quality.ssim);
    out.option(seen.quality.hvsq.as_ref(), |out, v| out.f64(*v));
    out.f64(seen.display_w);
}

fn read_seen(input: &mut In<'_>) -> Result<Seen, CheckpointError> {
    let (psnr_db, ssim) = (input.f64()?, input.f64()?);
    let quality = Quality { psnr_db, ssim, hvsq: input.option(In::f64)? };
    Ok(Seen { quality, display_w: input.f64()? })
}

fn write_check(out: &mut Out<'_>, check: &Check) {
    out.u32(check.iteration);
    write_seen(out, &check.seen);
    out.flag(check.passed);
    out.f64(check.lambda);
}

fn read_check(input: &mut In<'_>) -> Result<Check, CheckpointError> {
    Ok(Check {
        iteration: input.u32()?,
        seen: read_seen(input)?,
        passed: input.flag()?,
        lambda: input.f64()?,
    })
}

fn write_outcome(out: &mut Out<'_>, outcome: &Outcome) {
    out.text(&outcome.name);
    write_role(out, outcome.role);
    out.u32(u32::from(outcome.place.variant));
    out.u32(u32::from(outcome.place.level));
    out.f64(outcome.rho);
    out.u64(outcome.points as u64);
    out.u32(outcome.iterations);
    out.option(outcome.kept_at.as_ref(), |out, k| out.u32(*k));
    out.option(outcome.lambda.as_ref(), |out, l| out.f64(*l));
    out.option(outcome.passing_lambda.as_ref(), |out, l| out.f64(*l));
    write_seen(out, &outcome.gate);
    out.flag(outcome.passed);
    write_seen(out, &outcome.test);
    out.f64(outcome.flip_test);
    out.option(outcome.lpips_test.as_ref(), |out, v| out.f64(*v));
    out.f64(outcome.watts.render_w);
    out.f64(outcome.watts.display_w);
    outcome.watts.parts.0.iter().flatten().for_each(|w| out.f64(*w));
}

fn read_outcome(input: &mut In<'_>) -> Result<Outcome, CheckpointError> {
    Ok(Outcome {
        name: input.text()?,
        role: read_role(input)?,
        place: Place { variant: read_small(input)?, level: read_small(input)? },
        rho: input.f64()?,
        points: input.u64()? as usize,
        iterations: input.u32()?,
        kept_at: input.option(In::u32)?,
        lambda: input.option(In::f64)?,
        passing_lambda: input.option(In::f64)?,
        gate: read_seen(input)?,
        passed: input.flag()?,
        test: read_seen(input)?,
        flip_test: input.f64()?,
        lpips_test: input.option(In::f64)?,
        watts: read_watts(input)?,
    })
}

fn read_small(input: &mut In<'_>) -> Result<u8, CheckpointError> {
    u8::try_from(input.u32()?).map_err(|_| input.wrong("a place that there is not"))
}

fn read_watts(input: &mut In<'_>) -> Result<Watts, CheckpointError> {
    let (render_w, display_w) = (input.f64()?, input.f64()?);
    let mut parts = Parts::default();
    for part in parts.0.iter_mut().flatten() {
        *part = input.f64()?;
    }
    Ok(Watts { render_w, display_w, parts })
}

fn write_role(out: &mut Out<'_>, role: Role) {
    let (tag, number) = match role {
        Role::Dense => (0, 0.0),
        Role::Sample => (1, 0.0),
        Role::Final => (2, 0.0),
        Role::Baseline(Baseline::RenderOnly) => (3, 0.0),
        Role::Baseline(Baseline::DisplayOnly) => (4, 0.0),
        Role::Baseline(Baseline::LightGaussian(share)) => (5, share),
        Role::Baseline(Baseline::TwoStage) => (6, 0.0),
        Role::External(position) => (7, position as f64),
        Role::Sweep(lambda) => (8, lambda),
        Role::HeldOut => (9, 0.0),
    };
    out.u32(tag);
    out.f64(number);
}

fn read_role(input: &mut In<'_>) -> Result<Role, CheckpointError> {
    let (tag, number) = (input.u32()?, input.f64()?);
    Ok(match tag {
        0 => Role::Dense,
        1 => Role::Sample,
        2 => Role::Final,
        3 => Role::Baseline(Baseline::RenderOnly),
        4 => Role::Baseline(Baseline::DisplayOnly),
        5 => Role::Baseline(Baseline::LightGaussian(number)),
        6 => Role::Baseline(Baseline::TwoStage),
        7 => Role::External(number as usize),
        8 => Role::Sweep(number),
        9 => Role::HeldOut,
        _ => return Err(input.wrong("an unknown kind of job")),
    })
}
