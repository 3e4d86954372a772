//! The address streams that the reference simulators were driven with, request by request the same
//! (their generator is splitmix64, and every stream has a checksum).

use powergs_dram::drive::Access;

const MIB: u64 = 1 << 20;
/// Gathered records, 100 MiB.
const ARRAY: u64 = 0;
/// Tile lists.
const LIST: u64 = 0x0800_5000;
/// Streaming output.
const OUT: u64 = 0x1000_B000;
/// Key buckets.
const KEYS: u64 = 0x1801_4000;
/// Where records are gathered from.
const SPAN: u64 = 100 * MIB;

/// Requests of a stream.
pub const N: usize = 131_072;

/// splitmix64.
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(0x0123_4567))
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        ((self.next() >> 32) * n) >> 32
    }

    pub fn f64(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

fn read(address: u64, bytes: u32) -> Access {
    Access { write: false, address, bytes }
}

fn write(address: u64, bytes: u32) -> Access {
    Access { write: true, address, bytes }
}

fn access(reads: bool, address: u64) -> Access {
    if reads { read(address, 64) } else { write(address, 64) }
}

fn random(n: usize, seed: u64, size: u32, p_read: f64) -> Vec<Access> {
    let mut r = Rng::new(seed);
    let slots = SPAN / u64::from(size);
    let one = |_| {
        let address = r.below(slots) * u64::from(size);
        let reads = p_read >= 1.0 || (p_read > 0.0 && r.f64() < p_read);
        Access { write: !reads, address, bytes: size }
    };
    (0..n).map(one).collect()
}

fn stride(n: usize, step: u64) -> Vec<Access> {
    let (mut at, mut offset) = (0, 0);
    let mut one = |_| {
        let access = read(at + offset, 64);
        at += step;
        if at >= 64 * MIB {
            at = 0;
            offset = (offset + 64) % step;
        }
        access
    };
    (0..n).map(&mut one).collect()
}

fn copy(n: usize, chunk: u64) -> Vec<Access> {
    let k = chunk / 64;
    let mut all = Vec::new();
    let mut block = 0;
    while all.len() < n {
        all.extend((0..k).map(|j| read(ARRAY + block + 64 * j, 64)));
        all.extend((0..k).map(|j| write(OUT + block + 64 * j, 64)));
        block += chunk;
    }
    all
}

fn mixed(n: usize, seed: u64, p_read: f64) -> Vec<Access> {
    let mut r = Rng::new(seed);
    let mut at = [ARRAY, OUT];
    let one = |_| {
        let reads = r.f64() < p_read;
        let address = &mut at[usize::from(!reads)];
        *address += 64;
        access(reads, *address - 64)
    };
    (0..n).map(one).collect()
}

fn blocks_at_random(n: usize, seed: u64, block: u64) -> Vec<Access> {
    let mut r = Rng::new(seed);
    let k = block / 64;
    let mut all = Vec::new();
    for _ in 0..n as u64 / k {
        let first = r.below(SPAN / block) * block;
        all.extend((0..k).map(|j| read(ARRAY + first + 64 * j, 64)));
    }
    all
}

/// 64-byte blocks of `[low, high)` that are not below `done`, which moves on.
fn blocks(low: u64, high: u64, done: &mut u64, all: &mut Vec<Access>) {
    let mut block = (low & !63).max(*done);
    while block < high {
        all.push(read(block, 64));
        block += 64;
    }
    *done = (*done).max(block);
}

fn raster(n: usize, seed: u64, record: u64) -> Vec<Access> {
    const TILES_X: usize = 64;
    const ENTRY: u64 = 19;
    const REUSE: f64 = 0.5;
    let mut r = Rng::new(seed);
    let records = SPAN / record;
    let mut above: Vec<Option<Vec<u64>>> = vec![None; TILES_X];
    let (mut at, mut done) = (LIST, LIST);
    let mut all = Vec::new();
    let mut tile = 0;
    while all.len() < n {
        let x = tile % TILES_X;
        let length = (16 + (-(1.0 - r.f64()).ln() * (192.0 - 16.0)) as usize).min(1024);
        let mut ids = Vec::with_capacity(length);
        for _ in 0..length {
            let u = r.f64();
            let from = match u {
                u if u < REUSE * 0.6 => x.checked_sub(1).and_then(|left| above[left].as_ref()),
                u if u < REUSE => above[x].as_ref(),
                _ => None,
            };
            let id = match from {
                Some(list) => list[r.below(list.len() as u64) as usize],
                None => r.below(records),
            };
            ids.push(id);
        }
        for part in ids.chunks(32) {
            let bytes = ENTRY * part.len() as u64;
            blocks(at, at + bytes, &mut done, &mut all);
            at += bytes;
            all.extend(part.iter().map(|id| read(ARRAY + id * record, record as u32)));
        }
        let pixels = OUT + tile as u64 * 1024;
        all.extend((0..16).map(|j| write(pixels + 64 * j, 64)));
        above[x] = Some(ids);
        tile += 1;
    }
    all
}

fn preprocess(n: usize, seed: u64) -> Vec<Access> {
    const GROUPS: u64 = 64;
    let mut r = Rng::new(seed);
    let mut all = Vec::new();
    let (mut at, mut read_done) = (ARRAY, ARRAY);
    let (mut features, mut written) = (OUT, OUT);
    let mut keys: Vec<u64> = (0..GROUPS).map(|g| KEYS + g * (MIB + 0x2040)).collect();
    while all.len() < n {
        blocks(at, at + 236, &mut read_done, &mut all);
        at += 236;
        if r.f64() >= 0.4 {
            continue;
        }
        features += 19;
        while written + 64 <= features {
            all.push(write(written, 64));
            written += 64;
        }
        let m = 1 + r.below(7);
        let first = r.below(GROUPS);
        for j in 0..m {
            let bucket = &mut keys[((first + j / 2) % GROUPS) as usize];
            *bucket += 8;
            if bucket.is_multiple_of(64) {
                all.push(write(*bucket - 64, 64));
            }
        }
    }
    all
}

/// A stream by its name.
pub fn stream(name: &str) -> Vec<Access> {
    match name {
        "seq_read" => (0..N as u64).map(|i| read(64 * i, 64)).collect(),
        "seq_write" => (0..N as u64).map(|i| write(64 * i, 64)).collect(),
        "rand64_read" => random(N, 1, 64, 1.0),
        "rand32_read" => random(N, 2, 32, 1.0),
        "rand64_mix70" => random(N, 3, 64, 0.7),
        "stride256" => stride(N, 256),
        "stride4096" => stride(N, 4096),
        "copy1k" => copy(N, 1024),
        "mixseq70" => mixed(N, 4, 0.7),
        "block256" => blocks_at_random(N, 5, 256),
        "gs_raster64" => raster(N, 6, 64),
        "gs_preproc" => preprocess(N, 7),
        other => panic!("no stream {other}"),
    }
}

/// A stream with bursts of locality: `kind` mixes rows, directions and sizes.
pub fn traffic(seed: u64, n: usize, kind: u8) -> Vec<Access> {
    let mut r = Rng::new(seed);
    let mut at = 0;
    let one = |_| {
        let jump = r.below(8) < u64::from(kind % 4) * 2;
        if jump {
            at = r.below(1 << 22) * 32;
        }
        let bytes = [16, 32, 64, 200][r.below(4) as usize];
        let access = Access { write: r.below(10) < u64::from(kind), address: at, bytes };
        at += u64::from(bytes);
        access
    };
    (0..n).map(one).collect()
}

/// A stream as text.
pub fn as_text(stream: &[Access]) -> String {
    let line =
        |a: &Access| format!("{} 0x{:x} {}\n", if a.write { 'W' } else { 'R' }, a.address, a.bytes);
    stream.iter().map(line).collect()
}
