//! Weights from safetensors bytes.

use safetensors::tensor::{Dtype, SafeTensors, TensorView};

use super::Lpips;
use super::convolution::Filters;
use super::network::{ALEX, Network, VGG};

/// Shift and scale of version 0.1.
const SHIFT: [f32; 3] = [-0.030, -0.088, -0.188];
const SCALE: [f32; 3] = [0.458, 0.448, 0.450];
/// Tensors that an error names at most.
const NAMED: usize = 4;

/// Weights, or sizes of pictures, that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LpipsError {
    /// A file of PyTorch.
    #[error(
        "byte 0: this is a PyTorch file, which can hold programs and is not read; make a \
         safetensors file of it as docs/metrics.md shows"
    )]
    PyTorch,
    /// No safetensors, or damaged.
    #[error(
        "this is not a complete safetensors file ({why}); make it again as docs/metrics.md shows"
    )]
    Container {
        /// What the reader says.
        why: String,
    },
    /// Another network.
    #[error(
        "unknown network: neither `net.slice2.3.weight` (AlexNet) nor `net.slice1.2.weight` \
         (VGG16) is there, but {found}; docs/metrics.md shows how the file is made"
    )]
    Network {
        /// Names of some tensors.
        found: String,
    },
    /// A tensor is not there.
    #[error("tensor `{tensor}` of {network} is missing; save all tensors (docs/metrics.md)")]
    Missing {
        /// Its name.
        tensor: String,
        /// The network that needs it.
        network: &'static str,
    },
    /// A tensor of another shape.
    #[error(
        "tensor `{tensor}` has the shape {found:?}, {network} needs {expected:?}; save the \
         weights of version 0.1 (docs/metrics.md)"
    )]
    Shape {
        /// Its name.
        tensor: String,
        /// Its shape.
        found: Vec<usize>,
        /// The right one.
        expected: Vec<usize>,
        /// The network that needs it.
        network: &'static str,
    },
    /// Numbers of another type.
    #[error("tensor `{tensor}` holds {found}; save it as F32, F16 or BF16")]
    Type {
        /// Its name.
        tensor: String,
        /// Its type.
        found: String,
    },
    /// NaN, an infinity, or a scale of zero.
    #[error("tensor `{tensor}`, value {at}: {value} is not a weight; the file is damaged")]
    Value {
        /// Its name.
        tensor: String,
        /// The position of the value, from 0.
        at: usize,
        /// The value.
        value: f32,
    },
    /// Pictures of which nothing is left.
    #[error("{width} x {height} pixels: LPIPS ({network}) needs sides of {least} and more")]
    Small {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
        /// The smallest side, pixels.
        least: u32,
        /// The network.
        network: &'static str,
    },
    /// Pictures whose features take too much memory.
    #[error(
        "{width} x {height} pixels: LPIPS would take {gib} GiB of memory, at most {most} are \
         allowed; give smaller pictures, or weights of AlexNet"
    )]
    Large {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
        /// Memory, GiB.
        gib: u64,
        /// The most, GiB.
        most: u64,
    },
}

/// Reads all weights.
pub(crate) fn read(bytes: &[u8]) -> Result<Lpips, LpipsError> {
    // A zip archive or a pickle.
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(&[0x80, 2]) {
        return Err(LpipsError::PyTorch);
    }
    let container = |e: safetensors::SafeTensorError| LpipsError::Container { why: e.to_string() };
    let file = SafeTensors::deserialize(bytes).map_err(container)?;
    let network = network(&file)?;
    let reader = WeightReader { file: &file, network };
    let mut slices = Vec::new();
    let mut heads = Vec::new();
    for (i, slice) in network.slices.iter().enumerate() {
        let mut filters = Vec::new();
        for c in slice.convolutions {
            let (weight, bias) = (format!("net.{}.weight", c.name), format!("net.{}.bias", c.name));
            let weights = reader.values(&weight, &[c.outputs, c.inputs, c.side, c.side])?;
            filters.push(Filters::new(c, &weights, &reader.values(&bias, &[c.outputs])?));
        }
        slices.push(filters);
        heads.push(reader.values(&reader.head(i), &[1, slice.channels(), 1, 1])?);
    }
    let (shift, scale) = (reader.channels("shift", SHIFT)?, reader.channels("scale", SCALE)?);
    if let Some(at) = scale.iter().position(|s| *s == 0.0) {
        return Err(LpipsError::Value { tensor: "scaling_layer.scale".into(), at, value: 0.0 });
    }
    Ok(Lpips { network, slices, heads, shift, scale })
}

/// The network that the file has tensors of.
fn network(file: &SafeTensors<'_>) -> Result<&'static Network, LpipsError> {
    let has = |name| file.tensor(name).is_ok();
    if has("net.slice2.3.weight") {
        return Ok(&ALEX);
    }
    if has("net.slice1.2.weight") {
        return Ok(&VGG);
    }
    let mut names = file.names();
    names.sort_unstable();
    let short = |n: &&str| format!("`{}`", n.chars().take(60).collect::<String>());
    let some: Vec<String> = names.iter().take(NAMED).map(short).collect();
    let found = match names.len() {
        0 => "no tensor at all".into(),
        n if n > NAMED => format!("{} and {} more", some.join(", "), n - NAMED),
        _ => some.join(", "),
    };
    Err(LpipsError::Network { found })
}

struct WeightReader<'a> {
    file: &'a SafeTensors<'a>,
    network: &'static Network,
}

impl WeightReader<'_> {
    /// The name of a head: that of the package, or a shorter one if the file has it.
    fn head(&self, i: usize) -> String {
        let usual = format!("lin{i}.model.1.weight");
        let others = [
            format!("lin{i}.model.0.weight"),
            format!("lins.{i}.model.1.weight"),
            format!("lin{i}.weight"),
        ];
        let has = |name: &String| self.file.tensor(name).is_ok();
        if has(&usual) { usual } else { others.into_iter().find(has).unwrap_or(usual) }
    }

    /// Three numbers of the scaling layer, which need not be there.
    fn channels(&self, name: &str, fallback: [f32; 3]) -> Result<[f32; 3], LpipsError> {
        let name = format!("scaling_layer.{name}");
        if self.file.tensor(&name).is_err() {
            return Ok(fallback);
        }
        let values = self.values(&name, &[1, 3, 1, 1])?;
        Ok([values[0], values[1], values[2]])
    }

    fn values(&self, tensor: &str, expected: &[usize]) -> Result<Vec<f32>, LpipsError> {
        let network = self.network.title;
        let missing = |_| LpipsError::Missing { tensor: tensor.into(), network };
        let view = self.file.tensor(tensor).map_err(missing)?;
        if view.shape() != expected {
            let (found, expected) = (view.shape().to_vec(), expected.to_vec());
            return Err(LpipsError::Shape { tensor: tensor.into(), found, expected, network });
        }
        let values = decoded(&view).ok_or_else(|| LpipsError::Type {
            tensor: tensor.into(),
            found: format!("{:?}", view.dtype()),
        })?;
        match values.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(LpipsError::Value { tensor: tensor.into(), at, value: values[at] }),
            None => Ok(values),
        }
    }
}

/// Little-endian numbers as `f32`; `None` for other types.
fn decoded(view: &TensorView<'_>) -> Option<Vec<f32>> {
    let data = view.data();
    let pairs = || data.as_chunks::<2>().0.iter();
    Some(match view.dtype() {
        Dtype::F32 => data.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
        Dtype::F16 => pairs().map(|b| half(u16::from_le_bytes(*b))).collect(),
        Dtype::BF16 => {
            pairs().map(|b| f32::from_bits(u32::from(u16::from_le_bytes(*b)) << 16)).collect()
        }
        _ => return None,
    })
}

/// A half-precision number (IEEE 754 binary16).
fn half(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    let (exponent, fraction) = (u32::from(bits >> 10 & 0x1f), u32::from(bits & 0x3ff));
    let magnitude = match exponent {
        // Multiples of 2^-24, which `f32` holds exactly.
        0 => fraction as f32 / 16_777_216.0,
        0x1f => f32::from_bits(0x7f80_0000 | fraction << 13),
        _ => f32::from_bits((exponent + 112) << 23 | fraction << 13),
    };
    f32::from_bits(magnitude.to_bits() | sign)
}
