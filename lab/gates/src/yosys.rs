//! Mapped netlists as Yosys writes them (`write_json`).

use std::collections::HashMap;

use serde_json::{Map, Value};
use thiserror::Error;

/// Bytes of a netlist that are read at most.
const MAX_BYTES: usize = 1 << 30;
/// Net numbers are below this; what is read has as many nets as are named.
const MAX_NET: u64 = 1 << 32;

/// The net that is 0.
pub const ZERO: u32 = 0;
/// The net that is 1.
pub const ONE: u32 = 1;

/// A JSON file that is no mapped netlist.
#[derive(Debug, Error)]
#[error("{file}: {reason}")]
pub struct JsonError {
    /// Name of the file as it was given.
    pub file: String,
    /// What is wrong, and what to do about it.
    pub reason: String,
}

/// A module of cells.
#[derive(Debug)]
pub struct Mapped {
    /// Name of the module.
    pub name: String,
    /// Number of nets, in the order in which the file names them; 0 and 1 are constants.
    pub nets: u32,
    /// Ports in the order of the module.
    pub ports: Vec<Port>,
    /// Cells in the order of the file.
    pub cells: Vec<Instance>,
}

/// A port, lowest bit first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Whether it is an input.
    pub input: bool,
    /// Net of each bit.
    pub nets: Vec<u32>,
}

/// A cell as it is placed.
#[derive(Debug)]
pub struct Instance {
    /// Its name in the netlist.
    pub name: String,
    /// Its kind in the library.
    pub kind: String,
    /// Net of each pin.
    pub pins: Vec<(String, u32)>,
}

impl Mapped {
    /// Reads a file with one module, or the one whose attribute `top` is set.
    ///
    /// # Errors
    /// Says what is no netlist of Yosys, or not flat: memories, parameters, vectors at pins.
    pub fn parse(file: &str, text: &str) -> Result<Mapped, JsonError> {
        read(text).map_err(|reason| JsonError { file: file.to_owned(), reason })
    }
}

fn read(text: &str) -> Result<Mapped, String> {
    if text.len() > MAX_BYTES {
        return Err("larger than 1 GiB".to_owned());
    }
    let value: Value = serde_json::from_str(text)
        .map_err(|error| format!("no JSON ({error}); the file may be truncated"))?;
    let modules = value.get("modules").and_then(Value::as_object);
    let modules = modules.ok_or("no `modules`: not written by Yosys' write_json")?;
    let is_top = |module: &Value| {
        let top = module.get("attributes").and_then(|attributes| attributes.get("top"));
        top.and_then(Value::as_str).is_some_and(|top| top.ends_with('1'))
    };
    let top = modules.iter().find(|(_, module)| is_top(module)).or_else(|| {
        let mut all = modules.iter();
        all.next().filter(|_| modules.len() == 1)
    });
    let (name, module) = top.ok_or("several modules and none is top; run `hierarchy -top`")?;
    let mut mapped = Mapped { name: name.clone(), nets: 2, ports: Vec::new(), cells: Vec::new() };
    let mut nets = Nets(HashMap::new());
    for (name, port) in object(module, "ports")? {
        let input = match port.get("direction").and_then(Value::as_str) {
            Some("input") => true,
            Some("output") => false,
            _ => return Err(format!("port {name} is neither input nor output")),
        };
        let nets = nets.bits(port.get("bits"), name)?;
        mapped.ports.push(Port { name: name.clone(), input, nets });
    }
    for (name, cell) in object(module, "cells")? {
        let kind = cell.get("type").and_then(Value::as_str);
        let kind = kind.ok_or_else(|| format!("cell {name} has no type"))?.to_owned();
        let mut pins = Vec::new();
        for (pin, at) in object(cell, "connections")? {
            match *nets.bits(Some(at), name)? {
                [] => {}
                [net] => pins.push((pin.clone(), net)),
                _ => {
                    return Err(format!(
                        "pin {pin} of cell {name} ({kind}) is a vector: the netlist is not mapped \
                         to a library"
                    ));
                }
            }
        }
        mapped.cells.push(Instance { name: name.clone(), kind, pins });
    }
    mapped.nets += nets.0.len() as u32;
    Ok(mapped)
}

fn object<'a>(of: &'a Value, name: &str) -> Result<&'a Map<String, Value>, String> {
    let found = of.get(name).and_then(Value::as_object);
    found.ok_or_else(|| format!("no `{name}`: not written by Yosys' write_json"))
}

/// Our number of each net of the file: theirs may be large and far apart.
struct Nets(HashMap<u64, u32>);

impl Nets {
    fn bits(&mut self, value: Option<&Value>, owner: &str) -> Result<Vec<u32>, String> {
        let list = value.and_then(Value::as_array);
        let list = list.ok_or_else(|| format!("{owner}: no list of bits"))?;
        let bit = |bit: &Value| match (bit.as_u64(), bit.as_str()) {
            (Some(net @ 2..MAX_NET), _) => {
                let next = self.0.len() as u32 + 2;
                Ok(*self.0.entry(net).or_insert(next))
            }
            // A bit that nobody cares about is 0.
            (_, Some("0" | "x")) => Ok(ZERO),
            (_, Some("1")) => Ok(ONE),
            _ => Err(format!("{owner}: `{bit}` is no bit of a netlist")),
        };
        list.iter().map(bit).collect()
    }
}
