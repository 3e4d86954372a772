//! Whether a space is worth running: it has a design, every axis and every key of `set` moves
//! something, and no two energy tables price all designs alike.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::{
    AxisFound, Design, Draft, Energy, FileKind, Key, LibraryChange, LibraryFile, Rejected, Space,
    Value, get,
};
use crate::sweep::file::Method;
use crate::sweep::key::MACHINE;
use crate::sweep::library::ANY_CLOCK;
use crate::sweep::sample::sobol;
use powergs_base::config::embedded::INERT;
use powergs_base::quantity::Hertz;
use powergs_core::machine::{NO_DEVICE, Optional};
use powergs_core::run::identity::{content_id, timing_id};
use powergs_core::run::system::{DEVICE, ENERGY};
use powergs_core::sim::cost::untimed;
use powergs_dram::Device;

/// Points that are tried until one is a design.
const LOOK_MAX: u64 = 10_000;

/// Designs on which energy tables and keys of `set` are tried.
const TRIED: u64 = 24;

/// Surroundings in which an axis is tried.
const TRIES: usize = 6;

/// Values of an axis that are tried in each.
const VALUES_MAX: u32 = 64;

pub(super) fn all(space: &Space, found: &mut AxisFound<'_>) {
    files(space, found);
    if !found.problems.is_empty() {
        return;
    }
    let sides = space.lattice.sides().iter().filter(|s| s.len > 1).count();
    if space.sampling.method == Method::Sobol && sides > sobol::DIMENSIONS_MAX {
        let most = sobol::DIMENSIONS_MAX;
        let message = format!("{sides} axes, and the Sobol sequence here has {most}: use `lhs`");
        found.wrong("sampling.method", message);
    }
    axes(space, found);
    settings(space, found);
    tables(space, found);
    first_design(space, found);
}

/// Every file that is named without an expression.
fn files(space: &Space, found: &mut AxisFound<'_>) {
    let library = &space.library;
    let folder = space.folder.as_deref();
    let base = found.ok("base", library.machine(&space.base, None));
    let clock = base.map_or(ANY_CLOCK, |base| base.value.clock);
    for (i, energy) in space.energy.iter().enumerate() {
        if let Some(name) = &energy.table {
            let plain = library.table(LibraryFile::plain(name, folder), clock);
            let plain = found.ok(&format!("energy.{i}.table"), plain);
            if plain.is_some() && !energy.changes.is_empty() {
                let changed = LibraryFile { name, folder, changes: &energy.changes };
                found.ok(&format!("energy.{i}.set"), library.table(changed, clock));
            }
        }
    }
    if let Some(name) = &space.display {
        found.ok("display", library.display(LibraryFile::plain(name, folder)));
    }
    for (key, value) in &space.set {
        if let Some(message) = named(space, key, value, clock) {
            found.wrong(&format!("set.{key}"), message);
        }
    }
    for (number, axis) in space.axes.iter().enumerate() {
        for (i, step) in axis.steps.iter().enumerate() {
            for (key, value) in &step.settings {
                if let Some(message) = named(space, key, value, clock) {
                    let list = if axis.has_names { "variants" } else { "values" };
                    found.wrong(&format!("axes.{number}.{list}.{i}"), message);
                }
            }
        }
    }
}

/// What is wrong with the file that a key of the machine names; `None` of other keys.
fn named(space: &Space, key: &Key, value: &Value, clock: Hertz) -> Option<String> {
    let name = value.as_str().filter(|_| key.file == FileKind::Machine)?;
    let (library, folder) = (&space.library, space.folder.as_deref());
    let file = LibraryFile::plain(name, folder);
    match key.path.as_str() {
        MACHINE => library.machine(name, folder).err(),
        ENERGY => library.table(file, clock).err(),
        DEVICE if name == NO_DEVICE => None,
        DEVICE => library.device(file).err(),
        _ => None,
    }
}

/// Numbers of points to look at: all of a small space, random ones of a large one.
fn some_points(space: &Space, most: u64) -> Box<dyn Iterator<Item = u64>> {
    let points = space.lattice.points();
    if points <= most {
        return Box::new(0..points);
    }
    // A fixed seed: a file is always judged alike.
    let mut random = Pcg64::seed_from_u64(1);
    Box::new((0..most).map(move |_| random.random_range(0..points)))
}

/// Axes whose values all give the same design, wherever they are tried.
fn axes(space: &Space, found: &mut AxisFound<'_>) {
    if space.axes.is_empty() {
        return;
    }
    let mut random = Pcg64::seed_from_u64(2);
    let points = space.lattice.points();
    let mut around: Vec<u64> = vec![0, points - 1];
    around.extend((2..TRIES).map(|_| random.random_range(0..points)));
    for number in 0..space.axes.len() {
        if space.lattice.sides()[number].len < 2 {
            continue;
        }
        let places = match space.axes[number].when {
            None => around.clone(),
            Some(_) => where_it_counts(space, number),
        };
        if places.is_empty() {
            if space.has_common_axes {
                continue;
            }
            let message = "the condition holds at none of the points that were tried";
            found.wrong(&format!("axes.{number}.when"), message);
            continue;
        }
        match moves(space, number, &places) {
            Ok(false) => {
                let axis = &space.axes[number];
                let keys = axis.keys().into_iter().collect();
                let message = format!("the axis `{}` changes nothing{}", axis.name, why(&keys));
                found.wrong(&format!("axes.{number}"), message);
            }
            Ok(true) => {}
            Err(Rejected::Expression { place, message }) => found.wrong(&place, message),
            Err(_) => {}
        }
    }
}

/// Points at which an axis with a condition counts.
fn where_it_counts(space: &Space, number: usize) -> Vec<u64> {
    let counts = |index: &u64| {
        // What is wrong with the condition is found when the point is built.
        Draft::new(space, *index).map_or(true, |draft| draft.active[number])
    };
    some_points(space, LOOK_MAX).filter(counts).take(TRIES).collect()
}

/// Whether two values of an axis give different designs; also true where too few points are designs
/// at all to tell.
fn moves(space: &Space, number: usize, around: &[u64]) -> Result<bool, Rejected> {
    let len = space.lattice.sides()[number].len;
    let tried = len.min(VALUES_MAX);
    let mut compared = false;
    for &index in around {
        let mut digits = space.lattice.digits(index);
        let mut first: Option<Design> = None;
        for i in 0..tried {
            // Evenly from the first to the last; with two values at least, nothing is divided by 0.
            digits[number] = (u64::from(i) * u64::from(len - 1) / u64::from(tried - 1)) as u32;
            let design = match space.built(space.lattice.index(&digits), false) {
                Ok(design) => design,
                Err(error @ Rejected::Expression { .. }) => return Err(error),
                Err(_) => continue,
            };
            match &first {
                None => first = Some(design),
                Some(other) if !is_same(other, &design) => return Ok(true),
                Some(_) => compared = true,
            }
        }
    }
    Ok(!compared)
}

/// Whether two designs have the same results on every trace: one timing, and the same prices. Other
/// prices in files that do not reach them are no difference.
fn is_same(a: &Design, b: &Design) -> bool {
    let prices = |d: &Design| d.prices.iter().map(|p| p.prices.clone()).collect::<Vec<_>>();
    let display = |d: &Design| d.display.as_ref().map(|display| (display.id, d.display_fps));
    // The memory's own prices are in the table's, where that takes them.
    let timing = || {
        let (Some(own), Some(other)) = (&a.device, &b.device) else { return None };
        let device = Device { energy: own.value.energy.clone(), ..other.value.clone() };
        Some(timing_id(&b.machine, Some(content_id(&device).ok()?)))
    };
    (a.timing_id == b.timing_id || timing() == Some(a.timing_id))
        && untimed(&a.machine) == untimed(&b.machine)
        && prices(a) == prices(b)
        && display(a) == display(b)
}

/// Designs on which tables and keys of `set` are tried, whatever the constraints say.
fn tried(space: &Space) -> Vec<Design> {
    some_points(space, TRIED).filter_map(|index| space.built(index, false).ok()).collect()
}

/// Keys of `set` that change no design. A value that the file has anyway is no mistake.
fn settings(space: &Space, found: &mut AxisFound<'_>) {
    let is_name = |key: &Key| ["name", "description"].contains(&key.path.as_str());
    let of_interest = |(_, (key, _)): &(usize, &LibraryChange)| !key.is_machine() && !is_name(key);
    let designs = if space.set.is_empty() { Vec::new() } else { tried(space) };
    for (number, (key, value)) in space.set.iter().enumerate().filter(of_interest) {
        let moves = |design: &Design| match space.built_without(design.index, number) {
            Ok(other) => !is_same(design, &other),
            // Without it there is no machine.
            Err(_) => true,
        };
        let is_restated = |design: &Design| {
            let draft = Draft::without(space, design.index, Some(number));
            let own = draft.ok().and_then(|draft| draft.file_value(key));
            own.is_some_and(|own| is_alike(key, &own, value))
        };
        let is_dead = |design: &Design| !moves(design) && !is_restated(design);
        if !designs.is_empty() && designs.iter().all(is_dead) {
            let why = why(&BTreeSet::from([*key]));
            found.wrong(&format!("set.{key}"), format!("`{key}` changes nothing{why}"));
        }
    }
}

/// Energy tables that price every design as another one does, and changed keys of them that change
/// no price.
fn tables(space: &Space, found: &mut AxisFound<'_>) {
    let is_alone = space.energy.iter().all(|e| e.table.is_none());
    let designs = if is_alone { Vec::new() } else { tried(space) };
    if designs.is_empty() {
        return;
    }
    for (j, energy) in space.energy.iter().enumerate() {
        let dead: BTreeSet<&Key> = (0..energy.changes.len())
            .filter(|&number| !changes_price(space, &designs, j, number))
            .map(|number| energy.changes[number].0)
            .collect();
        let is_twin = |i: &usize| designs.iter().all(|d| d.prices[*i].prices == d.prices[j].prices);
        let label = &energy.label;
        let refused = |design: &Design| design.prices[j].prices.as_ref().err().cloned();
        if let Some(Some(message)) = designs.first().map(refused)
            && designs.iter().all(|design| refused(design).is_some())
        {
            let message = format!("the table `{label}` prices no design, e.g.: {message}");
            found.wrong(&format!("energy.{j}"), message);
            continue;
        }
        if let Some(i) = (0..j).find(is_twin) {
            let (other, why) = (&space.energy[i].label, why(&dead));
            let message = format!(
                "the table `{label}` prices every design as `{other}` does{why}; drop one of \
                 the two"
            );
            found.wrong(&format!("energy.{j}"), message);
        } else if !dead.is_empty() {
            let keys: Vec<String> = dead.iter().map(|key| format!("`{}`", key.path)).collect();
            let message = format!("{} changes no price{}", keys.join(", "), why(&dead));
            found.wrong(&format!("energy.{j}.set"), message);
        }
    }
}

/// Whether a changed key of a table changes a price of a design. A value that the table has anyway
/// counts as a change: it is no mistake.
fn changes_price(space: &Space, designs: &[Design], table: usize, number: usize) -> bool {
    let energy = &space.energy[table];
    let mut changes = energy.changes.clone();
    let (key, value) = changes.remove(number);
    let other = Energy { label: energy.label.clone(), table: energy.table.clone(), changes };
    designs.iter().any(|design| {
        // What cannot be built proves nothing against the key.
        let Ok(mut draft) = Draft::new(space, design.index) else { return true };
        if draft.derive().is_err() {
            return true;
        }
        match space.priced(&draft, &other, &design.machine) {
            Ok(priced) => {
                let own = get(&priced.table.table, &key.path);
                priced.prices != design.prices[table].prices
                    || own.is_some_and(|own| is_alike(key, own, &value))
            }
            Err(_) => true,
        }
    })
}

/// Whether two values of a key are one, in whatever unit.
fn is_alike(key: &Key, a: &Value, b: &Value) -> bool {
    let value = |value: &Value| key.domain().value(value);
    a == b || (value(a).is_some() && value(a) == value(b))
}

/// Why keys move nothing, where that is known.
fn why(keys: &BTreeSet<&Key>) -> String {
    static WHEN: LazyLock<toml::Table> = LazyLock::new(|| INERT.parse().unwrap_or_default());
    if keys.is_empty() {
        return String::new();
    }
    if keys.iter().all(|k| ["name", "description"].contains(&k.path.as_str())) {
        return ": names move reports only".to_owned();
    }
    if keys.iter().any(|k| k.file == FileKind::Machine && k.path == "energy") {
        return ": [[energy]] says which tables price every point; drop one of the two".to_owned();
    }
    let reason = |key: &super::Key| {
        let table = match key.file {
            FileKind::Machine => "machine",
            FileKind::Energy => "energy",
            FileKind::Dram => "dram",
            FileKind::Display => return None,
        };
        if let Some(part) = Optional::of(&key.path).filter(|_| key.file == FileKind::Machine) {
            let Optional { what, switch, .. } = part;
            return Some(format!(": `{key}` moves nothing without {what}: give `{switch}`"));
        }
        let inert = WHEN.get(table)?.get(&key.path)?;
        let when = inert.get("when")?.as_str()?;
        let bytes = key.file == FileKind::Energy && key.path.starts_with("dram.flat.");
        let other = if bytes { "; it does in the table `gscore-28nm-flat`" } else { "" };
        Some(format!(": `{key}` moves nothing where {when}{other}"))
    };
    if let Some(reason) = keys.iter().find_map(|key| reason(key)) {
        return reason;
    }
    if keys.iter().any(|k| k.file == FileKind::Dram && k.path.starts_with("energy.")) {
        return ": the energy table prices bytes (`dram.flat`), not the commands of the device"
            .to_owned();
    }
    if keys.iter().any(|k| k.file == FileKind::Dram) {
        return ": `dram.model` = \"bandwidth\" takes only the peak rate and prices from the device"
            .to_owned();
    }
    String::new()
}

/// At least one point must be a design.
fn first_design(space: &Space, found: &mut AxisFound<'_>) {
    let mut causes: BTreeMap<String, (u64, String)> = BTreeMap::new();
    let mut looked = 0u64;
    for index in some_points(space, LOOK_MAX) {
        looked += 1;
        match space.design(index) {
            Ok(_) => return,
            Err(Rejected::Expression { place, message }) => return found.wrong(&place, message),
            Err(other) => {
                let example = other.to_string();
                causes.entry(other.cause()).or_insert((0, example)).0 += 1;
            }
        }
    }
    let mut causes: Vec<(String, (u64, String))> = causes.into_iter().collect();
    causes.sort_by_key(|(_, (n, _))| std::cmp::Reverse(*n));
    let points = space.lattice.points();
    let of = match looked < points {
        true => format!("none of {looked} random points of {points} is a design"),
        false => format!("none of the {points} points is a design"),
    };
    let line = |(cause, (n, example)): &(String, (u64, String))| {
        let example = example.lines().next().unwrap_or("");
        let example: String = example.chars().take(240).collect();
        let is_constraint = cause.starts_with("constraint");
        let tail = if is_constraint { String::new() } else { format!(", e.g. {example}") };
        let kind = if is_constraint { "excluded by" } else { "invalid:" };
        format!("\n  {n} {kind} {cause}{tail}")
    };
    let lines: String = causes.iter().take(8).map(line).collect();
    let place = causes.iter().find_map(|(cause, _)| {
        let text = cause.strip_prefix("constraint `")?.strip_suffix('`')?;
        let number = space.constraints.iter().position(|c| c.expr.text() == text)?;
        Some(format!("constraints.{number}"))
    });
    found.wrong(&place.unwrap_or_else(|| "axes".to_owned()), format!("{of}:{lines}"));
}
