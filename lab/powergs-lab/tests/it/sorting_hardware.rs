//! The cycles of sorting units as they are counted here against what `rtl/qsu.sv` and `rtl/bsu.sv`
//! take, which co-simulation shows to be those of `powergs_datapath::vectors`, cycle for cycle.

use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::flow::tile_wise::bsu::Sort;
use powergs_core::flow::tile_wise::qsu::Keys;
use powergs_core::kernel::unit::Unit;
use powergs_datapath::vectors::{bsu, qsu};

use crate::support::gscore;

/// Units one a core, with the latencies of `rtl/`, which `arch-configs/machines/gscore.toml` has.
fn units() -> ResolvedUnits {
    let mut machine = gscore();
    (machine.tiles_mut().gsu.qsu_per_core, machine.tiles_mut().gsu.bsu_per_core) = (1, 1);
    (machine.tiles_mut().gsu.qsu_latency, machine.tiles_mut().gsu.bsu_latency) = (2, 4);
    ResolvedUnits::new(&machine)
}

/// A list whose order says nothing.
fn list(keys: u16) -> Vec<u16> {
    (0..keys).map(|i| i.wrapping_mul(40_503) & 0x7bff).collect()
}

#[test]
fn a_pass_takes_the_cycles_of_the_hardware() {
    let units = units();
    for keys in [257, 300, 1000, 5000] {
        let work = Keys { held: keys, sorted: keys, passes: 1, ..Keys::default() };
        let hardware = qsu(&[list(keys as u16)]).cycles().expect("they are known");
        assert_eq!(units.qsu.cycles(&work), u64::from(hardware), "{keys} keys");
    }
}

#[test]
fn a_chunk_takes_the_cycles_of_the_hardware() {
    let units = units();
    for keys in 1..=256u64 {
        let counted = units.bsu.cycles(&Sort { keys, filtered: 0 });
        let hardware = bsu(&[list(keys as u16)]).cycles().expect("they are known");
        assert_eq!(counted, u64::from(hardware), "{keys} keys");
    }
}
