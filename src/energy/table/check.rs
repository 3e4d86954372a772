//! What must hold in an energy table beyond the shape of its keys.

use super::{ActionPrice, BytePrice, EnergyTable, PowerPrice, SramPrices};
use crate::config::references::is_source;

type Found = Vec<(String, String)>;

/// Every contradiction, as (key, what is wrong and what to do).
pub(super) fn problems(table: &EnergyTable) -> Found {
    let mut found = Vec::new();
    for (key, price) in actions(table) {
        action(&key, price, table.flop.is_some(), &mut found);
    }
    if let Some(flop) = &table.flop {
        action("flop", flop, false, &mut found);
    }
    for (key, price) in [("dram.read", &table.dram.read), ("dram.write", &table.dram.write)] {
        byte(key, price, &mut found);
    }
    let leakage = &table.leakage;
    let powers = [
        ("dram.background", &table.dram.background),
        ("leakage.ccu", &leakage.ccu),
        ("leakage.qsu", &leakage.qsu),
        ("leakage.bsu", &leakage.bsu),
        ("leakage.vru", &leakage.vru),
    ];
    for (key, price) in powers {
        power(key, price, &mut found);
    }
    sram(&table.sram, &mut found);
    found
}

fn actions(table: &EnergyTable) -> Vec<(String, &ActionPrice)> {
    let arithmetic = |a| Some((a, table.arithmetic(a)?));
    let all = crate::action::Action::all();
    let priced = all.into_iter().filter_map(arithmetic);
    priced.map(|(a, price)| (format!("actions.{}", a.key()), price)).collect()
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

fn free(key: &str, what: &str, value: f64, free: bool, found: &mut Found) {
    if value == 0.0 && !free {
        zero(key, what, found);
    }
    if value != 0.0 && free {
        let message = format!("`{key}` is free and has a price: drop one of them");
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

fn sram(sram: &SramPrices, found: &mut Found) {
    if let Some(flat) = &sram.flat {
        byte("sram.flat", flat, found);
    }
    if sram.flat.is_some() == sram.table.is_some() {
        let message = "`sram` needs exactly one of [sram.flat] and [sram.table]";
        found.push(("sram".to_owned(), message.to_owned()));
    }
    let Some(table) = &sram.table else { return };
    source("sram.table", &table.source, found);
    let key = "sram.table.sizes";
    let ascending = table.sizes.windows(2).all(|w| w[0].capacity < w[1].capacity);
    if table.sizes.len() < 2 || !ascending {
        let message = format!("`{key}` needs at least two sizes, ascending");
        found.push((key.to_owned(), message));
    }
    for row in &table.sizes {
        if row.capacity.0 == 0 || row.read.0 == 0.0 || row.write.0 == 0.0 || row.leakage.0 == 0.0 {
            let message = format!("`{key}`: the row of {} has a zero", row.capacity);
            found.push((key.to_owned(), message));
        }
    }
}
