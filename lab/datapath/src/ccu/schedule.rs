//! Folds a graph over a few operators.
//!
//! A schedule repeats every `interval` cycles: work may enter at the beginning of each lap, and an
//! operation that is issued in cycle t behind that occupies its operator in cycle t modulo the
//! interval of every lap. Results are in a register [`LATENCY`] cycles behind the issue; one that
//! lives for longer than a lap moves on to another register, because the next work's is coming.

use super::binding::improve;
use super::graph::{Graph, KINDS, Value};

/// Cycles from the issue of an operation to the first one in which its result can be read.
pub const LATENCY: usize = 3;
/// Laps that are tried before an interval is given up.
const LATE_LAPS: usize = 6;
/// Times that operations are looked at again for a place that saves registers.
const PASSES: usize = 6;

/// Operators of each kind.
pub type Operators = [usize; 3];

/// An operation on an operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Issue {
    /// The operation.
    pub node: usize,
    /// The operator, among those of its kind.
    pub operator: usize,
    /// Cycle behind the entry of its work.
    pub cycle: usize,
    /// Whether a and b change sides.
    pub swapped: bool,
}

/// A number in a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stay {
    /// What is kept.
    pub value: Value,
    /// The register.
    pub register: usize,
    /// First and last cycle in which it can be read.
    pub cycles: [usize; 2],
    /// Whether it comes from the register in which it was before, or from the input.
    pub moves: bool,
}

/// A graph in time.
#[derive(Debug, Clone)]
pub struct Schedule {
    /// Cycles of a lap.
    pub interval: usize,
    /// Cycle in which the outputs can be read: the latency.
    pub leaves: usize,
    /// The lap in which late inputs are there.
    pub late_lap: usize,
    /// Operations by node.
    pub issues: Vec<Issue>,
    /// Numbers in registers.
    pub stays: Vec<Stay>,
    /// Registers.
    pub registers: usize,
}

impl Schedule {
    /// The schedule of `graph` with the shortest interval, of at least `least` cycles.
    pub fn new(graph: &Graph, operators: Operators, least: usize) -> Schedule {
        let needed =
            KINDS.iter().zip(operators).map(|(&kind, n)| graph.count(kind).div_ceil(n.max(1)));
        let mut interval = needed.max().unwrap_or(1).max(least);
        loop {
            for late_lap in 0..LATE_LAPS {
                if let Some(cycles) = place(graph, operators, interval, late_lap) {
                    return finish(graph, operators, interval, late_lap, cycles);
                }
                if graph.inputs[1] == 0 {
                    break;
                }
            }
            interval += 1;
        }
    }

    /// Where a value is in cycle `cycle`: its stay, or `None` where it is no register.
    pub fn stay(&self, value: Value, cycle: usize) -> Option<&Stay> {
        let there = |stay: &&Stay| {
            stay.value == value && (stay.cycles[0]..=stay.cycles[1]).contains(&cycle)
        };
        self.stays.iter().find(there)
    }
}

/// What a node reads.
fn reads(graph: &Graph, node: usize) -> [Value; 3] {
    let node = &graph.nodes[node];
    [node.operands[0].value, node.operands[1].value, node.sign]
}

/// Consumers of every node.
fn consumers(graph: &Graph) -> Vec<Vec<usize>> {
    let mut consumers = vec![Vec::new(); graph.nodes.len()];
    for node in 0..graph.nodes.len() {
        for value in reads(graph, node) {
            if let Value::Node(of) = value
                && consumers[of].last() != Some(&node)
            {
                consumers[of].push(node);
            }
        }
    }
    consumers
}

/// Operators in use in the cycles of a lap.
struct Occupied {
    interval: usize,
    operators: Operators,
    used: Vec<[usize; 3]>,
}

impl Occupied {
    fn is_free(&self, graph: &Graph, node: usize, cycle: usize) -> bool {
        let kind = graph.nodes[node].operation.kind() as usize;
        self.used[cycle % self.interval][kind] < self.operators[kind]
    }

    fn change(&mut self, graph: &Graph, node: usize, cycle: usize, taken: bool) {
        let used = &mut self.used[cycle % self.interval];
        let used = &mut used[graph.nodes[node].operation.kind() as usize];
        *used = if taken { *used + 1 } else { *used - 1 };
    }
}

/// Cycles of all operations; `None` where late inputs do not fit into their lap.
fn place(
    graph: &Graph,
    operators: Operators,
    interval: usize,
    late_lap: usize,
) -> Option<Vec<usize>> {
    let consumers = consumers(graph);
    let count = graph.nodes.len();
    // Longest ways to the end decide who comes first.
    let mut height = vec![LATENCY; count];
    for node in (0..count).rev() {
        let behind = consumers[node].iter().map(|&c| height[c] + LATENCY).max();
        height[node] = behind.unwrap_or(LATENCY);
    }
    let is_late = |node: usize| reads(graph, node).iter().any(|v| matches!(v, Value::Late(_)));
    let window = [late_lap * interval, (late_lap + 1) * interval];
    let mut occupied = Occupied { interval, operators, used: vec![[0; 3]; interval] };
    let mut cycles = vec![usize::MAX; count];
    let earliest = |node: usize, cycles: &[usize]| {
        let ready = reads(graph, node).map(|value| match value {
            Value::Node(of) => cycles[of].saturating_add(LATENCY),
            Value::Late(_) => window[0],
            Value::Input(_) | Value::Setting(_) | Value::Literal(_) => 0,
        });
        ready.into_iter().max().unwrap_or(0)
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&node| (std::cmp::Reverse(height[node]), node));
    let (mut left, mut cycle) = (count, 0);
    while left > 0 {
        for &node in &order {
            let waits = cycles[node] == usize::MAX && earliest(node, &cycles) <= cycle;
            if waits && occupied.is_free(graph, node, cycle) {
                cycles[node] = cycle;
                occupied.change(graph, node, cycle, true);
                left -= 1;
            }
        }
        cycle += 1;
        if cycle > 64 * (count + interval) {
            return None;
        }
    }
    let fits = |node: usize| !is_late(node) || cycles[node] < window[1];
    if !(0..count).all(fits) {
        return None;
    }
    save(graph, &consumers, &mut occupied, &mut cycles, window);
    Some(cycles)
}

/// Moves operations to where fewer numbers are kept for long.
fn save(
    graph: &Graph,
    consumers: &[Vec<usize>],
    occupied: &mut Occupied,
    cycles: &mut [usize],
    window: [usize; 2],
) {
    let end = cycles.iter().max().map_or(0, |last| last + LATENCY);
    for pass in 0..PASSES {
        for step in 0..cycles.len() {
            let node = if pass % 2 == 0 { cycles.len() - 1 - step } else { step };
            let late = reads(graph, node).iter().any(|v| matches!(v, Value::Late(_)));
            let mut first = if late { window[0] } else { 0 };
            for value in reads(graph, node) {
                if let Value::Node(of) = value {
                    first = first.max(cycles[of] + LATENCY);
                }
            }
            let behind = consumers[node].iter().map(|&c| cycles[c]).min();
            let is_output = graph.outputs.contains(&Value::Node(node));
            let mut last = behind.unwrap_or(end).min(end) - LATENCY;
            if late {
                last = last.min(window[1] - 1);
            }
            occupied.change(graph, node, cycles[node], false);
            let before = cycles[node];
            let mut best = (usize::MAX, before);
            for cycle in first..=last {
                if !occupied.is_free(graph, node, cycle) {
                    continue;
                }
                cycles[node] = cycle;
                let cost = kept(graph, consumers, cycles, node, is_output, end);
                if (cost, cycle != before) < (best.0, best.1 != before) {
                    best = (cost, cycle);
                }
            }
            cycles[node] = best.1;
            occupied.change(graph, node, best.1, true);
        }
    }
}

/// Cycles for which the operands and the result of a node are kept.
fn kept(
    graph: &Graph,
    consumers: &[Vec<usize>],
    cycles: &[usize],
    node: usize,
    is_output: bool,
    end: usize,
) -> usize {
    let last_of = |of: usize, outputs: bool| {
        let read = consumers[of].iter().map(|&c| cycles[c]).max().unwrap_or(0);
        if outputs { end } else { read }
    };
    let mut cost = last_of(node, is_output) - cycles[node];
    let mut seen = Vec::new();
    for value in reads(graph, node) {
        if let Value::Node(of) = value
            && !seen.contains(&of)
        {
            seen.push(of);
            let outputs = graph.outputs.contains(&value);
            cost += last_of(of, outputs) - cycles[of];
        }
        if let Value::Input(_) = value {
            // What is read in the first lap needs no register.
            cost += cycles[node].saturating_sub(end / 8);
        }
    }
    cost
}

fn finish(
    graph: &Graph,
    operators: Operators,
    interval: usize,
    late_lap: usize,
    cycles: Vec<usize>,
) -> Schedule {
    // Operators: in the order of nodes, the first one that is free.
    let mut taken = vec![[0usize; 3]; interval];
    let mut issues = Vec::new();
    for (node, &cycle) in cycles.iter().enumerate() {
        let kind = graph.nodes[node].operation.kind() as usize;
        let operator = taken[cycle % interval][kind];
        assert!(operator < operators[kind], "an operator is free");
        taken[cycle % interval][kind] += 1;
        issues.push(Issue { node, operator, cycle, swapped: false });
    }
    let ready = |value: &Value| match *value {
        Value::Node(of) => cycles[of] + LATENCY,
        Value::Input(_) | Value::Late(_) | Value::Setting(_) | Value::Literal(_) => 0,
    };
    let leaves = graph.outputs.iter().map(ready).max().unwrap_or(0);
    let mut last_read: Vec<(Value, usize)> = Vec::new();
    let mut note = |value: Value, cycle: usize| {
        if matches!(value, Value::Node(_) | Value::Input(_)) {
            match last_read.iter_mut().find(|(known, _)| *known == value) {
                Some((_, last)) => *last = (*last).max(cycle),
                None => last_read.push((value, cycle)),
            }
        }
    };
    for (node, &cycle) in cycles.iter().enumerate() {
        reads(graph, node).into_iter().for_each(|value| note(value, cycle));
    }
    graph.outputs.iter().for_each(|&value| note(value, leaves));
    let mut stays = Vec::new();
    for &(value, last) in &last_read {
        let is_input = matches!(value, Value::Input(_));
        let mut from = if is_input { interval } else { ready(&value) };
        let mut moves = is_input;
        while from <= last {
            let to = last.min(from + interval - 1);
            stays.push(Stay { value, register: 0, cycles: [from, to], moves });
            from = to + 1;
            moves = true;
        }
    }
    let registers = assign(&mut stays, interval);
    improve(graph, operators, interval, registers, &mut issues, &mut stays);
    Schedule { interval, leaves, late_lap, issues, stays, registers }
}

/// Registers: the longest stays first, each in the first register that is free.
fn assign(stays: &mut [Stay], interval: usize) -> usize {
    let mut order: Vec<usize> = (0..stays.len()).collect();
    order.sort_by_key(|&i| {
        let [from, to] = stays[i].cycles;
        (std::cmp::Reverse(to - from), from % interval, from)
    });
    let mut registers: Vec<Vec<bool>> = Vec::new();
    for i in order {
        let [from, to] = stays[i].cycles;
        let free = |used: &Vec<bool>| (from..=to).all(|cycle| !used[cycle % interval]);
        let register = registers.iter().position(free).unwrap_or_else(|| {
            registers.push(vec![false; interval]);
            registers.len() - 1
        });
        (from..=to).for_each(|cycle| registers[register][cycle % interval] = true);
        stays[i].register = register;
    }
    registers.len()
}
