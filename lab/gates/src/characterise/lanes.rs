//! Ports of 64 circuits at a time: a bit of every circuit is one word of the simulator.

use crate::characterise::CharacteriseError;
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// Circuits side by side.
pub const LANES: usize = 64;

/// Cycles without a beat after which a circuit is given up: the longest pause between offers is a
/// fiftieth of it.
const PATIENCE: u64 = 1 << 16;

/// Cycles since a circuit has taken something.
#[derive(Default)]
pub struct Patience(u64);

impl Patience {
    /// A cycle; `moved` says whether any lane has taken something in it.
    ///
    /// # Errors
    /// When nothing has moved for long: it never would.
    pub fn cycle(&mut self, moved: bool) -> Result<(), CharacteriseError> {
        self.0 = if moved { 0 } else { self.0 + 1 };
        if self.0 < PATIENCE { Ok(()) } else { Err(CharacteriseError::Stuck { cycles: self.0 }) }
    }
}

/// Nets of a port.
pub struct Lanes(Vec<u32>);

impl Lanes {
    /// The port called `port`, of `bits` bits.
    pub fn of(netlist: &Netlist, port: &str, bits: usize) -> Result<Lanes, CharacteriseError> {
        Lanes::sized(netlist, port, |found| found == bits, || bits.to_string())
    }

    /// A port that carries `count` numbers side by side, and the bits of each: at most `most`.
    pub fn numbers(
        netlist: &Netlist,
        port: &str,
        count: usize,
        most: usize,
    ) -> Result<(Lanes, usize), CharacteriseError> {
        let fits = |bits: usize| bits.is_multiple_of(count) && (1..=most).contains(&(bits / count));
        let expected = || format!("{count} numbers of 1 to {most}");
        let lanes = Lanes::sized(netlist, port, fits, expected)?;
        let width = lanes.0.len() / count;
        Ok((lanes, width))
    }

    /// The port called `port`, where its bits are right.
    pub fn sized(
        netlist: &Netlist,
        port: &str,
        fits: impl Fn(usize) -> bool,
        expected: impl Fn() -> String,
    ) -> Result<Lanes, CharacteriseError> {
        let missing = || CharacteriseError::Port { port: port.to_owned() };
        let nets = &netlist.port(port).ok_or_else(missing)?.nets;
        if fits(nets.len()) {
            return Ok(Lanes(nets.clone()));
        }
        let (port, bits) = (port.to_owned(), nets.len());
        Err(CharacteriseError::Width { port, bits, expected: expected() })
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
