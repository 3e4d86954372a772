//! Data-flow graphs of floating-point operations, and what they compute.

use super::special;
use crate::{Arithmetic, WideFormat};

/// What an operation does with its operands a, b and c.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// a b.
    Multiply,
    /// a + b.
    Add,
    /// The lesser of a and b; NaN where one is. -0 is less than +0.
    Minimum,
    /// The greater of a and b; NaN where one is.
    Maximum,
    /// b where the sign bit of c is set, else a.
    Select,
    /// 1 / a, off by 1.3 ulp at most in 15 bits of mantissa.
    Reciprocal,
    /// 1 / sqrt(a), off by 1.3 ulp at most in 15 bits of mantissa.
    ReciprocalRoot,
}

/// The operators that are there in numbers of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Multipliers.
    Multiply,
    /// Adders, which also compare and select.
    Add,
    /// Reciprocals and reciprocal roots.
    Special,
}

/// Kinds, in the order in which their operators are numbered.
pub const KINDS: [Kind; 3] = [Kind::Multiply, Kind::Add, Kind::Special];

impl Operation {
    /// The operators that do it.
    pub fn kind(self) -> Kind {
        match self {
            Operation::Multiply => Kind::Multiply,
            Operation::Add | Operation::Minimum | Operation::Maximum | Operation::Select => {
                Kind::Add
            }
            Operation::Reciprocal | Operation::ReciprocalRoot => Kind::Special,
        }
    }

    /// Its number among those of its kind.
    pub fn code(self) -> u64 {
        match self {
            Operation::Multiply | Operation::Add | Operation::Reciprocal => 0,
            Operation::Minimum | Operation::ReciprocalRoot => 1,
            Operation::Maximum => 2,
            Operation::Select => 3,
        }
    }
}

/// Where a number comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// An input that comes with the work.
    Input(usize),
    /// An input that comes later.
    Late(usize),
    /// A setting, the same for all work.
    Setting(usize),
    /// A constant.
    Literal(usize),
    /// The result of an operation.
    Node(usize),
}

/// A number with its sign as it is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand {
    /// The number.
    pub value: Value,
    /// Its sign bit is cleared first.
    pub absolute: bool,
    /// Then its sign bit is inverted.
    pub negate: bool,
}

impl Operand {
    /// Without its sign.
    pub fn abs(self) -> Operand {
        Operand { absolute: true, negate: false, ..self }
    }
}

impl std::ops::Neg for Operand {
    type Output = Operand;

    fn neg(self) -> Operand {
        Operand { negate: !self.negate, ..self }
    }
}

/// One operation. Operands that it does not have are those that it has.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// What is done.
    pub operation: Operation,
    /// Operands a and b.
    pub operands: [Operand; 2],
    /// c, of which the sign is looked at.
    pub sign: Value,
}

/// A graph; nodes are in an order in which they can be computed.
#[derive(Debug, Clone)]
pub struct Graph {
    /// Its name.
    pub name: &'static str,
    /// Numbers that come with the work, later, and once for all.
    pub inputs: [usize; 3],
    /// Constants.
    pub literals: Vec<f32>,
    /// Operations.
    pub nodes: Vec<Node>,
    /// What leaves.
    pub outputs: Vec<Value>,
}

impl Graph {
    /// An empty graph with so many inputs, late inputs and settings.
    pub fn new(name: &'static str, inputs: [usize; 3]) -> Graph {
        Graph { name, inputs, literals: Vec::new(), nodes: Vec::new(), outputs: Vec::new() }
    }

    fn plain(value: Value) -> Operand {
        Operand { value, absolute: false, negate: false }
    }

    /// Input `index`.
    pub fn input(&self, index: usize) -> Operand {
        assert!(index < self.inputs[0], "an input");
        Graph::plain(Value::Input(index))
    }

    /// Late input `index`.
    pub fn late(&self, index: usize) -> Operand {
        assert!(index < self.inputs[1], "a late input");
        Graph::plain(Value::Late(index))
    }

    /// Setting `index`.
    pub fn setting(&self, index: usize) -> Operand {
        assert!(index < self.inputs[2], "a setting");
        Graph::plain(Value::Setting(index))
    }

    /// A constant.
    pub fn literal(&mut self, value: f32) -> Operand {
        let known = self.literals.iter().position(|known| known.to_bits() == value.to_bits());
        let index = known.unwrap_or_else(|| {
            self.literals.push(value);
            self.literals.len() - 1
        });
        Graph::plain(Value::Literal(index))
    }

    fn node(&mut self, operation: Operation, a: Operand, b: Operand, sign: Value) -> Operand {
        self.nodes.push(Node { operation, operands: [a, b], sign });
        Graph::plain(Value::Node(self.nodes.len() - 1))
    }

    /// a b.
    pub fn mul(&mut self, a: Operand, b: Operand) -> Operand {
        self.node(Operation::Multiply, a, b, a.value)
    }

    /// a + b.
    pub fn add(&mut self, a: Operand, b: Operand) -> Operand {
        self.node(Operation::Add, a, b, a.value)
    }

    /// a - b.
    pub fn sub(&mut self, a: Operand, b: Operand) -> Operand {
        self.node(Operation::Add, a, -b, a.value)
    }

    /// The lesser one.
    pub fn min(&mut self, a: Operand, b: Operand) -> Operand {
        self.node(Operation::Minimum, a, b, a.value)
    }

    /// The greater one.
    pub fn max(&mut self, a: Operand, b: Operand) -> Operand {
        self.node(Operation::Maximum, a, b, a.value)
    }

    /// `negative` where the sign bit of `of` is set, else `positive`.
    pub fn select(&mut self, of: Operand, positive: Operand, negative: Operand) -> Operand {
        self.node(Operation::Select, positive, negative, of.value)
    }

    /// 1 / a.
    pub fn reciprocal(&mut self, a: Operand) -> Operand {
        self.node(Operation::Reciprocal, a, a, a.value)
    }

    /// 1 / sqrt(a).
    pub fn reciprocal_root(&mut self, a: Operand) -> Operand {
        self.node(Operation::ReciprocalRoot, a, a, a.value)
    }

    /// Σ a b.
    pub fn dot(&mut self, a: [Operand; 3], b: [Operand; 3]) -> Operand {
        let [x, y, z] = [0, 1, 2].map(|i| self.mul(a[i], b[i]));
        let xy = self.add(x, y);
        self.add(xy, z)
    }

    /// What leaves next.
    pub fn output(&mut self, operand: Operand) {
        assert!(!operand.absolute && !operand.negate, "outputs leave as they are");
        self.outputs.push(operand.value);
    }

    /// Operations of a kind.
    pub fn count(&self, kind: Kind) -> usize {
        self.nodes.iter().filter(|node| node.operation.kind() == kind).count()
    }

    /// The outputs, of inputs, late inputs and settings.
    pub fn run(&self, format: WideFormat, numbers: [&[u32]; 3]) -> Vec<u32> {
        let literals: Vec<u32> = self.literals.iter().map(|&l| format.from_f32(l)).collect();
        let mut results: Vec<u32> = Vec::with_capacity(self.nodes.len());
        let of = |value: Value, results: &[u32]| match value {
            Value::Input(i) => numbers[0][i],
            Value::Late(i) => numbers[1][i],
            Value::Setting(i) => numbers[2][i],
            Value::Literal(i) => literals[i],
            Value::Node(i) => results[i],
        };
        for node in &self.nodes {
            let [a, b] = node.operands.map(|operand| {
                let raw = of(operand.value, &results);
                let kept = if operand.absolute { raw & !format.sign() } else { raw };
                if operand.negate { kept ^ format.sign() } else { kept }
            });
            let negative = of(node.sign, &results) & format.sign() != 0;
            results.push(match node.operation {
                Operation::Multiply => format.multiply(a, b),
                Operation::Add => format.add(a, b),
                Operation::Minimum => extreme(format, a, b, false),
                Operation::Maximum => extreme(format, a, b, true),
                Operation::Select if negative => b,
                Operation::Select => a,
                Operation::Reciprocal => special::reciprocal(format, a),
                Operation::ReciprocalRoot => special::reciprocal_root(format, a),
            });
        }
        self.outputs.iter().map(|&value| of(value, &results)).collect()
    }
}

/// The greater or the lesser of two numbers, NaN where one is; -0 is less than +0.
fn extreme(format: WideFormat, a: u32, b: u32, greater: bool) -> u32 {
    if format.is_nan(a) || format.is_nan(b) {
        return format.nan();
    }
    let place = |number: u32| match number & format.sign() {
        0 => i64::from(number),
        _ => -1 - i64::from(number & !format.sign()),
    };
    if (place(a) < place(b)) == greater { b } else { a }
}
