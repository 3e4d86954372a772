//! Boolean functions of a cell's pins, evaluated for 64 lanes at once.

use thiserror::Error;

/// Operands that an evaluation may hold.
const MAX_DEPTH: usize = 16;
/// Steps of a function: the largest cells of open libraries have about 20.
const MAX_STEPS: usize = 200;

/// A step of a function in postfix order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Pushes the value of an input, by its place among the inputs.
    Pin(u8),
    /// Pushes 0 in all lanes.
    Zero,
    /// Pushes 1 in all lanes.
    One,
    /// Inverts the last operand.
    Not,
    /// Takes two operands.
    And,
    /// Takes two operands.
    Or,
    /// Takes two operands.
    Xor,
}

/// Why a text or a list of steps is no function.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{text}` is no Boolean function: {reason}")]
pub struct FunctionError {
    /// The text.
    pub text: String,
    /// What is wrong with it.
    pub reason: String,
}

/// A Boolean function of up to 255 inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Function(Vec<Step>);

impl Function {
    /// The function of `steps` over `inputs` inputs.
    ///
    /// # Errors
    /// When an operand is missing or left over, an input does not exist, or there are too many.
    pub fn new(steps: Vec<Step>, inputs: usize) -> Result<Function, FunctionError> {
        let refuse = |reason: &str| {
            Err(FunctionError { text: format!("{} steps", steps.len()), reason: reason.to_owned() })
        };
        let mut depth = 0usize;
        for step in &steps {
            match step {
                Step::Pin(pin) if usize::from(*pin) >= inputs => {
                    return refuse("an input that the cell does not have");
                }
                Step::Pin(_) | Step::Zero | Step::One => depth += 1,
                Step::Not if depth < 1 => return refuse("an operand is missing"),
                Step::Not => {}
                Step::And | Step::Or | Step::Xor if depth < 2 => {
                    return refuse("an operand is missing");
                }
                Step::And | Step::Or | Step::Xor => depth -= 1,
            }
            if depth > MAX_DEPTH {
                return refuse("more than 16 operands at a time");
            }
        }
        if depth != 1 {
            return refuse("not one result");
        }
        if steps.len() > MAX_STEPS {
            return refuse("more than 200 steps");
        }
        Ok(Function(steps))
    }

    /// Reads Liberty's notation: `!a`, `a'`, `a b`, `a*b`, `a&b`, `a+b`, `a|b`, `a^b`, brackets.
    ///
    /// # Errors
    /// When the text is malformed, or names a pin that is not in `pins`.
    pub fn parse(text: &str, pins: &[String]) -> Result<Function, FunctionError> {
        let mut parser = Parser { text, rest: text, pins, steps: Vec::new(), depth: 0 };
        let read = parser.sum().and_then(|()| match parser.peek() {
            None => Ok(()),
            Some(c) => Err(format!("`{c}` is not expected")),
        });
        let refuse = |reason| FunctionError { text: text.chars().take(60).collect(), reason };
        read.map_err(refuse)?;
        Function::new(parser.steps, pins.len()).map_err(|error| refuse(error.reason))
    }

    /// Its steps.
    pub fn steps(&self) -> &[Step] {
        &self.0
    }

    /// Its value in every lane, `input` giving the values of the inputs.
    #[inline]
    pub fn evaluate(&self, input: impl Fn(usize) -> u64) -> u64 {
        let mut stack = [0u64; MAX_DEPTH];
        let mut top = 0;
        for step in &self.0 {
            match *step {
                Step::Pin(pin) => {
                    stack[top] = input(usize::from(pin));
                    top += 1;
                }
                Step::Zero | Step::One => {
                    stack[top] = if *step == Step::One { !0 } else { 0 };
                    top += 1;
                }
                Step::Not => stack[top - 1] = !stack[top - 1],
                Step::And | Step::Or | Step::Xor => {
                    top -= 1;
                    let (a, b) = (stack[top - 1], stack[top]);
                    stack[top - 1] = match step {
                        Step::And => a & b,
                        Step::Or => a | b,
                        _ => a ^ b,
                    };
                }
            }
        }
        stack[0]
    }

    /// Whether it depends on input `pin` of `inputs`.
    pub fn depends_on(&self, pin: usize, inputs: usize) -> bool {
        let state = |number: u64, with: u64| {
            self.evaluate(|i| if i == pin { with } else { 0u64.wrapping_sub(number >> i & 1) })
        };
        (0..1u64 << inputs.min(12)).any(|number| state(number, 0) != state(number, !0))
    }
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
    pins: &'a [String],
    steps: Vec<Step>,
    depth: usize,
}

impl Parser<'_> {
    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    fn skip(&mut self) {
        let mut chars = self.rest.chars();
        chars.next();
        self.rest = chars.as_str();
    }

    fn push(&mut self, step: Step) -> Result<(), String> {
        self.steps.push(step);
        if self.steps.len() > MAX_STEPS { Err("more than 200 steps".to_owned()) } else { Ok(()) }
    }

    fn sum(&mut self) -> Result<(), String> {
        self.product()?;
        while let Some('+' | '|') = self.peek() {
            self.skip();
            self.product()?;
            self.push(Step::Or)?;
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), String> {
        self.difference()?;
        loop {
            match self.peek() {
                Some('*' | '&') => self.skip(),
                Some(c) if c == '(' || c == '!' || is_name(c) => {}
                _ => return Ok(()),
            }
            self.difference()?;
            self.push(Step::And)?;
        }
    }

    fn difference(&mut self) -> Result<(), String> {
        self.factor()?;
        while self.peek() == Some('^') {
            self.skip();
            self.factor()?;
            self.push(Step::Xor)?;
        }
        Ok(())
    }

    fn factor(&mut self) -> Result<(), String> {
        self.depth += 1;
        if self.depth > 100 {
            return Err("nested deeper than 100".to_owned());
        }
        match self.peek() {
            Some('!') => {
                self.skip();
                self.factor()?;
                self.push(Step::Not)?;
            }
            Some('(') => {
                self.skip();
                self.sum()?;
                if self.peek() != Some(')') {
                    return Err("a bracket is not closed".to_owned());
                }
                self.skip();
            }
            Some(c) if is_name(c) => self.name()?,
            Some(c) => return Err(format!("`{c}` is not expected")),
            None => return Err("an operand is missing".to_owned()),
        }
        while self.peek() == Some('\'') {
            self.skip();
            self.push(Step::Not)?;
        }
        self.depth -= 1;
        Ok(())
    }

    fn name(&mut self) -> Result<(), String> {
        let end = self.rest.find(|c| !is_name(c)).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        if let Some(place) = self.pins.iter().position(|pin| pin == name) {
            return match u8::try_from(place) {
                Ok(place) => self.push(Step::Pin(place)),
                Err(_) => Err("a cell of more than 255 inputs".to_owned()),
            };
        }
        match name {
            "0" => self.push(Step::Zero),
            "1" => self.push(Step::One),
            _ if self.text.len() > 10_000 => Err("longer than 10,000 characters".to_owned()),
            _ => Err(format!("the cell has no input `{name}`")),
        }
    }
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '[' || c == ']' || c == '.'
}
