//! Schedules and tables as SystemVerilog.
//!
//! `rtl/ccu_program_pkg.sv` and `rtl/fp_special_pkg.sv` are what [`programs()`] and [`tables()`]
//! give; a test compares them.

use std::fmt::Write;

use super::graph::{Graph, Operand, Value};
use super::programs;
use super::schedule::{LATENCY, Operators, Schedule};
use super::special::{reciprocal_table, root_table};

/// Operators of the projection that `rtl/` has schedules for: its parameter `OPS`.
pub const WIDTHS: [u32; 4] = [4, 8, 16, 32];
/// The shortest lap: work is seen in one cycle and taken in another.
const LEAST: usize = 2;
/// Bits of an operation of an operator, of a write of a register, and of an output.
const WORDS: [usize; 3] = [40, 16, 12];

/// A program of a unit of `ops` operators: its graphs, of which one runs at a time, in time.
#[derive(Debug)]
pub struct Program {
    /// Its name.
    pub name: &'static str,
    /// Its operators.
    pub operators: Operators,
    /// Each graph with its schedule.
    pub modes: Vec<(Graph, Schedule)>,
}

impl Program {
    fn new(name: &'static str, operators: Operators, graphs: Vec<Graph>) -> Program {
        let in_time = |graph: Graph| {
            let schedule = Schedule::new(&graph, operators, LEAST);
            (graph, schedule)
        };
        Program { name, operators, modes: graphs.into_iter().map(in_time).collect() }
    }

    /// Culling of a unit of `ops` operators.
    pub fn cull(ops: u32) -> Program {
        let operators = match ops {
            0..16 => [1, 1, 0],
            16..32 => [1, 2, 0],
            _ => [2, 3, 0],
        };
        Program::new("cull", operators, vec![programs::cull()])
    }

    /// Projection.
    pub fn project(ops: u32) -> Program {
        let operators = match ops {
            0..8 => [2, 2, 1],
            8..16 => [4, 4, 1],
            16..32 => [9, 7, 1],
            _ => [18, 14, 2],
        };
        Program::new("project", operators, vec![programs::project()])
    }

    /// Colours: a mode for each SH degree.
    pub fn colour(ops: u32) -> Program {
        let each = ops.max(4) as usize / 4;
        let graphs = (0..4).map(programs::colour).collect();
        Program::new("colour", [each, each, 0], graphs)
    }

    fn registers(&self) -> usize {
        self.modes.iter().map(|(_, schedule)| schedule.registers).max().unwrap_or(0)
    }

    fn steps(&self) -> usize {
        self.modes.iter().map(|(_, schedule)| schedule.interval).sum()
    }

    fn literals(&self) -> Vec<f32> {
        let mut literals: Vec<f32> = Vec::new();
        for (graph, _) in &self.modes {
            for literal in &graph.literals {
                if !literals.contains(literal) {
                    literals.push(*literal);
                }
            }
        }
        literals
    }

    fn stages(&self) -> usize {
        let stages = |(_, s): &(Graph, Schedule)| (s.leaves / s.interval).max(s.late_lap) + 1;
        self.modes.iter().map(stages).max().unwrap_or(1)
    }

    /// Where a value is in cycle `cycle` of a mode: registers, inputs, late inputs, settings,
    /// literals, then results of operators.
    fn source(&self, mode: usize, value: Value, cycle: usize) -> u64 {
        let (graph, schedule) = &self.modes[mode];
        let [inputs, late, settings] = graph.inputs;
        let registers = self.registers();
        let place = match value {
            Value::Node(_) => schedule.stay(value, cycle).expect("a result in a register").register,
            Value::Input(i) => match schedule.stay(value, cycle) {
                Some(stay) => stay.register,
                None => registers + i,
            },
            Value::Late(i) => registers + inputs + i,
            Value::Setting(i) => registers + inputs + late + i,
            Value::Literal(i) => {
                let known = self.literals();
                let at = known.iter().position(|l| *l == graph.literals[i]).expect("a literal");
                registers + inputs + late + settings + at
            }
        };
        place as u64
    }

    fn result(&self, kind: usize, operator: usize) -> u64 {
        let [inputs, late, settings] = self.modes[0].0.inputs;
        let before: usize = self.operators[..kind].iter().sum();
        let values = self.registers() + inputs + late + settings + self.literals().len();
        (values + before + operator) as u64
    }

    /// A word for every step of every operator: sources of a and b (9 bits each) with what is done
    /// to their signs (2), of c (9), what is done (2), stage (5), whether anything is (1).
    fn operations(&self) -> Vec<u64> {
        let (lanes, steps) = (self.operators.iter().sum::<usize>(), self.steps());
        let mut words = vec![0; lanes * steps];
        let mut first = 0;
        for (mode, (graph, schedule)) in self.modes.iter().enumerate() {
            for issue in &schedule.issues {
                let node = &graph.nodes[issue.node];
                let kind = node.operation.kind() as usize;
                let lane = self.operators[..kind].iter().sum::<usize>() + issue.operator;
                let operand = |operand: Operand| {
                    self.source(mode, operand.value, issue.cycle)
                        | u64::from(operand.absolute) << 9
                        | u64::from(operand.negate) << 10
                };
                let [mut a, mut b] = node.operands.map(operand);
                if issue.swapped {
                    (a, b) = (b, a);
                }
                let stage = (issue.cycle / schedule.interval) as u64;
                words[lane * steps + first + issue.cycle % schedule.interval] = a
                    | b << 11
                    | self.source(mode, node.sign, issue.cycle) << 22
                    | node.operation.code() << 31
                    | stage << 33
                    | 1 << 38;
            }
            first += schedule.interval;
        }
        idle_like_neighbours(&mut words, steps, 38, (1 << 33) - 1);
        words
    }

    /// A word for every step of every register: source (9 bits), stage (5), whether it is written.
    fn writes(&self) -> Vec<u64> {
        let steps = self.steps();
        let mut words = vec![0; self.registers() * steps];
        let mut first = 0;
        for (mode, (graph, schedule)) in self.modes.iter().enumerate() {
            for stay in &schedule.stays {
                let cycle = stay.cycles[0] - 1;
                let source = match stay.value {
                    Value::Node(node) if !stay.moves => {
                        let issue = schedule.issues[node];
                        assert_eq!(issue.cycle + LATENCY, cycle + 1, "a result is written at once");
                        let kind = graph.nodes[node].operation.kind() as usize;
                        self.result(kind, issue.operator)
                    }
                    value => self.source(mode, value, cycle),
                };
                let word = &mut words[stay.register * steps + first + cycle % schedule.interval];
                assert_eq!(*word, 0, "a register is written once");
                *word = source | ((cycle / schedule.interval) as u64) << 9 | 1 << 14;
            }
            first += schedule.interval;
        }
        idle_like_neighbours(&mut words, steps, 14, (1 << 9) - 1);
        words
    }

    /// A word for every output of every mode: its source.
    fn results(&self) -> Vec<u64> {
        let of = |mode: usize| {
            let (graph, schedule) = &self.modes[mode];
            graph.outputs.iter().map(move |&v| self.source(mode, v, schedule.leaves))
        };
        (0..self.modes.len()).flat_map(of).collect()
    }

    /// A word for every mode: first and last step, step and stage of the outputs, stage of the late
    /// inputs, 8 bits each; stage 255 is none.
    fn laps(&self) -> Vec<u64> {
        let mut first = 0;
        let lap = |(graph, s): &(Graph, Schedule)| {
            let leave = first + (s.leaves % s.interval) as u64;
            let last = first + s.interval as u64 - 1;
            let late = if graph.inputs[1] > 0 { s.late_lap as u64 } else { 255 };
            let stage = (s.leaves / s.interval) as u64;
            let word = first | last << 8 | leave << 16 | stage << 24 | late << 32;
            first = last + 1;
            word
        };
        self.modes.iter().map(lap).collect()
    }

    fn counts(&self) -> [(&'static str, usize); 8] {
        let [muls, adds, specials] = self.operators;
        [
            ("MULS", muls),
            ("ADDS", adds),
            ("SPECIALS", specials),
            ("REGISTERS", self.registers()),
            ("LITERALS", self.literals().len()),
            ("STEPS", self.steps()),
            ("STAGES", self.stages()),
            ("MODES", self.modes.len()),
        ]
    }
}

/// Where nothing is done, operands are those of the step before: multiplexers are smaller.
fn idle_like_neighbours(words: &mut [u64], steps: usize, used: u32, mask: u64) {
    for row in words.chunks_mut(steps) {
        let Some(last) = row.iter().rev().find(|word| **word >> used & 1 == 1) else { continue };
        let mut before = *last & mask;
        for word in row {
            if *word >> used & 1 == 0 {
                *word = before;
            }
            before = *word & mask;
        }
    }
}

/// A constant of words, the last one first, padded to `count` words.
fn constant(out: &mut String, name: &str, bits: usize, words: &[u64], count: usize) {
    let total = bits * count;
    writeln!(out, "    localparam logic [{}:0] {name} = {{", total - 1).expect("text");
    let digits = bits / 4;
    let mut line = String::from("       ");
    for place in (0..count).rev() {
        let word = words.get(place).copied().unwrap_or(0);
        let comma = if place == 0 { "" } else { "," };
        let item = format!(" {bits}'h{word:0digits$x}{comma}");
        if line.len() + item.len() > 100 {
            writeln!(out, "{line}").expect("text");
            line = String::from("       ");
        }
        line += &item;
    }
    writeln!(out, "{line}\n    }};").expect("text");
}

/// `rtl/ccu_program_pkg.sv`.
pub fn programs() -> String {
    let mut out = String::from(
        "// Schedules of the culling and conversion unit, made by lab/datapath (ccu::emit): do\n\
         // not edit. A test compares this file; with UPDATE_EXPECT=1 it writes it. Numbers of\n\
         // operators, registers and so on are words of 16 bits for OPS = 4, 8, 16, 32 from the\n\
         // lowest.\n\
         package ccu_program_pkg;\n",
    );
    for make in [Program::cull, Program::project, Program::colour] {
        let all = WIDTHS.map(make);
        let name = all[0].name.to_uppercase();
        for i in 0..all[0].counts().len() {
            let words: Vec<u64> = all.iter().map(|p| p.counts()[i].1 as u64).collect();
            constant(&mut out, &format!("{name}_{}", all[0].counts()[i].0), 16, &words, 4);
        }
        let literals: Vec<u64> =
            all[0].literals().iter().map(|literal| u64::from(literal.to_bits())).collect();
        constant(&mut out, &format!("{name}_LITERAL"), 32, &literals, literals.len());
        let tables = all.each_ref().map(|p| [p.operations(), p.writes(), p.results(), p.laps()]);
        let names = ["OPERATIONS", "WRITES", "RESULTS", "LAPS"];
        for (i, (table, bits)) in names.iter().zip(WORDS.into_iter().chain([40])).enumerate() {
            let count = tables.iter().map(|table| table[i].len()).max().unwrap_or(1);
            for (table_of, ops) in tables.iter().zip(WIDTHS) {
                constant(&mut out, &format!("{name}_{table}_{ops}"), bits, &table_of[i], count);
            }
            writeln!(out, "    localparam int {name}_{table}_BITS = {};", bits * count)
                .expect("text");
        }
    }
    out += "endpackage\n";
    out
}

/// `rtl/fp_special_pkg.sv`.
pub fn tables() -> String {
    let mut out = String::from(
        "// Lines of 1/x and 1/sqrt(x), made by lab/datapath (ccu::emit): do not edit. An\n\
         // entry is where a line begins, in 2^-22, behind what it falls by, of 16 bits.\n\
         package fp_special_pkg;\n",
    );
    for (name, table) in [("RECIPROCAL", reciprocal_table()), ("ROOT", root_table())] {
        let words: Vec<u64> =
            table.iter().map(|[from, fall]| u64::from(*from) << 16 | u64::from(*fall)).collect();
        constant(&mut out, name, 40, &words, words.len());
    }
    out += "endpackage\n";
    out
}
