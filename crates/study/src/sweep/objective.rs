//! What is wanted of a design: columns of the table that are to be small or large.

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

/// A metric and which way it is better.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Objective {
    /// Name of the column.
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
}
