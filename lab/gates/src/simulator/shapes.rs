//! Functions that are compiled in. A cell whose function is one of them, with its inputs in any
//! order, runs as straight code; all others are evaluated step by step.

use crate::function::Function;

/// Inputs of the largest shape.
const MAX_INPUTS: usize = 6;

/// Stores the value of a net and counts what changes.
#[inline(always)]
pub fn store(net: u32, value: u64, values: &mut [u64], toggles: &mut [u64]) {
    let net = net as usize;
    toggles[net] += u64::from((values[net] ^ value).count_ones());
    values[net] = value;
}

#[inline(always)]
fn all<const N: usize, const M: usize>(
    nets: &[u32],
    values: &mut [u64],
    toggles: &mut [u64],
    of: impl Fn([u64; N]) -> u64,
) {
    for gate in nets.as_chunks::<M>().0 {
        let mut inputs = [0; N];
        for (input, net) in inputs.iter_mut().zip(gate) {
            *input = values[*net as usize];
        }
        store(gate[N], of(inputs), values, toggles);
    }
}

macro_rules! shapes {
    ($($number:literal $count:literal $with_output:literal [$($input:ident)*] $value:expr;)*) => {
        /// Number of inputs of each shape.
        const INPUTS: &[usize] = &[$($count),*];

        /// The value of a shape.
        fn value(shape: usize, inputs: &[u64; MAX_INPUTS]) -> u64 {
            match shape {
                $($number => {
                    let [$($input),*] = *inputs.first_chunk::<$count>().expect("six inputs");
                    $value
                })*
                _ => unreachable!("there is no shape {shape}"),
            }
        }

        /// Runs a list of gates of one shape: inputs in its order, then the output, of each.
        #[inline(always)]
        pub fn run(shape: usize, nets: &[u32], values: &mut [u64], toggles: &mut [u64]) {
            match shape {
                $($number => all::<$count, $with_output>(
                    nets, values, toggles, #[inline(always)] |[$($input),*]| $value,
                ),)*
                _ => unreachable!("there is no shape {shape}"),
            }
        }
    };
}

shapes! {
    0 1 2 [a] a;
    1 1 2 [a] !a;
    2 2 3 [a b] a & b;
    3 2 3 [a b] a | b;
    4 2 3 [a b] !(a & b);
    5 2 3 [a b] !(a | b);
    6 2 3 [a b] a ^ b;
    7 2 3 [a b] !(a ^ b);
    8 3 4 [a b c] a & b & c;
    9 3 4 [a b c] a | b | c;
    10 3 4 [a b c] !(a & b & c);
    11 3 4 [a b c] !(a | b | c);
    12 3 4 [a b c] (a & b) | c;
    13 3 4 [a b c] (a | b) & c;
    14 3 4 [a b c] !((a & b) | c);
    15 3 4 [a b c] !((a | b) & c);
    16 3 4 [s a b] (s & b) | (!s & a);
    17 3 4 [a b c] (a & b) | (a & c) | (b & c);
    18 3 4 [a b c] !((a & b) | (a & c) | (b & c));
    19 4 5 [a b c d] a & b & c & d;
    20 4 5 [a b c d] a | b | c | d;
    21 4 5 [a b c d] !(a & b & c & d);
    22 4 5 [a b c d] !(a | b | c | d);
    23 4 5 [a b c d] !((a & b) | (c & d));
    24 4 5 [a b c d] !((a | b) & (c | d));
    25 4 5 [a b c d] (a & b) | (c & d);
    26 4 5 [a b c d] (a | b) & (c | d);
    27 4 5 [a b c d] !((a & b) | c | d);
    28 4 5 [a b c d] !((a | b) & c & d);
    29 4 5 [a b c d] (a & b) | c | d;
    30 4 5 [a b c d] (a | b) & c & d;
    31 4 5 [a b c d] !((a & b & c) | d);
    32 4 5 [a b c d] !((a | b | c) & d);
    33 4 5 [a b c d] !(((a & b) | c) & d);
    34 4 5 [a b c d] !(((a | b) & c) | d);
    35 4 5 [a b c d] (a & b & c) | d;
    36 4 5 [a b c d] (a | b | c) & d;
    37 5 6 [a b c d e] !((a & b) | (c & d) | e);
    38 5 6 [a b c d e] !((a | b) & (c | d) & e);
    39 5 6 [a b c d e] (a & b) | (c & d) | e;
    40 5 6 [a b c d e] (a | b) & (c | d) & e;
    41 6 7 [a b c d e f] !((a & b) | (c & d) | (e & f));
    42 6 7 [a b c d e f] !((a | b) & (c | d) & (e | f));
    43 5 6 [a b c d e] a & b & c & d & e;
    44 5 6 [a b c d e] a | b | c | d | e;
}

/// Columns of a truth table of six inputs.
const COLUMNS: [u64; MAX_INPUTS] = [
    0xaaaa_aaaa_aaaa_aaaa,
    0xcccc_cccc_cccc_cccc,
    0xf0f0_f0f0_f0f0_f0f0,
    0xff00_ff00_ff00_ff00,
    0xffff_0000_ffff_0000,
    0xffff_ffff_0000_0000,
];

/// The shape of `function`, and which of its inputs stands where in the shape.
pub fn find(function: &Function, inputs: usize) -> Option<(usize, Vec<usize>)> {
    if inputs == 0 || inputs > MAX_INPUTS {
        return None;
    }
    let table = function.evaluate(|input| COLUMNS[input]);
    let orders = orders(inputs);
    let shapes = (0..INPUTS.len()).filter(|shape| INPUTS[*shape] == inputs);
    for shape in shapes {
        let fits = |order: &&Vec<usize>| {
            let mut columns = [0; MAX_INPUTS];
            order.iter().zip(&mut columns).for_each(|(input, column)| *column = COLUMNS[*input]);
            value(shape, &columns) == table
        };
        if let Some(order) = orders.iter().find(fits) {
            return Some((shape, order.clone()));
        }
    }
    None
}

/// All orders of `count` inputs.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let mut orders = vec![Vec::new()];
    for _ in 0..count {
        let longer = |order: &Vec<usize>| {
            let free = (0..count).filter(|input| !order.contains(input));
            free.map(|input| order.iter().copied().chain([input]).collect()).collect::<Vec<_>>()
        };
        orders = orders.iter().flat_map(longer).collect();
    }
    orders
}
