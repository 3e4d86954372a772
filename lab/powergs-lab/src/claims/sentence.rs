//! What a finding says: words with numbers between them, which are not text yet.

/// What a number measures, and so how it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A share that is saved, negative where more is spent: `63.1 % less`.
    Saved,
    /// A share, written in percent.
    Percent,
    /// Watts, written with a prefix.
    Watts,
    /// HVSQ, written in units of 1e-5.
    Hvsq,
    /// Decibels.
    Decibels,
    /// Frames a second.
    FramesPerSecond,
    /// Codes of 8 bits.
    Codes,
    /// λ, 1/W.
    PerWatt,
    /// How many.
    Count,
    /// Without unit: SSIM, ρ, R², factors.
    One,
}

/// A number in a sentence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// The value, in the unit without prefix or factor.
    pub value: f64,
    /// What it measures.
    pub unit: Unit,
    /// Digits after the point, where the unit does not say how it is written.
    pub decimals: u8,
    /// Whether a plus is written.
    pub is_signed: bool,
}

/// A piece of a sentence.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// As it is.
    Words(String),
    /// To be written by whoever shows it.
    Number(Number),
}

/// Words with numbers between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sentence {
    /// Its pieces, in order.
    pub parts: Vec<Part>,
}

impl Sentence {
    /// The numbers alone, in order.
    pub fn numbers(&self) -> impl Iterator<Item = Number> {
        self.parts.iter().filter_map(|part| match part {
            Part::Number(number) => Some(*number),
            Part::Words(_) => None,
        })
    }

    /// Both, with words between.
    pub(super) fn then(mut self, words: &str, next: impl Into<Sentence>) -> Sentence {
        self.parts.push(Part::Words(words.to_owned()));
        self.parts.extend(next.into().parts);
        self
    }
}

impl<T: Into<String>> From<T> for Sentence {
    fn from(words: T) -> Sentence {
        Sentence { parts: vec![Part::Words(words.into())] }
    }
}

/// `template` with a sentence in place of each `{}`.
pub(super) fn say<const N: usize>(template: &str, values: [Sentence; N]) -> Sentence {
    let mut words = template.split("{}");
    let mut sentence = Sentence::from(words.next().unwrap_or_default());
    for value in values {
        let after = words.next().expect("a place for every value");
        sentence.parts.extend(value.parts);
        sentence.parts.push(Part::Words(after.to_owned()));
    }
    assert!(words.next().is_none(), "a value for every place in `{template}`");
    sentence
}

/// All of them, with words between; `None` if there is none.
pub(super) fn joined(
    sentences: impl IntoIterator<Item = Sentence>,
    words: &str,
) -> Option<Sentence> {
    sentences.into_iter().reduce(|all, next| all.then(words, next))
}

fn number(value: f64, unit: Unit, decimals: u8, is_signed: bool) -> Sentence {
    let number = Number { value, unit, decimals, is_signed };
    Sentence { parts: vec![Part::Number(number)] }
}

/// A number with so many digits after the point.
pub(super) fn fixed(value: f64, unit: Unit, decimals: u8) -> Sentence {
    number(value, unit, decimals, false)
}

/// The same with its sign.
pub(super) fn signed(value: f64, unit: Unit, decimals: u8) -> Sentence {
    number(value, unit, decimals, true)
}

/// How many.
pub(super) fn count(n: usize) -> Sentence {
    number(n as f64, Unit::Count, 0, false)
}

/// `63.1 % less`, or `4.2 % more`.
pub(super) fn less(share: f64) -> Sentence {
    number(share, Unit::Saved, 1, false)
}

/// Watts with a prefix.
pub(super) fn watts(w: f64) -> Sentence {
    number(w, Unit::Watts, 0, false)
}
