//! Frames through any number of machines.
//!
//! Each frame is binned once per geometry. Cache hits, the order of the lists and the reuse of the
//! previous order are measured once for all machines that agree in the parameters. Machines that
//! agree in all parameters of timing are timed once. Frames and machines are simulated in parallel;
//! results are handed on frame by frame, so that they do not depend on the number of threads.

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
use crate::flow::tile_wise::Memo;
use crate::flow::tile_wise::{CacheSpec, DepthKey, PivotRule, TileOrder};
use crate::machine::Machine;
use crate::sim::{
    FrameReport, Incompatible, Label, Lists, Measured, Periods, Timed, check, paper, priced,
    time_again,
};
use crate::workload::demand::demand;
use crate::workload::{FrameWorkload, Geometry, bin, binning};

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

    fn geometry(&self) -> Geometry {
        self.machine().map_or(Geometry::REFERENCE, |machine| machine.tiles().geometry)
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
    pub workload: &'a FrameWorkload,
    /// Cache hits and order of its lists.
    pub measured: &'a Measured,
    /// A small picture of it, where the trace has one.
    pub preview: Option<&'a Preview>,
    /// The report of the frame.
    pub report: FrameReport,
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

/// Geometries of one part fill so much of the memory on the first frame: others may take more.
const ROOM_PERCENT: u64 = 70;

/// Frames, and who watches.
pub struct Session<'a> {
    frames: &'a mut dyn Frames,
    watch: &'a dyn Watch,
}

/// A frame, binned.
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
    /// By geometry.
    pub bins: BTreeMap<Geometry, Binned>,
}

/// A frame under one geometry.
pub struct Binned {
    /// The work.
    pub workload: FrameWorkload,
    /// Its preprocessing on machines that were simulated before.
    pub memo: Memo,
    /// What the workload and its lists may take.
    budget: Budget,
}

impl BinnedFrame {
    /// Bins a frame for some geometries. A geometry and what machines on it need may take
    /// `budget`.
    pub(crate) fn new(
        position: usize,
        frame: &Frame,
        geometries: &[Geometry],
        budget: Budget,
    ) -> BinnedFrame {
        let binned = |&geometry: &Geometry| {
            (geometry, Binned { workload: bin(frame, geometry), memo: Memo::default(), budget })
        };
        BinnedFrame {
            position,
            name: frame.facts.camera.name.clone(),
            eye: frame.facts.camera.eye,
            sh_degree: frame.facts.sh_degree,
            mean_linear_rgb: frame.facts.mean_linear_rgb,
            preview: frame.preview.clone(),
            bins: geometries.par_iter().map(binned).collect(),
        }
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

    /// Bytes of the binned workloads in host memory.
    pub fn bytes(&self) -> usize {
        self.bins.values().map(|b| b.workload.bytes()).sum()
    }
}

/// Memory that a frame takes when it is binned for all of some geometries, bytes.
///
/// # Errors
/// [`RunError::Input`]: more than `budget`.
pub(crate) fn bin_demand(
    name: &str,
    frame: &Frame,
    geometries: &[Geometry],
    budget: Budget,
) -> Result<u64, RunError> {
    let too_large = |e: &dyn std::fmt::Display| RunError::Input {
        place: name.to_owned(),
        message: format!("frame {}: {e}", frame.facts.camera.name),
    };
    let mut bytes = 0_u64;
    for &geometry in geometries {
        let more = demand(frame, geometry, budget).map_err(|e| too_large(&e))?;
        bytes = bytes.saturating_add(more);
    }
    if geometries.len() > 1 {
        budget.check(bytes).map_err(|over| too_large(&over))?;
    }
    Ok(bytes)
}

/// The parameters that measurements of a frame depend on.
#[derive(Debug, Clone, PartialEq)]
struct MeasureKey {
    geometry: Geometry,
    /// The cache, the pitch of its records and the order of tiles, where there is a cache.
    cache: Option<(CacheSpec, u64, TileOrder)>,
    reuse_period: u32,
    /// The key and the pivots of the sorter, where its order is checked.
    sorter: Option<(DepthKey, u32, PivotRule)>,
}

impl MeasureKey {
    fn of(subject: &Subject) -> Option<MeasureKey> {
        let machine = subject.machine()?;
        let has_cache = machine.tiles().cache.ways > 0;
        let gsu = &machine.tiles().gsu;
        Some(MeasureKey {
            geometry: machine.tiles().geometry,
            cache: has_cache.then(|| {
                let pitch = machine.tiles().record.feature_pitch.0;
                (machine.tiles().cache.clone(), pitch, machine.tiles().schedule.order)
            }),
            reuse_period: gsu.reuse_period,
            sorter: subject.checks_order.then_some((gsu.depth, gsu.pivots, gsu.pivot_rule)),
        })
    }
}

/// Measures frames for one set of parameters, with the lists of the previous frame.
struct Measurer<'a> {
    key: MeasureKey,
    machine: &'a Machine,
    checks_order: bool,
    lists: Lists,
}

impl Measurer<'_> {
    /// Measures frames that come in order.
    fn next(&mut self, frames: &[BinnedFrame]) -> Vec<Measured> {
        let machine = self.machine;
        let (lists, checks_order) = (&mut self.lists, self.checks_order);
        let views = frames.iter().map(|f| (f.eye, &f.bins[&machine.tiles().geometry].workload));
        if self.key.reuse_period > 1 {
            let next = |(eye, w)| Measured::of(w, eye, machine, lists, checks_order);
            return views.map(next).collect();
        }
        let workloads: Vec<&FrameWorkload> = views.map(|(_, workload)| workload).collect();
        workloads.par_iter().map(|w| Measured::first(w, machine, checks_order)).collect()
    }
}

/// Subjects that share one timing.
struct SessionGroup {
    /// Places in the list of subjects.
    subjects: Vec<usize>,
    /// Place in the list of measurers; the `paper` model has none.
    measurer: Option<usize>,
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

    /// Subjects whose geometries fit into memory together, by the first frame: frames are read anew
    /// for each part.
    fn parts(&mut self, subjects: &[Subject<'_>]) -> Result<Vec<Vec<usize>>, RunError> {
        let mut geometries: BTreeMap<Geometry, Vec<usize>> = BTreeMap::new();
        for (i, subject) in subjects.iter().enumerate() {
            geometries.entry(subject.geometry()).or_default().push(i);
        }
        let all = || Ok(vec![(0..subjects.len()).collect()]);
        let range = self.frames.range();
        if geometries.len() < 2 || range.is_empty() {
            return all();
        }
        let frame = self.frames.take(range.start)?.get()?;
        let budget = self.frames.budget();
        let most = budget.0.0 / 100 * ROOM_PERCENT;
        let mut parts: Vec<(u64, Vec<usize>)> = Vec::new();
        for (geometry, subjects) in geometries {
            // One that does not fit by itself is told with its frame.
            let Ok(bytes) = demand(&frame, geometry, budget) else { return all() };
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
            let window = self.window(position, end, &plan.geometries)?;
            // What did not fit is decoded again; the next time fewer are tried at once.
            together = if window.len() < end - position { window.len() } else { width };
            let end = position + window.len();
            let measured = plan.measure(&window);
            let reports = self.simulate(subjects, &plan, &window, &measured)?;
            for (k, (frame, reports)) in window.iter().zip(reports).enumerate() {
                let Some(reports) = reports else { break };
                plan.step(subjects, frame, &measured, k, reports, &mut states, step);
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
        let first = match machine.tiles().gsu.reuse_period {
            0 | 1 => position,
            _ => self.frames.range().start,
        };
        let mut lists = Lists::default();
        let mut last = None;
        for k in first..=position {
            let frame = self.frames.take(k)?.get()?;
            let geometry = [machine.tiles().geometry];
            bin_demand(self.frames.name(), &frame, &geometry, self.frames.budget())?;
            let workload = bin(&frame, machine.tiles().geometry);
            let name = &frame.facts.camera.name;
            check::fits(&workload, machine).map_err(|e| RunError::in_frame(name, e.into()))?;
            lists_fit(&workload, machine, &Memo::default(), self.frames.budget())
                .map_err(|e| RunError::in_frame(name, e.into()))?;
            let eye = frame.facts.camera.eye;
            let measured = Measured::of(&workload, eye, machine, &mut lists, false);
            last = Some(FrameOn { machine, workload, measured });
        }
        last.ok_or_else(|| RunError::Request(format!("there is no frame {position}")))
    }

    /// Frames from `start` to at most `end`, decoded and binned in parallel: as many as the budget
    /// of the frames allows at a time, one at least.
    fn window(
        &mut self,
        start: usize,
        end: usize,
        geometries: &[Geometry],
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
            let bytes = bin_demand(name, &frame, geometries, budget)?;
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
        let binned = |(i, frame): (usize, Arc<Frame>)| {
            BinnedFrame::new(start + i, &frame, geometries, budget)
        };
        Ok(frames.into_par_iter().enumerate().map(binned).collect())
    }

    /// The reports of the frames of a window; `None` from the first frame on that was not finished
    /// because the run was cancelled.
    fn simulate(
        &self,
        subjects: &[Subject<'_>],
        plan: &SessionPlan<'_>,
        window: &[BinnedFrame],
        measured: &[Vec<Measured>],
    ) -> Result<Vec<Option<Reports>>, RunError> {
        let pairs: Vec<(usize, usize)> =
            (0..window.len()).flat_map(|k| (0..plan.groups.len()).map(move |g| (k, g))).collect();
        let one = |&(k, g): &(usize, usize)| {
            if self.watch.is_cancelled() {
                return Ok(None);
            }
            let group = &plan.groups[g];
            let frame = &window[k];
            let measured = group.measurer.map(|m| &measured[m][k]);
            let reports = on_group(subjects, group, frame, measured)?;
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

/// A frame on all machines of a group that want it: timed once, priced for each.
fn on_group(
    subjects: &[Subject<'_>],
    group: &SessionGroup,
    frame: &BinnedFrame,
    measured: Option<&Measured>,
) -> Result<GroupReports, RunError> {
    let wanted = group.subjects.iter().copied().filter(|&i| subjects[i].wants(frame.position));
    let mut timed: Option<Timed> = None;
    let mut reports = Vec::new();
    for i in wanted {
        let report = match (subjects[i].target, measured) {
            (Target::System(system), Some(measured)) => {
                let timed = match &timed {
                    Some(timed) => timed,
                    None => timed.insert(time(system.machine(), frame, measured)?),
                };
                priced(frame.label(system.display()), timed, system.prices())
                    .map_err(|e| RunError::in_frame(&frame.name, e.into()))?
            }
            (Target::Paper(model), _) => {
                let workload = &frame.bins[&Geometry::REFERENCE].workload;
                let label = frame.label(model.display.as_ref());
                paper::simulate(label, workload, model.padding, &model.prices)
            }
            (Target::System(_), None) => unreachable!("every machine has a measurer"),
        };
        reports.push((i, report));
    }
    Ok(reports)
}

/// Times a binned frame on a machine; a panic is a defect that ends this run and no other.
///
/// # Errors
/// [`RunError::Incompatible`]: the machine cannot run the frame; otherwise a defect.
pub fn time(
    machine: &Machine,
    frame: &BinnedFrame,
    measured: &Measured,
) -> Result<Timed, RunError> {
    let binned = &frame.bins[&machine.tiles().geometry];
    lists_fit(&binned.workload, machine, &binned.memo, binned.budget)
        .map_err(|e| RunError::in_frame(&frame.name, e.into()))?;
    let run = || time_again(frame.position, &binned.workload, measured, machine, &binned.memo);
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(timed) => timed.map_err(|e| RunError::in_frame(&frame.name, e)),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().copied();
            let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
            let text = text.unwrap_or("it says no more");
            Err(RunError::Internal(format!("frame {}: {text}", frame.name)))
        }
    }
}

/// Whether what a machine does to make the lists of a frame fits into host memory.
fn lists_fit(
    workload: &FrameWorkload,
    machine: &Machine,
    memo: &Memo,
    budget: Budget,
) -> Result<(), Incompatible> {
    let Some(shape) = machine.tiles().list_shape().filter(|shape| !memo.has_lists(shape)) else {
        return Ok(());
    };
    match binning::demand(workload, &shape, budget) {
        Ok(_) => Ok(()),
        Err(over) => Err(Incompatible::Lists { machine: machine.name.clone(), over }),
    }
}

/// What is kept of a subject, and the left eye whose right one comes next.
struct State<S> {
    of_subject: S,
    periods: Periods,
    /// Views that make a frame.
    eyes: usize,
}

/// Who is binned, measured and timed together.
struct SessionPlan<'a> {
    geometries: Vec<Geometry>,
    measurers: Vec<Measurer<'a>>,
    groups: Vec<SessionGroup>,
}

impl<'a> SessionPlan<'a> {
    fn new(subjects: &[Subject<'a>]) -> SessionPlan<'a> {
        let mut geometries: Vec<Geometry> = subjects.iter().map(Subject::geometry).collect();
        geometries.sort();
        geometries.dedup();
        let mut measurers: Vec<Measurer> = Vec::new();
        let mut by_timing: BTreeMap<(u128, usize), usize> = BTreeMap::new();
        let mut groups: Vec<SessionGroup> = Vec::new();
        for (i, subject) in subjects.iter().enumerate() {
            let Some(key) = MeasureKey::of(subject) else {
                groups.push(SessionGroup { subjects: vec![i], measurer: None });
                continue;
            };
            let known = measurers.iter().position(|m| m.key == key);
            let measurer = known.unwrap_or_else(|| {
                measurers.push(Measurer {
                    key,
                    machine: subject.machine().expect("it has a key"),
                    checks_order: subject.checks_order,
                    lists: Lists::default(),
                });
                measurers.len() - 1
            });
            let Target::System(system) = subject.target else { continue };
            let place = *by_timing.entry((system.timing_id(), measurer)).or_insert(groups.len());
            if place == groups.len() {
                groups.push(SessionGroup { subjects: Vec::new(), measurer: Some(measurer) });
            }
            groups[place].subjects.push(i);
        }
        SessionPlan { geometries, measurers, groups }
    }

    /// By measurer, by frame of the window.
    fn measure(&mut self, window: &[BinnedFrame]) -> Vec<Vec<Measured>> {
        self.measurers.par_iter_mut().map(|m| m.next(window)).collect()
    }

    /// Adds a frame to the states of all subjects.
    fn step<S: Send>(
        &self,
        subjects: &[Subject<'_>],
        frame: &BinnedFrame,
        measured: &[Vec<Measured>],
        k: usize,
        reports: Reports,
        states: &mut [State<S>],
        step: &(impl Fn(&mut S, FrameView<'_>) + Sync),
    ) {
        let nothing = Measured::default();
        let mut of_subject: Vec<&Measured> = vec![&nothing; subjects.len()];
        for group in &self.groups {
            let Some(m) = group.measurer else { continue };
            group.subjects.iter().for_each(|&i| of_subject[i] = &measured[m][k]);
        }
        let jobs = states.par_iter_mut().zip(reports).zip(subjects).zip(of_subject);
        jobs.for_each(|(((state, report), subject), measured)| {
            let report = report.and_then(|report| state.periods.add(report, state.eyes));
            let Some(report) = report else { return };
            let workload = &frame.bins[&subject.geometry()].workload;
            let preview = frame.preview.as_ref();
            step(
                &mut state.of_subject,
                FrameView { position: frame.position, workload, measured, preview, report },
            );
        });
    }
}
