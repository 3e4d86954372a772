//! What machines are called: by what they have on the axes of the space.

use super::pricing::{MachinePoint, Row};

/// The ending of columns that repeat a measure in SI units.
const SI: &str = ".si";

impl Row {
    /// The columns of the axes, without those in SI units: places and names.
    pub fn axes(&self) -> Vec<(usize, &str)> {
        let columns = self.columns[..self.axes.min(self.columns.len())].iter().enumerate();
        columns.filter(|(_, name)| !name.ends_with(SI)).map(|(i, name)| (i, &**name)).collect()
    }

    /// A machine by what it has on the axes: `cores=2 channels=4`. Empty where it has nothing.
    pub fn name(&self, machine: MachinePoint) -> String {
        let Some(settings) = self.settings.get(&machine) else { return String::new() };
        let axes = self.axes();
        let keys: Vec<&str> = axes.iter().map(|(_, key)| *key).collect();
        let values = axes.iter().map(|(i, _)| compact(&settings[*i]));
        let set = short(&keys).into_iter().zip(values).filter(|(_, value)| !value.is_empty());
        set.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
    }
}

/// Keys without the words before their last dot, where no other one could be meant by that.
fn short<'a>(keys: &[&'a str]) -> Vec<&'a str> {
    let last = |key: &'a str| key.rsplit(['.', ':']).next().unwrap_or(key);
    let is_meant = |word: &str, other: &str| {
        other.strip_prefix(word).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    };
    let name = |key: &&'a str| {
        let word = last(key);
        let meant = keys.iter().filter(|other| is_meant(word, last(other))).count();
        if meant > 1 { *key } else { word }
    };
    keys.iter().map(name).collect()
}

/// A measure without the blank before its unit; words as they are.
fn compact(value: &str) -> String {
    match value.starts_with(|c: char| c.is_ascii_digit()) {
        true => value.replace(' ', ""),
        false => value.to_owned(),
    }
}
