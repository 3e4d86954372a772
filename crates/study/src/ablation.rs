//! What a machine may be without: each of its optional parts switched off.

use powergs_base::config::knob;
use powergs_core::flow;
use powergs_core::machine::Machine;
use powergs_core::run::Change;

/// The changes that take one optional part out of a machine each, in the order of its stages: its
/// switch back to what files without the part have, or, where every file says it, to what the
/// machine has that shows the dataflow.
pub fn ablations(machine: &Machine) -> Vec<Change> {
    let table = machine.table();
    let shown = flow::example(machine.flow()).and_then(|file| Machine::parse(file.text).ok());
    let shown = shown.map(|machine| machine.table());
    let of_example = |key| knob::values(shown.as_ref()?, key).pop();
    let mut changes: Vec<Change> = Vec::new();
    for part in machine.optional_parts().filter(|part| part.is_in(machine)) {
        let switch = part.switch;
        let is_known = changes.iter().any(|change| change.path == switch);
        let own = knob::values(&table, switch).pop();
        let (Some(own), Some(off)) =
            (own, machine.default_of(switch).or_else(|| of_example(switch)))
        else {
            continue;
        };
        if !is_known && own != off {
            changes.push(Change::machine(switch, off));
        }
    }
    changes
}
