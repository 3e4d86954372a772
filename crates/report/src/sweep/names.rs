//! Short names of axes for the heads of tables.

use powergs_core::flow;
use powergs_study::sweep::key::Key;

/// For every name the shortest end of it that only it has, among the others and among all keys of
/// all files, machines of other dataflows left out: `sorting.capacity` for
/// `buffers.sorting.capacity`. An end that another one begins with (`units` beside
/// `units-per-core`) is too short.
pub fn short(names: &[&str]) -> Vec<String> {
    let flow_of = |name: &str| Some(flow::of_table(name.split('.').next()?)?.key());
    let flows: Vec<&str> = names.iter().filter_map(|name| flow_of(name)).collect();
    let is_near = |name: &&str| flow_of(name).is_none_or(|flow| flows.contains(&flow));
    let mut others: Vec<&str> = Key::all().filter(is_near).collect();
    others.extend(names);
    let one = |name: &&str| {
        ends(name).find(|end| is_clear(end, name, &others)).unwrap_or(name).to_owned()
    };
    names.iter().map(one).collect()
}

/// The ends of a dotted name, the shortest first.
fn ends(name: &str) -> impl Iterator<Item = &str> {
    let cuts = name.rmatch_indices(['.', ':']).map(|(at, _)| &name[at + 1..]);
    cuts.chain([name])
}

fn is_clear(end: &str, name: &str, others: &[&str]) -> bool {
    let last = end.rsplit(['.', ':']).next().unwrap_or(end);
    let clashes = |other: &str| {
        let is_end = other.strip_suffix(end).is_some_and(|rest| rest.ends_with(['.', ':']));
        let other_last = other.rsplit(['.', ':']).next().unwrap_or(other);
        let is_beginning = end == last && other_last.starts_with(&format!("{end}-"));
        other != name && (other == end || is_end || is_beginning)
    };
    !others.iter().any(|other| clashes(other))
}
