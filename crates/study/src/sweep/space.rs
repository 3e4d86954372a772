//! The space of a sweep file: its points by number, and the design of each.
//!
//! Nothing is held per point: a space of 10^12 points is a few lists of values. A point becomes a
//! design by putting the values of its axes on the base machine, then the derived keys, then
//! checking everything that a machine file is checked for, then the constraints.

use std::path::PathBuf;
use std::sync::Arc;

use toml::{Table, Value};

use super::axis::{self, Axis, AxisFound};
use super::design::{Design, DesignPriced, DesignSetting, Rejected, full_id};
use super::expr::Expr;
use super::file::{Sampling, SweepFile};
use super::key::{FileKind, Key, get};
use super::lattice::{Lattice, LatticeSide};
use super::library::{Library, LibraryChange, LibraryDocument, LibraryFile};
use super::sample;
use powergs_base::config::{ConfigError, Problem};
use powergs_core::machine::Machine;
use powergs_core::run::files::Files;
use powergs_core::run::identity::timing_id;
use powergs_core::sim;

pub(crate) mod carried;
mod check;
mod derive;
mod draft;
mod free;
mod names;

use derive::Derived;
use draft::Draft;
pub use free::FreeAxis;
use names::Computed;
pub(crate) use names::{facts, known};

/// Label of the energy table that the machine names, where points name different ones.
pub(crate) const OWN: &str = "own";

/// Everything that is wrong with a sweep, in the order of its lines.
pub type SweepError = ConfigError;

/// A checked sweep: every point is a design, or is left out for a reason.
pub struct Space {
    axes: Vec<Axis>,
    lattice: Lattice,
    base: String,
    /// [`SweepFile::folder`].
    folder: Option<PathBuf>,
    set: Vec<LibraryChange>,
    derived: Vec<Derived>,
    constraints: Vec<Constraint>,
    energy: Vec<Energy>,
    display: Option<String>,
    display_fps: f64,
    sampling: Sampling,
    /// [`SweepFile::has_common_axes`].
    has_common_axes: bool,
    library: Library,
}

/// A constraint.
struct Constraint {
    expr: Expr,
    /// Whether it can only be decided once the machine is priced.
    needs_prices: bool,
}

/// An energy table of the sweep.
struct Energy {
    label: String,
    /// `None` for the one that the machine names.
    table: Option<String>,
    changes: Vec<LibraryChange>,
}

/// A point of a space.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Its number; the last axis counts fastest.
    pub index: u64,
    /// Which value of each axis it has.
    pub digits: Vec<u32>,
    /// Its columns, in the order of [`Space::columns`].
    pub settings: Vec<DesignSetting>,
}

impl Space {
    /// Checks a sweep file and everything that it names.
    ///
    /// # Errors
    /// Everything that is wrong, each with its line: unknown keys and names with the nearest one,
    /// values that a key does not take, lists of different lengths, circles of derived keys, axes
    /// that change nothing, a space without a single design (with what excludes how many points).
    pub fn new(file: &SweepFile, files: Arc<dyn Files>) -> Result<Space, SweepError> {
        let mut found = AxisFound { places: file.places(), problems: Vec::new() };
        let space = Space::build(file, Library::new(files), &mut found);
        let mut problems = found.problems;
        let Some(space) = space else { return Err(sorted(problems)) };
        if problems.is_empty() {
            let mut found = AxisFound { places: file.places(), problems };
            check::all(&space, &mut found);
            problems = found.problems;
        }
        if problems.is_empty() { Ok(space) } else { Err(sorted(problems)) }
    }

    /// The design of a file without axes.
    ///
    /// # Errors
    /// What is wrong first, without its place.
    pub fn only_design(file: &SweepFile, files: &Arc<dyn Files>) -> Result<Design, String> {
        let mut found = AxisFound { places: file.places(), problems: Vec::new() };
        let space = Space::build(file, Library::new(Arc::clone(files)), &mut found);
        match (found.problems.into_iter().next(), space) {
            (None, Some(space)) => space.design(0).map_err(|why| why.to_string()),
            (problem, _) => Err(problem.map_or_else(String::new, |problem| problem.message)),
        }
    }

    /// As [`Space::new`], of a file with problems of its own: all of them are told at once.
    ///
    /// # Errors
    /// As [`Space::new`], with `problems` among them.
    pub fn whole(
        file: &SweepFile,
        mut problems: Vec<Problem>,
        files: Arc<dyn Files>,
    ) -> Result<Space, SweepError> {
        let space = match Space::new(file, files) {
            Ok(space) if problems.is_empty() => return Ok(space),
            Ok(_) => Vec::new(),
            Err(error) => error.problems,
        };
        problems.extend(space);
        Err(sorted(problems))
    }

    fn build(file: &SweepFile, library: Library, found: &mut AxisFound<'_>) -> Option<Space> {
        let set = axis::settings(&file.set, "set", found);
        let read = |(i, spec)| Some((i, axis::axis(spec, i, found)?));
        let axes: Vec<(usize, Axis)> = file.axes.iter().enumerate().filter_map(read).collect();
        let mut derived = derive::read(&file.derived, found);
        let mut taken: Vec<(String, &'static Key)> = Vec::new();
        let by = |key: &Key| match found.places.typed(&key.to_string()) {
            Some(_) => "`--set`",
            None => "`set`",
        };
        taken.extend(set.iter().map(|(key, _)| (by(key).to_owned(), *key)));
        taken.extend(derived.iter().map(|d| ("`derived`".to_owned(), d.key)));
        axis::between(&axes, &taken, found);
        let mut energy: Vec<Energy> = Vec::new();
        for (i, spec) in file.energy.iter().enumerate() {
            let changes = table_settings(spec, i, found);
            let (label, table) = (spec.label.clone(), Some(spec.table.clone()));
            energy.push(Energy { label, table, changes });
        }
        if energy.is_empty() {
            let label = own_label(file, &library).unwrap_or_else(|| OWN.to_owned());
            energy.push(Energy { label, table: None, changes: Vec::new() });
        }
        let constraints = constraints(file, &energy, found);
        let axes: Vec<Axis> = axes.into_iter().map(|(_, axis)| axis).collect();
        derived.extend(carried::derived(file, &axes, &library, found));
        let side = |a: &Axis| LatticeSide { len: a.steps.len() as u32, ordered: a.ordered };
        let lattice = Lattice::new(axes.iter().map(side).collect());
        let all_there = axes.len() == file.axes.len();
        if lattice.is_none() && all_there {
            found.wrong("axes", "more than 2^63 points: fewer axes, or fewer values on them");
        }
        let mut space = Space {
            axes,
            lattice: lattice?,
            base: file.base.clone(),
            folder: file.folder.clone(),
            set,
            derived,
            constraints,
            energy,
            display: file.display.clone(),
            display_fps: file.display_fps,
            sampling: file.sampling.clone(),
            has_common_axes: file.has_common_axes,
            library,
        };
        // Names of axes are known only if every axis could be read.
        if all_there {
            names::check(&space, file, found);
        }
        derive::order(&mut space.derived, found);
        Some(space)
    }

    /// How many points there are before conditions and constraints.
    pub fn proposed(&self) -> u128 {
        u128::from(self.lattice.points())
    }

    /// The points as numbers.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The axes.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Keys that follow an axis by default, as the file says nothing of them: each with what it is.
    pub fn carried(&self) -> Vec<(&str, &str)> {
        let carried = self.derived.iter().filter(|d| d.is_carried);
        carried.map(|d| (d.name.as_str(), d.expr.text())).collect()
    }

    /// How points are chosen, as the file says.
    pub fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    /// Labels of the energy tables, in order.
    pub fn energy_labels(&self) -> Vec<&str> {
        self.energy.iter().map(|e| e.label.as_str()).collect()
    }

    /// Names of the columns of every point: for an axis its keys, or its name if it has variants;
    /// then the derived keys.
    pub fn columns(&self) -> Vec<String> {
        let derived = self.derived.iter().map(|d| d.key.to_string());
        self.axis_columns().into_iter().chain(derived).collect()
    }

    /// Those of the columns that are of axes.
    pub fn axis_columns(&self) -> Vec<String> {
        let of_axis = |axis: &Axis| match axis.has_names {
            true => vec![axis.name.clone()],
            false => axis.steps[0].settings.iter().map(|(key, _)| key.to_string()).collect(),
        };
        self.axes.iter().flat_map(of_axis).collect()
    }

    /// The points that the sampling of the file takes, one at a time; for a search, none: it asks
    /// for points as results come in.
    pub fn selected(&self) -> sample::Selection {
        sample::select(&self.lattice, &self.sampling)
    }

    /// The point that stands for all points that are the same as this one because an axis does not
    /// count there.
    ///
    /// # Errors
    /// A condition that has no value.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn canonical(&self, index: u64) -> Result<u64, Rejected> {
        Ok(self.lattice.index(&Draft::new(self, index)?.digits))
    }

    /// What [`Search::ask`](super::search::Search::ask) wants to know of a point: the point that
    /// stands for it, if it is a design.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn allowed(&self, index: u64) -> Option<u64> {
        let index = self.canonical(index).ok()?;
        self.design(index).ok().map(|design| design.index)
    }

    /// A point with its columns.
    ///
    /// # Errors
    /// As [`Space::design`], but constraints and contradictions are not checked.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn point(&self, index: u64) -> Result<Point, Rejected> {
        let mut draft = Draft::new(self, index)?;
        draft.derive()?;
        let digits = self.lattice.digits(index);
        Ok(Point { index, digits, settings: draft.settings() })
    }

    /// The design of a point.
    ///
    /// # Errors
    /// Why it is left out: a constraint that does not hold, a machine that does not fit together,
    /// the same machine as another point.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn design(&self, index: u64) -> Result<Design, Rejected> {
        self.built(index, true)
    }

    fn built(&self, index: u64, constrained: bool) -> Result<Design, Rejected> {
        self.designed(Draft::new(self, index)?, index, constrained)
    }

    /// The design of a point without one of the keys of `set`, whatever the constraints say.
    fn built_without(&self, index: u64, setting: usize) -> Result<Design, Rejected> {
        self.designed(Draft::without(self, index, Some(setting))?, index, false)
    }

    fn designed<'a>(
        &'a self,
        mut draft: Draft<'a>,
        index: u64,
        constrained: bool,
    ) -> Result<Design, Rejected> {
        let digits = self.lattice.digits(index);
        if let Some(i) = (0..digits.len()).find(|&i| draft.digits[i] != digits[i]) {
            let canonical = self.lattice.index(&draft.digits);
            return Err(Rejected::Duplicate { axis: self.axes[i].name.clone(), canonical });
        }
        draft.derive()?;
        if constrained {
            self.hold(&draft, None)?;
        }
        let device = draft.device().map_err(Rejected::Machine)?;
        let machine =
            Machine::from_table(draft.machine_table(), device.as_deref().map(|d| &d.value));
        let mut machine = machine.map_err(Rejected::Machine)?;
        machine.keep(draft.base()).map_err(Rejected::Machine)?;
        let mut prices = Vec::with_capacity(self.energy.len());
        for energy in &self.energy {
            prices.push(self.priced(&draft, energy, &machine)?);
        }
        // A machine that one table cannot price is a design for the others.
        if let Some(DesignPriced { label, prices: Err(message), .. }) = prices.first()
            && prices.iter().all(|p: &DesignPriced| p.prices.is_err())
        {
            return Err(Rejected::Price { label: label.clone(), message: message.clone() });
        }
        if constrained {
            self.hold(&draft, Some(&Computed { machine: &machine, prices: &prices }))?;
        }
        let display = draft.display().map_err(Rejected::Machine)?;
        let timing_id = timing_id(&machine, device.as_ref().map(|d| d.id));
        let shown = display.as_ref().map(|d| (d.id, self.display_fps));
        let id = full_id(timing_id, &machine, &prices, shown);
        let settings = draft.settings();
        let display_fps = self.display_fps;
        Ok(Design { index, machine, prices, device, display, display_fps, settings, timing_id, id })
    }

    fn priced(
        &self,
        draft: &Draft<'_>,
        energy: &Energy,
        machine: &Machine,
    ) -> Result<DesignPriced, Rejected> {
        let fail = |message| Rejected::Price { label: energy.label.clone(), message };
        let table = draft.energy(energy).map_err(fail)?;
        let prices = sim::cost::prices(&table.value, machine).map_err(|e| e.to_string());
        Ok(DesignPriced { label: energy.label.clone(), table, prices })
    }

    /// The constraints that can be decided now: those without prices first, the others later.
    fn hold(&self, draft: &Draft<'_>, computed: Option<&Computed<'_>>) -> Result<(), Rejected> {
        let due = |c: &&(usize, &Constraint)| c.1.needs_prices == computed.is_some();
        let all: Vec<(usize, &Constraint)> = self.constraints.iter().enumerate().collect();
        for (number, constraint) in all.iter().filter(due) {
            let value = constraint.expr.holds(&|name| draft.value(name, computed));
            let text = constraint.expr.text();
            match value {
                Ok(true) => {}
                Ok(false) => {
                    return Err(Rejected::Constraint { number: *number, text: text.to_owned() });
                }
                Err(error) => {
                    let place = format!("constraints.{number}");
                    return Err(Rejected::Expression { place, message: error.to_string() });
                }
            }
        }
        Ok(())
    }
}

/// The name of the one energy table that all points have: that of the base machine, or of `set`.
fn own_label(file: &SweepFile, library: &Library) -> Option<String> {
    const ENERGY: &str = "energy";
    if carried::varied(file).any(|key| [ENERGY, super::key::MACHINE].contains(&key)) {
        return None;
    }
    let set = file.set.0.iter().find(|(key, _)| key == ENERGY).map(|(_, value)| value.clone());
    let own = || get(&library.machine(&file.base, None).ok()?.table, ENERGY).cloned();
    let name = set.or_else(own)?;
    let stem = std::path::Path::new(name.as_str()?).file_stem()?.to_str()?.to_owned();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    (!stem.is_empty() && stem.chars().all(is_plain)).then_some(stem)
}

/// Changed keys of an energy table: without `energy:`, which goes without saying there.
fn table_settings(
    spec: &super::file::EnergySpec,
    number: usize,
    found: &mut AxisFound<'_>,
) -> Vec<LibraryChange> {
    let mut changes = Vec::new();
    for (name, raw) in &spec.set.0 {
        let path = format!("energy.{number}.set.{name}");
        let prefix = FileKind::Energy.prefix();
        let full = format!("{prefix}{}", name.strip_prefix(prefix).unwrap_or(name));
        let Some(key) = found.ok(&path, Key::find(&full)) else { continue };
        changes.extend(axis::value(key, raw, &path, found));
    }
    changes
}

fn constraints(file: &SweepFile, energy: &[Energy], found: &mut AxisFound<'_>) -> Vec<Constraint> {
    let mut all = Vec::new();
    for (i, text) in file.constraints.iter().enumerate() {
        let Some(expr) = found.ok(&format!("constraints.{i}"), Expr::parse(text)) else { continue };
        let needs_prices = expr.names().into_iter().any(|n| names::is_computed(n, energy));
        all.push(Constraint { expr, needs_prices });
    }
    all
}

fn sorted(mut problems: Vec<Problem>) -> SweepError {
    problems.sort_by_key(|p| p.place.line());
    SweepError::new(problems)
}
