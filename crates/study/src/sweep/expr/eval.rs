//! Evaluates the tree of an expression.

use super::{ExprError, Function, Node, Two, Value, What};

/// What names stand for, also inside of `mean(...)`, and the text for errors.
#[derive(Clone, Copy)]
struct EvalContext<'a> {
    text: &'a str,
    lookup: &'a dyn Fn(&str) -> Option<Value>,
    mean: &'a dyn Fn(&str) -> Option<Value>,
}

pub(super) fn value(
    text: &str,
    node: &Node,
    lookup: &dyn Fn(&str) -> Option<Value>,
    mean: &dyn Fn(&str) -> Option<Value>,
) -> Result<Value, ExprError> {
    EvalContext { text, lookup, mean }.value(node)
}

pub(super) fn missed_by(
    text: &str,
    node: &Node,
    lookup: &dyn Fn(&str) -> Option<Value>,
    mean: &dyn Fn(&str) -> Option<Value>,
) -> Result<f64, ExprError> {
    EvalContext { text, lookup, mean }.missed_by(node)
}

impl EvalContext<'_> {
    fn fail(&self, node: &Node, message: impl Into<String>) -> ExprError {
        ExprError::new(self.text, &node.span, message)
    }

    /// See [`super::Expr::missed_by`].
    fn missed_by(&self, node: &Node) -> Result<f64, ExprError> {
        if let What::Two(two, sides) = &node.what {
            let [a, b] = &**sides;
            match two {
                // As in `value`, the second side counts only where the first does not decide, and
                // may have no value elsewhere: `x > 0 && y / x < 3`.
                Two::And => {
                    let first = self.missed_by(a)?;
                    return match self.missed_by(b) {
                        Err(_) if first > 0.0 => Ok(first),
                        second => Ok(first.max(second?)),
                    };
                }
                Two::Or => {
                    let first = self.missed_by(a)?;
                    return match self.missed_by(b) {
                        Err(_) if first <= 0.0 => Ok(first),
                        second => Ok(first.min(second?)),
                    };
                }
                // Equal sides miss a strict bound, by nothing that can be measured.
                Two::Less | Two::More if self.number(a)? == self.number(b)? => {
                    return Ok(f64::MIN_POSITIVE);
                }
                Two::Less | Two::AtMost | Two::More | Two::AtLeast => {
                    let (x, y) = (self.number(a)?, self.number(b)?);
                    let is_upper = matches!(two, Two::Less | Two::AtMost);
                    let over = if is_upper { x - y } else { y - x };
                    // The limit is the side that names nothing, else the right one. One of 0
                    // divides nothing: then it is a share of the value.
                    let limit = if a.has_names() || !b.has_names() { y } else { x };
                    let scale = if limit != 0.0 { limit.abs() } else { x.abs().max(y.abs()) };
                    return Ok(if scale > 0.0 { over / scale } else { 0.0 });
                }
                _ => {}
            }
        }
        Ok(if self.truth(node)? { 0.0 } else { f64::INFINITY })
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
            What::Two(..) => self.chain(node),
            What::Call(Function::If, arguments) => {
                let branch = if self.truth(&arguments[0])? { 1 } else { 2 };
                self.value(&arguments[branch])
            }
            What::Call(Function::Mean, arguments) => {
                EvalContext { lookup: self.mean, ..*self }.value(&arguments[0])
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
        self.as_number(node, self.value(node)?)
    }

    fn as_number(&self, node: &Node, value: Value) -> Result<f64, ExprError> {
        match value {
            Value::Number(number) => Ok(number),
            other => Err(self.fail(node, format!("{} where a number is wanted", other.kind()))),
        }
    }

    fn truth(&self, node: &Node) -> Result<bool, ExprError> {
        self.as_truth(node, self.value(node)?)
    }

    fn as_truth(&self, node: &Node, value: Value) -> Result<bool, ExprError> {
        match value {
            Value::Truth(truth) => Ok(truth),
            other => {
                Err(self.fail(node, format!("{} where true or false is wanted", other.kind())))
            }
        }
    }

    /// An operator. Those to its left, which may be thousands (`1+1+1+...`), are worked off from
    /// the first one; what is to the right of one is at most as deep as parentheses go.
    fn chain(&self, node: &Node) -> Result<Value, ExprError> {
        let mut operators = Vec::new();
        let mut first = node;
        while let What::Two(two, sides) = &first.what {
            operators.push((first, *two, sides));
            first = &sides[0];
        }
        let mut left = self.value(first)?;
        for (node, two, sides) in operators.into_iter().rev() {
            left = self.two(node, two, &sides[0], left, &sides[1])?;
        }
        Ok(left)
    }

    fn two(
        &self,
        node: &Node,
        two: Two,
        a: &Node,
        left: Value,
        b: &Node,
    ) -> Result<Value, ExprError> {
        let truth = |truth: bool| Ok(Value::Truth(truth));
        match two {
            Two::Or => return truth(self.as_truth(a, left)? || self.truth(b)?),
            Two::And => return truth(self.as_truth(a, left)? && self.truth(b)?),
            Two::Equal => return truth(self.equal(node, left, b)?),
            Two::NotEqual => return truth(!self.equal(node, left, b)?),
            _ => {}
        }
        let (x, y) = (self.as_number(a, left)?, self.number(b)?);
        match two {
            Two::Less => truth(x < y),
            Two::AtMost => truth(x <= y),
            Two::More => truth(x > y),
            Two::AtLeast => truth(x >= y),
            Two::Plus => self.finite(node, x + y),
            Two::Minus => self.finite(node, x - y),
            Two::Times => self.finite(node, x * y),
            Two::Over => self.finite(node, x / y),
            Two::Remainder => self.finite(node, x % y),
            Two::Power => self.finite(node, x.powf(y)),
            Two::Or | Two::And | Two::Equal | Two::NotEqual => unreachable!("returned above"),
        }
    }

    fn equal(&self, node: &Node, left: Value, b: &Node) -> Result<bool, ExprError> {
        match (left, self.value(b)?) {
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
        Function::If | Function::Mean => unreachable!("they decide what is looked at"),
    }
}

/// The power of two at or next to `x`, which must be above zero.
fn power_of_two(x: f64, above: bool) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return f64::NAN;
    }
    let mut power = x.log2().floor().exp2();
    // The logarithm is rounded: next to a power of two it may be one off, either way.
    if power > x {
        power /= 2.0;
    }
    if power * 2.0 <= x {
        power *= 2.0;
    }
    if above && power < x { power * 2.0 } else { power }
}
