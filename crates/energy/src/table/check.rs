//! Consistency of an energy table, beyond the shape of its keys.

use super::{
    ActionPrice, BytePrice, EnergyTable, PowerPrice, SramCacti, SramMacro, SramPrices, SramTable,
};
use crate::hardware::{Catalogue, Does, Unpriced};
use powergs_base::config::references::is_source;

type Found = Vec<(String, String)>;

/// Every contradiction, as (key, what is wrong and what to do).
pub(super) fn problems<C: Catalogue>(table: &EnergyTable<C>) -> Found {
    let mut found = Vec::new();
    for (key, price) in table.actions.iter() {
        action(&format!("actions.{key}"), price, table.flop.is_some(), &mut found);
    }
    if let Some(flop) = &table.flop {
        action("flop", flop, false, &mut found);
    }
    for (unit, price) in table.leakage.iter() {
        power(&format!("leakage.{unit}"), price, &mut found);
    }
    whole(table, &mut found);
    clock(table, &mut found);
    rows(table, &mut found);
    numbers(table, &mut found);
    dram(table, &mut found);
    sram(table, &mut found);
    nodes(table, &mut found);
    area(table, &mut found);
    parts(table, &mut found);
    phy(table, &mut found);
    supply(table, &mut found);
    idle(table, &mut found);
    found
}

/// A table that prices something of a unit prices all of it.
fn whole<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let hardware = C::hardware();
    for (id, unit) in hardware.units().filter(|(_, unit)| unit.counted_in.is_none()) {
        let works = |is_own: bool| {
            hardware.actions().filter_map(move |(_, does)| match does {
                Does::Work(stage, work)
                    if work.unpriced == Unpriced::Never
                        && (stage == id) == is_own
                        && hardware.doers(stage, work.key).any(|doer| doer == id) =>
                {
                    Some((table.actions.contains_key(work.key), "actions", work.key))
                }
                _ => None,
            })
        };
        let mut keys: Vec<(bool, &str, &str)> = works(true).collect();
        keys.push((table.leakage.contains_key(unit.key), "leakage", unit.key));
        if let Some(area) = &table.area {
            keys.push((area.units.contains_key(unit.key), "area", unit.key));
        }
        if let Some(clock) = &table.clock {
            keys.push((clock.contains_key(unit.key), "clock", unit.key));
        }
        if keys.iter().any(|(is_there, ..)| *is_there) {
            let all = keys.into_iter().chain(works(false));
            for (_, at, key) in all.filter(|(is_there, ..)| !is_there) {
                let message = format!(
                    "missing key `{key}` in [{at}]: the table has other prices of the {}",
                    unit.words
                );
                found.push((at.to_owned(), message));
            }
        }
    }
}

fn action(key: &str, price: &ActionPrice, has_flop: bool, found: &mut Found) {
    let ways = [price.energy.is_some(), price.flops.is_some(), price.free];
    if ways.iter().filter(|w| **w).count() != 1 {
        let message = "needs exactly one of `energy`, `flops` and `free = true`";
        found.push((key.to_owned(), format!("`{key}` {message}")));
    }
    if price.flops.is_some() && !has_flop {
        let message = "counts FLOPs, but the table has no price of one: add [flop]";
        found.push((key.to_owned(), format!("`{key}` {message}")));
    }
    if price.energy.is_some_and(|e| e.0 == 0.0) {
        zero(key, "energy", found);
    }
    source(key, &price.source, found);
}

fn byte(key: &str, price: &BytePrice, found: &mut Found) {
    free(key, "energy", price.energy.0, price.free, found);
    source(key, &price.source, found);
}

fn power(key: &str, price: &PowerPrice, found: &mut Found) {
    free(key, "power", price.power.0, price.free, found);
    source(key, &price.source, found);
}

fn clock<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(clock) = &table.clock else { return };
    for (unit, price) in clock.iter() {
        let key = format!("clock.{unit}");
        free(&key, "energy", price.energy.0, false, found);
        source(&key, &price.source, found);
    }
}

fn numbers<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(numbers) = &table.numbers else { return };
    source("numbers", &numbers.source, found);
    for (i, row) in numbers.formats.iter().enumerate() {
        let mut say = |what: String| found.push(("numbers.formats".to_owned(), what));
        for (key, factor) in [
            ("energy", row.energy),
            ("clock", row.clock.unwrap_or(1.0)),
            ("leakage", row.leakage),
            ("area", row.area),
        ] {
            if !(0.01..=100.0).contains(&factor) {
                say(format!("`{key}` = {factor} of {} must be from 0.01 to 100", row.numbers));
            }
        }
        if row.clock.is_some() != table.clock.is_some() {
            say(format!("`clock` of {} is given where the table has [clock]", row.numbers));
        }
        if numbers.formats[..i].iter().any(|other| other.numbers == row.numbers) {
            say(format!("`numbers.formats` has {} twice", row.numbers));
        }
    }
}

/// What is made of another action is priced itself, with all others that are, or by that action.
fn rows<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let actions = &table.actions;
    for whole in actions.keys() {
        let made = C::hardware().actions().filter_map(|(_, does)| match does {
            Does::Work(_, work) => match work.unpriced {
                Unpriced::MadeOf(of) if of == whole => Some(work.key),
                _ => None,
            },
            _ => None,
        });
        let made: Vec<&str> = made.collect();
        let priced = made.iter().filter(|key| actions.contains_key(**key)).count();
        let is_free = actions[whole].free;
        if priced == 0 || (priced == made.len() && is_free) {
            continue;
        }
        let made: Vec<String> = made.iter().map(|key| format!("`{key}`")).collect();
        let message = format!(
            "`actions` prices `{whole}` and what it is made into: give {} and set `{whole}.free = \
             true`, or give none of them",
            made.join(" and ")
        );
        found.push((format!("actions.{whole}"), message));
    }
}

fn free(key: &str, what: &str, value: f64, free: bool, found: &mut Found) {
    if value == 0.0 && !free {
        zero(key, what, found);
    }
    if value != 0.0 && free {
        let message = format!("`{key}` is free and has a price: drop `free` or `{what}`");
        found.push((key.to_owned(), message));
    }
}

fn zero(key: &str, what: &str, found: &mut Found) {
    let message = format!("`{key}.{what}` is zero: give a price, or say `free = true`");
    found.push((key.to_owned(), message));
}

fn source(key: &str, source: &str, found: &mut Found) {
    if !is_source(source) {
        let message = format!(
            "`{key}.source` = \"{source}\" is neither a key of references.toml nor an assumption \
             number (A1, A2, ...)"
        );
        found.push((key.to_owned(), message));
    }
}

fn dram<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    if table.dram.flat.is_none() && !table.dram.device {
        let message = "`dram` needs [dram.flat], `device = true` or both";
        found.push(("dram".to_owned(), message.to_owned()));
    }
    if let Some(hits) = &table.dram.row_hits {
        share("dram.row-hits.share", hits.share, found);
        source("dram.row-hits", &hits.source, found);
    }
    let Some(flat) = &table.dram.flat else { return };
    byte("dram.flat.read", &flat.read, found);
    byte("dram.flat.write", &flat.write, found);
    power("dram.flat.background", &flat.background, found);
    power("dram.flat.refresh", &flat.refresh, found);
    let standby = !flat.background.free || !flat.refresh.free;
    if flat.channels.is_none() && standby {
        let message = "missing key `channels` in [dram.flat]: write how many memory channels \
                       `background` and `refresh` are for, e.g. channels = 8";
        found.push(("dram.flat".into(), message.into()));
    }
}

/// Published units are divided over what they consist of.
fn parts<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(parts) = &table.parts else {
        if table.area.is_some() || table.leakage.values().any(|l| !l.free) {
            let message = "missing table [parts]: it says what of a unit grows with its widths and \
                           depths; copy it from gscore-28nm (`arch show gscore-28nm`)";
            found.push(("parts".into(), message.into()));
        }
        return;
    };
    for (stage, factor) in &parts.factors {
        source(&format!("parts.{stage}"), &factor.source, found);
    }
    for (stage, shares) in &parts.shares {
        for (part, share) in shares {
            source(&format!("parts.{stage}.{part}"), &share.source, found);
        }
    }
    for (key, sum) in parts.too_much() {
        let message = format!("the shares in `{key}` sum to {sum:.3}: they must be at most 1");
        found.push((key, message));
    }
}

fn phy<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(phy) = &table.phy else {
        if table.area.is_some() {
            let message = "missing table [phy]: area and standby power of the chip's side of one \
                           memory channel; copy it from gscore-28nm (`arch show gscore-28nm`)";
            found.push(("phy".into(), message.into()));
        }
        return;
    };
    if phy.area.area.0 == 0.0 {
        found.push(("phy.area".into(), "`phy.area.area` is zero: no PHY takes no area".into()));
    }
    source("phy.area", &phy.area.source, found);
    if phy.controller.area.0 == 0.0 {
        let message = "`phy.controller.area` is zero: no controller takes no area";
        found.push(("phy.controller".into(), message.into()));
    }
    source("phy.controller", &phy.controller.source, found);
    power("phy.standby", &phy.standby, found);
}

fn supply<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(supply) = &table.supply else { return };
    source("supply", &supply.source, found);
    let (choice, voltage) = match (&supply.curve, supply.voltage) {
        (Some(choice), Some(voltage)) => (choice, voltage.0),
        // The clock alone: prices are as given at any other one.
        (None, None) => return,
        (Some(_), None) => {
            let message = "missing key `voltage` in [supply]: the curve needs the voltage at which \
                           the units reach `clock`";
            return found.push(("supply".into(), message.into()));
        }
        (None, Some(_)) => {
            let message = "`supply.voltage` does nothing without `supply.curve`: add one, e.g. \
                           curve = { node = \"28 nm\" }, or leave `voltage` out";
            return found.push(("supply.voltage".into(), message.into()));
        }
    };
    match (choice.node, table.node) {
        (Some(curve), Some(node)) if curve != node => {
            let message = format!("`supply.curve.node` = {curve} and `node` = {node} disagree");
            found.push(("supply.curve".into(), message));
        }
        _ => {}
    }
    match &choice.source {
        Some(given) => source("supply.curve", given, found),
        None if choice.node.is_none() => {
            let message = "`supply.curve` is of your own: say where it is from in `source`";
            found.push(("supply.curve".into(), message.into()));
        }
        None => {}
    }
    match choice.curve() {
        Ok(curve) if !(curve.lowest.0..=curve.highest.0).contains(&voltage) => {
            let message = format!(
                "`supply.voltage` = {voltage} V is outside of `supply.curve`: {} to {} V",
                curve.lowest.0, curve.highest.0
            );
            found.push(("supply.voltage".into(), message));
        }
        Ok(_) => {}
        Err(message) => {
            found.push(("supply.curve".into(), format!("`supply.curve`: {message}")));
        }
    }
}

/// What stays between frames is a share of what there is.
fn idle<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(idle) = &table.idle else { return };
    share("idle.leakage", idle.leakage, found);
    share("idle.background", idle.background, found);
    source("idle", &idle.source, found);
}

fn share(key: &str, value: f64, found: &mut Found) {
    if !(0.0..=1.0).contains(&value) {
        found.push((key.to_owned(), format!("`{key}` = {value} must be from 0 to 1")));
    }
}

fn sram<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let sram = &table.sram;
    if forms(sram) != 1 {
        let message = "`sram` needs exactly one of [sram.flat], [sram.table], [sram.cacti] and \
                       [[sram.macros]]";
        found.push(("sram".to_owned(), message.to_owned()));
    }
    if let Some(flat) = &sram.flat {
        byte("sram.flat", flat, found);
    }
    if let Some(sizes) = &sram.table {
        sizes_of(sizes, found);
    }
    if let Some(cacti) = &sram.cacti {
        rows_of(cacti, found);
    }
    if let Some(macros) = &sram.macros {
        macros_of::<C>(macros, found);
    }
}

/// How many of the ways to price buffers are there.
fn forms(sram: &SramPrices) -> usize {
    let ways =
        [sram.flat.is_some(), sram.table.is_some(), sram.cacti.is_some(), sram.macros.is_some()];
    ways.into_iter().filter(|there| *there).count()
}

fn sizes_of(table: &SramTable, found: &mut Found) {
    source("sram.table", &table.source, found);
    let key = "sram.table.sizes";
    let ascending = table.sizes.windows(2).all(|w| w[0].capacity < w[1].capacity);
    if table.sizes.len() < 2 || !ascending {
        let message = format!("`{key}` needs at least two sizes, ascending");
        found.push((key.to_owned(), message));
    }
    for row in &table.sizes {
        let area = row.area.is_some_and(|a| a.0 == 0.0);
        let prices = [row.read.0, row.write.0, row.leakage.0];
        if row.capacity.0 == 0 || area || prices.contains(&0.0) {
            let message = format!("`{key}`: the row of {} has a zero", row.capacity);
            found.push((key.to_owned(), message));
        }
    }
}

fn rows_of(cacti: &SramCacti, found: &mut Found) {
    source("sram.cacti", &cacti.source, found);
    if let Err(message) = cacti.banks() {
        let message = format!("`sram.cacti` (`node`, `cell`, `temperature`): {message}");
        found.push(("sram.cacti".to_owned(), message));
    }
}

fn macros_of<C: Catalogue>(macros: &[SramMacro], found: &mut Found) {
    let key = "sram.macros";
    let names: Vec<String> = C::hardware().buffers().map(|(_, buffer)| buffer.key()).collect();
    for (i, one) in macros.iter().enumerate() {
        source(key, &one.source, found);
        let name = &one.buffer;
        let wrong = if !names.contains(name) {
            Some(format!("no buffer `{name}`; there are {}", names.join(", ")))
        } else if macros[..i].iter().any(|m| m.buffer == *name) {
            Some(format!("`{name}` appears twice"))
        } else {
            None
        };
        found.extend(wrong.map(|message| (key.to_owned(), format!("`{key}`: {message}"))));
    }
}

/// Prices are for the node of the table, or are brought there.
fn nodes<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(node) = table.node else {
        found.push(("node".into(), "missing key `node`: write e.g. node = \"28 nm\"".into()));
        return;
    };
    let (of, key) = match &table.scaling {
        Some(scaling) => (scaling.from, "scaling.from"),
        None => (node, "node"),
    };
    if let Some(cacti) = table.sram.cacti.as_ref().filter(|cacti| cacti.node != of) {
        let message = format!(
            "`sram.cacti.node` = {} and `{key}` = {of} disagree: all prices of a file are for one \
             node; take rows of {of}, or bring the others there by [scaling]",
            cacti.node
        );
        found.push(("sram.cacti.node".into(), message));
    }
    let Some(scaling) = &table.scaling else { return };
    if scaling.from == node {
        let message = format!(
            "`scaling.from` and `node` are both {node}: there is nothing to scale, drop [scaling]"
        );
        found.push(("scaling.from".into(), message));
    }
    for (name, factor, what) in scaling.all() {
        let key = format!("scaling.{name}");
        if let Err(message) = factor.value(what, scaling.from, node) {
            found.push((key.clone(), format!("`{key}`: {message}")));
        }
        match &factor.source {
            Some(given) => source(&key, given, found),
            None if factor.factor.is_some() => {
                let message = format!(
                    "`{key}` is a number of your own: say where it is from in \
                                       `source`"
                );
                found.push((key, message));
            }
            None => {}
        }
    }
}

fn area<C: Catalogue>(table: &EnergyTable<C>, found: &mut Found) {
    let Some(area) = &table.area else { return };
    for (name, price) in area.units.iter() {
        let key = format!("area.{name}");
        if price.area.0 == 0.0 {
            found.push((key.clone(), format!("`{key}.area` is zero: no unit takes no area")));
        }
        source(&key, &price.source, found);
    }
    source("area.sram-overhead", &area.sram_overhead.source, found);
    source("area.rest", &area.rest.source, found);
    let sram = &table.sram;
    let missing = sram.flat.is_some()
        || sram.table.as_ref().is_some_and(|t| t.sizes.iter().any(|s| s.area.is_none()))
        || sram.macros.as_ref().is_some_and(|all| all.iter().any(|m| m.area.is_none()));
    if missing && forms(sram) == 1 {
        let message = "`area` needs the area of every buffer: `sram.flat` has none, and rows of \
                       [sram.table] and [[sram.macros]] have it in `area`; give it or drop [area]";
        found.push(("area".into(), message.into()));
    }
}
