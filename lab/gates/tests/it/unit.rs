//! A committed netlist in 64 lanes, its ports by name.

use powergs_gates::netlist::Netlist;
use powergs_gates::simulator::Simulator;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Circuits side by side.
pub const LANES: usize = 64;
/// Libraries that the units are mapped to.
pub const LIBRARIES: [&str; 2] = ["nangate45", "asap7"];

/// A unit in 64 lanes, its ports by name.
pub struct Unit {
    pub netlist: Netlist,
    pub simulator: Simulator,
    pub random: Pcg64Mcg,
}

impl Unit {
    /// After reset, every input at 0.
    pub fn new(unit: &str, library: &str) -> Unit {
        let root = env!("CARGO_MANIFEST_DIR");
        let path = format!("{root}/../../rtl/netlists/{unit}-{library}.gates");
        let bytes = std::fs::read(&path).expect("a committed netlist");
        let netlist = Netlist::from_bytes(&path, &bytes).expect("a netlist");
        let about = &netlist.parts().about;
        assert_eq!((about.unit.as_str(), about.library.as_str()), (unit, library));
        let mut unit = Unit {
            simulator: Simulator::new(&netlist),
            netlist,
            random: Pcg64Mcg::seed_from_u64(1),
        };
        if unit.netlist.port("rst_n").is_some() {
            unit.cycle();
            unit.set("rst_n", &[1; LANES]);
        }
        unit
    }

    fn nets(&self, port: &str) -> Vec<u32> {
        self.netlist.port(port).unwrap_or_else(|| panic!("port {port}")).nets.clone()
    }

    /// A port of up to 64 bits.
    pub fn set(&mut self, port: &str, values: &[u64; LANES]) {
        for (bit, net) in self.nets(port).into_iter().enumerate() {
            let lane = |(lane, value): (usize, &u64)| (value >> bit & 1) << lane;
            let word = values.iter().enumerate().map(lane).sum();
            self.simulator.set(net, word);
        }
    }

    pub fn get(&self, port: &str) -> [u64; LANES] {
        let mut values = [0; LANES];
        for (bit, net) in self.nets(port).into_iter().enumerate() {
            let word = self.simulator.get(net);
            for (lane, value) in values.iter_mut().enumerate() {
                *value |= (word >> lane & 1) << bit;
            }
        }
        values
    }

    /// Words of up to 32 x 16 bits: rows of 16 entries of 32 bits, records.
    pub fn set_rows(&mut self, port: &str, rows: &[Option<[u32; 16]>; LANES]) {
        for (bit, net) in self.nets(port).into_iter().enumerate() {
            let lane = |(lane, row): (usize, &Option<[u32; 16]>)| {
                row.map_or(0, |row| u64::from(row[bit / 32] >> (bit % 32) & 1) << lane)
            };
            let word = rows.iter().enumerate().map(lane).sum();
            self.simulator.set(net, word);
        }
    }

    /// Words of any number of bits, the lowest first; what is missing is 0.
    pub fn set_words(&mut self, port: &str, words: &[Vec<u32>]) {
        for (bit, net) in self.nets(port).into_iter().enumerate() {
            let lane = |(lane, words): (usize, &Vec<u32>)| {
                let word = words.get(bit / 32).copied().unwrap_or(0);
                u64::from(word >> (bit % 32) & 1) << lane
            };
            let word = words.iter().enumerate().map(lane).sum();
            self.simulator.set(net, word);
        }
    }

    pub fn rows(&self, port: &str) -> [[u32; 16]; LANES] {
        let mut rows = [[0; 16]; LANES];
        for (bit, net) in self.nets(port).into_iter().enumerate() {
            let word = self.simulator.get(net);
            for (lane, row) in rows.iter_mut().enumerate() {
                row[bit / 32] |= ((word >> lane & 1) as u32) << (bit % 32);
            }
        }
        rows
    }

    pub fn cycle(&mut self) {
        self.simulator.settle();
        self.simulator.clock();
    }

    /// One in each lane with a probability of three quarters.
    pub fn coins(&mut self) -> [u64; LANES] {
        std::array::from_fn(|_| u64::from(self.random.random_bool(0.75)))
    }
}
