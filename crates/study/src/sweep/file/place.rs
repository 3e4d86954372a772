//! Where a part of a sweep file stands.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use powergs_base::config::Problem;
use powergs_base::config::error::Place;

/// The parsed text with the places of everything in it, and what was typed in place of keys of it.
pub(in crate::sweep) struct Places<'a> {
    text: &'a str,
    typed: &'a [String],
    root: Option<DeTable<'a>>,
}

impl<'a> Places<'a> {
    pub(in crate::sweep) fn new(text: &'a str, typed: &'a [String]) -> Self {
        Self { text, typed, root: DeTable::parse(text).ok().map(Spanned::into_inner) }
    }

    /// What was typed for a key of `set`.
    pub(in crate::sweep) fn typed(&self, key: &str) -> Option<&'a String> {
        let of_key = |set: &&String| set.split('=').next().is_some_and(|own| own.trim() == key);
        self.typed.iter().rev().find(of_key)
    }

    /// A problem at `path`: dotted, with the numbers of list items (`axes.2.values.0`), or the
    /// nearest part around it that there is.
    pub(in crate::sweep) fn problem(&self, path: &str, message: String) -> Problem {
        if let Some(set) = path.strip_prefix("set.").and_then(|key| self.typed(key)) {
            return Problem { place: Place::Set(set.clone()), key: path.to_owned(), message };
        }
        let span = self.root.as_ref().and_then(|root| in_table(root, path));
        let place = Place::of(self.text, span.unwrap_or(0..0));
        Problem { place, key: path.to_owned(), message }
    }
}

fn in_table(table: &DeTable<'_>, path: &str) -> Option<Range<usize>> {
    for (key, value) in table.iter() {
        let name = key.get_ref().as_ref();
        let Some(rest) = path.strip_prefix(name) else { continue };
        let own = || key.span().start..value.span().end.max(key.span().end);
        match rest.strip_prefix('.') {
            Some(rest) => return Some(in_value(value, rest).unwrap_or_else(own)),
            None if rest.is_empty() => return Some(own()),
            None => {}
        }
    }
    None
}

fn in_value(value: &Spanned<DeValue<'_>>, path: &str) -> Option<Range<usize>> {
    match value.get_ref() {
        DeValue::Table(table) => in_table(table, path),
        DeValue::Array(items) => {
            let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
            let item = items.get(first.parse::<usize>().ok()?)?;
            let inner = rest.and_then(|rest| in_value(item, rest));
            Some(inner.unwrap_or_else(|| item.span()))
        }
        DeValue::String(_)
        | DeValue::Integer(_)
        | DeValue::Float(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_) => None,
    }
}
