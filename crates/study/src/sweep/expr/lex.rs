//! The lexer of expressions: text to tokens.

use std::ops::Range;

use super::{ExprError, Two};
use crate::sweep::measure::Measure;
use powergs_base::config::suggest::nearest;

/// A word.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum LexWord {
    Number(f64),
    Measured(f64, Measure),
    Text(String),
    Name(String),
    Two(Two),
    Not,
    Open,
    Close,
    Comma,
}

/// A word and where it stands, in bytes.
pub(super) type Token = (LexWord, Range<usize>);

const SIGNS: [(&str, LexWord); 18] = [
    ("||", LexWord::Two(Two::Or)),
    ("&&", LexWord::Two(Two::And)),
    ("==", LexWord::Two(Two::Equal)),
    ("!=", LexWord::Two(Two::NotEqual)),
    ("<=", LexWord::Two(Two::AtMost)),
    (">=", LexWord::Two(Two::AtLeast)),
    ("<", LexWord::Two(Two::Less)),
    (">", LexWord::Two(Two::More)),
    ("+", LexWord::Two(Two::Plus)),
    ("-", LexWord::Two(Two::Minus)),
    ("*", LexWord::Two(Two::Times)),
    ("/", LexWord::Two(Two::Over)),
    ("%", LexWord::Two(Two::Remainder)),
    ("^", LexWord::Two(Two::Power)),
    ("!", LexWord::Not),
    ("(", LexWord::Open),
    (")", LexWord::Close),
    (",", LexWord::Comma),
];

pub(super) fn tokens(text: &str) -> Result<Vec<Token>, ExprError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        if c.is_whitespace() {
            at += c.len_utf8();
            continue;
        }
        // Labels come before numbers: `28nm:area_mm2` begins with a digit and is a name.
        let (word, length) = match c {
            '0'..='9' if let Some(length) = labelled(&text[at..]) => {
                (LexWord::Name(text[at..at + length].to_owned()), length)
            }
            '0'..='9' | '.' => number(text, at)?,
            '\'' | '"' | '`' => quoted(text, at, c)?,
            c if c.is_ascii_alphabetic() || c == '_' => {
                let length = name_length(&text[at..]);
                (LexWord::Name(text[at..at + length].to_owned()), length)
            }
            _ => sign(text, at, c)?,
        };
        tokens.push((word, at..at + length));
        at += length;
    }
    Ok(tokens)
}

fn sign(text: &str, at: usize, c: char) -> Result<(LexWord, usize), ExprError> {
    // The list has longer signs first, so that `<=` is not read as `<`.
    if let Some((sign, word)) = SIGNS.iter().find(|(sign, _)| text[at..].starts_with(sign)) {
        return Ok((word.clone(), sign.len()));
    }
    let message = match c {
        '=' => "write `==` to compare".to_owned(),
        '&' => "write `&&`".to_owned(),
        '|' => "write `||`".to_owned(),
        '≤' => "write `<=`".to_owned(),
        '≥' => "write `>=`".to_owned(),
        c => format!("`{}` means nothing here", c.escape_default()),
    };
    Err(ExprError::new(text, &(at..at + c.len_utf8()), message))
}

fn quoted(text: &str, at: usize, quote: char) -> Result<(LexWord, usize), ExprError> {
    let Some(length) = text[at + 1..].find(quote) else {
        return Err(ExprError::new(text, &(at..at + 1), format!("no closing {quote}")));
    };
    let inside = text[at + 1..at + 1 + length].to_owned();
    let word = if quote == '`' { LexWord::Name(inside) } else { LexWord::Text(inside) };
    Ok((word, length + 2))
}

/// Bytes of the name at the start of `text`: letters, digits and `_`; `.`, `-` and `:` only where a
/// letter, or behind a dot a digit, follows.
fn name_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let is_word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
    let mut end = 0;
    while let Some(b) = bytes.get(end) {
        let next = bytes.get(end + 1);
        let joins = match b {
            b'.' => next.is_some_and(is_word),
            b'-' | b':' => next.is_some_and(u8::is_ascii_alphabetic),
            b => is_word(b),
        };
        if !joins {
            break;
        }
        end += 1;
    }
    end
}

/// Bytes of the name at the start of `text`, where that has a label which begins with a digit:
/// `28nm:power_w.mean`.
fn labelled(text: &str) -> Option<usize> {
    let is_word = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b == b'-';
    let label = text.bytes().take_while(|b| is_word(*b)).count();
    let rest = text[label..].strip_prefix(':')?;
    let name = name_length(rest);
    let is_name = name > 0 && !rest.starts_with(|c: char| c.is_ascii_digit());
    is_name.then_some(label + 1 + name)
}

/// Bytes of the plain decimal number at the start of `text`, with its exponent.
fn digits_length(text: &str) -> usize {
    let digits = |from: &str| from.bytes().take_while(u8::is_ascii_digit).count();
    let mut end = digits(text);
    if text[end..].starts_with('.') {
        end += 1 + digits(&text[end + 1..]);
    }
    let mut exponent = end;
    if text[exponent..].starts_with(['e', 'E']) {
        exponent += 1;
        exponent += usize::from(text[exponent..].starts_with(['+', '-']));
        let length = digits(&text[exponent..]);
        // An `e` without digits behind it belongs to what follows.
        if length > 0 {
            end = exponent + length;
        }
    }
    end
}

fn number(text: &str, at: usize) -> Result<(LexWord, usize), ExprError> {
    let length = digits_length(&text[at..]);
    let span = at..at + length.max(1);
    let digits = &text[at..at + length];
    let value = digits.parse::<f64>().ok().filter(|n| n.is_finite());
    let value = value.ok_or_else(|| ExprError::new(text, &span, "this is not a number"))?;
    let after = &text[at + length..];
    let unit_text = after.trim_start();
    let spaces = after.len() - unit_text.len();
    if !unit_text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        return Ok((LexWord::Number(value), length));
    }
    let unit_at = at + length + spaces;
    let Some((measure, unit)) = unit(unit_text) else {
        let written = &unit_text[..name_length(unit_text)];
        return Err(ExprError::new(text, &(unit_at..unit_at + written.len()), no_unit(written)));
    };
    let end = unit_at + unit.len();
    let measured = measure.read(&format!("{digits} {unit}"));
    let measured = measured.map_err(|message| ExprError::new(text, &(at..end), message))?;
    Ok((LexWord::Measured(measured, measure), end - at))
}

fn no_unit(written: &str) -> String {
    if written.eq_ignore_ascii_case("fps") {
        return "frame rates have no unit in expressions: leave `FPS` out".to_owned();
    }
    let all: Vec<String> = Measure::ALL.iter().map(|m| m.unit_names()).collect();
    let near = nearest(written, all.iter().flat_map(|names| names.split(", ")));
    let hint = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
    format!("`{written}` is not a unit; {hint}For a product, write `*`")
}

/// The longest unit at the start of `text`.
fn unit(text: &str) -> Option<(Measure, String)> {
    let mut best: Option<(Measure, String)> = None;
    for measure in Measure::ALL {
        for name in measure.unit_names().split(", ") {
            let ends =
                |rest: &str| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
            let fits = text.strip_prefix(name).is_some_and(ends);
            if fits && best.as_ref().is_none_or(|(_, b)| b.len() < name.len()) {
                best = Some((measure, name.to_owned()));
            }
        }
    }
    best
}
