//! Whether the answer holds under other energy tables and other views, and what makes the pair.

use super::compare::{CompareBudget, Comparison, Market, Pair, Way};
use super::pricing::{HALVES, Price, SCOPES};

/// The five ways under an energy table, on some views, with the calibrated model of the DRAM.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// Label of the energy table.
    pub table: String,
    /// Which views: all, or a half of them.
    pub views: &'static str,
    /// Watts of (a) to (e), searched anew; `None` where a way finds nothing.
    pub watts: [Option<f64>; Way::ALL.len()],
    /// The pair that (e) finds here.
    pub pair: Option<Pair>,
    /// What the pair of the run takes here beyond the best one, watts; `None` where it does not
    /// keep the budget.
    pub regret_w: Option<f64>,
}

impl Alternative {
    /// Watts that the joint pair saves against the best of (a) to (d).
    pub fn gain_w(&self) -> Option<f64> {
        let [.., joint] = self.watts;
        Some(sequential(&self.watts)? - joint?)
    }
}

/// The least watts of (a) to (d).
pub fn sequential(watts: &[Option<f64>; Way::ALL.len()]) -> Option<f64> {
    watts[..Way::ALL.len() - 1].iter().copied().flatten().reduce(f64::min)
}

/// The run's tables on all views, and its first table on each half. `budget` gives the budget under
/// a table.
pub fn alternatives(
    market: &Market<'_>,
    tables: &[String],
    joint: Option<Pair>,
    budget: &dyn Fn(usize) -> CompareBudget,
) -> Vec<Alternative> {
    let on_tables = (0..tables.len()).map(|table| (table, 0));
    let on_halves = (1..SCOPES).map(|scope| (0, scope));
    let alternative = |(table, scope): (usize, usize)| {
        let market = Market { table, scope, budget: budget(table), ..*market };
        let found = ways(&market);
        let pair = found[Way::Joint as usize].map(|(pair, _)| pair);
        let best = found[Way::Joint as usize].map(|(_, price)| price.total_w);
        let own = joint.and_then(|pair| market.price(pair));
        let own = own.filter(|price| market.budget.limit(price).is_none());
        Alternative {
            table: tables[table].clone(),
            views: if scope == 0 { "all" } else { HALVES[scope - 1] },
            watts: found.map(|found| found.map(|(_, price)| price.total_w)),
            pair,
            regret_w: own.zip(best).map(|(own, best)| own.total_w - best),
        }
    };
    on_tables.chain(on_halves).map(alternative).collect()
}

/// What the five ways find without confirming it.
fn ways(market: &Market<'_>) -> [Option<(Pair, Price)>; Way::ALL.len()] {
    let best = |keep: &dyn Fn(&Pair) -> bool| {
        market.ranked(market.pairs().filter(|pair| keep(pair))).ok().map(|ranked| ranked[0])
    };
    let dense = best(&|pair| pair.0 == 0);
    let base = best(&|pair| pair.1.is_none());
    let machine_first = dense.and_then(|(first, _)| best(&|pair| pair.1 == first.1));
    let model_first = base.and_then(|(first, _)| best(&|pair| pair.0 == first.0));
    [dense, base, machine_first, model_first, best(&|_| true)]
}

/// Why the joint pair is one, with the calibrated model of the DRAM: each half of it with the
/// other half of the best sequential pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// The best of (a) to (d).
    pub sequential: Way,
    /// Its pair and its price.
    pub before: (Pair, Price),
    /// The joint pair and its price.
    pub joint: (Pair, Price),
    /// The joint model on the machine of before; `None` where there is no such pair.
    pub model_alone: Option<(Pair, Price)>,
    /// The joint machine with the model of before.
    pub machine_alone: Option<(Pair, Price)>,
}

/// The coupling; `None` where (e) finds nothing, or what (a) to (d) found.
pub fn coupling(market: &Market<'_>, comparisons: &[Comparison]) -> Option<Coupling> {
    let found = |c: &Comparison| Some((c.way, *c.found.as_ref().ok()?));
    let all = || comparisons.iter().filter_map(found);
    let (_, joint) = all().find(|(way, _)| *way == Way::Joint)?;
    let (way, before) = all()
        .filter(|(way, _)| *way != Way::Joint)
        .min_by(|a, b| a.1.confirmed.total_w.total_cmp(&b.1.confirmed.total_w))?;
    if before.pair == joint.pair {
        return None;
    }
    let priced = |pair: Pair| Some((pair, market.price(pair)?));
    Some(Coupling {
        sequential: way,
        before: (before.pair, before.calibrated),
        joint: (joint.pair, joint.calibrated),
        model_alone: priced((joint.pair.0, before.pair.1)),
        machine_alone: priced((before.pair.0, joint.pair.1)),
    })
}
