//! The file of a netlist (`*.gates`): a versioned header and columns packed with Zstandard.
//!
//! `PGSGATES`, the version as a 32-bit number (little endian), then one Zstandard frame with a
//! checksum. Inside: what the netlist is, kinds, ports, and for all cells the kind, then for all
//! inputs the distance to the driving net, for all flip-flops their clock gate, then energies and
//! capacitances. These are kept as the
//! upper 16 bits of a 32-bit float (8 bits of mantissa: 0.2 % each, without bias). Integers are
//! variable-length, seven bits a byte; reals of the header are 64-bit.

use std::collections::BTreeMap;
use std::io::Read;

use thiserror::Error;

use super::{
    About, Behaviour, ClockGate, FlipFlop, Kind, Netlist, NetlistError, Parts, Pin, input_bits,
};
use crate::function::{Function, Step};
use crate::yosys::Port;

const MAGIC: &[u8; 8] = b"PGSGATES";
/// The version that is written.
pub const VERSION: u32 = 2;
/// The version before it, which is read too: netlists without clock gates.
const UNGATED: u32 = 1;
/// Bytes of a file that are read at most, unpacked.
const MAX_BYTES: u64 = 256 << 20;
/// Nets that are read at most.
const MAX_NETS: u32 = 1 << 24;
/// Outputs that a kind of cell has at most.
const MAX_OUTPUTS: usize = 8;

/// A file that is no netlist.
#[derive(Debug, Error)]
#[error("{file}: {reason}")]
pub struct FileError {
    /// Name of the file as it was given.
    pub file: String,
    /// What is wrong, and what to do about it.
    pub reason: String,
}

/// `value` with 8 bits of mantissa, rounded to the nearest, ties to even.
pub fn rounded(value: f64) -> f32 {
    let bits = (value as f32).to_bits();
    f32::from_bits(bits.wrapping_add(0x7fff + (bits >> 16 & 1)) & 0xffff_0000)
}

impl Netlist {
    /// The bytes of a file.
    ///
    /// # Panics
    /// When memory runs out while packing.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(Vec::new());
        out.parts(self);
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        let packed = zstd::stream::encode_all(out.0.as_slice(), 19);
        bytes.extend(packed.expect("packing into memory"));
        bytes
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// When it is no netlist, of another version, damaged, or cannot be simulated.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Netlist, FileError> {
        let refuse = |reason: String| FileError { file: file.to_owned(), reason };
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err(refuse("no netlist of powergs-gates (it begins otherwise)".to_owned()));
        };
        let Some((version, packed)) = rest.split_first_chunk::<4>() else {
            return Err(refuse("truncated; fetch it again".to_owned()));
        };
        let version = u32::from_le_bytes(*version);
        if ![VERSION, UNGATED].contains(&version) {
            let read = format!("this program reads {UNGATED} and {VERSION}");
            let reason = format!("version {version}, {read}; map it anew");
            return Err(refuse(reason));
        }
        let mut unpacked = Vec::new();
        let decoder = zstd::stream::read::Decoder::new(packed);
        let read = decoder.and_then(|d| d.take(MAX_BYTES + 1).read_to_end(&mut unpacked));
        read.map_err(|error| refuse(format!("damaged ({error}); fetch it again")))?;
        if unpacked.len() as u64 > MAX_BYTES {
            return Err(refuse("larger than 256 MiB unpacked".to_owned()));
        }
        let mut reader = Reader(&unpacked);
        let parts = reader.parts(version).map_err(|error| refuse(error.to_string()))?;
        if !reader.0.is_empty() {
            return Err(refuse("bytes are left over: damaged; fetch it again".to_owned()));
        }
        Netlist::new(parts).map_err(|error| refuse(error.to_string()))
    }
}

struct Writer(Vec<u8>);

impl Writer {
    fn number(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    fn real(&mut self, value: f64) {
        self.0.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.0.extend(text.as_bytes());
    }

    /// Upper halves of 32-bit floats, high bytes first: they are alike.
    fn halves(&mut self, values: &[f32]) {
        for shift in [24, 16] {
            self.0.extend(values.iter().map(|value| (value.to_bits() >> shift) as u8));
        }
    }

    fn function(&mut self, function: &Function) {
        self.number(function.steps().len() as u64);
        for step in function.steps() {
            match step {
                Step::Zero => self.0.push(0),
                Step::One => self.0.push(1),
                Step::Not => self.0.push(2),
                Step::And => self.0.push(3),
                Step::Or => self.0.push(4),
                Step::Xor => self.0.push(5),
                Step::Pin(pin) => self.0.extend([6, *pin]),
            }
        }
    }

    fn parts(&mut self, netlist: &Netlist) {
        let parts = netlist.parts();
        let about = &parts.about;
        for text in [&about.unit, &about.library, &about.corner, &about.wires] {
            self.text(text);
        }
        self.real(about.voltage);
        self.real(about.period_ns);
        self.real(about.critical_path_ns);
        self.real(about.clock_transition_ns);
        self.real(about.input_transition_ns);
        self.real(about.load_ff);
        self.number(parts.kinds.len() as u64);
        parts.kinds.iter().for_each(|kind| self.kind(kind));
        self.number(parts.ports.len() as u64);
        for port in &parts.ports {
            self.text(&port.name);
            self.0.push(u8::from(port.input));
            self.number(port.nets.len() as u64);
            let nets = port.nets.iter().filter(|_| !port.input);
            nets.for_each(|net| self.number(u64::from(*net)));
        }
        self.number(u64::from(parts.clock));
        self.number(parts.cells.len() as u64);
        parts.cells.iter().for_each(|kind| self.number(u64::from(*kind)));
        let mut own = 2 + input_bits(&parts.ports) as i64;
        for cell in 0..parts.cells.len() {
            let (inputs, outputs) = netlist.pins(cell);
            for pin in inputs {
                let away = own - i64::from(pin.net);
                self.number((away << 1 ^ away >> 63) as u64);
            }
            own += outputs.len() as i64;
        }
        // For each flip-flop the place of its clock gate among those, from 1; 0 without one.
        let is_gate =
            |cell: &usize| matches!(netlist.kind(*cell).behaviour, Behaviour::ClockGate(_));
        let gates = (0..parts.cells.len()).filter(is_gate);
        let place: BTreeMap<u32, u64> =
            gates.map(|cell| netlist.pins(cell).1[0].net).zip(1..).collect();
        for cell in 0..parts.cells.len() {
            if let Behaviour::FlipFlop(_) = netlist.kind(cell).behaviour {
                self.number(place.get(&parts.clocks[cell]).copied().unwrap_or(0));
            }
        }
        for of in [|pin: &Pin| pin.rise_fj, |pin: &Pin| pin.fall_fj] {
            self.halves(&parts.pins.iter().map(of).collect::<Vec<_>>());
        }
        self.halves(&parts.capacitance);
    }

    fn kind(&mut self, kind: &Kind) {
        self.text(&kind.name);
        self.real(kind.area);
        self.real(kind.leakage);
        self.0.push(kind.inputs);
        match &kind.behaviour {
            Behaviour::Gate(functions) => {
                self.0.push(0);
                self.number(functions.len() as u64);
                functions.iter().for_each(|function| self.function(function));
            }
            Behaviour::FlipFlop(flip_flop) => {
                self.0.push(1);
                self.function(&flip_flop.next);
                self.number(flip_flop.inverted.len() as u64);
                self.0.extend(flip_flop.inverted.iter().map(|inverted| u8::from(*inverted)));
                self.real(flip_flop.idle_fj);
                self.real(flip_flop.change_fj);
                self.real(flip_flop.clock_ff);
            }
            Behaviour::ClockGate(gate) => {
                self.0.push(2);
                self.function(&gate.enable);
                self.real(gate.closed_fj);
                self.real(gate.clock_ff);
            }
        }
    }
}

/// What is not read yet.
struct Reader<'a>(&'a [u8]);

type Decoded<T> = Result<T, NetlistError>;

fn damaged() -> NetlistError {
    NetlistError::Malformed("damaged or truncated; fetch it again".to_owned())
}

/// The largest number of a file, in its units.
const LARGEST: f64 = 1e15;

impl<'a> Reader<'a> {
    fn bytes(&mut self, count: usize) -> Decoded<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(damaged)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Decoded<u8> {
        Ok(self.bytes(1)?[0])
    }

    fn number(&mut self) -> Decoded<u64> {
        let mut value = 0u64;
        for shift in (0..63).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(damaged())
    }

    /// A number of things of a byte at least each: no larger than what is left.
    fn count(&mut self) -> Decoded<usize> {
        let count = self.number()?;
        usize::try_from(count).ok().filter(|count| *count <= self.0.len()).ok_or_else(damaged)
    }

    fn net(&mut self) -> Decoded<u32> {
        u32::try_from(self.number()?).map_err(|_| damaged())
    }

    fn real(&mut self) -> Decoded<f64> {
        let bytes = self.bytes(8)?.try_into().expect("eight bytes");
        let value = Some(f64::from_le_bytes(bytes));
        value.filter(|value| value.abs() <= LARGEST).ok_or_else(damaged)
    }

    /// An area, a leakage, a capacitance, a time.
    fn size(&mut self) -> Decoded<f64> {
        self.real().and_then(|size| if size < 0.0 { Err(damaged()) } else { Ok(size) })
    }

    fn text(&mut self) -> Decoded<String> {
        let length = self.count()?;
        String::from_utf8(self.bytes(length)?.to_vec()).map_err(|_| damaged())
    }

    fn halves(&mut self, count: usize) -> Decoded<Vec<f32>> {
        let (high, low) = (self.bytes(count)?, self.bytes(count)?);
        let bits = high.iter().zip(low).map(|(h, l)| u32::from(*h) << 24 | u32::from(*l) << 16);
        Ok(bits.map(f32::from_bits).collect())
    }

    fn function(&mut self, inputs: u8) -> Decoded<Function> {
        let mut steps = Vec::new();
        for _ in 0..self.count()? {
            steps.push(match self.byte()? {
                0 => Step::Zero,
                1 => Step::One,
                2 => Step::Not,
                3 => Step::And,
                4 => Step::Or,
                5 => Step::Xor,
                6 => Step::Pin(self.byte()?),
                _ => return Err(damaged()),
            });
        }
        Function::new(steps, usize::from(inputs)).map_err(|_| damaged())
    }

    fn kind(&mut self) -> Decoded<Kind> {
        let (name, area, leakage) = (self.text()?, self.size()?, self.size()?);
        let inputs = self.byte()?;
        let behaviour = match self.byte()? {
            0 => {
                let mut functions = Vec::new();
                for _ in 0..self.count()? {
                    functions.push(self.function(inputs)?);
                }
                Behaviour::Gate(functions)
            }
            1 => {
                let next = self.function(inputs)?;
                let outputs = self.count()?;
                let inverted = self.bytes(outputs)?.iter().map(|byte| *byte != 0).collect();
                Behaviour::FlipFlop(FlipFlop {
                    next,
                    inverted,
                    idle_fj: self.real()?,
                    change_fj: self.real()?,
                    clock_ff: self.size()?,
                })
            }
            2 => Behaviour::ClockGate(ClockGate {
                enable: self.function(inputs)?,
                closed_fj: self.real()?,
                clock_ff: self.size()?,
            }),
            _ => return Err(damaged()),
        };
        let kind = Kind { name, area, leakage, inputs, behaviour };
        if kind.outputs() > MAX_OUTPUTS { Err(damaged()) } else { Ok(kind) }
    }

    fn parts(&mut self, version: u32) -> Decoded<Parts> {
        let mut parts = Parts { about: self.about()?, ..Parts::default() };
        for _ in 0..self.count()? {
            parts.kinds.push(self.kind()?);
        }
        let mut next = 2u32;
        for _ in 0..self.count()? {
            let (name, input) = (self.text()?, self.byte()? != 0);
            // An output's bit is a byte at least, a net's capacitance behind it two.
            let bits = self.count()?;
            let mut nets = Vec::new();
            for _ in 0..bits {
                nets.push(if input { next } else { self.net()? });
                next += u32::from(input);
                if next > MAX_NETS {
                    return Err(damaged());
                }
            }
            parts.ports.push(Port { name, input, nets });
        }
        parts.clock = self.net()?;
        let cells = self.count()?;
        for _ in 0..cells {
            parts.cells.push(u16::try_from(self.number()?).map_err(|_| damaged())?);
        }
        for cell in 0..cells {
            let kind = parts.kinds.get(usize::from(parts.cells[cell])).ok_or_else(damaged)?;
            let pin = |net| Pin { net, rise_fj: 0.0, fall_fj: 0.0 };
            for _ in 0..kind.inputs {
                let folded = self.number()? as i64;
                let away = folded >> 1 ^ -(folded & 1);
                let net = i64::from(next).checked_sub(away).and_then(|net| net.try_into().ok());
                parts.pins.push(pin(net.ok_or_else(damaged)?));
            }
            for _ in 0..kind.outputs() {
                parts.pins.push(pin(next));
                next += 1;
            }
            if next > MAX_NETS {
                return Err(damaged());
            }
        }
        self.clocks(&mut parts, version)?;
        let (rise, fall) = (self.halves(parts.pins.len())?, self.halves(parts.pins.len())?);
        for (pin, (rise, fall)) in parts.pins.iter_mut().zip(rise.into_iter().zip(fall)) {
            (pin.rise_fj, pin.fall_fj) = (rise, fall);
        }
        parts.capacitance = self.halves(next as usize)?;
        Ok(parts)
    }

    fn clocks(&mut self, parts: &mut Parts, version: u32) -> Decoded<()> {
        // The clock, then the outputs of the clock gates.
        let (mut nets, mut pin) = (vec![parts.clock], 0);
        for kind in &parts.cells {
            let kind = &parts.kinds[usize::from(*kind)];
            if let Behaviour::ClockGate(_) = kind.behaviour {
                nets.push(parts.pins[pin + usize::from(kind.inputs)].net);
            }
            pin += kind.pins();
        }
        for kind in &parts.cells {
            parts.clocks.push(match parts.kinds[usize::from(*kind)].behaviour {
                Behaviour::Gate(_) => 0,
                Behaviour::ClockGate(_) => parts.clock,
                Behaviour::FlipFlop(_) if version == UNGATED => parts.clock,
                Behaviour::FlipFlop(_) => {
                    let place = usize::try_from(self.number()?).map_err(|_| damaged())?;
                    *nets.get(place).ok_or_else(damaged)?
                }
            });
        }
        Ok(())
    }

    fn about(&mut self) -> Decoded<About> {
        Ok(About {
            unit: self.text()?,
            library: self.text()?,
            corner: self.text()?,
            wires: self.text()?,
            voltage: self.size()?,
            period_ns: self.size()?,
            critical_path_ns: self.size()?,
            clock_transition_ns: self.size()?,
            input_transition_ns: self.size()?,
            load_ff: self.size()?,
        })
    }
}
