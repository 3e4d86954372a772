//! Keys that follow an axis because machines without them would contradict themselves.
//!
//! A sort group is a square of tiles, and a tile is a whole number of sub-tiles. So where an axis
//! varies `geometry.tile` and nothing says what becomes of these two, groups keep their number of
//! tiles of the base machine, and sub-tiles their size, up to a tile; where each sub-tile has its
//! own units (`vru.impl = "parallel"`), they are as large as the units are enough for.

use std::collections::BTreeSet;

use toml::{Table, Value};

use super::derive::Derived;
use super::{Axis, AxisFound, FileKind, Key, Library, get};
use crate::sweep::expr::Expr;
use crate::sweep::file::{AxisSpec, SweepFile};
use crate::sweep::key::MACHINE;

const TILE: &str = "geometry.tile";
const GROUP: &str = "geometry.sort-group";
const SUBTILE: &str = "geometry.subtile";

/// The keys that follow an axis of a sweep file by default.
pub(crate) fn keys(file: &SweepFile) -> Vec<&'static str> {
    let axes: BTreeSet<&str> = varied(file).collect();
    if !axes.contains(TILE) || axes.contains(MACHINE) {
        return Vec::new();
    }
    let is_given = |key: &str| {
        let mut others = file.set.0.iter().chain(&file.derived.0);
        axes.contains(key) || others.any(|(other, _)| other == key)
    };
    [GROUP, SUBTILE].into_iter().filter(|key| !is_given(key)).collect()
}

/// The keys that any axis varies.
pub(super) fn varied(file: &SweepFile) -> impl Iterator<Item = &str> {
    file.axes.iter().flat_map(of_axis)
}

/// The keys that an axis varies.
fn of_axis(axis: &AxisSpec) -> Vec<&str> {
    let zip = axis.zip.iter().flat_map(|zip| zip.0.iter().map(|(key, _)| key.as_str()));
    let variants = axis.variants.iter().flatten();
    let set = variants.flat_map(|variant| variant.set.0.iter().map(|(key, _)| key.as_str()));
    axis.key.as_deref().into_iter().chain(zip).chain(set).collect()
}

/// Those keys with what they are derived as.
pub(super) fn derived(
    file: &SweepFile,
    axes: &[Axis],
    library: &Library,
    found: &mut AxisFound<'_>,
) -> Vec<Derived> {
    let keys = keys(file);
    let settings = axes.iter().flat_map(|axis| axis.steps.iter().flat_map(|s| &s.settings));
    let tiles =
        settings.filter(|(key, _)| is_tile(key)).filter_map(|(_, value)| value.as_integer());
    let ends = tiles.fold(None, |ends: Option<(i64, i64)>, tile| {
        Some(ends.map_or((tile, tile), |(a, b)| (a.min(tile), b.max(tile))))
    });
    let Some(ends) = ends.filter(|_| !keys.is_empty()) else { return Vec::new() };
    // A base machine that cannot be read is told about elsewhere.
    let Ok(base) = library.machine(&file.base, None) else { return Vec::new() };
    let one = |name: &&'static str| {
        let key = found.ok("axes", Key::find(name))?;
        let expr = found.ok("axes", Expr::parse(&expression(name, &base.table, ends)?))?;
        Some(Derived { name: (*name).to_owned(), key, expr, is_carried: true })
    };
    keys.iter().filter_map(one).collect()
}

fn is_tile(key: &Key) -> bool {
    key.file == FileKind::Machine && key.path == TILE
}

/// How many sub-tiles may be side by side in a tile, where each has its own units.
fn most_abreast(base: &Table) -> Option<i64> {
    let way = get(base, "vru.impl").and_then(Value::as_str);
    let units = get(base, "vru.units-per-core").and_then(Value::as_integer);
    let units = units.filter(|n| *n > 0 && way == Some("parallel"))?;
    // A power of two on each side, and the square of it no more than the units.
    Some(1 << (units.ilog2() / 2))
}

/// How a key of the base machine follows its tile, which goes from the smallest to the largest;
/// `None` where it can stay.
fn expression(key: &str, base: &Table, (smallest, largest): (i64, i64)) -> Option<String> {
    let number = |key: &str| get(base, key).and_then(Value::as_integer).filter(|n| *n > 0);
    let (tile, own) = (number(TILE)?, number(key)?);
    Some(match key {
        GROUP if own > tile => format!("{} * {TILE}", own / tile),
        GROUP => TILE.to_owned(),
        _ => {
            let abreast = most_abreast(base).filter(|most| largest > own * most);
            match (abreast, own <= smallest) {
                (None, true) => return None,
                (None, false) => format!("min({own}, {TILE})"),
                (Some(most), _) => format!("max(min({own}, {TILE}), {TILE} / {most})"),
            }
        }
    })
}
