//! Transforms of columns before compression: lossless, exact to the bit.
//!
//! All but the last act on 32-bit words (floats by their bits). Byte planes put the bytes of equal
//! weight of all words side by side, least significant plane first: exponents and high bytes then
//! compress well, and the noise of low mantissa bytes stays apart from them.

/// The transform of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transform {
    /// The bytes as they are; words are little-endian.
    Plain = 0,
    /// Byte planes.
    Planes = 1,
    /// Each word rotated left by one bit (the sign goes last, the exponent fills the top byte),
    /// then byte planes.
    RotatedPlanes = 2,
    /// The difference to the word before (the first to 0), modulo 2³², then byte planes.
    DeltaPlanes = 3,
    /// That difference as a signed number, folded: 0, −1, 1, −2 become 0, 1, 2, 3; then byte
    /// planes.
    FoldedDeltaPlanes = 4,
    /// For bytes: the difference to the byte three before (the first three to 0), modulo 256: the
    /// same channel of the pixel to the left.
    RgbDelta = 5,
}

impl Transform {
    /// The transform of this number in a block header.
    pub fn from_code(code: u8) -> Option<Transform> {
        const ALL: [Transform; 6] = [
            Transform::Plain,
            Transform::Planes,
            Transform::RotatedPlanes,
            Transform::DeltaPlanes,
            Transform::FoldedDeltaPlanes,
            Transform::RgbDelta,
        ];
        ALL.get(usize::from(code)).copied()
    }

    /// Whether the result consists of four byte planes.
    pub(super) fn is_planar(self) -> bool {
        !self.suits_bytes()
    }

    /// Whether it is for columns of bytes.
    pub(super) fn suits_bytes(self) -> bool {
        matches!(self, Transform::Plain | Transform::RgbDelta)
    }

    /// Whether it is for columns of words.
    pub(super) fn suits_words(self) -> bool {
        self != Transform::RgbDelta
    }

    /// The bytes to compress of a column of bytes.
    pub fn apply_bytes(self, mut bytes: Vec<u8>) -> Vec<u8> {
        if self == Transform::RgbDelta {
            for i in (3..bytes.len()).rev() {
                bytes[i] = bytes[i].wrapping_sub(bytes[i - 3]);
            }
        }
        bytes
    }

    /// The column of bytes of [`Transform::apply_bytes`]'s result.
    pub fn undo_bytes(self, mut bytes: Vec<u8>) -> Vec<u8> {
        if self == Transform::RgbDelta {
            for i in 3..bytes.len() {
                bytes[i] = bytes[i].wrapping_add(bytes[i - 3]);
            }
        }
        bytes
    }

    /// The bytes to compress: four a word.
    pub fn apply(self, mut words: Vec<u32>) -> Vec<u8> {
        match self {
            Transform::Plain | Transform::RgbDelta => {
                return words.iter().flat_map(|w| w.to_le_bytes()).collect();
            }
            Transform::Planes => {}
            Transform::RotatedPlanes => words.iter_mut().for_each(|w| *w = w.rotate_left(1)),
            Transform::DeltaPlanes => deltas(&mut words, |d| d),
            Transform::FoldedDeltaPlanes => deltas(&mut words, fold),
        }
        to_planes(&words)
    }

    /// The words of [`Transform::apply`]'s result; the length of `bytes` is a multiple of four.
    pub fn undo(self, bytes: &[u8]) -> Vec<u32> {
        debug_assert!(bytes.len().is_multiple_of(4), "columns of words have whole words");
        if !self.is_planar() {
            return bytes.chunks_exact(4).map(le_word).collect();
        }
        let mut words = from_planes(bytes);
        match self {
            Transform::Plain | Transform::RgbDelta | Transform::Planes => {}
            Transform::RotatedPlanes => words.iter_mut().for_each(|w| *w = w.rotate_right(1)),
            Transform::DeltaPlanes => sums(&mut words, |d| d),
            Transform::FoldedDeltaPlanes => sums(&mut words, unfold),
        }
        words
    }
}

fn le_word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn deltas(words: &mut [u32], map: impl Fn(u32) -> u32) {
    let mut before = 0;
    for word in words {
        let value = *word;
        *word = map(value.wrapping_sub(before));
        before = value;
    }
}

fn sums(words: &mut [u32], map: impl Fn(u32) -> u32) {
    let mut sum = 0u32;
    for word in words {
        sum = sum.wrapping_add(map(*word));
        *word = sum;
    }
}

fn fold(difference: u32) -> u32 {
    (difference << 1) ^ ((difference as i32 >> 31) as u32)
}

fn unfold(folded: u32) -> u32 {
    (folded >> 1) ^ (folded & 1).wrapping_neg()
}

fn to_planes(words: &[u32]) -> Vec<u8> {
    let mut planes = Vec::with_capacity(4 * words.len());
    for shift in [0, 8, 16, 24] {
        planes.extend(words.iter().map(|w| (w >> shift) as u8));
    }
    planes
}

fn from_planes(bytes: &[u8]) -> Vec<u32> {
    let n = bytes.len() / 4;
    let (low, high) = bytes.split_at(2 * n);
    let ((p0, p1), (p2, p3)) = (low.split_at(n), high.split_at(n));
    p0.iter()
        .zip(p1)
        .zip(p2.iter().zip(p3))
        .map(|((&a, &b), (&c, &d))| u32::from_le_bytes([a, b, c, d]))
        .collect()
}
