//! Machine files, energy tables and sweep files: any text is one or a list of problems.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::machine::Machine;
use powergs_sim::stage::EnergyTable;
use powergs_sim::sweep::file::SweepFile;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(machine) = Machine::parse(text) {
        assert_eq!(Machine::parse(&machine.to_toml()).ok(), Some(machine));
    }
    if let Err(error) = EnergyTable::parse(text) {
        assert!(error.to_string().len() < 1 << 20);
    }
    if let Err(error) = SweepFile::parse(text) {
        assert!(error.to_string().len() < 1 << 20);
    }
});
