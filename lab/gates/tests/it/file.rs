//! Files of netlists: the same after writing and reading, and nothing else is read.

use std::sync::LazyLock;

use powergs_gates::netlist::Netlist;
use powergs_gates::netlist::file::rounded;
use proptest::prelude::*;

use super::toy::{counter, gated, priced};

fn bytes() -> &'static [u8] {
    static BYTES: LazyLock<Vec<u8>> =
        LazyLock::new(|| priced(&gated()).expect("a netlist").netlist.to_bytes());
    &BYTES
}

fn refusal(bytes: &[u8]) -> String {
    Netlist::from_bytes("x.gates", bytes).expect_err("refused").to_string()
}

#[test]
fn what_is_written_is_read() {
    for circuit in [counter(), gated()] {
        let netlist = priced(&circuit).expect("a netlist").netlist;
        let read = Netlist::from_bytes("x.gates", &netlist.to_bytes()).expect("a netlist");
        assert_eq!(read, netlist);
    }
}

#[test]
fn energies_keep_eight_bits_and_the_nearest() {
    for (value, near) in
        [(1.0, 1.0), (1.001, 1.0), (1.0039, 1.0), (1.004, 1.0078125), (-3.01, -3.015625)]
    {
        assert_eq!(rounded(value), near);
    }
}

#[test]
fn other_files_are_refused() {
    assert!(refusal(b"PGTRACE1").contains("no netlist of powergs-gates"));
    assert!(refusal(b"PGSGATES").contains("truncated"));
    let mut other = bytes().to_vec();
    other[8] = 3;
    assert_eq!(refusal(&other), "x.gates: version 3, this program reads 1 and 2; map it anew");
    for length in 12..bytes().len() {
        assert!(Netlist::from_bytes("x.gates", &bytes()[..length]).is_err(), "{length} bytes");
    }
    // Contents that pack well: the size is limited before they are looked at.
    let zeros = zstd::stream::encode_all(&*vec![0; 300 << 20], 1).expect("memory");
    let bomb = [&bytes()[..12], &zeros].concat();
    assert!(refusal(&bomb).contains("larger than 256 MiB"));
}

#[test]
fn clocks_that_cannot_be_are_refused() {
    let parts = priced(&gated()).expect("a netlist").netlist.parts().clone();
    let refusal = |change: &dyn Fn(&mut powergs_gates::netlist::Parts)| {
        let mut parts = parts.clone();
        change(&mut parts);
        Netlist::new(parts).expect_err("refused").to_string()
    };
    let behind = parts.clocks[0];
    let cannot = "has a clock that it cannot have";
    assert!(refusal(&|parts| parts.clocks[0] = 3).contains(cannot));
    assert!(refusal(&|parts| parts.clocks[0] = u32::MAX).contains(cannot));
    assert!(refusal(&|parts| parts.clocks[1] = behind).contains(cannot));
    assert!(refusal(&|parts| parts.clocks[2] = parts.clock).contains(cannot));
    assert!(refusal(&|parts| parts.clocks.truncate(1)).contains("not one clock for each cell"));
    let read = refusal(&|parts| parts.pins[0].net = behind);
    assert!(read.contains("cell 0 reads the output of a clock gate"), "{read}");
}

/// The unpacked contents behind the header.
fn contents() -> Vec<u8> {
    zstd::stream::decode_all(&bytes()[12..]).expect("a frame")
}

fn changes() -> impl Strategy<Value = Vec<(prop::sample::Index, u8)>> {
    prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)
}

proptest! {
    #[test]
    fn damaged_contents_never_panic(changes in changes()) {
        let mut inside = contents();
        for (at, value) in changes {
            let at = at.index(inside.len());
            inside[at] = value;
        }
        let packed = zstd::stream::encode_all(&*inside, 1).expect("memory");
        let file = [&bytes()[..12], &packed].concat();
        if let Ok(netlist) = Netlist::from_bytes("x.gates", &file) {
            powergs_gates::simulator::Simulator::new(&netlist).settle();
        }
    }
}
