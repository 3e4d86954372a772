//! The machines of a space: a sweep file for every model, with the record that the model has.

use std::path::Path;

use toml::{Table, Value};
use xxhash_rust::xxh3::xxh3_128;

use powergs_base::config::embedded::{MACHINES, find};
use powergs_core::flow::RecordKeys;
use powergs_core::flow::tile_wise::CodebookSpec;
use powergs_core::machine::DramModel;
use powergs_core::run::files::{DiskFiles, found_as};
use powergs_core::run::system::{DEVICE, ENERGY};
use powergs_core::run::{Change, FileKind, RunError, System, SystemSpec};
use powergs_study::sweep::SweepFile;
use powergs_study::sweep::file::{EnergySpec, Method, Settings};
use powergs_study::sweep::run::opened::lies_in;

use super::error::CodesignError;
use super::model::{ENTRIES, ModelPoint, RecordBytes, unreadable};
use super::space::{MachineSpec, axis_keys};

/// The question of the sweeps; only people read it.
const QUESTION: &str = "Which machine needs the fewest watts for this model?";
/// The table that further ones stand beside by default.
const USUAL: &str = "gscore-28nm";
/// What an adaptive search looks for the front of: what ways choose by, and both limits.
const OBJECTIVES: [&str; 3] = ["rendering_plus_display_w", "area_mm2", "frame_time_ms.max"];
/// Energies of the units of `rtl/`; the first that reaches the clock of the base machine.
const RTL: [&str; 2] = ["gscore-rtl-28nm", "gscore-rtl-7nm"];
/// Another price of DRAM.
const FLAT: &str = "gscore-28nm-flat";
/// The key of the clock.
const CLOCK: &str = "clock";
/// The key of the DRAM model.
const MODEL: &str = "dram.model";
/// The key of the banks of a codebook.
const BANKS: &str = "codebook.banks";
/// What keys of a codebook begin with.
pub(super) const CODEBOOK: &str = "codebook.";
/// Where axes of a codebook count.
const HAS_CODEBOOK: &str = "codebook.entries > 0";
/// Where a space says nothing of the banks of a codebook: as many as make each no larger than this,
/// bytes, which every energy table has a price for.
const BANK_MOST: u64 = 64 << 10;

/// The machines of a space.
#[derive(Debug, Clone)]
pub struct Machines {
    /// The base machine with the keys that all machines have, and its display.
    pub base: System,
    /// Whether a model has a codebook: then axes of the codebook count for those that have one, and
    /// the others have the machines without them.
    pub has_codebooks: bool,
    /// Energy tables that the space does not name and that have no price for a machine of it, with
    /// the reason: they are left out.
    pub left_out: Vec<(String, String)>,
    /// Whether the energy tables are those by default.
    is_usual: bool,
    /// What the space file calls the base machine, wherever it lies.
    written: String,
    /// Where its files have what is stored of a Gaussian.
    record: RecordKeys,
    /// The sweep of the machine's own record.
    file: SweepFile,
}

impl Machines {
    /// The machines of a space file with this text, which `origin` names in messages.
    ///
    /// # Errors
    /// [`RunError::Config`]: a machine or a display that is not there, a key that it does not have.
    pub fn open(spec: &MachineSpec, text: &str, origin: &str) -> Result<Machines, RunError> {
        let folder = spec.folder.as_deref();
        let system = SystemSpec {
            machine: found_as(FileKind::Machine, &spec.base, folder),
            display: Some(found_as(FileKind::Display, &spec.display, folder)),
            ..SystemSpec::default()
        };
        let in_space = |e: RunError| match e {
            RunError::Config { .. } => RunError::config(origin, e),
            other => other,
        };
        let system = System::load(&system, &DiskFiles).map_err(in_space)?;
        let base = system.with(&changes(&spec.set, folder, origin)?).map_err(in_space)?;
        // Models decide the record.
        let flow = base.machine().flow();
        let Some(record) = flow.record() else {
            let what = format!(
                "base machine `{}` has `dataflow = \"{}\"`, whose files do not say what is stored \
                 of a Gaussian: take another one (`gscore`)",
                base.machine().name,
                flow.key()
            );
            return Err(RunError::config(origin, what));
        };
        let mut file = sweep_file(spec, text).map_err(|e| RunError::config(origin, e))?;
        lies_in(&mut file, folder);
        let is_usual = file.energy.is_empty() && find(MACHINES, &spec.base).is_some();
        if is_usual {
            file.energy = usual(&base, &file);
        }
        file.display = Some(spec.display.clone());
        file.display_fps = spec.display_fps;
        if file.sampling.method == Method::Nsga2 {
            file.objectives.minimize = OBJECTIVES.map(str::to_owned).into();
        }
        let written = spec.base.clone();
        let (has_codebooks, left_out) = (false, Vec::new());
        Ok(Machines { base, record, has_codebooks, left_out, is_usual, written, file })
    }

    /// Frames that the display shows in a second.
    pub fn fps(&self) -> f64 {
        self.file.display_fps
    }

    /// The sweep of a model: the same axes, with the record of the model.
    pub fn sweep(&self, model: &ModelPoint, dram: DramModel) -> SweepFile {
        let mut file = self.file.clone();
        let mut set = |key: &str, value: Value| {
            file.set.0.retain(|(known, _)| known != key);
            file.set.0.push((key.to_owned(), value));
        };
        let machine = self.base.machine();
        let record = RecordBytes::of(model, machine, self.record);
        for (key, value) in record.settings() {
            set(&key, value);
        }
        // A base machine may have one, which is not of this model.
        let own = machine.tables.get::<CodebookSpec>();
        if record.codebook.is_none() && own.is_some_and(|own| own.entries > 0) {
            set(ENTRIES, 0.into());
        }
        if let Some((entries, entry)) = record.codebook
            && !self.gives(BANKS)
        {
            let word = own.map_or(1, |own| own.word.0.max(1));
            let copy = u64::from(entries) * entry.0.next_multiple_of(word);
            let banks = copy.div_ceil(BANK_MOST).next_power_of_two();
            set(BANKS, i64::try_from(banks).unwrap_or(i64::MAX).into());
        }
        if record.codebook.is_none() && self.has_codebooks {
            // The axes stay and count nowhere, so that points have the same numbers for all models.
            file.has_common_axes = true;
            for axis in &mut file.axes {
                if axis_keys(axis).iter().all(|key| key.starts_with(CODEBOOK)) {
                    let own = axis.when.take().map(|when| format!("({when}) && "));
                    axis.when = Some(own.unwrap_or_default() + HAS_CODEBOOK);
                }
            }
        }
        // A machine with a mere rate of DRAM keeps it, as in sweeps.
        if self.base.machine().dram.model == DramModel::Banked {
            set(MODEL, dram.name().into());
        }
        file
    }

    /// The same without its `n`-th energy table, where that one only stands beside the first by
    /// default.
    pub(super) fn without(&self, n: usize) -> Option<Machines> {
        let is_extra = self.is_usual && (1..self.file.energy.len()).contains(&n);
        is_extra.then(|| {
            let mut others = self.clone();
            others.file.energy.remove(n);
            others
        })
    }

    /// Labels of the energy tables.
    pub(super) fn tables(&self) -> impl Iterator<Item = &str> {
        self.file.energy.iter().map(|table| table.label.as_str())
    }

    /// Whether the space itself has a key.
    fn gives(&self, key: &str) -> bool {
        let SweepFile { set, derived, axes, .. } = &self.file;
        let has = |settings: &Settings| settings.0.iter().any(|(known, _)| known == key);
        has(set) || has(derived) || axes.iter().any(|axis| axis_keys(axis).iter().any(|k| k == key))
    }

    /// Whether the base machine's DRAM has banks, so that winners are confirmed with them.
    pub fn has_banks(&self) -> bool {
        self.base.machine().dram.model == DramModel::Banked
    }

    /// Refuses models whose record the base machine cannot read.
    ///
    /// # Errors
    /// [`CodesignError::Space`].
    pub fn check(&self, models: &[ModelPoint], origin: &str) -> Result<(), CodesignError> {
        let machine = self.base.machine();
        let numbers = machine.flow().numbers(machine);
        let book = models.iter().find(|model| model.formats.codebook.is_some());
        if let (None, Some(model)) = (self.record.codebook, book) {
            let message = format!(
                "`model.codebook`: base machine `{}` has `dataflow = \"{}\"`, whose records name \
                 no colours by a number, as `{}` does: leave it out, or take another machine \
                 (`gscore`)",
                machine.name,
                machine.flow().key(),
                model.name()
            );
            return Err(CodesignError::Space { place: origin.to_owned(), message });
        }
        match models.iter().find_map(|model| unreadable(model, numbers)) {
            Some(message) => Err(CodesignError::Space { place: origin.to_owned(), message }),
            None => Ok(()),
        }
    }

    /// Hash of the machines of a model.
    pub fn id(&self, model: &ModelPoint, dram: DramModel) -> u128 {
        let mut file = self.sweep(model, dram);
        file.base = self.written.clone();
        let file = toml::to_string(&file).unwrap_or_default();
        // A sweep is continued only with the same text.
        let text = self.file.text();
        xxh3_128(format!("{file}{:032x}{text}", self.base.id()).as_bytes())
    }
}

/// The energy tables by default. Units of `rtl/` have a highest clock: where the space varies that,
/// it has to say which tables there are.
fn usual(base: &System, file: &SweepFile) -> Vec<EnergySpec> {
    let own = base.machine().energy.as_str();
    let mut tables = vec![own];
    if own == USUAL {
        let has_clock = |table: &&&str| base.with(&[Change::machine("energy", **table)]).is_ok();
        let varies = file.axes.iter().any(|axis| axis_keys(axis).iter().any(|key| key == CLOCK));
        let rtl = RTL.iter().find(has_clock).filter(|_| !varies);
        tables.extend(rtl.into_iter().chain([&FLAT]));
    }
    let spec = |table: &str| EnergySpec {
        label: table.into(),
        table: table.into(),
        set: Settings::default(),
    };
    tables.into_iter().map(spec).collect()
}

fn changes(set: &Settings, folder: Option<&Path>, origin: &str) -> Result<Vec<Change>, RunError> {
    let change = |(key, value): &(String, Value)| {
        let others = FileKind::ALL.into_iter().filter(|kind| !kind.prefix().is_empty());
        let found = others.filter_map(|kind| Some((kind, key.strip_prefix(kind.prefix())?))).next();
        let (file, path) = found.unwrap_or((FileKind::Machine, key));
        if path.is_empty() {
            return Err(RunError::config(origin, format_args!("`machine.set`: `{key}` is no key")));
        }
        let named = match (file, path) {
            (FileKind::Machine, ENERGY) => Some(FileKind::Energy),
            (FileKind::Machine, DEVICE) => Some(FileKind::Dram),
            _ => None,
        };
        let value = match named.zip(value.as_str()) {
            Some((kind, name)) => found_as(kind, name, folder).into(),
            None => value.clone(),
        };
        Ok(Change { file, path: path.to_owned(), value })
    };
    set.0.iter().map(change).collect()
}

/// The part of the machine as a sweep file, with the lines of the space file.
fn sweep_file(spec: &MachineSpec, text: &str) -> Result<SweepFile, String> {
    let plain = {
        let mut table = Table::new();
        table.insert("question".into(), QUESTION.into());
        table.insert("display-fps".into(), spec.display_fps.into());
        let spec = Table::try_from(spec).map_err(|e| e.to_string())?;
        table.extend(spec);
        table.to_string()
    };
    let of = |text: &str| SweepFile::parse(text);
    let whole = of(&plain).map_err(|e| e.to_string())?;
    let same = |file: &SweepFile| {
        (&file.base, &file.set, &file.axes, &file.derived)
            == (&whole.base, &whole.set, &whole.axes, &whole.derived)
            && (&file.constraints, &file.energy, &file.sampling)
                == (&whole.constraints, &whole.energy, &whole.sampling)
    };
    // Where the text can be taken apart line by line, messages have the lines that the user knows.
    let placed = of(&machine_lines(text, &spec.base)).ok().filter(same);
    Ok(placed.unwrap_or(whole))
}

/// The lines of `[machine]` as those of a sweep file; all others are empty, or hold what the space
/// file leaves out.
fn machine_lines(text: &str, base: &str) -> String {
    let question = format!("question = \"{QUESTION}\"");
    let (mut lines, mut is_ours, mut is_top) = (Vec::new(), false, false);
    let (mut asks, mut names_base) = (false, false);
    for line in text.lines() {
        let header = line.trim_start().strip_prefix('[').map(|rest| rest.trim_start_matches('['));
        let line = match header.map(|rest| rest.split(']').next().unwrap_or_default().trim()) {
            Some("machine") => {
                (is_ours, is_top, asks) = (true, true, true);
                question.clone()
            }
            Some(name) => {
                (is_ours, is_top) = (name.starts_with("machine."), false);
                if is_ours { line.replacen("machine.", "", 1) } else { String::new() }
            }
            None if is_ours => line.to_owned(),
            None => String::new(),
        };
        let key = line.split('=').next().unwrap_or_default().trim();
        names_base |= is_top && key == "base";
        lines.push(line);
    }
    let missing =
        [(!asks).then_some(question), (!names_base).then(|| format!("base = \"{base}\""))];
    // Into the empty lines above, so that no other line moves.
    let first = lines.iter().position(|line| !line.is_empty()).unwrap_or(0);
    let free = lines[..first].iter_mut().rev();
    free.zip(missing.into_iter().flatten()).for_each(|(line, key)| *line = key);
    lines.join("\n")
}
