//! DRAM device files: any text is a device that works or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::dram::drive::{Access, banked};
use powergs_sim::dram::{Device, EnergyUse, Mode};

fuzz_target!(|text: &str| {
    let Ok(device) = Device::parse(text) else { return };
    let accesses = (0..200u64).map(|i| Access {
        write: i % 3 == 0,
        address: i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (i % 60),
        bytes: 1 + (i as u32 * 37) % 500,
    });
    let run = banked(&device, Mode::Saturated, accesses);
    let _ = EnergyUse::new(&device, &run.stats, run.cycles);
});
