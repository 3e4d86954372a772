//! A sweep, opened and checked: its file, its space, its traces.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::Definition;
use super::columns;
use super::files::DiskFiles;
use super::state::State;
use super::traces::{self, OpenedTrace, Wanted};
use crate::cli::failure::ConfigUsage;
use crate::cli::{Exit, Failure, OrExit};
use powergs_base::config::embedded::SWEEPS;
use powergs_core::run::files::read;
use powergs_core::run::{ConfigText, Frames, Input};
use powergs_study::sweep::design::{Design, Rejected};
use powergs_study::sweep::file::{Method, SweepFile, TraceSpec};
use powergs_study::sweep::space::Space;
use powergs_study::sweep::table::{Cell, Column};

/// Something that is to be small or large.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Objective {
    /// A column of the table.
    pub column: String,
    /// Whether it is to be large.
    pub maximize: bool,
}

/// A sweep, ready to run.
pub struct Opened {
    /// Name for people and folders.
    pub name: String,
    /// The file.
    pub file: SweepFile,
    /// What it spans.
    pub space: Space,
    /// The base machine alone.
    pub base: Design,
    /// The traces.
    pub traces: Vec<OpenedTrace>,
    /// Frames per second of the display.
    pub display_fps: f64,
    /// What is wanted.
    pub objectives: Vec<Objective>,
    /// The columns of the axes.
    columns: Vec<Column>,
    /// Everything that results depend on.
    pub state: State,
}

impl Opened {
    /// Opens a sweep file by name or path, and everything that it names.
    ///
    /// # Errors
    /// Exit code 2: everything that is wrong with the file; 3: traces that cannot be read.
    pub fn open(definition: &Definition) -> Result<Opened, Failure> {
        let name = definition.file.as_deref().unwrap_or_default();
        let text = read("sweep", name, SWEEPS, None)?;
        let mut file = SweepFile::parse(&text.text).usage(&text.origin)?;
        change(&mut file, definition, &text)?;
        let disk = DiskFiles::default();
        let space = Space::new(&file, Arc::new(disk.clone())).usage(&text.origin)?;
        let base = base(&file, &disk, &text.origin)?;
        let traces =
            traces::open(&wanted(&file, definition), text.folder.as_deref(), definition.frames)?;
        if traces.is_empty() {
            let what = "no traces: name some with --traces, or in the sweep file ([[traces]])";
            return Err(Failure::new(Exit::Usage, format!("{}: {what}", text.origin)));
        }
        let objectives = objectives(&file);
        columns::check_objectives(&objectives, &space, &text.origin)?;
        let mut inputs = vec![Input::of_text("sweep", &text.origin, &text.text)];
        inputs.extend(disk.inputs());
        inputs.extend(traces.iter().map(|t| t.source.input().clone()));
        let state = State::new(options(definition, &traces), &inputs);
        let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let columns = columns::kinds(&space);
        let display_fps = file.display_fps;
        Ok(Opened {
            name: stem,
            file,
            space,
            base,
            traces,
            display_fps,
            objectives,
            columns,
            state,
        })
    }

    /// The base machine alone.
    pub fn baseline(&self) -> Design {
        self.base.clone()
    }

    /// The design of a point, or the baseline.
    ///
    /// # Errors
    /// Why it is none.
    pub fn design(&self, point: Option<u64>) -> Result<Design, Rejected> {
        point.map_or_else(|| Ok(self.baseline()), |point| self.space.design(point))
    }

    /// Labels of the energy tables.
    pub fn tables(&self) -> Vec<String> {
        self.space.energy_labels().into_iter().map(str::to_owned).collect()
    }

    /// The columns of the axes.
    pub fn axis_columns(&self) -> &[Column] {
        &self.columns
    }

    /// What a design has in the columns of the axes.
    pub fn axis_cells(&self, point: Option<u64>) -> Vec<Cell> {
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

/// What the command line changes.
fn change(file: &mut SweepFile, definition: &Definition, text: &ConfigText) -> Result<(), Failure> {
    for set in &definition.sets {
        let (key, value) = set
            .split_once('=')
            .ok_or_else(|| Failure::new(Exit::Usage, format!("--set {set}: write KEY=VALUE")))?;
        let value = powergs_base::config::knob::written(value.trim());
        file.set.0.retain(|(known, _)| known != key.trim());
        file.set.0.push((key.trim().to_owned(), value));
    }
    if let Some(points) = definition.points {
        file.sampling.points = Some(points);
    }
    find_base(file, text.folder.as_deref());
    Ok(())
}

/// A machine file beside the sweep file is found from anywhere.
pub fn find_base(file: &mut SweepFile, folder: Option<&Path>) {
    let beside = folder.map(|f| f.join(&file.base)).filter(|p| p.is_file());
    if let Some(path) = beside {
        file.base = path.display().to_string();
    }
}

/// The base machine as a design: the sweep without its axes.
fn base(file: &SweepFile, disk: &DiskFiles, origin: &str) -> Result<Design, Failure> {
    let mut alone = file.clone();
    alone.axes.clear();
    alone.derived = Default::default();
    alone.constraints.clear();
    let space = Space::new(&alone, Arc::new(disk.clone())).usage(origin)?;
    space.design(0).or_exit(Exit::Usage, format_args!("{origin}: base machine"))
}

fn wanted(file: &SweepFile, definition: &Definition) -> Vec<Wanted> {
    let of_file = |t: &TraceSpec| Wanted {
        pattern: t.path.clone(),
        label: t.label.clone(),
        weight: t.weight,
    };
    if definition.traces.is_empty() {
        return file.traces.iter().map(of_file).collect();
    }
    let typed = definition.traces.iter();
    typed.map(|p| Wanted { pattern: p.clone(), label: None, weight: 1.0 }).collect()
}

fn objectives(file: &SweepFile) -> Vec<Objective> {
    let of = |names: &[String], maximize| -> Vec<Objective> {
        names.iter().map(|n| Objective { column: n.clone(), maximize }).collect()
    };
    let mut all = of(&file.objectives.minimize, false);
    all.extend(of(&file.objectives.maximize, true));
    all
}

/// What was typed, as far as results depend on it.
fn options(definition: &Definition, traces: &[OpenedTrace]) -> Vec<String> {
    let mut options: Vec<String> = definition.sets.iter().map(|s| format!("--set {s}")).collect();
    options.extend(definition.points.map(|n| format!("--points {n}")));
    for trace in traces {
        let range = trace.source.range();
        let label = &trace.label;
        let (start, end) = (range.start, range.end);
        options.push(format!("{} x {}: frames {start}..{end}", label.label, label.weight));
    }
    options
}

/// The default folder of a sweep.
pub fn folder(out: Option<&Path>, name: &str) -> PathBuf {
    out.map_or_else(|| Path::new("reports").join(name), Path::to_path_buf)
}
