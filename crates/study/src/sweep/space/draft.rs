//! A point on its way to a design: the files with their changes, before anything is checked.

use std::path::Path;

use super::{
    Arc, Axis, Computed, DesignSetting, Energy, FileKind, Key, LibraryChange, LibraryDocument,
    LibraryFile, Machine, Rejected, Space, Table, Value, get, names,
};
use crate::sweep::expr;
use powergs_base::config::{knob, layer};
use powergs_base::quantity::Hertz;
use powergs_core::machine::NO_DEVICE;
use powergs_core::run::system::{DEVICE, ENERGY};
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_frame::display::Display;

/// The files of a point.
pub(super) struct Draft<'a> {
    pub(super) space: &'a Space,
    /// Which value of each axis it has; 0 for an axis that does not count.
    pub(super) digits: Vec<u32>,
    /// Whether each axis counts.
    pub(super) active: Vec<bool>,
    base: Arc<LibraryDocument<Machine>>,
    base_name: String,
    machine: Table,
    /// Keys of the machine that the sweep changes.
    named: Vec<&'static str>,
    changes: Vec<LibraryChange>,
}

impl<'a> Draft<'a> {
    pub(super) fn new(space: &'a Space, index: u64) -> Result<Draft<'a>, Rejected> {
        Draft::without(space, index, None)
    }

    /// The same without one of the keys of `set`.
    pub(super) fn without(
        space: &'a Space,
        index: u64,
        setting: Option<usize>,
    ) -> Result<Draft<'a>, Rejected> {
        let digits = space.lattice.digits(index);
        let (base_name, folder) = base_of(space, &digits);
        let base = space.library.machine(&base_name, folder).map_err(Rejected::Machine)?;
        let machine = base.table.clone();
        let active = Vec::with_capacity(digits.len());
        let (named, changes) = (Vec::new(), Vec::new());
        let mut draft = Draft { space, digits, active, base, base_name, machine, named, changes };
        for (_, change) in space.set.iter().enumerate().filter(|(i, _)| Some(*i) != setting) {
            draft.put(change);
        }
        // In the order of the file: a condition sees the axes before its own.
        for (i, axis) in space.axes.iter().enumerate() {
            let counts = draft.counts(i, axis)?;
            draft.active.push(counts);
            if !counts {
                // All values of it are one point here, and the first is the one that is simulated.
                draft.digits[i] = 0;
                continue;
            }
            for change in &axis.steps[draft.digits[i] as usize].settings {
                draft.put(change);
            }
        }
        Ok(draft)
    }

    fn counts(&self, number: usize, axis: &Axis) -> Result<bool, Rejected> {
        let Some(when) = &axis.when else { return Ok(true) };
        when.holds(&|name| self.value(name, None)).map_err(|error| Rejected::Expression {
            place: format!("axes.{number}.when"),
            message: error.to_string(),
        })
    }

    fn put(&mut self, (key, value): &LibraryChange) {
        if key.is_machine() {
            return;
        }
        match key.file {
            FileKind::Machine => {
                self.named.push(&key.path);
                if key.is_part() {
                    knob::remove(&mut self.machine, &key.path);
                } else {
                    knob::set(&mut self.machine, &key.path, value);
                }
            }
            FileKind::Energy | FileKind::Dram | FileKind::Display => {
                self.changes.push((key, value.clone()));
            }
        }
    }

    /// Computes the derived keys.
    pub(super) fn derive(&mut self) -> Result<(), Rejected> {
        for derived in &self.space.derived {
            let key = derived.key;
            let fail = |message| Rejected::Derived { key: key.to_string(), message };
            let value = derived.expr.eval(&|name| self.value(name, None));
            let value = value.map_err(|error| Rejected::Expression {
                place: format!("derived.{}", derived.name),
                message: error.to_string(),
            })?;
            let value = key.domain().write(&value).map_err(fail)?;
            self.put(&(key, value));
        }
        Ok(())
    }

    /// The machine that it is a variant of.
    pub(super) fn base(&self) -> &Machine {
        &self.base.value
    }

    pub(super) fn machine_table(&self) -> Table {
        self.machine.clone()
    }

    fn changes_of(&self, kind: FileKind) -> Vec<LibraryChange> {
        self.changes.iter().filter(|(key, _)| key.file == kind).cloned().collect()
    }

    /// The folder of a file that the machine names: beside the sweep file, where that names it.
    fn folder_of<'s>(&'s self, key: &str, own: Option<&'s Path>) -> Option<&'s Path> {
        let is_named = self.named.contains(&key);
        if is_named { self.space.folder.as_deref() } else { own }
    }

    /// The DRAM device; `None` where the machine has a mere rate.
    pub(super) fn device(&self) -> Result<Option<Arc<LibraryDocument<Device>>>, String> {
        let name = get(&self.machine, DEVICE).and_then(Value::as_str).unwrap_or("");
        if name == NO_DEVICE {
            return Ok(None);
        }
        let folder = self.folder_of(DEVICE, self.base.device_in.as_deref());
        let changes = self.changes_of(FileKind::Dram);
        self.space.library.device(LibraryFile { name, folder, changes: &changes }).map(Some)
    }

    /// The clock of the machine, as far as it has a valid one.
    fn clock(&self) -> Hertz {
        match self.value("clock", None) {
            Some(expr::Value::Number(hertz)) => Hertz(hertz),
            Some(expr::Value::Text(_) | expr::Value::Truth(_)) | None => self.base.value.clock,
        }
    }

    pub(super) fn energy(
        &self,
        energy: &Energy,
    ) -> Result<Arc<LibraryDocument<EnergyTable>>, String> {
        let mut changes = energy.changes.clone();
        changes.extend(self.changes_of(FileKind::Energy));
        let (name, folder) = match &energy.table {
            Some(name) => (name.as_str(), self.space.folder.as_deref()),
            None => (
                get(&self.machine, ENERGY).and_then(Value::as_str).unwrap_or(""),
                self.folder_of(ENERGY, self.base.energy_in.as_deref()),
            ),
        };
        self.space.library.table(LibraryFile { name, folder, changes: &changes }, self.clock())
    }

    pub(super) fn display(&self) -> Result<Option<Arc<LibraryDocument<Display>>>, String> {
        let Some(name) = &self.space.display else { return Ok(None) };
        let (folder, changes) = (self.space.folder.as_deref(), self.changes_of(FileKind::Display));
        self.space.library.display(LibraryFile { name, folder, changes: &changes }).map(Some)
    }

    /// What a key has; `None` where its file has none, or several.
    pub(super) fn file_value(&self, key: &Key) -> Option<Value> {
        if key.is_machine() {
            return Some(Value::String(self.base_name.clone()));
        }
        if key.file == FileKind::Machine {
            let own = get(&self.machine, &key.path);
            if key.is_part() {
                let is_absent = own.is_none()
                    || own == get(&self.base.table, &key.path)
                        && self.base.value.leaves_out(&key.path);
                return is_absent.then(|| layer::NONE.into());
            }
            return own.cloned();
        }
        // Of several changes the last counts.
        if let Some((_, value)) = self.changes.iter().rev().find(|(k, _)| *k == key) {
            return Some(value.clone());
        }
        match key.file {
            FileKind::Energy => {
                get(&self.energy(&self.space.energy[0]).ok()?.table, &key.path).cloned()
            }
            FileKind::Dram => get(&self.device().ok()??.table, &key.path).cloned(),
            FileKind::Display => get(&self.display().ok()??.table, &key.path).cloned(),
            FileKind::Machine => None,
        }
    }

    /// What a name stands for in an expression.
    pub(super) fn value(&self, name: &str, computed: Option<&Computed<'_>>) -> Option<expr::Value> {
        // Before keys: an axis may be called as the part that its variants have.
        let named = |axis: &Axis| axis.has_names && axis.name == name;
        if let Some(i) = self.space.axes.iter().position(named) {
            return Some(expr::Value::Text(self.label(i).to_owned()));
        }
        if let Some((key, domain)) = Key::known(name) {
            return domain.value(&self.file_value(key)?);
        }
        names::computed(name, computed?)
    }

    /// The name of a variant, `-` where its axis does not count (yet).
    fn label(&self, axis: usize) -> &str {
        match self.active.get(axis) {
            Some(true) => &self.space.axes[axis].steps[self.digits[axis] as usize].label,
            Some(false) | None => "-",
        }
    }

    /// The columns of the point.
    pub(super) fn settings(&self) -> Vec<DesignSetting> {
        let mut settings = Vec::new();
        let of_key = |key: &Key| DesignSetting {
            name: key.to_string(),
            value: self.file_value(key).unwrap_or_else(|| "-".into()),
        };
        for (i, axis) in self.space.axes.iter().enumerate() {
            if axis.has_names {
                let value = Value::String(self.label(i).to_owned());
                settings.push(DesignSetting { name: axis.name.clone(), value });
            } else {
                settings.extend(axis.steps[0].settings.iter().map(|(key, _)| of_key(key)));
            }
        }
        settings.extend(self.space.derived.iter().map(|d| of_key(d.key)));
        settings
    }
}

/// The base machine, and the folder that it is looked for in: that of an axis or of `set`, or that
/// of the file, whose place is known.
fn base_of<'a>(space: &'a Space, digits: &[u32]) -> (String, Option<&'a Path>) {
    let steps = space.axes.iter().zip(digits).map(|(axis, &d)| &axis.steps[d as usize].settings);
    let all = steps.flatten().chain(&space.set);
    let machine = all.filter(|(key, _)| key.is_machine()).find_map(|(_, value)| value.as_str());
    match machine {
        Some(name) => (name.to_owned(), space.folder.as_deref()),
        None => (space.base.clone(), None),
    }
}
