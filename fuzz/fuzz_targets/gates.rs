//! Netlists with prices: any bytes, and any contents behind a right header and checksum, are a
//! circuit, which runs and is written as it was read, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_gates::energy;
use powergs_gates::netlist::Netlist;
use powergs_gates::simulator::Simulator;

fn run(bytes: &[u8]) {
    let Ok(netlist) = Netlist::from_bytes("x.gates", bytes) else { return };
    let mut simulator = Simulator::new(&netlist);
    simulator.settle();
    simulator.clock();
    let _ = energy::of(&netlist, &simulator.toggles());
    let again = Netlist::from_bytes("again.gates", &netlist.to_bytes()).expect("what was written");
    assert!(again == netlist, "a file that reads differently");
}

fuzz_target!(|bytes: &[u8]| {
    run(bytes);
    let Some((version, contents)) = bytes.split_first() else { return };
    let packed = zstd::stream::encode_all(contents, 1).expect("packing into memory");
    run(&[b"PGSGATES".as_slice(), &u32::from(version % 4).to_le_bytes(), &packed].concat());
});
