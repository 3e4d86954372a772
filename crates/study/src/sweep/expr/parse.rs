//! The parser of expressions: tokens to a tree, by precedence.

use std::ops::Range;

use super::lex::{LexWord, Token};
use super::{ExprError, Function, Node, Two, Value, What};
use powergs_base::config::suggest::nearest;

/// How deep parentheses, signs and functions may nest.
const DEPTH_MAX: usize = 64;

struct Parser<'a> {
    text: &'a str,
    tokens: &'a [Token],
    at: usize,
    depth: usize,
}

pub(super) fn parse(text: &str, tokens: &[Token]) -> Result<Node, ExprError> {
    let mut parser = Parser { text, tokens, at: 0, depth: 0 };
    let node = parser.operators(0)?;
    match parser.peek() {
        None => Ok(node),
        Some(LexWord::Close) => Err(parser.fail("a `)` without its `(`")),
        Some(_) => Err(parser.fail("an operator is missing before this")),
    }
}

/// How tight an operator binds; a power binds to the right.
const fn strength(two: Two) -> usize {
    match two {
        Two::Or => 1,
        Two::And => 2,
        Two::Equal | Two::NotEqual | Two::Less | Two::AtMost | Two::More | Two::AtLeast => 3,
        Two::Plus | Two::Minus => 4,
        Two::Times | Two::Over | Two::Remainder => 5,
        Two::Power => 7,
    }
}

/// Of `!` and of a sign: tighter than products, looser than powers.
const SIGN: usize = 6;

impl Parser<'_> {
    fn peek(&self) -> Option<&LexWord> {
        self.tokens.get(self.at).map(|(word, _)| word)
    }

    /// The place of the next word, or the end.
    fn span(&self) -> Range<usize> {
        let end = self.text.trim_end().len();
        self.tokens.get(self.at).map_or(end..end, |(_, span)| span.clone())
    }

    fn fail(&self, message: impl Into<String>) -> ExprError {
        ExprError::new(self.text, &self.span(), message)
    }

    /// A value and all operators behind it that bind at least as tight as `least`.
    fn operators(&mut self, least: usize) -> Result<Node, ExprError> {
        self.depth += 1;
        if self.depth > DEPTH_MAX {
            return Err(self.fail(format!("more than {DEPTH_MAX} levels deep")));
        }
        let mut left = self.one()?;
        while let Some(LexWord::Two(two)) = self.peek() {
            let two = *two;
            let own = strength(two);
            if own < least.max(1) {
                break;
            }
            if two.compares() && matches!(&left.what, What::Two(l, _) if l.compares()) {
                let hint = "comparisons do not chain: write `a < b && b < c`";
                // In parentheses it is meant: `(a < b) == c`.
                if !self.is_closed() {
                    return Err(self.fail(hint));
                }
            }
            self.at += 1;
            // A power binds to the right and takes a sign: `2^-1`. All others bind to the left.
            let right = self.operators(if two == Two::Power { SIGN } else { own + 1 })?;
            let span = left.span.start..right.span.end;
            left = Node { span, what: What::Two(two, Box::new([left, right])) };
        }
        self.depth -= 1;
        Ok(left)
    }

    /// Whether the word before the next one is a `)`.
    fn is_closed(&self) -> bool {
        self.at > 0 && self.tokens[self.at - 1].0 == LexWord::Close
    }

    fn one(&mut self) -> Result<Node, ExprError> {
        let span = self.span();
        let Some(word) = self.peek().cloned() else {
            return Err(self.fail("a value is missing at the end"));
        };
        self.at += 1;
        let what = match word {
            LexWord::Number(n) => What::Value(Value::Number(n)),
            LexWord::Measured(n, measure) => What::Measured(n, measure),
            LexWord::Text(text) => What::Value(Value::Text(text)),
            LexWord::Name(name) if self.peek() == Some(&LexWord::Open) => {
                return self.call(&name, span);
            }
            LexWord::Name(name) => match name.as_str() {
                "true" => What::Value(Value::Truth(true)),
                "false" => What::Value(Value::Truth(false)),
                _ => What::Name(name),
            },
            LexWord::Not => What::Not(Box::new(self.operators(SIGN)?)),
            LexWord::Two(Two::Minus) => What::Minus(Box::new(self.operators(SIGN)?)),
            LexWord::Two(Two::Plus) => return self.operators(SIGN),
            LexWord::Open => {
                let inner = self.operators(0)?;
                if self.peek() != Some(&LexWord::Close) {
                    return Err(ExprError::new(self.text, &span, "this `(` is never closed"));
                }
                self.at += 1;
                return Ok(inner);
            }
            LexWord::Two(_) | LexWord::Close | LexWord::Comma => {
                // Messages are about the next word, which is this one.
                self.at -= 1;
                return Err(self.fail("a value is missing before this"));
            }
        };
        let end = self.tokens[self.at - 1].1.end;
        Ok(Node { span: span.start..end, what })
    }

    fn call(&mut self, name: &str, span: Range<usize>) -> Result<Node, ExprError> {
        let found = Function::ALL.iter().find(|(known, _)| *known == name);
        let Some((_, function)) = found else {
            let known = || Function::ALL.iter().map(|(known, _)| *known);
            let hint = match nearest(name, known()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are {}", known().collect::<Vec<_>>().join(", ")),
            };
            let message = format!("no function `{name}`; {hint}");
            return Err(ExprError::new(self.text, &span, message));
        };
        self.at += 1;
        let mut arguments = Vec::new();
        loop {
            if self.peek() == Some(&LexWord::Close) && arguments.is_empty() {
                break;
            }
            arguments.push(self.operators(0)?);
            match self.peek() {
                Some(LexWord::Comma) => self.at += 1,
                Some(LexWord::Close) => break,
                Some(_) => return Err(self.fail("`,` or `)` is missing before this")),
                None => return Err(ExprError::new(self.text, &span, "no closing `)`")),
            }
        }
        self.at += 1;
        let span = span.start..self.tokens[self.at - 1].1.end;
        let (least, most) = function.arguments();
        if !(least..=most).contains(&arguments.len()) {
            let wants =
                if least == most { format!("{least}") } else { format!("at least {least}") };
            let message = format!("`{name}` takes {wants} values, not {}", arguments.len());
            return Err(ExprError::new(self.text, &span, message));
        }
        Ok(Node { span, what: What::Call(*function, arguments) })
    }
}
