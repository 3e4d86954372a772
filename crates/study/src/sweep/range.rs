//! Rows of numbers: equal steps, equal ratios, powers of two.

use toml::Value;

use super::axis::{VALUES_MAX, about};
use super::expr;
use super::file::{RangeSpec, Raw, Scale};
use super::key::{Domain, Key};
use super::measure::Measure;

/// How far beyond the end a value may be that rounding pushed there.
const SLACK: f64 = 1e-9;

/// How to come from one value to the next.
enum RangeWalk {
    Step(f64),
    Factor(f64),
    Linear(u32),
    Geometric(u32),
}

/// The values of a range for a key, ascending, each once.
pub(super) fn values(key: &Key, range: &RangeSpec) -> Result<Vec<Value>, String> {
    let domain = key.domain();
    if !domain.is_ordered() {
        return Err(format!("`{key}` is not a number: list its `values`"));
    }
    let number = |name: &str, Raw(raw): &Raw| {
        let value = domain.read(raw).map_err(|e| format!("`{name}`: {}", about(key, &e)))?;
        match domain.value(&value) {
            Some(expr::Value::Number(n)) => Ok(n),
            _ => Err(format!("`{name}` is not a number")),
        }
    };
    let difference = |Raw(raw): &Raw| match (domain, raw) {
        (Domain::Measure(measure), Value::String(text)) => measure.read(text),
        (Domain::Measure(_), other) => Err(format!("`step` = {other} needs its unit")),
        (_, Value::Integer(n)) => Ok(*n as f64),
        (_, Value::Float(n)) => Ok(*n),
        (_, other) => Err(format!("`step` must be a number, not {other}")),
    };
    let (from, to) = (number("from", &range.from)?, number("to", &range.to)?);
    if from > to {
        let (from, to) = (&range.from.0, &range.to.0);
        return Err(format!("`from` = {from} is above `to` = {to}: a range goes upwards"));
    }
    let numbers = match walk(range, from, &difference)? {
        RangeWalk::Step(step) => row(from, to, |i| from + f64::from(i) * step)?,
        RangeWalk::Factor(factor) => row(from, to, |i| from * factor.powi(i as i32))?,
        RangeWalk::Linear(count) => {
            let last = f64::from(count - 1);
            (0..count).map(|i| from + (to - from) * f64::from(i) / last).collect()
        }
        RangeWalk::Geometric(count) => {
            let ratio = (to / from).ln() / f64::from(count - 1);
            // The end is as it was given, not what `exp` makes of it.
            let inner = (0..count - 1).map(|i| from * (ratio * f64::from(i)).exp());
            inner.chain([to]).collect()
        }
    };
    let mut all: Vec<Value> = Vec::new();
    for number in numbers {
        let whole = matches!(domain, Domain::Integer(..) | Domain::Measure(Measure::Size));
        let number = if whole { number.round() } else { number };
        let number = super::measure::twelve_digits(number);
        let value = domain.write(&expr::Value::Number(number));
        let value = value.map_err(|e| format!("value {number}: {}", about(key, &e)))?;
        // Rounding to whole numbers may give one twice.
        if all.last() != Some(&value) {
            all.push(value);
        }
    }
    Ok(all)
}

fn walk(
    range: &RangeSpec,
    from: f64,
    difference: &dyn Fn(&Raw) -> Result<f64, String>,
) -> Result<RangeWalk, String> {
    let positive = |walk: RangeWalk| match from > 0.0 {
        true => Ok(walk),
        false => Err("equal ratios start above zero: change `from`".to_owned()),
    };
    match (&range.step, range.factor, range.count, range.scale) {
        (Some(step), None, None, None | Some(Scale::Linear)) => {
            let step = difference(step)?;
            if step > 0.0 {
                Ok(RangeWalk::Step(step))
            } else {
                Err("`step` must be above zero".into())
            }
        }
        (None, Some(factor), None, None | Some(Scale::Geometric)) => {
            positive(RangeWalk::Factor(factor))
        }
        (None, None, Some(count), None | Some(Scale::Linear)) => {
            Ok(RangeWalk::Linear(count.max(2)))
        }
        (None, None, Some(count), Some(Scale::Geometric | Scale::Log2)) => {
            positive(RangeWalk::Geometric(count.max(2)))
        }
        (None, None | Some(2.0), None, Some(Scale::Log2)) => positive(RangeWalk::Factor(2.0)),
        _ => Err("a range has one of `step` (equal differences), `factor` (equal ratios), \
                  `count` (with `scale`) and `scale = \"log2\"` (doubling)"
            .into()),
    }
}

fn row(from: f64, to: f64, at: impl Fn(u32) -> f64) -> Result<Vec<f64>, String> {
    let end = to + to.abs().max(from.abs()) * SLACK;
    let limit = VALUES_MAX as u32;
    // One more than are allowed, so that too many are noticed.
    let row: Vec<f64> = (0..=limit).map(at).take_while(|n| *n <= end).collect();
    if row.len() > VALUES_MAX {
        return Err(format!("more than {VALUES_MAX} values on one axis: a typing error?"));
    }
    Ok(row)
}
