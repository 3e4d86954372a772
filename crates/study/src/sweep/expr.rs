//! Expressions over named values: `area_mm2 <= 4 && geometry.test == 'obb'`.
//!
//! A number with a unit (`64 KiB`, `10.88 pJ/B`) is converted to SI units. A name may contain dots,
//! dashes and a leading `file:`; a dash between letters is part of the name, so the difference of
//! two names needs spaces. Any name can be put in backquotes. Operators from the lowest precedence
//! to the highest: `||`, `&&`, comparisons, `+ -`, `* / %`, `! -`, `^`. Functions: `min`, `max`,
//! `abs`, `ceil`, `floor`, `round`, `sqrt`, `log2`, `ceil_pow2`, `floor_pow2`,
//! `if(condition, then, else)`, and `mean(x)`: `x` over all traces, in a condition that has to hold
//! on each of them.
//!
//! A statistic says its unit in its name, and a number beside it may be bare (`frame_time_ms.p99 <=
//! 16.67`) or have a unit, which is then converted to that of the name (`energy_pj.mean <= 2 mJ`).

mod eval;
mod lex;
mod parse;
mod units;

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;

/// The longest expression that is read, bytes.
pub const TEXT_MAX: usize = 4096;

/// The value of an expression or of a name.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A finite number; measures in SI units.
    Number(f64),
    /// A name out of a list, or a text.
    Text(String),
    /// True or false.
    Truth(bool),
}

impl Value {
    /// What kind of value it is, with its article.
    pub const fn kind(&self) -> &'static str {
        match self {
            Value::Number(_) => "a number",
            Value::Text(_) => "a text",
            Value::Truth(_) => "true or false",
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(n) => n.fmt(f),
            Value::Text(text) => write!(f, "'{text}'"),
            Value::Truth(truth) => truth.fmt(f),
        }
    }
}

/// What is wrong with an expression, and where.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct ExprError {
    /// The expression; cut short if it is too long to be one.
    pub text: String,
    /// Column of the first character in question, from 1.
    pub column: usize,
    /// Characters to underline, at least 1.
    pub width: usize,
    /// What is wrong and what to do.
    pub message: String,
    /// The name, if the trouble is that nothing has it.
    pub unknown: Option<String>,
}

impl ExprError {
    pub(super) fn new(text: &str, span: &Range<usize>, message: impl Into<String>) -> ExprError {
        let characters = |bytes: &str| bytes.chars().count();
        let before = text.get(..span.start).map_or(0, characters);
        let width = text.get(span.clone()).map_or(1, characters).max(1);
        let text = text.chars().take(TEXT_MAX).collect();
        ExprError { text, column: before + 1, width, message: message.into(), unknown: None }
    }
}

impl fmt::Display for ExprError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {}: {}", self.column, self.message)?;
        let plain = |c: char| if c.is_control() { ' ' } else { c };
        let shown: String = self.text.chars().map(plain).collect();
        if shown.chars().count() > 200 || shown.trim().is_empty() {
            return Ok(());
        }
        let under = " ".repeat(self.column - 1) + &"^".repeat(self.width);
        write!(f, "\n  | {shown}\n  | {under}")
    }
}

/// An expression that has been read.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    text: String,
    root: Node,
}

/// A part of an expression and where it stands in the text, in bytes.
#[derive(Debug, Clone, PartialEq)]
struct Node {
    span: Range<usize>,
    what: What,
}

#[derive(Debug, Clone, PartialEq)]
enum What {
    Value(Value),
    /// A number with a unit, in SI units.
    Measured(f64, super::measure::Measure),
    Name(String),
    Not(Box<Node>),
    Minus(Box<Node>),
    Two(Two, Box<[Node; 2]>),
    Call(Function, Vec<Node>),
}

/// An operator between two values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Two {
    Or,
    And,
    Equal,
    NotEqual,
    Less,
    AtMost,
    More,
    AtLeast,
    Plus,
    Minus,
    Times,
    Over,
    Remainder,
    Power,
}

impl Two {
    fn compares(self) -> bool {
        use Two::*;
        matches!(self, Equal | NotEqual | Less | AtMost | More | AtLeast)
    }
}

/// A function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Function {
    Min,
    Max,
    Abs,
    Ceil,
    Floor,
    Round,
    Sqrt,
    Log2,
    CeilPow2,
    FloorPow2,
    If,
    /// Of its value over the traces, where the rest is of each of them.
    Mean,
}

impl Function {
    const ALL: [(&'static str, Function); 12] = [
        ("min", Function::Min),
        ("max", Function::Max),
        ("abs", Function::Abs),
        ("ceil", Function::Ceil),
        ("floor", Function::Floor),
        ("round", Function::Round),
        ("sqrt", Function::Sqrt),
        ("log2", Function::Log2),
        ("ceil_pow2", Function::CeilPow2),
        ("floor_pow2", Function::FloorPow2),
        ("if", Function::If),
        ("mean", Function::Mean),
    ];

    /// How many values it takes, at least and at most.
    const fn arguments(self) -> (usize, usize) {
        match self {
            Function::Min | Function::Max => (1, usize::MAX),
            Function::If => (3, 3),
            Function::Abs
            | Function::Ceil
            | Function::Floor
            | Function::Round
            | Function::Sqrt
            | Function::Log2
            | Function::CeilPow2
            | Function::FloorPow2
            | Function::Mean => (1, 1),
        }
    }
}

impl Expr {
    /// Reads an expression.
    ///
    /// # Errors
    /// What is wrong with it, the column, and what to do.
    pub fn parse(text: &str) -> Result<Expr, ExprError> {
        if text.len() > TEXT_MAX {
            let message = format!("longer than {TEXT_MAX} bytes: split it into several");
            return Err(ExprError::new(text, &(0..0), message));
        }
        let tokens = lex::tokens(text)?;
        let mut root = parse::parse(text, &tokens)?;
        // Only the tree says which two sides are compared.
        units::fit(text, &mut root)?;
        Ok(Expr { text: text.to_owned(), root })
    }

    /// The text that it was read from.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Every name in it, each once.
    pub fn names(&self) -> BTreeSet<&str> {
        let mut names = BTreeSet::new();
        visit(&self.root, &mut |node| {
            if let What::Name(name) = &node.what {
                names.insert(name.as_str());
            }
        });
        names
    }

    /// Its value, where `lookup` says what a name stands for. `&&`, `||` and `if` leave out what
    /// does not matter.
    ///
    /// # Errors
    /// A name that stands for nothing, values of the wrong kind, or no finite number (a division by
    /// zero); with the column.
    pub fn eval(&self, lookup: &dyn Fn(&str) -> Option<Value>) -> Result<Value, ExprError> {
        eval::value(&self.text, &self.root, lookup, lookup)
    }

    /// As [`Expr::holds`], where names inside of `mean(...)` stand for what `mean` says.
    ///
    /// # Errors
    /// As [`Expr::holds`].
    pub fn holds_with(
        &self,
        lookup: &dyn Fn(&str) -> Option<Value>,
        mean: &dyn Fn(&str) -> Option<Value>,
    ) -> Result<bool, ExprError> {
        match eval::value(&self.text, &self.root, lookup, mean)? {
            Value::Truth(truth) => Ok(truth),
            other => {
                let message = format!("this is {}; a condition is true or false", other.kind());
                Err(ExprError::new(&self.text, &self.root.span, message))
            }
        }
    }

    /// By which share of its limit a condition is missed: 0.1 where a value is 10 % above or below
    /// what it may be, at most 0 where it holds. A condition that is no comparison of numbers is
    /// met or missed by infinity.
    ///
    /// # Errors
    /// As [`Expr::holds`].
    pub fn missed_by(
        &self,
        lookup: &dyn Fn(&str) -> Option<Value>,
        mean: &dyn Fn(&str) -> Option<Value>,
    ) -> Result<f64, ExprError> {
        eval::missed_by(&self.text, &self.root, lookup, mean)
    }

    /// As [`Expr::eval`], for an expression that must be true or false.
    ///
    /// # Errors
    /// Also a number or a text.
    pub fn holds(&self, lookup: &dyn Fn(&str) -> Option<Value>) -> Result<bool, ExprError> {
        self.holds_with(lookup, lookup)
    }

    /// An error about a name of the expression, at its first place.
    pub(crate) fn at_name(&self, name: &str, message: impl Into<String>) -> ExprError {
        let mut place = 0..0;
        visit(&self.root, &mut |node| {
            if place.is_empty() && matches!(&node.what, What::Name(n) if n == name) {
                place = node.span.clone();
            }
        });
        ExprError::new(&self.text, &place, message)
    }
}

impl std::str::FromStr for Expr {
    type Err = ExprError;

    fn from_str(text: &str) -> Result<Expr, ExprError> {
        Expr::parse(text)
    }
}

impl Node {
    /// Whether a name is in it.
    fn has_names(&self) -> bool {
        let mut any = false;
        visit(self, &mut |node| any |= matches!(node.what, What::Name(_)));
        any
    }
}

/// Calls `each` on every part, in the order of the text but for operators, which come before their
/// sides.
fn visit<'a>(root: &'a Node, each: &mut impl FnMut(&'a Node)) {
    // A list in place of recursion: a chain of operators is as deep as it is long.
    let mut open = vec![root];
    while let Some(node) = open.pop() {
        each(node);
        match &node.what {
            What::Value(_) | What::Measured(..) | What::Name(_) => {}
            What::Not(inner) | What::Minus(inner) => open.push(inner),
            What::Two(_, sides) => open.extend(sides.iter().rev()),
            What::Call(_, arguments) => open.extend(arguments.iter().rev()),
        }
    }
}
