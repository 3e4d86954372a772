//! A sweep, opened and checked: its file, its space, its traces.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use super::columns;
use super::confirm::CONFIRMED_MAX;
use super::hand_out::HandOut;
use super::noted::NotedFiles;
use super::request::{StandIn, SweepRequest};
use super::state::{FPS, State};
use super::traces::{self, SweepTrace, TraceRequest};
use crate::sweep::design::{Design, DesignPriced, Rejected};
use crate::sweep::file::{Method, SweepFile, TraceSpec};
use crate::sweep::key::MACHINE;
use crate::sweep::objective::Objective;
use crate::sweep::space::Space;
use crate::sweep::table::{Cell, Column, TraceLabel};
use powergs_base::budget::Budget;
use powergs_base::config::Problem;
use powergs_base::config::embedded::SWEEPS;
use powergs_base::config::knob;
use powergs_core::machine::DramModel;
use powergs_core::run::files::{ConfigText, DiskFiles, Files, found_as, raw};
use powergs_core::run::system::{DEVICE, ENERGY, doubts};
use powergs_core::run::{FileKind, Input, RunError};
use powergs_core::stage::EnergyTable;
use powergs_energy::table::PowerScope;
use toml::Value;

/// What a sweep file spans, and the base machine.
pub struct Designs {
    /// The points.
    pub space: Space,
    /// The base machine with the keys of `set`; the first design of the space where it does not
    /// fit together with them.
    pub base: Design,
    /// Why it is that.
    pub base_is_first: Option<String>,
    columns: Vec<Column>,
}

/// The key of a machine file that says its clock.
const CLOCK: &str = "clock";

/// Designs that are looked at for what they do not have in common.
const MIXED_TRIED: u64 = 48;

impl Designs {
    /// Checks a sweep file with the `problems` that its form has, and everything that it names.
    ///
    /// # Errors
    /// [`RunError::Config`]: everything that is wrong, with its lines; `origin` is what messages
    /// call the file.
    pub fn new(
        file: &SweepFile,
        problems: Vec<Problem>,
        files: &Arc<dyn Files>,
        origin: &str,
    ) -> Result<Designs, RunError> {
        let wrong = |e| RunError::config(origin, e);
        let space = Space::whole(file, problems, Arc::clone(files)).map_err(wrong)?;
        let mut alone = file.clone();
        alone.axes.clear();
        alone.derived = Default::default();
        alone.constraints.clear();
        let (base, base_is_first) = match Space::only_design(&alone, files) {
            Ok(base) => (base, None),
            // Keys of `set` may need those of an axis beside them.
            Err(reason) => {
                let mut points = 0..space.lattice().points().min(LOOK_MAX);
                let first = points.find_map(|index| space.design(index).ok());
                let none = || RunError::config(origin, format_args!("base machine: {reason}"));
                (first.ok_or_else(none)?, Some(reason))
            }
        };
        let columns = columns::kinds(&space);
        Ok(Designs { space, base, base_is_first, columns })
    }

    /// What the sweep file of a request spans, whatever traces it names.
    ///
    /// # Errors
    /// [`RunError::Config`]: everything that is wrong with the file.
    pub fn of_file(request: &SweepRequest) -> Result<Designs, RunError> {
        let (text, file, problems) = asked_file(request)?;
        let files: Arc<dyn Files> = Arc::new(DiskFiles);
        Designs::new(&file, problems, &files, &text.origin)
    }

    /// The design of a point; of `None` the base machine.
    ///
    /// # Errors
    /// Why it is none.
    pub fn design(&self, point: Option<u64>) -> Result<Design, Rejected> {
        point.map_or_else(|| Ok(self.base.clone()), |point| self.space.design(point))
    }

    /// Labels of the energy tables.
    pub fn tables(&self) -> Vec<String> {
        self.space.energy_labels().into_iter().map(str::to_owned).collect()
    }

    /// What is right in the base machine and in the energy tables, and doubtful, in sentences
    /// without their ends.
    pub fn doubts(&self) -> Vec<String> {
        let clock_varies = self.columns.iter().any(|column| column.name == CLOCK);
        let of = |priced: &DesignPriced| {
            let table = &priced.table.value;
            let fixed = table.fixed_clock().filter(|_| clock_varies).map(|own| {
                format!(
                    "energy table `{}`: its prices are for {own} and as given at any other clock \
                     (no `supply.curve`), and `{CLOCK}` varies: energy and power of slower designs \
                     are too high, those of faster ones too low",
                    table.name
                )
            });
            doubts(&self.base.machine, table).into_iter().chain(fixed)
        };
        let all: BTreeSet<String> = self.base.prices.iter().flat_map(of).collect();
        all.into_iter().chain(self.mixed()).collect()
    }

    /// What designs do not have in common without which no one is better than another: what a frame
    /// is, the node, what power is of.
    fn mixed(&self) -> Option<String> {
        let may_mix = |column: &Column| {
            column.name == MACHINE || column.name == ENERGY || column.name.starts_with("training.")
        };
        self.columns.iter().find(|column| may_mix(column))?;
        let points = self.space.lattice().points();
        let every = (points / MIXED_TRIED).max(1) as usize;
        let designs: Vec<Design> =
            (0..points).step_by(every).filter_map(|point| self.space.design(point).ok()).collect();
        let task = |d: &Design| vec![d.machine.flow().task(&d.machine).name()];
        let priced = |d: &Design, of: fn(&EnergyTable) -> String| {
            d.prices.iter().map(|priced| of(&priced.table.value)).collect::<Vec<_>>()
        };
        let node = |t: &EnergyTable| t.node.map_or("?".into(), |node| node.to_string());
        let scope = |t: &EnergyTable| {
            let power = t.scope.as_ref().map_or(PowerScope::BlockAndMemory, |scope| scope.power);
            power.name().replace('-', " ")
        };
        // Several tables price every design alike; what differs between designs is mixed.
        let differ = |what: &str, of: &dyn Fn(&Design) -> Vec<String>| {
            let all: BTreeSet<Vec<String>> = designs.iter().map(of).collect();
            let each: BTreeSet<String> = all.iter().flatten().cloned().collect();
            let each: Vec<String> = each.into_iter().collect();
            (all.len() > 1).then(|| format!("{what} ({})", each.join(", ")))
        };
        let mixed = [
            differ("what a frame is", &task),
            differ("technology nodes", &|d| priced(d, node)),
            differ("what power is of", &|d| priced(d, scope)),
        ];
        let mixed: Vec<String> = mixed.into_iter().flatten().collect();
        (!mixed.is_empty()).then(|| {
            format!(
                "designs differ in {}: they rank by that as much as by their machines; sweep those \
                 of one kind, or compare a few with `compare`",
                mixed.join(", in ")
            )
        })
    }

    /// The dataflow of its machines.
    pub fn flow(&self) -> &'static str {
        self.base.machine.flow().key()
    }

    /// The columns of the axes.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// How many of the columns, from the first on, are of axes; the others are of keys that follow
    /// from them.
    pub fn axis_columns(&self) -> usize {
        let first = self.space.columns().into_iter().nth(self.space.axis_columns().len());
        let place = first.and_then(|key| self.columns.iter().position(|c| c.name == key));
        place.unwrap_or(self.columns.len())
    }

    /// What a design has in the columns of the axes.
    pub fn cells(&self, point: Option<u64>) -> Vec<Cell> {
        match point {
            Some(point) => columns::cells(&self.space, point, &self.columns),
            None => columns::baseline_cells(&self.base, &self.columns),
        }
    }

    /// Whether points are asked for as results come in.
    pub fn is_adaptive(&self) -> bool {
        self.space.sampling().method == Method::Nsga2
    }
}

/// A sweep, ready to run.
pub struct OpenedSweep<'a> {
    /// Name for people and folders.
    pub name: String,
    /// The file.
    pub file: SweepFile,
    /// What it spans.
    pub designs: Designs,
    /// The traces.
    pub traces: Vec<SweepTrace<'a>>,
    /// What is wanted.
    pub objectives: Vec<Objective>,
    /// Everything that results depend on.
    pub state: State,
    /// Whether designs have the `calibrated` model of the DRAM in place of the base machine's
    /// `banked`.
    pub is_calibrated: bool,
    /// The same designs with the `banked` model, where they have `calibrated`.
    pub banked: Option<Designs>,
    /// What its designs are handed out with; none where it was built in memory.
    pub hand_out: Option<HandOut>,
}

impl OpenedSweep<'static> {
    /// Opens a sweep file by name or path, and everything that it names.
    ///
    /// # Errors
    /// [`RunError::Config`]: everything that is wrong with the file; [`RunError::Input`]: traces
    /// that cannot be read; [`RunError::Request`]: frames that they do not have.
    pub fn open(request: &SweepRequest) -> Result<OpenedSweep<'static>, RunError> {
        let name = request.file.as_str();
        let (text, mut file, problems) = asked_file(request)?;
        let files = NotedFiles::new(Arc::new(DiskFiles));
        let shared: Arc<dyn Files> = Arc::new(files.clone());
        let mut designs = Designs::new(&file, problems, &shared, &text.origin)?;
        // So few designs are not worth a model of the model.
        let most = designs.space.selected().size_hint().1.unwrap_or(usize::MAX);
        let stands_in = match request.stand_in {
            StandIn::Many => most > usize::from(CONFIRMED_MAX),
            StandIn::Always => true,
            StandIn::Never => false,
        };
        // Whoever names the model means that one. With a second master it is no faster.
        let is_calibrated = stands_in
            && designs.base.machine.dram.is_alone()
            && request.dram_model.is_none()
            && designs.base.machine.dram.model == DramModel::Banked
            && !file.text().contains(MODEL)
            && !request.sets.iter().any(|set| set.contains(MODEL));
        let mut banked = None;
        if is_calibrated {
            set(&mut file, MODEL, DramModel::Calibrated.name());
            banked = Some(designs);
            designs = Designs::new(&file, Vec::new(), &shared, &text.origin)?;
        } else if designs.base.machine.dram.model == DramModel::Calibrated
            && designs.columns().iter().all(|column| column.name != MODEL)
        {
            let mut file = file.clone();
            set(&mut file, MODEL, DramModel::Banked.name());
            banked = Some(Designs::new(&file, Vec::new(), &shared, &text.origin)?);
        }
        let traces = traces::open(&wanted(&file, request), request.frames)?;
        let folder = file.folder.clone();
        let hand_out = HandOut::new(request, &file, folder.as_deref(), &traces, is_calibrated);
        let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
        let mut asked: Vec<String> = request.sets.iter().map(|s| format!("--set {s}")).collect();
        asked.extend(request.points.map(|n| format!("--points {n}")));
        asked.extend(request.display_fps.map(|fps| format!("{FPS}{fps}")));
        asked.extend(request.display.iter().map(|name| format!("--display {name}")));
        asked.extend(request.dram_model.iter().map(|model| format!("--dram-model {model}")));
        asked.extend(is_calibrated.then(|| "calibrated in place of banked".to_owned()));
        let mut inputs = vec![Input::of_text("sweep", &text.origin, &text.text)];
        inputs.extend(files.inputs());
        let name = stem.into_owned();
        let sweep =
            OpenedSweep::assemble(name, &text.origin, file, designs, traces, asked, inputs)?;
        Ok(OpenedSweep { is_calibrated, banked, hand_out: Some(hand_out), ..sweep })
    }
}

impl<'a> OpenedSweep<'a> {
    /// Allows each frame so much memory.
    pub fn allow(&mut self, budget: Budget) {
        self.traces.iter_mut().for_each(|trace| trace.frames.allow(budget));
    }

    /// A sweep that was built in memory, on these frames.
    ///
    /// # Errors
    /// As [`OpenedSweep::open`].
    pub fn of(
        name: &str,
        file: SweepFile,
        files: Arc<dyn Files>,
        traces: Vec<SweepTrace<'a>>,
    ) -> Result<OpenedSweep<'a>, RunError> {
        let files = NotedFiles::new(files);
        let shared: Arc<dyn Files> = Arc::new(files.clone());
        let designs = Designs::new(&file, Vec::new(), &shared, name)?;
        let mut inputs = vec![Input::of_text("sweep", name, file.text())];
        inputs.extend(files.inputs());
        OpenedSweep::assemble(name.to_owned(), name, file, designs, traces, Vec::new(), inputs)
    }

    /// `asked` is what was asked for besides the sweep file, `inputs` what was read besides traces.
    fn assemble(
        name: String,
        origin: &str,
        file: SweepFile,
        designs: Designs,
        traces: Vec<SweepTrace<'a>>,
        mut asked: Vec<String>,
        mut inputs: Vec<Input>,
    ) -> Result<OpenedSweep<'a>, RunError> {
        if traces.is_empty() {
            let what = "no traces: name some with --traces, or in the sweep file ([[traces]])";
            return Err(RunError::config(origin, what));
        }
        let objectives = file.objectives.all();
        columns::check_objectives(&objectives, &designs.space, origin)?;
        for SweepTrace { frames, label, input, .. } in &traces {
            let (start, end) = (frames.range().start, frames.range().end);
            asked.push(format!("{} x {}: frames {start}..{end}", label.label, label.weight));
            inputs.push(input.clone());
        }
        let state = State::new(asked, &inputs);
        Ok(OpenedSweep {
            name,
            file,
            designs,
            traces,
            objectives,
            state,
            is_calibrated: false,
            banked: None,
            hand_out: None,
        })
    }

    /// What the table calls the traces, and their weights.
    pub fn labels(&self) -> Vec<TraceLabel> {
        self.traces.iter().map(|t| t.label.clone()).collect()
    }

    /// Frames of all traces.
    pub fn frames(&self) -> usize {
        self.traces.iter().map(|t| t.frames.range().len()).sum()
    }
}

/// Points among which a baseline is looked for.
const LOOK_MAX: u64 = 4096;

/// The key of the DRAM model.
pub(super) const MODEL: &str = "dram.model";

fn set(file: &mut SweepFile, key: &str, value: &str) {
    set_value(file, key, Value::String(value.to_owned()));
}

fn set_value(file: &mut SweepFile, key: &str, value: Value) {
    file.set.0.retain(|(known, _)| known != key);
    file.set.0.push((key.to_owned(), value));
}

/// The sweep file of a request as it was read, and as the request changes it, with what is wrong.
fn asked_file(request: &SweepRequest) -> Result<(ConfigText, SweepFile, Vec<Problem>), RunError> {
    let text = raw("sweep", &request.file, SWEEPS, None)?;
    let parsed = SweepFile::parse_around(&text.text);
    let (mut file, problems) = parsed.map_err(|e| RunError::config(&text.origin, e))?;
    lies_in(&mut file, text.folder.as_deref());
    change(&mut file, request)?;
    Ok((text, file, problems))
}

/// What a request changes in a sweep file.
fn change(file: &mut SweepFile, request: &SweepRequest) -> Result<(), RunError> {
    let folder = request.folder();
    let folder = folder.as_deref();
    for set in &request.sets {
        let (key, value) = set
            .split_once('=')
            .ok_or_else(|| RunError::Request(format!("--set {set}: write KEY=VALUE")))?;
        let (key, value) = (key.trim(), knob::written(value.trim()));
        set_value(file, key, typed(key, value, folder));
    }
    file.typed.clone_from(&request.sets);
    if let Some(model) = &request.dram_model {
        set(file, MODEL, model);
    }
    if let Some(points) = request.points {
        file.sampling.points = Some(points);
    }
    if let Some(fps) = request.display_fps {
        file.display_fps = fps;
    }
    if let Some(display) = &request.display {
        file.display = Some(found_as(FileKind::Display, display, folder));
    }
    Ok(())
}

/// A value that somebody typed in `folder`: a file that it names lies there, not beside the sweep
/// file.
fn typed(key: &str, value: Value, folder: Option<&Path>) -> Value {
    let kind = match key {
        MACHINE => FileKind::Machine,
        ENERGY => FileKind::Energy,
        DEVICE => FileKind::Dram,
        _ => return value,
    };
    match value.as_str() {
        Some(name) => found_as(kind, name, folder).into(),
        None => value,
    }
}

/// The files that a sweep file names lie in its folder.
pub fn lies_in(file: &mut SweepFile, folder: Option<&Path>) {
    file.base = found_as(FileKind::Machine, &file.base, folder);
    file.folder = folder.map(Path::to_path_buf);
}

fn wanted(file: &SweepFile, request: &SweepRequest) -> Vec<TraceRequest> {
    let of_file = |t: &TraceSpec| TraceRequest {
        pattern: t.path.clone(),
        folder: file.folder.clone(),
        label: t.label.clone(),
        weight: t.weight,
    };
    if request.traces.is_empty() {
        return file.traces.iter().map(of_file).collect();
    }
    let typed = |pattern: &String| TraceRequest {
        pattern: pattern.clone(),
        folder: None,
        label: None,
        weight: 1.0,
    };
    request.traces.iter().map(typed).collect()
}
