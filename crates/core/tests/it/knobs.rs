//! Every knob is alive: each key of each file that comes with the program moves some output, or is
//! listed in `arch-configs/inert.toml` as inert under a condition that is then lifted. And every
//! assumption has its knob, or a reason to have none.

mod assumptions;
mod dram;
mod energy;
mod inert;
mod machine;
mod support;

use powergs_base::config::knob;
use toml::Value;

/// What became of a changed value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Moved,
    Same,
    /// An error that names the key, the table it is in, or the value.
    Refused,
    /// An error that names neither.
    Misnamed,
}

impl Verdict {
    fn of_error(error: &str, key: &str, value: &Value) -> Verdict {
        let (table, last) = key.rsplit_once('.').unwrap_or((key, key));
        let value = knob::shown(value);
        let named = [table, last, &value].iter().any(|name| error.contains(*name));
        if named { Verdict::Refused } else { Verdict::Misnamed }
    }

    fn of(moved: bool) -> Verdict {
        if moved { Verdict::Moved } else { Verdict::Same }
    }

    /// Whether a key is alive. Of numbers it is enough that one moves something; of names each
    /// must. An error counts for a name, and where there is no other number.
    fn is_alive(all: &[Verdict], is_name: bool) -> bool {
        let (moved, same) = (all.contains(&Verdict::Moved), all.contains(&Verdict::Same));
        let misnamed = all.contains(&Verdict::Misnamed);
        match is_name {
            true => !same && !misnamed,
            false => moved || (!same && !misnamed),
        }
    }
}
