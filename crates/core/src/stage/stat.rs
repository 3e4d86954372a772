//! What stages measure of a frame besides times and counts of actions: a number declares itself
//! beside the rule that measures it, and statistics in every output are read off the declaration.

/// A measured value. Counts stay integers up to the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// An exact count.
    Count(u64),
    /// A measure; always finite.
    Real(f64),
}

impl Value {
    /// The value as a floating-point number.
    pub fn as_f64(self) -> f64 {
        match self {
            Value::Count(n) => n as f64,
            Value::Real(x) => x,
        }
    }
}

/// What a pair of views has of a number that each of its views may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Merge {
    /// The sum, where both have one.
    Sum,
    /// The larger one, where both have one.
    Most,
    /// That of the second view.
    Second,
}

/// Where the number comes from.
#[derive(Debug, Clone, Copy)]
pub enum StatOf {
    /// It is counted.
    Count(Merge),
    /// It is measured, and no whole number.
    Real(Merge),
    /// It is measured in cycles, and shown in milliseconds.
    Cycles,
    /// A share, 0 to 1: one measured count over the sum of others; nothing where these are 0.
    Share(&'static StatDecl, &'static [&'static StatDecl]),
}

/// A number of a frame.
#[derive(Debug, Clone, Copy)]
pub struct StatDecl {
    /// The name in every output, dotted: `cache.hits`. Names of times end in `_ms`.
    pub name: &'static str,
    /// Its unit; `1` for plain counts and ratios.
    pub unit: &'static str,
    /// What it says, in one or two sentences; empty for what only others are made of.
    pub means: &'static str,
    /// Where it comes from.
    pub of: StatOf,
}

impl PartialEq for StatDecl {
    fn eq(&self, other: &StatDecl) -> bool {
        self.name == other.name
    }
}

impl Eq for StatDecl {}

/// A count that stages measure, summed over the views of a pair.
pub const fn counted(name: &'static str, means: &'static str) -> StatDecl {
    StatDecl { name, unit: "1", means, of: StatOf::Count(Merge::Sum) }
}

/// A number that stages measure, and that is no whole one.
pub const fn real(name: &'static str, merge: Merge, means: &'static str) -> StatDecl {
    StatDecl { name, unit: "1", means, of: StatOf::Real(merge) }
}

/// A time that stages measure in cycles.
pub const fn timed(name: &'static str, means: &'static str) -> StatDecl {
    StatDecl { name, unit: "ms", means, of: StatOf::Cycles }
}

/// A share of measured counts.
pub const fn share(
    name: &'static str,
    part: &'static StatDecl,
    whole: &'static [&'static StatDecl],
    means: &'static str,
) -> StatDecl {
    StatDecl { name, unit: "1", means, of: StatOf::Share(part, whole) }
}

impl StatDecl {
    /// The same count, of which a pair of views has something else than the sum.
    pub const fn merged(self, merge: Merge) -> StatDecl {
        StatDecl { of: StatOf::Count(merge), ..self }
    }

    /// Whether it is a whole number.
    pub const fn is_count(&self) -> bool {
        matches!(self.of, StatOf::Count(_))
    }

    /// What a pair of views has of what is measured of each.
    const fn merge(&self) -> Merge {
        match self.of {
            StatOf::Count(merge) | StatOf::Real(merge) => merge,
            StatOf::Cycles | StatOf::Share(..) => Merge::Sum,
        }
    }

    /// Whether it is a number of its own, or only something that others are made of.
    pub const fn is_shown(&self) -> bool {
        !self.means.is_empty()
    }

    /// Its value of a frame in which this was measured, on a machine of this clock in hertz; `None`
    /// where that was not.
    pub fn value(&self, measured: &Measured, clock: f64) -> Option<Value> {
        match self.of {
            StatOf::Count(_) | StatOf::Real(_) => measured.get(self),
            StatOf::Cycles => Some(Value::Real(measured.get(self)?.as_f64() / clock * 1e3)),
            StatOf::Share(part, whole) => {
                let count = |one: &&StatDecl| measured.count(one);
                let whole = whole.iter().map(count).sum::<Option<u64>>()?;
                let part = measured.count(part)?;
                (whole > 0).then(|| Value::Real(part as f64 / whole as f64))
            }
        }
    }
}

/// What was measured of a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measured(Vec<(&'static StatDecl, Value)>);

impl Measured {
    /// These counts.
    pub fn of(counts: &[(&'static StatDecl, u64)]) -> Measured {
        Measured(counts.iter().map(|(decl, n)| (*decl, Value::Count(*n))).collect())
    }

    /// Adds a value.
    pub fn set(&mut self, decl: &'static StatDecl, value: Value) {
        match self.0.iter_mut().find(|(known, _)| *known == decl) {
            Some((_, old)) => *old = value,
            None => self.0.push((decl, value)),
        }
    }

    /// Adds what others measured; theirs is taken where both have a value.
    pub fn extend(&mut self, more: Measured) {
        more.0.into_iter().for_each(|(decl, value)| self.set(decl, value));
    }

    /// All values.
    pub fn all(&self) -> impl Iterator<Item = (&'static StatDecl, Value)> + '_ {
        self.0.iter().copied()
    }

    /// What was measured of this; `None` where nothing was.
    pub fn get(&self, decl: &StatDecl) -> Option<Value> {
        self.all().find(|(known, _)| *known == decl).map(|(_, value)| value)
    }

    /// The same of a count.
    pub fn count(&self, decl: &StatDecl) -> Option<u64> {
        match self.get(decl)? {
            Value::Count(n) => Some(n),
            Value::Real(_) => None,
        }
    }

    /// What a pair has of this first view and its second one.
    #[must_use]
    pub fn with_second(self, second: &Measured) -> Measured {
        let both = |(decl, first): (&'static StatDecl, Value)| {
            let value = match (decl.merge(), first, second.get(decl)?) {
                (Merge::Sum, Value::Count(a), Value::Count(b)) => Value::Count(a + b),
                (Merge::Sum, a, b) => Value::Real(a.as_f64() + b.as_f64()),
                (Merge::Most, a, b) if a.as_f64() > b.as_f64() => a,
                (Merge::Most | Merge::Second, _, b) => b,
            };
            Some((decl, value))
        };
        let mut pair = Measured(self.0.into_iter().filter_map(both).collect());
        let of_second = second.all().filter(|(decl, _)| decl.merge() == Merge::Second);
        of_second.for_each(|(decl, value)| pair.set(decl, value));
        pair
    }
}
