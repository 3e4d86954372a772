//! Which operator does an operation and which register keeps a number: so that few different
//! sources meet at each input, for a multiplexer grows with them.
//!
//! Operators and registers change places while that removes a source somewhere.

use super::graph::{Graph, KINDS, Operation, Value};
use super::schedule::{Issue, Operators, Stay};

/// Times that all places are gone through.
const PASSES: usize = 12;

/// Where a wire ends.
#[derive(Debug, Clone, Copy)]
enum To {
    /// An operand of a node.
    Operand(usize, usize),
    /// The register of a stay.
    Stay(usize),
}

/// Where it begins.
#[derive(Debug, Clone, Copy)]
enum From {
    /// The register of a stay.
    Stay(usize),
    /// The operator of a node.
    Node(usize),
    /// An input, a setting or a constant.
    Fixed(usize),
}

/// Wires of a schedule, with the operators and registers that they meet.
struct Binding<'a> {
    graph: &'a Graph,
    interval: usize,
    operators: Operators,
    registers: usize,
    issues: &'a mut [Issue],
    stays: &'a mut [Stay],
    wires: Vec<(To, From)>,
    /// Wires of each node and of each stay.
    of_node: Vec<Vec<usize>>,
    of_stay: Vec<Vec<usize>>,
    /// How many wires go from a source to an input.
    counts: Vec<u16>,
    sources: usize,
}

/// Improves on the operators and registers of a schedule; there are as many registers as before.
pub(super) fn improve(
    graph: &Graph,
    operators: Operators,
    interval: usize,
    registers: usize,
    issues: &mut [Issue],
    stays: &mut [Stay],
) {
    let [inputs, late, settings] = graph.inputs;
    let lanes: usize = operators.iter().sum();
    let sources = registers + lanes + inputs + late + settings + graph.literals.len();
    let mut binding = Binding {
        graph,
        interval,
        operators,
        registers,
        of_node: vec![Vec::new(); issues.len()],
        of_stay: vec![Vec::new(); stays.len()],
        issues,
        stays,
        wires: Vec::new(),
        counts: vec![0; (2 * lanes + registers) * sources],
        sources,
    };
    binding.connect();
    for _ in 0..PASSES {
        let changes = binding.change_operators() + binding.change_registers();
        if changes == 0 {
            break;
        }
    }
}

impl Binding<'_> {
    /// Notes all wires.
    fn connect(&mut self) {
        let [inputs, late, settings] = self.graph.inputs;
        let fixed = |value: Value| match value {
            Value::Input(i) => i,
            Value::Late(i) => inputs + i,
            Value::Setting(i) => inputs + late + i,
            Value::Literal(i) => inputs + late + settings + i,
            Value::Node(_) => unreachable!("results are in registers"),
        };
        let from = |value: Value, cycle: usize, stays: &[Stay]| {
            let there = |stay: &Stay| {
                stay.value == value && (stay.cycles[0]..=stay.cycles[1]).contains(&cycle)
            };
            match stays.iter().position(there) {
                Some(stay) => From::Stay(stay),
                None => From::Fixed(fixed(value)),
            }
        };
        let mut wires = Vec::new();
        for issue in self.issues.iter() {
            let node = &self.graph.nodes[issue.node];
            let kept = if node.operation.kind() == KINDS[2] { 1 } else { 2 };
            for (operand, number) in node.operands.iter().take(kept).enumerate() {
                let source = from(number.value, issue.cycle, self.stays);
                wires.push((To::Operand(issue.node, operand), source));
            }
        }
        for (i, stay) in self.stays.iter().enumerate() {
            let source = match (stay.moves, stay.value) {
                (false, Value::Node(node)) => From::Node(node),
                (_, value) => from(value, stay.cycles[0] - 1, self.stays),
            };
            wires.push((To::Stay(i), source));
        }
        for (wire, &(to, source)) in wires.iter().enumerate() {
            match to {
                To::Operand(node, _) => self.of_node[node].push(wire),
                To::Stay(stay) => self.of_stay[stay].push(wire),
            }
            match source {
                From::Stay(stay) => self.of_stay[stay].push(wire),
                From::Node(node) => self.of_node[node].push(wire),
                From::Fixed(_) => {}
            }
        }
        self.wires = wires;
        for wire in 0..self.wires.len() {
            let place = self.place(wire);
            self.counts[place] += 1;
        }
    }

    fn lane(&self, node: usize) -> usize {
        let kind = self.graph.nodes[node].operation.kind() as usize;
        self.operators[..kind].iter().sum::<usize>() + self.issues[node].operator
    }

    /// Where a wire is counted.
    fn place(&self, wire: usize) -> usize {
        let lanes: usize = self.operators.iter().sum();
        let (to, from) = self.wires[wire];
        let to = match to {
            To::Operand(node, operand) => {
                2 * self.lane(node) + (operand ^ usize::from(self.issues[node].swapped))
            }
            To::Stay(stay) => 2 * lanes + self.stays[stay].register,
        };
        let from = match from {
            From::Stay(stay) => self.stays[stay].register,
            From::Node(node) => self.registers + self.lane(node),
            From::Fixed(number) => self.registers + lanes + number,
        };
        to * self.sources + from
    }

    /// Changes something about the items of these wires; keeps it where less sources meet.
    fn attempt(
        &mut self,
        wires: &[usize],
        change: impl Fn(&mut Self),
        revert: impl Fn(&mut Self),
    ) -> bool {
        let (mut removed, mut added) = (0, 0);
        for &wire in wires {
            let place = self.place(wire);
            self.counts[place] -= 1;
            removed += usize::from(self.counts[place] == 0);
        }
        change(self);
        for &wire in wires {
            let place = self.place(wire);
            added += usize::from(self.counts[place] == 0);
            self.counts[place] += 1;
        }
        if added < removed {
            return true;
        }
        for &wire in wires {
            let place = self.place(wire);
            self.counts[place] -= 1;
        }
        revert(self);
        for &wire in wires {
            let place = self.place(wire);
            self.counts[place] += 1;
        }
        false
    }

    fn both(a: &[usize], b: &[usize]) -> Vec<usize> {
        let mut wires: Vec<usize> = a.iter().chain(b).copied().collect();
        wires.sort_unstable();
        wires.dedup();
        wires
    }

    /// Operands change sides, operations of the same step change operators.
    fn change_operators(&mut self) -> usize {
        let mut changes = 0;
        for node in 0..self.issues.len() {
            let operation = self.graph.nodes[node].operation;
            let kind = operation.kind() as usize;
            let wires = Self::both(&self.of_node[node], &[]);
            if kind < 2 && operation != Operation::Select {
                let swap = |b: &mut Self| b.issues[node].swapped ^= true;
                changes += usize::from(self.attempt(&wires, swap, swap));
            }
            for operator in 0..self.operators[kind] {
                let before = self.issues[node].operator;
                if operator == before {
                    continue;
                }
                let step = self.issues[node].cycle % self.interval;
                let other = self.issues.iter().position(|issue| {
                    issue.operator == operator
                        && issue.cycle % self.interval == step
                        && self.graph.nodes[issue.node].operation.kind() as usize == kind
                });
                let wires = match other {
                    Some(other) => Self::both(&wires, &self.of_node[other]),
                    None => wires.clone(),
                };
                let set = |b: &mut Self, [own, others]: [usize; 2]| {
                    b.issues[node].operator = own;
                    if let Some(other) = other {
                        b.issues[other].operator = others;
                    }
                };
                let change = |b: &mut Self| set(b, [operator, before]);
                let revert = |b: &mut Self| set(b, [before, operator]);
                changes += usize::from(self.attempt(&wires, change, revert));
            }
        }
        changes
    }

    /// Whether two stays need a register in the same step of a lap.
    fn meet(&self, a: usize, b: usize) -> bool {
        let [a, b] = [a, b].map(|stay| self.stays[stay].cycles);
        (a[0]..=a[1]).any(|cycle| {
            let behind =
                (cycle % self.interval + self.interval - b[0] % self.interval) % self.interval;
            behind <= b[1] - b[0]
        })
    }

    /// Numbers change registers.
    fn change_registers(&mut self) -> usize {
        let mut changes = 0;
        for stay in 0..self.stays.len() {
            for register in 0..self.registers {
                let before = self.stays[stay].register;
                if register == before {
                    continue;
                }
                let in_the_way: Vec<usize> = (0..self.stays.len())
                    .filter(|&s| self.stays[s].register == register && self.meet(s, stay))
                    .collect();
                let other = match in_the_way[..] {
                    [] => None,
                    [other] => Some(other),
                    _ => continue,
                };
                if let Some(other) = other {
                    let blocked = |s: usize| {
                        s != stay && self.stays[s].register == before && self.meet(s, other)
                    };
                    if (0..self.stays.len()).any(blocked) {
                        continue;
                    }
                }
                let others: &[usize] = other.map_or(&[], |other| &self.of_stay[other]);
                let wires = Self::both(&self.of_stay[stay], others);
                let set = |b: &mut Self, [own, others]: [usize; 2]| {
                    b.stays[stay].register = own;
                    if let Some(other) = other {
                        b.stays[other].register = others;
                    }
                };
                let change = |b: &mut Self| set(b, [register, before]);
                let revert = |b: &mut Self| set(b, [before, register]);
                changes += usize::from(self.attempt(&wires, change, revert));
            }
        }
        changes
    }
}
