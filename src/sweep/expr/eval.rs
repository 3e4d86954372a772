//! The value of a tree.

use super::{ExprError, Function, Node, Two, Value, What};

/// What names stand for, and the text for errors.
struct Context<'a> {
    text: &'a str,
    lookup: &'a dyn Fn(&str) -> Option<Value>,
}

pub(super) fn value(
    text: &str,
    node: &Node,
    lookup: &dyn Fn(&str) -> Option<Value>,
) -> Result<Value, ExprError> {
    Context { text, lookup }.value(node)
}

impl Context<'_> {
    fn fail(&self, node: &Node, message: impl Into<String>) -> ExprError {
        ExprError::new(self.text, &node.span, message)
    }

    fn value(&self, node: &Node) -> Result<Value, ExprError> {
        match &node.what {
            What::Value(value) => Ok(value.clone()),
            What::Measured(number, _) => Ok(Value::Number(*number)),
            What::Name(name) => match (self.lookup)(name) {
                Some(Value::Number(n)) => self.finite(node, n),
                Some(value) => Ok(value),
                None => {
                    let mut error = self.fail(node, format!("nothing is called `{name}`"));
                    error.unknown = Some(name.clone());
                    Err(error)
                }
            },
            What::Not(inner) => Ok(Value::Truth(!self.truth(inner)?)),
            What::Minus(inner) => Ok(Value::Number(-self.number(inner)?)),
            What::Two(two, sides) => self.two(node, *two, &sides[0], &sides[1]),
            What::Call(Function::If, arguments) => {
                let branch = if self.truth(&arguments[0])? { 1 } else { 2 };
                self.value(&arguments[branch])
            }
            What::Call(function, arguments) => {
                let numbers = arguments.iter().map(|a| self.number(a));
                let numbers = numbers.collect::<Result<Vec<f64>, ExprError>>()?;
                self.finite(node, call(*function, &numbers))
            }
        }
    }

    fn finite(&self, node: &Node, number: f64) -> Result<Value, ExprError> {
        if number.is_finite() {
            return Ok(Value::Number(number));
        }
        Err(self.fail(node, "this is not a finite number"))
    }

    fn number(&self, node: &Node) -> Result<f64, ExprError> {
        match self.value(node)? {
            Value::Number(number) => Ok(number),
            other => Err(self.fail(node, format!("{} where a number is wanted", other.kind()))),
        }
    }

    fn truth(&self, node: &Node) -> Result<bool, ExprError> {
        match self.value(node)? {
            Value::Truth(truth) => Ok(truth),
            other => {
                Err(self.fail(node, format!("{} where true or false is wanted", other.kind())))
            }
        }
    }

    fn two(&self, node: &Node, two: Two, a: &Node, b: &Node) -> Result<Value, ExprError> {
        let truth = |truth: bool| Ok(Value::Truth(truth));
        match two {
            Two::Or => truth(self.truth(a)? || self.truth(b)?),
            Two::And => truth(self.truth(a)? && self.truth(b)?),
            Two::Equal => truth(self.equal(node, a, b)?),
            Two::NotEqual => truth(!self.equal(node, a, b)?),
            Two::Less => truth(self.number(a)? < self.number(b)?),
            Two::AtMost => truth(self.number(a)? <= self.number(b)?),
            Two::More => truth(self.number(a)? > self.number(b)?),
            Two::AtLeast => truth(self.number(a)? >= self.number(b)?),
            Two::Plus => self.finite(node, self.number(a)? + self.number(b)?),
            Two::Minus => self.finite(node, self.number(a)? - self.number(b)?),
            Two::Times => self.finite(node, self.number(a)? * self.number(b)?),
            Two::Over => self.finite(node, self.number(a)? / self.number(b)?),
            Two::Remainder => self.finite(node, self.number(a)? % self.number(b)?),
            Two::Power => self.finite(node, self.number(a)?.powf(self.number(b)?)),
        }
    }

    fn equal(&self, node: &Node, a: &Node, b: &Node) -> Result<bool, ExprError> {
        match (self.value(a)?, self.value(b)?) {
            (Value::Number(a), Value::Number(b)) => Ok(a == b),
            (Value::Text(a), Value::Text(b)) => Ok(a == b),
            (Value::Truth(a), Value::Truth(b)) => Ok(a == b),
            (a, b) => {
                let message = format!("{} and {} are never equal", a.kind(), b.kind());
                Err(self.fail(node, message))
            }
        }
    }
}

fn call(function: Function, numbers: &[f64]) -> f64 {
    let first = numbers[0];
    match function {
        Function::Min => numbers.iter().copied().fold(first, f64::min),
        Function::Max => numbers.iter().copied().fold(first, f64::max),
        Function::Abs => first.abs(),
        Function::Ceil => first.ceil(),
        Function::Floor => first.floor(),
        Function::Round => first.round(),
        Function::Sqrt => first.sqrt(),
        Function::Log2 => first.log2(),
        Function::CeilPow2 => power_of_two(first, true),
        Function::FloorPow2 => power_of_two(first, false),
        Function::If => unreachable!("`if` leaves out a branch and is not called"),
    }
}

/// The power of two at or next to `x`, which must be above zero.
fn power_of_two(x: f64, above: bool) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return f64::NAN;
    }
    let mut power = x.log2().floor().exp2();
    if power > x {
        power /= 2.0;
    }
    if power * 2.0 <= x {
        power *= 2.0;
    }
    if above && power < x { power * 2.0 } else { power }
}
