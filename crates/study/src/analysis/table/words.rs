//! A column of words: each different word once, a number per row.

use std::collections::HashMap;

use crate::sweep::expr::{Expr, Value};

/// A column of words.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Words {
    codes: Vec<u32>,
    words: Vec<String>,
    /// The words as numbers in base units, where they are numbers.
    numbers: Vec<Option<f64>>,
}

impl Words {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.codes.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.codes.is_empty()
    }

    /// The number of the word of a row; equal words have equal numbers.
    pub fn code(&self, row: u32) -> u32 {
        self.codes[row as usize]
    }

    /// The word of a row.
    pub fn word(&self, row: u32) -> &str {
        &self.words[self.code(row) as usize]
    }

    /// Gives a row another word.
    pub fn set(&mut self, row: u32, word: &str) {
        let code = self.find(word).unwrap_or_else(|| {
            self.words.push(word.to_owned());
            self.numbers.push(None);
            self.words.len() as u32 - 1
        });
        self.codes[row as usize] = code;
    }

    /// The value of a row in base units, if its word is a number with or without a unit.
    pub fn number(&self, row: u32) -> Option<f64> {
        self.number_of(self.code(row))
    }

    /// The value of a code in base units.
    pub(crate) fn number_of(&self, code: u32) -> Option<f64> {
        self.numbers[code as usize]
    }

    /// Whether two rows have the same value, however it is written (`1 KiB`, `1024 B`).
    pub fn same(&self, a: u32, b: u32) -> bool {
        let number = || self.number(a).is_some_and(|x| Some(x) == self.number(b));
        self.code(a) == self.code(b) || number()
    }

    /// The different words, by their codes.
    pub fn distinct(&self) -> &[String] {
        &self.words
    }

    /// The code of a word, if it occurs.
    pub fn find(&self, word: &str) -> Option<u32> {
        self.words.iter().position(|w| w == word).map(|code| code as u32)
    }

    /// Whether every word is a number.
    pub fn is_numeric(&self) -> bool {
        !self.words.is_empty() && self.numbers.iter().all(Option::is_some)
    }

    /// The codes in the order of an axis: numbers by value, then words as they first occur.
    pub fn ordered(&self) -> Vec<u32> {
        let mut codes: Vec<u32> = (0..self.words.len() as u32).collect();
        let key = |c: &u32| self.number_of(*c).unwrap_or(f64::INFINITY);
        codes.sort_by(|a, b| key(a).total_cmp(&key(b)));
        codes
    }
}

/// Collects a column of words.
#[derive(Debug, Default)]
pub(super) struct WordBuilder {
    words: Words,
    known: HashMap<String, u32>,
}

impl WordBuilder {
    /// Adds the word of the next row.
    pub(super) fn push(&mut self, word: &str) {
        let code = match self.known.get(word) {
            Some(code) => *code,
            None => {
                let code = self.words.words.len() as u32;
                self.words.words.push(word.to_owned());
                self.words.numbers.push(number(word));
                self.known.insert(word.to_owned(), code);
                code
            }
        };
        self.words.codes.push(code);
    }

    /// The column.
    pub(super) fn finish(self) -> Words {
        self.words
    }
}

/// The longest word that may be a number.
const NUMBER_MAX: usize = 64;

/// `64 KiB` in base units.
fn number(word: &str) -> Option<f64> {
    if word.len() > NUMBER_MAX {
        return None;
    }
    match Expr::parse(word).ok()?.eval(&|_| None) {
        Ok(Value::Number(x)) if x.is_finite() => Some(x),
        _ => None,
    }
}
