//! Thrift's compact protocol, as far as the headers and the footer of a Parquet file need it.

/// Types of fields.
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A structure; its fields are added in the order of their numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct Struct {
    bytes: Vec<u8>,
    last: u8,
}

impl Struct {
    pub fn new() -> Self {
        Self::default()
    }

    /// A field of type `i32`, or of an enumeration.
    pub fn int(self, field: u8, value: i64) -> Self {
        self.with(field, I32, |bytes| zigzag(bytes, value))
    }

    /// A field of type `i64`.
    pub fn long(self, field: u8, value: i64) -> Self {
        self.with(field, I64, |bytes| zigzag(bytes, value))
    }

    pub fn text(self, field: u8, value: &str) -> Self {
        self.with(field, BINARY, |bytes| text(bytes, value))
    }

    pub fn inner(self, field: u8, value: Struct) -> Self {
        self.with(field, STRUCT, |bytes| bytes.extend(value.bytes()))
    }

    pub fn ints(self, field: u8, values: &[i64]) -> Self {
        self.list(field, I32, values, |bytes, v| zigzag(bytes, *v))
    }

    pub fn texts(self, field: u8, values: &[&str]) -> Self {
        self.list(field, BINARY, values, |bytes, v| text(bytes, v))
    }

    pub fn structs(self, field: u8, values: &[Struct]) -> Self {
        self.list(field, STRUCT, values, |bytes, v| bytes.extend(v.clone().bytes()))
    }

    /// The structure as it is in a file.
    pub fn bytes(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }

    fn with(mut self, field: u8, kind: u8, value: impl FnOnce(&mut Vec<u8>)) -> Self {
        self.bytes.push((field - self.last) << 4 | kind);
        self.last = field;
        value(&mut self.bytes);
        self
    }

    fn list<T>(self, field: u8, kind: u8, of: &[T], each: impl Fn(&mut Vec<u8>, &T)) -> Self {
        self.with(field, LIST, |bytes| {
            if of.len() < 15 {
                bytes.push((of.len() as u8) << 4 | kind);
            } else {
                bytes.push(0xf0 | kind);
                varint(bytes, of.len() as u64);
            }
            of.iter().for_each(|value| each(bytes, value));
        })
    }
}

fn text(bytes: &mut Vec<u8>, value: &str) {
    varint(bytes, value.len() as u64);
    bytes.extend(value.as_bytes());
}

fn zigzag(bytes: &mut Vec<u8>, value: i64) {
    varint(bytes, (value << 1 ^ value >> 63) as u64);
}

/// Seven bits a byte, the lowest first.
pub(super) fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}
