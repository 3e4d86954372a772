//! Made-up weights, and safetensors bytes of them, written by hand.

use std::collections::BTreeMap;

/// A convolution with ReLU, and what surrounds it.
pub struct Layer {
    pub name: &'static str,
    pub inputs: usize,
    pub outputs: usize,
    pub side: usize,
    pub stride: usize,
    pub pad: usize,
    /// Side of the pool before it, or 0; its stride is 2.
    pub pool: usize,
    /// Whether its output is compared.
    pub is_compared: bool,
}

const fn layer(
    name: &'static str,
    channels: (usize, usize),
    shape: (usize, usize, usize),
    pool: usize,
    is_compared: bool,
) -> Layer {
    let (inputs, outputs) = channels;
    let (side, stride, pad) = shape;
    Layer { name, inputs, outputs, side, stride, pad, pool, is_compared }
}

pub const ALEX: [Layer; 5] = [
    layer("slice1.0", (3, 64), (11, 4, 2), 0, true),
    layer("slice2.3", (64, 192), (5, 1, 2), 3, true),
    layer("slice3.6", (192, 384), (3, 1, 1), 3, true),
    layer("slice4.8", (384, 256), (3, 1, 1), 0, true),
    layer("slice5.10", (256, 256), (3, 1, 1), 0, true),
];

const SQUARE: (usize, usize, usize) = (3, 1, 1);

pub const VGG: [Layer; 13] = [
    layer("slice1.0", (3, 64), SQUARE, 0, false),
    layer("slice1.2", (64, 64), SQUARE, 0, true),
    layer("slice2.5", (64, 128), SQUARE, 2, false),
    layer("slice2.7", (128, 128), SQUARE, 0, true),
    layer("slice3.10", (128, 256), SQUARE, 2, false),
    layer("slice3.12", (256, 256), SQUARE, 0, false),
    layer("slice3.14", (256, 256), SQUARE, 0, true),
    layer("slice4.17", (256, 512), SQUARE, 2, false),
    layer("slice4.19", (512, 512), SQUARE, 0, false),
    layer("slice4.21", (512, 512), SQUARE, 0, true),
    layer("slice5.24", (512, 512), SQUARE, 2, false),
    layer("slice5.26", (512, 512), SQUARE, 0, false),
    layer("slice5.28", (512, 512), SQUARE, 0, true),
];

/// How numbers are stored.
#[derive(Clone, Copy)]
pub enum Kind {
    F32,
    F16,
    Bf16,
    /// Not readable as weights.
    I32,
}

/// Tensors by name: shape and values.
#[derive(Clone, Default)]
pub struct Made {
    pub tensors: BTreeMap<String, (Vec<usize>, Vec<f32>)>,
}

/// Numbers from -1 to 1, the same everywhere.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }
}

impl Made {
    pub fn alex(seed: u64) -> Made {
        Made::of(&ALEX, seed)
    }

    pub fn vgg(seed: u64) -> Made {
        Made::of(&VGG, seed)
    }

    /// Weights of such a size that features neither fade nor grow; heads as they are trained: not
    /// negative.
    fn of(layers: &[Layer], seed: u64) -> Made {
        let (mut made, mut dice) = (Made::default(), Dice(seed));
        let mut head = 0;
        for l in layers {
            let terms = l.inputs * l.side * l.side;
            let size = (6.0 / terms as f32).sqrt();
            let weights = (0..l.outputs * terms).map(|_| size * dice.roll()).collect();
            let shape = [l.outputs, l.inputs, l.side, l.side];
            made.add(&format!("net.{}.weight", l.name), &shape, weights);
            let bias = (0..l.outputs).map(|_| 0.1 * dice.roll()).collect();
            made.add(&format!("net.{}.bias", l.name), &[l.outputs], bias);
            if l.is_compared {
                let weights = (0..l.outputs).map(|_| dice.roll().abs()).collect();
                made.add(&format!("lin{head}.model.1.weight"), &[1, l.outputs, 1, 1], weights);
                head += 1;
            }
        }
        made
    }

    pub fn rounded_to_bf16(mut self) -> Made {
        for v in self.tensors.values_mut().flat_map(|t| &mut t.1) {
            *v = f32::from_bits(v.to_bits() & 0xffff_0000);
        }
        self
    }

    pub fn values(&self, name: &str) -> &[f32] {
        &self.tensors[name].1
    }

    pub fn add(&mut self, name: &str, shape: &[usize], values: Vec<f32>) {
        self.tensors.insert(name.into(), (shape.to_vec(), values));
    }

    pub fn remove(&mut self, name: &str) {
        self.tensors.remove(name).unwrap();
    }

    pub fn rename(&mut self, from: &str, to: &str) {
        let tensor = self.tensors.remove(from).unwrap();
        self.tensors.insert(to.into(), tensor);
    }

    /// All values in one row.
    pub fn reshape(&mut self, name: &str) {
        let (shape, values) = self.tensors.get_mut(name).unwrap();
        *shape = vec![1, values.len()];
    }

    pub fn set(&mut self, name: &str, at: usize, value: f32) {
        self.tensors.get_mut(name).unwrap().1[at] = value;
    }

    pub fn each(&mut self, name: &str, to: impl Fn(f32) -> f32) {
        self.tensors.get_mut(name).unwrap().1.iter_mut().for_each(|v| *v = to(*v));
    }

    pub fn bytes(&self, kind: Kind) -> Vec<u8> {
        let (mut head, mut body) = (Vec::new(), Vec::new());
        for (name, (shape, values)) in &self.tensors {
            let begin = body.len();
            for v in values {
                match kind {
                    Kind::F32 => body.extend(v.to_le_bytes()),
                    Kind::F16 => body.extend(half(*v).to_le_bytes()),
                    Kind::Bf16 => body.extend(&v.to_le_bytes()[2..]),
                    Kind::I32 => body.extend((*v as i32).to_le_bytes()),
                }
            }
            let word = match kind {
                Kind::F32 => "F32",
                Kind::F16 => "F16",
                Kind::Bf16 => "BF16",
                Kind::I32 => "I32",
            };
            let end = body.len();
            head.push(format!(
                r#""{name}":{{"dtype":"{word}","shape":{shape:?},"data_offsets":[{begin},{end}]}}"#
            ));
        }
        let head = format!("{{{}}}", head.join(","));
        [&(head.len() as u64).to_le_bytes()[..], head.as_bytes(), &body].concat()
    }
}

/// The half-precision number (IEEE 754 binary16) nearest to a weight, the even one of two.
fn half(value: f32) -> u16 {
    let sign = (value.to_bits() >> 16) as u16 & 0x8000;
    let size = value.abs();
    assert!(size < 65_504.0, "weights are small");
    // Steps of 2^-24 below 2^-14, else of a 1024th of the power of two below.
    let power = (size.log2().floor() as i32).max(-14);
    let steps = (size / 2f32.powi(power - 10)).round_ties_even() as u16;
    sign + steps + if steps < 1024 { 0 } else { ((power + 14) as u16) << 10 }
}
