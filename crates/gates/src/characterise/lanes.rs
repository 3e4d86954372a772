//! Ports of 64 circuits at a time: a bit of every circuit is one word of the simulator.

use crate::characterise::CharacteriseError;
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// Circuits side by side.
pub const LANES: usize = 64;

/// Nets of a port.
pub struct Lanes(Vec<u32>);

impl Lanes {
    /// The port called `port`.
    pub fn of(netlist: &Netlist, port: &'static str) -> Result<Lanes, CharacteriseError> {
        let found = netlist.port(port).ok_or(CharacteriseError::Port { port })?;
        Ok(Lanes(found.nets.clone()))
    }

    /// The port called `port`, which may be missing.
    pub fn named(netlist: &Netlist, port: &str) -> Option<Lanes> {
        Some(Lanes(netlist.port(port)?.nets.clone()))
    }

    /// Its bits.
    pub fn bits(&self) -> usize {
        self.0.len()
    }

    /// The lowest bits of each lane's value.
    pub fn set(&self, simulator: &mut Simulator, values: &[u64; LANES]) {
        for (bit, net) in self.0.iter().enumerate() {
            let of_lane = |lane: usize| (values[lane] >> bit & 1) << lane;
            simulator.set(*net, (0..LANES).map(of_lane).sum());
        }
    }

    /// Each lane's row of 16 entries.
    pub fn set_rows(&self, simulator: &mut Simulator, rows: &[[u32; 16]; LANES]) {
        for (bit, net) in self.0.iter().enumerate() {
            let of_lane = |lane: usize| u64::from(rows[lane][bit / 32] >> (bit % 32) & 1) << lane;
            simulator.set(*net, (0..LANES).map(of_lane).sum());
        }
    }

    /// Each lane's words, the lowest first.
    pub fn set_words(&self, simulator: &mut Simulator, words: &[Vec<u32>]) {
        for (bit, net) in self.0.iter().enumerate() {
            let of_lane = |lane: usize| u64::from(words[lane][bit / 32] >> (bit % 32) & 1) << lane;
            simulator.set(*net, (0..LANES).map(of_lane).sum());
        }
    }

    /// `bits` bits of one lane's value, from bit `first` on.
    pub fn part(&self, simulator: &Simulator, lane: usize, first: usize, bits: usize) -> u64 {
        let nets = self.0[first..][..bits].iter().enumerate();
        nets.map(|(bit, net)| (simulator.get(*net) >> lane & 1) << bit).sum()
    }

    /// One bit, in all lanes.
    pub fn bit(&self, simulator: &Simulator) -> u64 {
        self.0.first().map_or(0, |net| simulator.get(*net))
    }

    /// One lane's row of 16 entries.
    pub fn row(&self, simulator: &Simulator, lane: usize) -> [u32; 16] {
        let mut row = [0; 16];
        for (bit, net) in self.0.iter().enumerate() {
            row[bit / 32] |= ((simulator.get(*net) >> lane & 1) as u32) << (bit % 32);
        }
        row
    }

    /// One lane's value.
    pub fn value(&self, simulator: &Simulator, lane: usize) -> u64 {
        let bit = |(bit, net): (usize, &u32)| (simulator.get(*net) >> lane & 1) << bit;
        self.0.iter().enumerate().map(bit).sum()
    }
}

/// Work dealt to lanes so that all have about as much: the largest first, to the lane with least.
pub fn dealt<T>(work: &[T], size: impl Fn(&T) -> usize) -> Vec<Vec<&T>> {
    let mut order: Vec<&T> = work.iter().collect();
    order.sort_by_key(|piece| std::cmp::Reverse(size(piece)));
    let mut lanes: Vec<(usize, Vec<&T>)> = (0..LANES).map(|_| (0, Vec::new())).collect();
    for piece in order {
        let least = lanes.iter_mut().min_by_key(|(load, _)| *load).expect("64 lanes");
        least.0 += size(piece);
        least.1.push(piece);
    }
    lanes.into_iter().map(|(_, pieces)| pieces).collect()
}

/// Numbers of `width` bits side by side, the first in the lowest bits.
pub fn side_by_side(numbers: impl Iterator<Item = u32>, width: usize, words: &mut [u32]) {
    words.fill(0);
    for (i, number) in numbers.enumerate() {
        for bit in (0..width).filter(|bit| number >> bit & 1 == 1) {
            let at = i * width + bit;
            words[at / 32] |= 1 << (at % 32);
        }
    }
}
