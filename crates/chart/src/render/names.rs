//! Names that are too long for their place, shortened so that they can still be told apart.

use std::collections::BTreeSet;

use super::{LONGEST, TEXT, font};

/// `names` within `room`: without the parts that all have in common at their ends
/// (`lpddr5-6400-x16` and `lpddr4-3200-x16`), then cut inside, at the end or at the beginning,
/// whichever leaves most of them different.
pub(super) fn told_apart(names: &[&str], room: f64) -> Vec<String> {
    let fits = |names: &[String]| names.iter().all(|name| font::width(name, TEXT, false) <= room);
    let whole: Vec<String> = names.iter().map(ToString::to_string).collect();
    if fits(&whole) {
        return whole;
    }
    let is_same = names.iter().all(|name| *name == names[0]);
    let own = if is_same { whole } else { without_common(names) };
    let longest = own.iter().map(|name| name.chars().count()).max().unwrap_or(0).min(LONGEST);
    let distinct = |cut: &Vec<String>| cut.iter().collect::<BTreeSet<_>>().len();
    let cuts = [NameCut::Inside, NameCut::End, NameCut::Beginning].map(|cut| {
        let at = |width: usize| own.iter().map(|name| cut.to(name, width)).collect::<Vec<_>>();
        (1..=longest).rev().map(at).find(|names| fits(names)).unwrap_or_else(|| at(1))
    });
    // Of equals the first.
    cuts.into_iter().rev().max_by_key(distinct).unwrap_or_default()
}

/// The names without the parts between dashes with which all of them begin, or end.
fn without_common(names: &[&str]) -> Vec<String> {
    let mut parts: Vec<Vec<&str>> = names.iter().map(|name| name.split('-').collect()).collect();
    for _end in 0..2 {
        parts.iter_mut().for_each(|parts| parts.reverse());
        while parts.iter().all(|p| p.len() > 1 && p.last() == parts[0].last()) {
            parts.iter_mut().for_each(|parts| parts.truncate(parts.len() - 1));
        }
    }
    parts.iter().map(|parts| parts.join("-")).collect()
}

/// Where a name is cut.
#[derive(Clone, Copy)]
enum NameCut {
    Inside,
    End,
    Beginning,
}

impl NameCut {
    /// The name in so many characters, at least one.
    fn to(self, name: &str, width: usize) -> String {
        let all: Vec<char> = name.chars().collect();
        if all.len() <= width {
            return name.to_owned();
        }
        let kept = width.saturating_sub(1);
        let (head, tail) = match self {
            NameCut::Inside => (kept - kept / 2, kept / 2),
            NameCut::End => (kept, 0),
            NameCut::Beginning => (0, kept),
        };
        all[..head].iter().chain(&['…']).chain(&all[all.len() - tail..]).collect()
    }
}
