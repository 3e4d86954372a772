//! The bottleneck in words.

use powergs_core::stage::{Stall, stage};
use powergs_energy::action::StageId;
use powergs_study::findings::bottleneck::{Bottleneck, Limit, Root, Wait};

fn cause_words(cause: Stall, unit: StageId) -> &'static str {
    if cause == Stall::INPUT { stage(unit).input } else { cause.words().what }
}

/// The name of a unit in sentences.
fn unit_name(unit: StageId) -> String {
    stage(unit).key.to_uppercase()
}

/// Shares in whole percent that add up to `total`, by the largest remainders; the first of equal
/// ones.
fn whole_of(shares: &[f64], total: u32) -> Vec<u32> {
    let mut percent: Vec<u32> = shares.iter().map(|s| (s * 100.0).max(0.0) as u32).collect();
    let rest = |i: usize| shares[i] * 100.0 - f64::from(percent[i]);
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|&a, &b| rest(b).total_cmp(&rest(a)));
    let missing = total.saturating_sub(percent.iter().sum());
    for &i in order.iter().take(missing as usize) {
        percent[i] += 1;
    }
    percent
}

/// Roots below this part of their wait are told together.
const SMALL: f64 = 0.1;

/// Waits of fewer percent of the frame are not traced: nobody would act on them.
const WORTH_TRACING: u32 = 10;

/// Where a wait of `percent` of the frame begins.
fn traced(roots: &[Root], percent: u32) -> Option<String> {
    if percent < WORTH_TRACING {
        return None;
    }
    let all: f64 = roots.iter().map(|r| r.share).sum();
    let mut parts: Vec<(String, f64)> = Vec::new();
    for root in roots {
        let words = match root.cause {
            _ if root.share < SMALL * all => "others".to_owned(),
            Some(cause) => cause_words(cause, root.unit).to_owned(),
            None => format!("{} at work", unit_name(root.unit)),
        };
        match parts.iter_mut().find(|(known, _)| *known == words) {
            Some((_, share)) => *share += root.share,
            None => parts.push((words, root.share)),
        }
    }
    let rest = (f64::from(percent) / 100.0 - all).max(0.0);
    let shares: Vec<f64> = parts.iter().map(|(_, share)| *share).chain([rest]).collect();
    let rounded = parts.iter().zip(whole_of(&shares, percent)).filter(|(_, share)| *share > 0);
    let told: Vec<String> =
        rounded.map(|((words, _), share)| format!("{words} {share} %")).collect();
    (!told.is_empty()).then(|| format!(" (in the end: {})", told.join(", ")))
}

/// One sentence: what bounds the frame, and what the leading units wait for. The shares add up to
/// 100 %.
pub fn sentence(found: &Bottleneck) -> String {
    let shares = found.bounds.iter().map(|b| b.share).chain(found.waits.iter().map(|w| w.share));
    let shares: Vec<f64> = shares.chain([found.without_work]).collect();
    let percent = whole_of(&shares, 100);
    let (bounds, rest) = percent.split_at(found.bounds.len());
    let (waits, idle) = rest.split_at(found.waits.len());
    let cause = |(w, share): (&Wait, &u32)| {
        let row = |m: f64| format!(" (row-miss {} %)", crate::format::percent(m));
        let why = w.row_miss.map(row).or_else(|| traced(&w.roots, *share));
        format!("{} {share} %{}", cause_words(w.cause, w.unit), why.unwrap_or_default())
    };
    let waits = || found.waits.iter().zip(waits).filter(|(_, share)| **share > 0);
    let of = |dram: bool| -> Vec<String> {
        waits().filter(|(w, _)| w.is_for_dram() == dram).map(cause).collect()
    };
    let bounds = found.bounds.iter().zip(bounds).filter(|(_, share)| **share > 0);
    let units = |what: &str| -> Vec<String> {
        bounds.clone().map(|(b, share)| format!("{}{what} {share} %", unit_name(b.unit))).collect()
    };
    let mut parts = Vec::new();
    let waiting = |causes: Vec<String>| format!("waiting for {}", causes.join(", "));
    if found.limit == Limit::Dram {
        let direct: u32 = waits().filter(|(w, _)| w.cause.is_dram()).map(|(_, share)| share).sum();
        let traced: f64 = found.waits.iter().map(Wait::traced_to_dram).sum();
        let share = direct + (traced * 100.0).round() as u32;
        let causes = of(true);
        let why =
            if causes.is_empty() { String::new() } else { format!(" ({})", causes.join(", ")) };
        parts.push(match found.is_bus_full() {
            true => format!(
                "DRAM-bound: the bus moves data for {} % of the frame; units wait for it \
                 {share} %{why}",
                crate::format::percent(found.bus_busy)
            ),
            false => format!("DRAM-bound for {share} % of the frame{why}"),
        });
        // Units that work beside a full bus bound nothing.
        let at_work = units(" at work").join(", ");
        if !at_work.is_empty() {
            parts.push(at_work);
        }
        let others = of(false);
        if !others.is_empty() {
            parts.push(waiting(others));
        }
    } else {
        let first = found.bounds.first().map(|b| Limit::Unit(b.unit));
        let leads = first == Some(found.limit);
        let mut heads = units(if leads { "-bound for" } else { " at work" });
        if let Limit::Unit(unit) = found.limit
            && !leads
        {
            let share = crate::format::percent(found.holds_up(unit));
            let unit = unit_name(unit);
            parts.push(format!("{unit}-bound for {share} % of the frame, others wait for it"));
        } else if let Some(first) = heads.first_mut() {
            first.push_str(" of the frame");
        }
        parts.push(heads.join(", "));
        let causes: Vec<String> = waits().map(cause).collect();
        if !causes.is_empty() {
            parts.push(waiting(causes));
        }
    }
    if idle[0] > 0 {
        parts.push(format!("idle {} %", idle[0]));
    }
    parts.retain(|part| !part.is_empty());
    parts.join("; ") + "."
}
