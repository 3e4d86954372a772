//! Frames through any number of machines.
//!
//! Each frame is prepared once for all machines that need the same of it; what else machines share
//! is in the memo of the frame. Machines that agree in all parameters of timing are timed once.
//! Frames and machines are simulated in parallel; results are handed on frame by frame, so that
//! they do not depend on the number of threads.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use powergs_base::budget::Budget;
use powergs_frame::display::Display;
use powergs_frame::scene::{Eye, ShDegree};
use powergs_frame::trace::{Frame, Preview};
use rayon::prelude::*;

use super::error::RunError;
use super::frames::Frames;
use super::observed::FrameOn;
use super::paper::PaperModel;
use super::system::System;
use super::watch::Watch;
use crate::flow::lists::work_key;
use crate::flow::{FrameTask, Handed, History, TakesOver, Work, WorkKey};
use crate::kernel::{Halt, Halted, Memo};
use crate::machine::Machine;
use crate::sim::{self, FrameReport, Label, Periods, Timed, paper, priced};
use crate::workload::{FrameWorkload, Geometry};

/// The model that a frame is simulated with.
#[derive(Debug, Clone, Copy)]
pub enum Target<'a> {
    /// The simulated machine.
    System(&'a System),
    /// The published closed-form model.
    Paper(&'a PaperModel),
}

/// A machine in a session.
#[derive(Debug, Clone)]
pub struct Subject<'a> {
    /// The machine.
    pub target: Target<'a>,
    /// Whether the order of the lists that it sorts is checked. That costs about as much as binning
    /// the frame, and changes no time and no energy.
    pub checks_order: bool,
    /// The positions of the frames that it is simulated on; `None`: all.
    pub only: Option<&'a [usize]>,
}

impl<'a> Subject<'a> {
    /// A machine on all frames, without the check of orders.
    pub fn of(system: &'a System) -> Subject<'a> {
        Subject { target: Target::System(system), checks_order: false, only: None }
    }

    /// The published model on all frames.
    pub fn paper(model: &'a PaperModel) -> Subject<'a> {
        Subject { target: Target::Paper(model), checks_order: false, only: None }
    }

    /// The same with the check of orders.
    pub fn checking_order(self) -> Subject<'a> {
        Subject { checks_order: true, ..self }
    }

    /// The same on some frames only, by position.
    pub fn only(self, positions: &'a [usize]) -> Subject<'a> {
        Subject { only: Some(positions), ..self }
    }

    fn machine(&self) -> Option<&'a Machine> {
        match self.target {
            Target::System(system) => Some(system.machine()),
            Target::Paper(_) => None,
        }
    }

    fn work(&self) -> WorkKey {
        match self.machine() {
            Some(machine) => machine.flow().work_key(machine),
            None => work_key(Geometry::REFERENCE),
        }
    }

    fn wants(&self, position: usize) -> bool {
        self.only.is_none_or(|positions| positions.contains(&position))
    }
}

/// A simulated frame on one machine. Of a pair of views the report is that of both, and the rest
/// belongs to the right eye.
pub struct FrameView<'a> {
    /// Position of the view in the list of frames.
    pub position: usize,
    /// The view as the machine sees it.
    pub work: &'a dyn Work,
    /// A small picture of it, where the trace has one.
    pub preview: Option<&'a Preview>,
    /// The report of the frame.
    pub report: FrameReport,
}

impl FrameView<'_> {
    /// Its lists of tiles; `None` where the dataflow has none.
    pub fn tiles(&self) -> Option<&FrameWorkload> {
        self.work.of()
    }
}

/// The result of [`Session::fold`].
#[derive(Debug)]
pub struct Folded<S> {
    /// One per subject, in their order.
    pub states: Vec<S>,
    /// Number of frames (pairs, where views are in pairs) that were simulated on all of their
    /// subjects.
    pub frames: usize,
    /// Whether these are all frames; not after a cancellation.
    pub is_complete: bool,
}

/// Frames prepared for one part fill so much of the memory on the first frame: others may take
/// more.
const ROOM_PERCENT: u64 = 70;

/// Frames, and who watches.
pub struct Session<'a> {
    frames: &'a mut dyn Frames,
    watch: &'a dyn Watch,
}

/// A frame, prepared.
pub struct BinnedFrame {
    /// Position in the list of frames.
    pub position: usize,
    /// Name of the view.
    pub name: String,
    /// The eye that sees it, where it is half of a pair.
    pub eye: Option<Eye>,
    /// Degree of the scene's spherical harmonics, where the trace says it.
    pub sh_degree: Option<ShDegree>,
    /// Mean linear colour of its image, where the trace has it.
    pub mean_linear_rgb: Option<[f64; 3]>,
    /// A small picture, where the trace has one.
    pub preview: Option<Preview>,
    /// By who shares it.
    pub bins: BTreeMap<WorkKey, Binned>,
}

/// A frame, prepared for all machines with a key.
pub struct Binned {
    /// The work.
    pub work: Box<dyn Work>,
    /// What machines that were simulated before have prepared further.
    pub memo: Memo,
    /// What the work and what is prepared further may take.
    budget: Budget,
}

impl BinnedFrame {
    /// Prepares a frame for some keys. The work of a key and what machines on it need may take
    /// `budget`.
    pub(crate) fn new(
        position: usize,
        frame: &Frame,
        keys: &[WorkKey],
        budget: Budget,
    ) -> BinnedFrame {
        let binned = |key: &WorkKey| {
            let work = key.prepare(frame);
            (key.clone(), Binned { work, memo: Memo::default(), budget })
        };
        BinnedFrame {
            position,
            name: frame.facts.camera.name.clone(),
            eye: frame.facts.camera.eye,
            sh_degree: frame.facts.sh_degree,
            mean_linear_rgb: frame.facts.mean_linear_rgb,
            preview: frame.preview.clone(),
            bins: keys.par_iter().map(binned).collect(),
        }
    }

    /// The frame on a machine with a key that it was prepared for.
    pub fn task<'a>(
        &'a self,
        machine: &'a Machine,
        key: &WorkKey,
        before: Option<&'a Handed>,
    ) -> FrameTask<'a> {
        let Binned { work, memo, budget } = &self.bins[key];
        let first = FrameTask::first(machine, &**work, memo);
        FrameTask { frame: self.position, before, budget: *budget, ..first }
    }

    /// The label of its report, with the power of the display that shows it.
    pub fn label(&self, display: Option<&Display>) -> Label {
        let shown = display.zip(self.mean_linear_rgb);
        Label {
            frame: self.position,
            name: self.name.clone(),
            eye: self.eye,
            sh_degree: self.sh_degree,
            display_w: shown.map(|(display, mean)| display.power(mean).0),
        }
    }

    /// Bytes of the prepared work in host memory.
    pub fn bytes(&self) -> usize {
        self.bins.values().map(|b| b.work.bytes()).sum()
    }
}

/// Memory that a frame takes when it is prepared for all of some keys, bytes.
///
/// # Errors
/// [`RunError::Input`]: more than `budget`.
pub(crate) fn bin_demand(
    name: &str,
    frame: &Frame,
    keys: &[WorkKey],
    budget: Budget,
) -> Result<u64, RunError> {
    let too_large = |e: &dyn std::fmt::Display| RunError::Input {
        place: name.to_owned(),
        message: format!("frame {}: {e}", frame.facts.camera.name),
    };
    let mut bytes = 0_u64;
    for key in keys {
        let more = key.demand(frame, budget).map_err(|e| too_large(&e))?;
        bytes = bytes.saturating_add(more);
    }
    if keys.len() > 1 {
        budget.check(bytes).map_err(|over| too_large(&over))?;
    }
    Ok(bytes)
}

/// Hands on from frame to frame what machines with the same history share.
struct Relay<'a> {
    key: TakesOver,
    machine: &'a Machine,
    history: History,
}

impl Relay<'_> {
    /// What is taken over into frames that come in order.
    fn next(&mut self, frames: &[BinnedFrame]) -> Vec<Option<Handed>> {
        let (machine, history) = (self.machine, &mut self.history);
        let frames = frames.iter().map(|frame| (frame.eye, &*frame.bins[&self.key.work].work));
        frames.map(|(eye, work)| machine.flow().hand_over(machine, work, eye, history)).collect()
    }
}

/// Subjects that share one timing.
struct SessionGroup {
    /// Places in the list of subjects.
    subjects: Vec<usize>,
    /// What they need of a frame.
    work: WorkKey,
    /// Place in the list of relays; machines for which each frame stands alone have none.
    relay: Option<usize>,
    checks_order: bool,
}

/// The reports of one frame on a group, with the places of their subjects.
type GroupReports = Vec<(usize, FrameReport)>;

/// The reports of one frame by subject; `None` where it was not wanted.
type Reports = Vec<Option<FrameReport>>;

impl<'a> Session<'a> {
    /// A session over `frames`.
    pub fn new(frames: &'a mut dyn Frames, watch: &'a dyn Watch) -> Session<'a> {
        Session { frames, watch }
    }

    /// Number of simulations (frames times machines): the final count of [`Watch::simulated`].
    pub fn steps(&self, subjects: &[Subject]) -> u64 {
        let of = |s: &Subject| self.frames.range().filter(|&k| s.wants(k)).count() as u64;
        subjects.iter().map(of).sum()
    }

    /// Simulates all frames on all subjects. Every subject has a state, made by `start`; `step`
    /// adds a frame to it, frame by frame in order; a pair of views is one frame
    /// ([`Frames::eyes`]).
    ///
    /// # Errors
    /// The first [`RunError`] in the order of frames and subjects. Results of earlier frames are
    /// not returned.
    pub fn fold<S: Send>(
        &mut self,
        subjects: &[Subject<'_>],
        start: impl Fn(usize) -> S,
        step: impl Fn(&mut S, FrameView<'_>) + Sync,
    ) -> Result<Folded<S>, RunError> {
        let parts = self.parts(subjects)?;
        let (range, eyes) = (self.frames.range(), self.frames.eyes());
        for machine in subjects.iter().filter_map(Subject::machine) {
            let frames = range.len() / eyes;
            machine
                .flow()
                .goes_over(machine, frames)
                .map_err(|why| RunError::Request(format!("{}: {why}", self.frames.name())))?;
        }
        self.watch.begins((range.len() * parts.len()) as u64, self.steps(subjects));
        let mut states: Vec<(usize, S)> = Vec::with_capacity(subjects.len());
        let mut done = 0;
        for part in &parts {
            let some: Vec<Subject> = part.iter().map(|&i| subjects[i].clone()).collect();
            let of_part: Vec<S> = part.iter().map(|&i| start(i)).collect();
            let (of_part, frames) = self.fold_part(&some, of_part, &step)?;
            states.extend(part.iter().copied().zip(of_part));
            done = frames;
        }
        // After a cancellation parts have seen different frames, and nothing can be compared.
        let is_complete = done == range.len();
        let done = if is_complete || parts.len() == 1 { done } else { 0 };
        states.sort_by_key(|(i, _)| *i);
        let states = states.into_iter().map(|(_, state)| state).collect();
        Ok(Folded { states, frames: done / eyes, is_complete })
    }

    /// Subjects whose work fits into memory together, by the first frame: frames are read anew
    /// for each part.
    fn parts(&mut self, subjects: &[Subject<'_>]) -> Result<Vec<Vec<usize>>, RunError> {
        let mut keys: BTreeMap<WorkKey, Vec<usize>> = BTreeMap::new();
        for (i, subject) in subjects.iter().enumerate() {
            keys.entry(subject.work()).or_default().push(i);
        }
        let all = || Ok(vec![(0..subjects.len()).collect()]);
        let range = self.frames.range();
        if keys.len() < 2 || range.is_empty() {
            return all();
        }
        let frame = self.frames.take(range.start)?.get()?;
        let budget = self.frames.budget();
        let most = budget.0.0 / 100 * ROOM_PERCENT;
        let mut parts: Vec<(u64, Vec<usize>)> = Vec::new();
        for (key, subjects) in keys {
            // One that does not fit by itself is told with its frame.
            let Ok(bytes) = key.demand(&frame, budget) else { return all() };
            match parts.last_mut().filter(|(sum, _)| sum + bytes <= most) {
                Some((sum, part)) => {
                    *sum += bytes;
                    part.extend(subjects);
                }
                None => parts.push((bytes, subjects)),
            }
        }
        Ok(parts.into_iter().map(|(_, part)| part).collect())
    }

    /// All frames on subjects that fit into memory together: their states, and how many frames were
    /// done.
    fn fold_part<S: Send>(
        &mut self,
        subjects: &[Subject<'_>],
        states: Vec<S>,
        step: &(impl Fn(&mut S, FrameView<'_>) + Sync),
    ) -> Result<(Vec<S>, usize), RunError> {
        let mut plan = SessionPlan::new(subjects);
        let eyes = self.frames.eyes();
        let state = |of_subject| State { of_subject, periods: Periods::default(), eyes };
        let mut states: Vec<State<S>> = states.into_iter().map(state).collect();
        let range = self.frames.range();
        let threads = rayon::current_num_threads().max(1);
        let width = (2 * threads).div_ceil(plan.groups.len().max(1)).clamp(1, threads);
        let (mut position, mut done, mut together) = (range.start, 0, width);
        while position < range.end && !self.watch.is_cancelled() {
            let end = (position + together).min(range.end);
            let window = self.window(position, end, &plan.keys)?;
            // What did not fit is decoded again; the next time fewer are tried at once.
            together = if window.len() < end - position { window.len() } else { width };
            let end = position + window.len();
            let handed = plan.hand_over(&window);
            let reports = self.simulate(subjects, &plan, &window, &handed)?;
            for (frame, reports) in window.iter().zip(reports) {
                let Some(reports) = reports else { break };
                plan.step(frame, reports, &mut states, step);
                done += 1;
                self.watch.frame_done();
            }
            position = end;
        }
        Ok((states.into_iter().map(|state| state.of_subject).collect(), done))
    }

    /// The reports of all frames on each of some systems.
    ///
    /// # Errors
    /// As [`Session::fold`].
    pub fn reports(&mut self, systems: &[System]) -> Result<Vec<Vec<FrameReport>>, RunError> {
        let subjects: Vec<Subject> = systems.iter().map(Subject::of).collect();
        let folded = self.fold(&subjects, |_| Vec::new(), |all, view| all.push(view.report))?;
        Ok(folded.states)
    }

    /// A frame as a machine finds it in the course of the trace: with the order of the previous
    /// frame, where the machine reuses it.
    ///
    /// # Errors
    /// [`RunError`]: a frame that cannot be read, or that the machine cannot run.
    pub fn frame_on<'s>(
        &mut self,
        system: &'s System,
        position: usize,
    ) -> Result<FrameOn<'s>, RunError> {
        let machine = system.machine();
        let flow = machine.flow();
        let first = match flow.takes_over(machine) {
            None => position,
            Some(_) => self.frames.range().start,
        };
        let key = [flow.work_key(machine)];
        let (budget, mut history) = (self.frames.budget(), History::default());
        let mut last = None;
        for k in first..=position {
            let frame = self.frames.take(k)?.get()?;
            bin_demand(self.frames.name(), &frame, &key, budget)?;
            let (work, memo) = (key[0].prepare(&frame), Memo::default());
            flow.fits(&FrameTask { budget, ..FrameTask::first(machine, &*work, &memo) })
                .map_err(|e| RunError::in_frame(&frame.facts.camera.name, e.into()))?;
            let before = flow.hand_over(machine, &*work, frame.facts.camera.eye, &mut history);
            last = Some(FrameOn { machine, work, before, memo });
        }
        last.ok_or_else(|| RunError::Request(format!("there is no frame {position}")))
    }

    /// Frames from `start` to at most `end`, decoded and prepared in parallel: as many as the
    /// budget of the frames allows at a time, one at least.
    fn window(
        &mut self,
        start: usize,
        end: usize,
        keys: &[WorkKey],
    ) -> Result<Vec<BinnedFrame>, RunError> {
        let (budget, mut bytes) = (self.frames.budget(), 0_u64);
        let mut pending = Vec::new();
        for k in start..end {
            let frame = self.frames.take(k);
            bytes = bytes.saturating_add(frame.as_ref().map_or(0, |frame| frame.bytes));
            if !pending.is_empty() && budget.check(bytes).is_err() {
                break;
            }
            pending.push(frame);
        }
        let name = self.frames.name();
        let decoded = |pending: Result<super::Pending, RunError>| {
            let frame: Arc<Frame> = pending?.get()?;
            let bytes = bin_demand(name, &frame, keys, budget)?;
            Ok((frame, bytes))
        };
        let mut decoded: Vec<Result<(Arc<Frame>, u64), RunError>> =
            pending.into_par_iter().map(decoded).collect();
        bytes = 0;
        let fits = |frame: &Result<(Arc<Frame>, u64), RunError>| {
            bytes = bytes.saturating_add(frame.as_ref().map_or(0, |(_, bytes)| *bytes));
            budget.check(bytes).is_ok()
        };
        let many = decoded.iter().map(fits).take_while(|fits| *fits).count().max(1);
        decoded.truncate(many);
        let frames = decoded.into_iter().map(|frame| Ok(frame?.0));
        let frames: Vec<Arc<Frame>> = frames.collect::<Result<_, RunError>>()?;
        let binned =
            |(i, frame): (usize, Arc<Frame>)| BinnedFrame::new(start + i, &frame, keys, budget);
        Ok(frames.into_par_iter().enumerate().map(binned).collect())
    }

    /// The reports of the frames of a window; `None` from the first frame on that was not finished
    /// because the run was cancelled.
    fn simulate(
        &self,
        subjects: &[Subject<'_>],
        plan: &SessionPlan<'_>,
        window: &[BinnedFrame],
        handed: &[Vec<Option<Handed>>],
    ) -> Result<Vec<Option<Reports>>, RunError> {
        let pairs: Vec<(usize, usize)> =
            (0..window.len()).flat_map(|k| (0..plan.groups.len()).map(move |g| (k, g))).collect();
        let one = |&(k, g): &(usize, usize)| {
            if self.watch.is_cancelled() {
                return Ok(None);
            }
            let group = &plan.groups[g];
            let frame = &window[k];
            let before = group.relay.and_then(|relay| handed[relay][k].as_ref());
            let is_due = || self.watch.is_cancelled();
            let halt = Halt::when(&is_due);
            let Some(reports) = on_group(subjects, group, frame, before, halt)? else {
                return Ok(None);
            };
            self.watch.simulated(reports.len() as u64);
            Ok(Some(reports))
        };
        let all: Vec<Result<Option<GroupReports>, RunError>> = pairs.par_iter().map(one).collect();
        let mut frames: Vec<Option<Reports>> =
            window.iter().map(|_| Some(vec![None; subjects.len()])).collect();
        for (&(k, _), reports) in pairs.iter().zip(all) {
            match (reports?, &mut frames[k]) {
                (Some(reports), Some(frame)) => {
                    reports.into_iter().for_each(|(i, report)| frame[i] = Some(report));
                }
                (_, frame) => *frame = None,
            }
        }
        Ok(frames)
    }
}

/// A frame on all machines of a group that want it: timed once, priced for each; `None` where it
/// was not wanted any more.
fn on_group(
    subjects: &[Subject<'_>],
    group: &SessionGroup,
    frame: &BinnedFrame,
    before: Option<&Handed>,
    halt: Halt<'_>,
) -> Result<Option<GroupReports>, RunError> {
    let wanted = group.subjects.iter().copied().filter(|&i| subjects[i].wants(frame.position));
    let mut timed: Option<Timed> = None;
    let mut reports = Vec::new();
    for i in wanted {
        let report = match subjects[i].target {
            Target::System(system) => {
                let timed = match &timed {
                    Some(timed) => timed,
                    None => {
                        let task = frame.task(system.machine(), &group.work, before);
                        let task = FrameTask { checks_order: group.checks_order, halt, ..task };
                        let Some(found) = time(&frame.name, &task)? else { return Ok(None) };
                        timed.insert(found)
                    }
                };
                priced(frame.label(system.display()), timed, system.prices())
                    .map_err(|e| RunError::in_frame(&frame.name, e.into()))?
            }
            Target::Paper(model) => {
                let workload = frame.bins[&group.work].work.of();
                let workload = workload.expect("the published model counts tiles");
                let label = frame.label(model.display.as_ref());
                paper::simulate(label, workload, model.padding, &model.prices)
            }
        };
        reports.push((i, report));
    }
    Ok(Some(reports))
}

/// Times a frame on a machine; a panic is a defect that ends this run and no other. `None` where
/// the frame was not wanted any more.
///
/// # Errors
/// [`RunError::Incompatible`]: the machine cannot run the frame; otherwise a defect.
pub fn time(name: &str, task: &FrameTask<'_>) -> Result<Option<Timed>, RunError> {
    match catch_unwind(AssertUnwindSafe(|| sim::time(task))) {
        Ok(timed) => timed.map(Some).map_err(|e| RunError::in_frame(name, e)),
        Err(end) if end.is::<Halted>() => Ok(None),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().copied();
            let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
            let text = text.unwrap_or("it says no more");
            Err(RunError::Internal(format!("frame {name}: {text}")))
        }
    }
}

/// What is kept of a subject, and the left eye whose right one comes next.
struct State<S> {
    of_subject: S,
    periods: Periods,
    /// Views that make a frame.
    eyes: usize,
}

/// Who is prepared and timed together.
struct SessionPlan<'a> {
    keys: Vec<WorkKey>,
    relays: Vec<Relay<'a>>,
    groups: Vec<SessionGroup>,
    /// By subject, the place of its group.
    of_subject: Vec<usize>,
}

impl<'a> SessionPlan<'a> {
    fn new(subjects: &[Subject<'a>]) -> SessionPlan<'a> {
        let mut keys: Vec<WorkKey> = subjects.iter().map(Subject::work).collect();
        keys.sort();
        keys.dedup();
        let mut relays: Vec<Relay> = Vec::new();
        let mut by_timing: BTreeMap<_, usize> = BTreeMap::new();
        let mut groups: Vec<SessionGroup> = Vec::new();
        let mut of_subject = Vec::with_capacity(subjects.len());
        for (i, subject) in subjects.iter().enumerate() {
            let (work, checks_order) = (subject.work(), subject.checks_order);
            let (mut relay, mut place) = (None, groups.len());
            if let Target::System(system) = subject.target {
                let machine = system.machine();
                relay = TakesOver::of(machine).map(|key| {
                    let known = relays.iter().position(|relay| relay.key == key);
                    known.unwrap_or_else(|| {
                        relays.push(Relay { key, machine, history: History::default() });
                        relays.len() - 1
                    })
                });
                place = *by_timing.entry((system.timing_id(), checks_order)).or_insert(place);
            }
            if place == groups.len() {
                groups.push(SessionGroup { subjects: Vec::new(), work, relay, checks_order });
            }
            groups[place].subjects.push(i);
            of_subject.push(place);
        }
        SessionPlan { keys, relays, groups, of_subject }
    }

    /// By relay, by frame of the window.
    fn hand_over(&mut self, window: &[BinnedFrame]) -> Vec<Vec<Option<Handed>>> {
        self.relays.par_iter_mut().map(|relay| relay.next(window)).collect()
    }

    /// Adds a frame to the states of all subjects.
    fn step<S: Send>(
        &self,
        frame: &BinnedFrame,
        reports: Reports,
        states: &mut [State<S>],
        step: &(impl Fn(&mut S, FrameView<'_>) + Sync),
    ) {
        let jobs = states.par_iter_mut().zip(reports).zip(&self.of_subject);
        jobs.for_each(|((state, report), &group)| {
            let report = report.and_then(|report| state.periods.add(report, state.eyes));
            let Some(report) = report else { return };
            let work = &*frame.bins[&self.groups[group].work].work;
            let preview = frame.preview.as_ref();
            step(
                &mut state.of_subject,
                FrameView { position: frame.position, work, preview, report },
            );
        });
    }
}
