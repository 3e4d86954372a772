//! Made-up weights, and safetensors bytes of them, written by hand.

use std::collections::BTreeMap;

use super::twin::{ALEX, Layer, VGG};

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
                    Kind::F16 => body.extend(half::f16::from_f32(*v).to_le_bytes()),
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
