//! Whether a space is worth running: it has a design, and every axis moves something.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::{Axis, Draft, FileKind, Found, Rejected, Space};
use crate::sweep::file::Method;
use crate::sweep::sample::sobol;
use powergs_base::config::embedded::INERT;
use powergs_core::accel::machine::NO_DEVICE;

/// Points that are tried until one is a design.
const LOOK_MAX: u64 = 10_000;

/// Surroundings in which an axis is tried.
const TRIES: usize = 6;

/// Values of an axis that are tried in each.
const VALUES_MAX: u32 = 64;

pub(super) fn all(space: &Space, found: &mut Found<'_>) {
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
    if space.axes.is_empty() {
        return first_design(space, found);
    }
    axes(space, found);
    first_design(space, found);
}

/// Every file that is named without an expression.
fn files(space: &Space, found: &mut Found<'_>) {
    let library = &space.library;
    let base = found.ok("base", library.machine(&space.base));
    let folder = base.as_ref().and_then(|b| b.folder.clone());
    for (i, energy) in space.energy.iter().enumerate() {
        if let Some(name) = &energy.table {
            let plain = found.ok(&format!("energy.{i}.table"), library.table(name, None, &[]));
            if plain.is_some() && !energy.changes.is_empty() {
                let changed = library.table(name, None, &energy.changes);
                found.ok(&format!("energy.{i}.set"), changed);
            }
        }
    }
    if let Some(name) = &space.display {
        found.ok("display", library.display(name, &[]));
    }
    let named = |axis: &'_ Axis| {
        let settings = axis.steps.iter().enumerate();
        let settings = settings.flat_map(|(i, s)| s.settings.iter().map(move |c| (i, c.clone())));
        settings.collect::<Vec<_>>()
    };
    for (number, axis) in space.axes.iter().enumerate() {
        for (i, (key, value)) in named(axis) {
            let (FileKind::Machine, Some(name)) = (key.file, value.as_str()) else { continue };
            let beside = folder.as_deref();
            let wrong = match key.path.as_str() {
                "machine" => library.machine(name).err(),
                "energy" => library.table(name, beside, &[]).err(),
                "dram.device" if name == NO_DEVICE => None,
                "dram.device" => library.device(name, beside, &[]).err(),
                _ => None,
            };
            if let Some(message) = wrong {
                let list = if axis.has_names { "variants" } else { "values" };
                found.wrong(&format!("axes.{number}.{list}.{i}"), message);
            }
        }
    }
}

/// Numbers of points to look at: all of a small space, random ones of a large one.
fn some_points(space: &Space, most: u64) -> Box<dyn Iterator<Item = u64>> {
    let points = space.lattice.points();
    if points <= most {
        return Box::new(0..points);
    }
    let mut random = Pcg64::seed_from_u64(1);
    Box::new((0..most).map(move |_| random.random_range(0..points)))
}

/// Axes whose values all give the same design, wherever they are tried.
fn axes(space: &Space, found: &mut Found<'_>) {
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
                let message = format!("the axis `{}` changes nothing{}", axis.name, why(axis));
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
        let mut first: Option<u128> = None;
        for i in 0..tried {
            digits[number] = (u64::from(i) * u64::from(len - 1) / u64::from(tried - 1)) as u32;
            let id = match space.built(space.lattice.index(&digits), false) {
                Ok(design) => design.id,
                Err(error @ Rejected::Expression { .. }) => return Err(error),
                Err(_) => continue,
            };
            match first {
                None => first = Some(id),
                Some(other) if other != id => return Ok(true),
                Some(_) => compared = true,
            }
        }
    }
    Ok(!compared)
}

/// Why the keys of an axis move nothing, where that is known.
fn why(axis: &Axis) -> String {
    static WHEN: LazyLock<toml::Table> = LazyLock::new(|| INERT.parse().unwrap_or_default());
    let keys = axis.keys();
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
        let when = WHEN.get(table)?.get(&key.path)?.get("when")?.as_str()?;
        Some(format!(": `{key}` moves nothing where {when}"))
    };
    if let Some(reason) = keys.iter().find_map(|key| reason(key)) {
        return reason;
    }
    if keys.iter().any(|k| k.file == FileKind::Dram) {
        return ": `dram.model` = \"bandwidth\" takes only the peak rate from the device"
            .to_owned();
    }
    String::new()
}

/// At least one point must be a design.
fn first_design(space: &Space, found: &mut Found<'_>) {
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
