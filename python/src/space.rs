//! Spaces of designs that the caller searches: points, settings, machines.

use std::sync::Arc;

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyAny, PyDict, PyList};

use crate::error::Fault;
use crate::machine::{Machine, path_text};
use crate::sweep::over;
use crate::value;
use crate::watch::{self, Counts};
use powergs_core::run::{Change, System};
use powergs_study::sweep::design::{Design, Rejected};
use powergs_study::sweep::run::{Designs, SweepRequest};

/// Points that are listed at most.
const MOST: u64 = 10_000_000;

/// What a sweep file, or axes over a machine, span.
#[pyclass(frozen, module = "powergs", name = "_Space")]
pub struct AskedSpace {
    designs: Arc<Designs>,
    /// The machine that axes are of; of a file the designs say it.
    base: Option<Arc<System>>,
    name: String,
}

impl AskedSpace {
    fn points(&self) -> u64 {
        self.designs.space.lattice().points()
    }

    /// The design of a point, or why it is none.
    fn design(&self, point: u64) -> PyResult<Result<Design, Rejected>> {
        let count = self.points();
        if point >= count {
            return Err(PyIndexError::new_err(format!("design {point} of {count}")));
        }
        Ok(self.designs.space.design(point))
    }

    fn machine_of(&self, design: &Design) -> PyResult<Machine> {
        match &self.base {
            Some(base) => {
                let settings = design.settings.iter();
                let change = |(name, value): (&String, &toml::Value)| {
                    let written: Result<Change, String> = format!("{name}=0").parse();
                    Ok(Change { value: value.clone(), ..written.map_err(Fault::config)? })
                };
                let changes = settings.map(|setting| change((&setting.name, &setting.value)));
                let changes = changes.collect::<Result<Vec<Change>, Fault>>()?;
                let machine = Machine::new(&self.name, (**base).clone());
                Ok(machine.of(machine.changed(&changes)?))
            }
            None => Machine::of_design(design),
        }
    }
}

#[pymethods]
impl AskedSpace {
    /// A dictionary of keys with their values over a machine.
    #[staticmethod]
    #[pyo3(signature = (base, axes, constraints, sampling))]
    fn of_axes(
        py: Python<'_>,
        base: &Machine,
        axes: &Bound<'_, PyDict>,
        constraints: Vec<String>,
        sampling: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<AskedSpace> {
        let sweep = over((*base.system()).clone(), axes, &constraints, sampling)?;
        let work =
            move |_: &watch::Shared| sweep.designs().map_err(|e| Fault::from(e).without_lines());
        let designs = Arc::new(watch::run(py, None, (Counts::Steps, "designs"), work)?);
        Ok(AskedSpace { designs, base: Some(base.system()), name: base.opened_as().to_owned() })
    }

    /// A sweep file.
    #[staticmethod]
    fn of_file(
        py: Python<'_>,
        file: &Bound<'_, PyAny>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<AskedSpace> {
        let sets = value::changes(keys, None)?.iter().map(ToString::to_string).collect();
        let name = path_text(file)?;
        let request = SweepRequest { file: name.clone(), sets, ..SweepRequest::default() };
        let work = move |_: &watch::Shared| Ok(Designs::of_file(&request)?);
        let designs = Arc::new(watch::run(py, None, (Counts::Steps, "designs"), work)?);
        Ok(AskedSpace { designs, base: None, name })
    }

    /// Names of the axes, and what each has at its steps.
    fn axes<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyList>)>> {
        let mut axes = Vec::new();
        for axis in self.designs.space.axes() {
            let steps = PyList::empty(py);
            for step in &axis.steps {
                match &*step.settings {
                    [(_, value)] if !axis.has_names => steps.append(value::python(py, value)?)?,
                    _ => steps.append(&step.label)?,
                }
            }
            axes.push((axis.name.clone(), steps));
        }
        Ok(axes)
    }

    /// The point at a step of each axis.
    fn point(&self, steps: Vec<u32>) -> PyResult<u64> {
        let sides = self.designs.space.lattice().sides();
        let fits = steps.len() == sides.len()
            && steps.iter().zip(sides).all(|(step, side)| *step < side.len);
        if !fits {
            return Err(PyIndexError::new_err("a step of each axis"));
        }
        Ok(self.designs.space.lattice().index(&steps))
    }

    /// The points that a sweep takes, in order; those that constraints leave out are among them.
    fn points_of_sweep(&self) -> PyResult<Vec<u64>> {
        if self.designs.is_adaptive() {
            let what = "an adaptive search asks for points as results come in: sweep without \
                        functions, ask with settings, or another method of sampling";
            return Err(Fault::config(what).raise());
        }
        let selected = self.designs.space.selected();
        let most = selected.size_hint().1.unwrap_or(usize::MAX) as u64;
        if most > MOST {
            let what =
                format!("{most} designs: at most {MOST} are asked for one by one; sample them");
            return Err(Fault::config(what).raise());
        }
        Ok(selected.collect())
    }

    /// Settings and machine of a point; no settings where it is the same as another one, or left
    /// out by a constraint, no machine where it is none, and then the reason.
    fn candidate<'py>(
        &self,
        py: Python<'py>,
        point: u64,
    ) -> PyResult<(Option<Bound<'py, PyDict>>, Option<Machine>, String)> {
        let settings = PyDict::new(py);
        let found = self.design(point)?;
        if let Ok(known) = self.designs.space.point(point) {
            for setting in &known.settings {
                settings.set_item(&setting.name, value::python(py, &setting.value)?)?;
            }
        }
        match found {
            Ok(design) => Ok((Some(settings), Some(self.machine_of(&design)?), String::new())),
            Err(why @ (Rejected::Constraint { .. } | Rejected::Duplicate { .. })) => {
                Ok((None, None, why.to_string()))
            }
            Err(why) => Ok((Some(settings), None, why.to_string())),
        }
    }

    /// Display rate that the sweep file says, frames per second.
    fn display_fps(&self) -> f64 {
        self.designs.base.display_fps
    }

    /// Labels of the energy tables; machines have the first.
    fn energy_tables(&self) -> Vec<String> {
        self.designs.tables()
    }

    /// The machine that designs differ from.
    fn base(&self) -> PyResult<Machine> {
        match &self.base {
            Some(base) => Ok(Machine::new(&self.name, (**base).clone())),
            None => Machine::of_design(&self.designs.base),
        }
    }

    fn __len__(&self) -> usize {
        usize::try_from(self.points()).unwrap_or(usize::MAX)
    }
}
