//! The two networks as tables.

/// A convolution with ReLU.
#[derive(Debug)]
pub(crate) struct Convolution {
    /// What its tensors are called: `net.NAME.weight`, `net.NAME.bias`.
    pub name: &'static str,
    /// Channels of its input.
    pub inputs: usize,
    /// Channels of its output, a multiple of 16.
    pub outputs: usize,
    /// Side of the kernel, pixels.
    pub side: usize,
    /// Pixels between places.
    pub stride: usize,
    /// Zeros around the input, pixels.
    pub pad: usize,
}

/// A maximum over squares.
#[derive(Debug, Clone, Copy)]
pub struct Pool {
    /// Side of a square, pixels.
    pub side: usize,
    /// Pixels between squares.
    pub stride: usize,
}

/// The part of a network whose output is compared.
#[derive(Debug)]
pub struct Slice {
    /// The pool in front, if any.
    pub pool: Option<Pool>,
    /// The convolutions after it.
    pub convolutions: &'static [Convolution],
}

/// A network.
#[derive(Debug)]
pub(crate) struct Network {
    /// As the package of Python calls it.
    pub name: &'static str,
    /// The name for people.
    pub title: &'static str,
    /// Its parts.
    pub slices: &'static [Slice],
}

/// 3 x 3, as wide as its input.
const fn plain(name: &'static str, inputs: usize, outputs: usize) -> Convolution {
    Convolution { name, inputs, outputs, side: 3, stride: 1, pad: 1 }
}

const FIRST: Convolution =
    Convolution { name: "slice1.0", inputs: 3, outputs: 64, side: 11, stride: 4, pad: 2 };
const SECOND: Convolution =
    Convolution { name: "slice2.3", inputs: 64, outputs: 192, side: 5, stride: 1, pad: 2 };

const OVERLAPPING: Option<Pool> = Some(Pool { side: 3, stride: 2 });
const HALVING: Option<Pool> = Some(Pool { side: 2, stride: 2 });

/// AlexNet, the usual one.
pub static ALEX: Network = Network {
    name: "alex",
    title: "AlexNet",
    slices: &[
        Slice { pool: None, convolutions: &[FIRST] },
        Slice { pool: OVERLAPPING, convolutions: &[SECOND] },
        Slice { pool: OVERLAPPING, convolutions: &[plain("slice3.6", 192, 384)] },
        Slice { pool: None, convolutions: &[plain("slice4.8", 384, 256)] },
        Slice { pool: None, convolutions: &[plain("slice5.10", 256, 256)] },
    ],
};

/// VGG16.
pub static VGG: Network = Network {
    name: "vgg",
    title: "VGG16",
    slices: &[
        Slice { pool: None, convolutions: &[plain("slice1.0", 3, 64), plain("slice1.2", 64, 64)] },
        Slice {
            pool: HALVING,
            convolutions: &[plain("slice2.5", 64, 128), plain("slice2.7", 128, 128)],
        },
        Slice {
            pool: HALVING,
            convolutions: &[
                plain("slice3.10", 128, 256),
                plain("slice3.12", 256, 256),
                plain("slice3.14", 256, 256),
            ],
        },
        Slice {
            pool: HALVING,
            convolutions: &[
                plain("slice4.17", 256, 512),
                plain("slice4.19", 512, 512),
                plain("slice4.21", 512, 512),
            ],
        },
        Slice {
            pool: HALVING,
            convolutions: &[
                plain("slice5.24", 512, 512),
                plain("slice5.26", 512, 512),
                plain("slice5.28", 512, 512),
            ],
        },
    ],
};

impl Convolution {
    /// Side of the output for an input of `side`; `None` if the kernel does not fit.
    pub(crate) fn output_side(&self, side: usize) -> Option<usize> {
        Some((side + 2 * self.pad).checked_sub(self.side)? / self.stride + 1)
    }
}

impl Pool {
    /// As [`Convolution::output_side`].
    pub(crate) fn output_side(&self, side: usize) -> Option<usize> {
        Some(side.checked_sub(self.side)? / self.stride + 1)
    }
}

impl Slice {
    /// Channels of its output.
    pub(crate) fn channels(&self) -> usize {
        self.convolutions.last().map_or(0, |c| c.outputs)
    }
}

impl Network {
    /// The smallest side, pixels, of which something is left at the end.
    pub(crate) fn least_side(&self) -> u32 {
        let fits = |side: &u32| {
            let mut side = Some(*side as usize);
            for slice in self.slices {
                if let Some(pool) = slice.pool {
                    side = side.and_then(|s| pool.output_side(s));
                }
                for c in slice.convolutions {
                    side = side.and_then(|s| c.output_side(s));
                }
            }
            side.is_some()
        };
        (1..1000).find(fits).unwrap_or(1000)
    }

    /// The most memory in use at a time, bytes: the padded input and the output of the largest
    /// convolution, and its input and output for the other picture.
    pub(crate) fn memory_bytes(&self, width: u32, height: u32) -> u64 {
        let (mut width, mut height) = (width as usize, height as usize);
        let values = |w: u64, h: u64, c: usize| w.saturating_mul(h).saturating_mul(c as u64);
        let mut most = 0;
        for slice in self.slices {
            if let Some(pool) = slice.pool {
                width = pool.output_side(width).unwrap_or(0);
                height = pool.output_side(height).unwrap_or(0);
            }
            for c in slice.convolutions {
                let side = |n: usize| (n + 2 * c.pad) as u64;
                let input = values(side(width), side(height), c.inputs);
                width = c.output_side(width).unwrap_or(0);
                height = c.output_side(height).unwrap_or(0);
                let output = values(width as u64, height as u64, c.outputs);
                let all = input.saturating_mul(3).saturating_add(output.saturating_mul(2));
                most = most.max(all.saturating_mul(4));
            }
        }
        most
    }
}
