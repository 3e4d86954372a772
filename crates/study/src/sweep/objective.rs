//! What is wanted of a design: columns of the table, or numbers made of them, that are to be small
//! or large.

use std::collections::BTreeSet;

use super::expr::{Expr, Value};

/// Share below which a difference is noise, unless somebody says otherwise.
pub const EPSILON: f64 = 1e-3;

/// Which way an objective is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// Less is better.
    Minimize,
    /// More is better.
    Maximize,
}

impl Goal {
    /// The value as a cost: less is better.
    pub fn cost(self, value: f64) -> f64 {
        match self {
            Goal::Minimize => value,
            Goal::Maximize => -value,
        }
    }

    /// How much better `new` is than `old`, in the unit of both; negative if it is worse.
    pub fn gain(self, old: f64, new: f64) -> f64 {
        self.cost(old) - self.cost(new)
    }
}

/// A number and which way it is better.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Objective {
    /// Name of the column, or an expression of columns: `area_mm2 * frame_time_ms.p99`.
    pub name: String,
    /// Which way is better.
    pub goal: Goal,
}

impl Objective {
    /// What is to be small.
    pub fn minimize(name: impl Into<String>) -> Objective {
        Objective { name: name.into(), goal: Goal::Minimize }
    }

    /// What is to be large.
    pub fn maximize(name: impl Into<String>) -> Objective {
        Objective { name: name.into(), goal: Goal::Maximize }
    }

    /// The columns that it is made of.
    pub fn columns(&self) -> BTreeSet<String> {
        let names = |expr: Expr| expr.names().into_iter().map(str::to_owned).collect();
        Expr::parse(&self.name).map_or_else(|_| BTreeSet::from([self.name.clone()]), names)
    }

    /// Its value, where `lookup` says what a column has; `None` if it has none there.
    pub fn value(&self, lookup: &dyn Fn(&str) -> Option<Value>) -> Option<f64> {
        let value = match Expr::parse(&self.name) {
            Ok(expr) => expr.eval(lookup).ok()?,
            Err(_) => lookup(&self.name)?,
        };
        match value {
            Value::Number(x) if x.is_finite() => Some(x),
            Value::Number(_) | Value::Text(_) | Value::Truth(_) => None,
        }
    }
}
