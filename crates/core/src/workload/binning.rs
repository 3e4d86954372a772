//! How (splat, tile) pairs get into the lists of tiles (A90).
//!
//! Pairs come in storage order of their splats, those of a splat in the order of its tiles. Where
//! tiles are sorted in groups a group has one list, and a splat one entry in it: "tile" then means
//! a group. Every tile has a pointer to the end of its list. The pointers of `pointers` tiles are
//! on chip, that of tile `t` in place `t mod pointers`: one that is not there is read from DRAM,
//! and the one that was in its place is written back. With no places every pair reads and writes
//! its pointer there.
//!
//! Entries of a tile are combined in a line: bytes leave for DRAM when they reach a multiple of
//! `line` bytes in their list, or when another tile needs the place (tile `t` has place `t mod
//! lines`), and at the end of the frame, tile by tile. With no places the bytes of every pair leave
//! by themselves.
//!
//! - **Append.** Lists grow in blocks, which are allocated as entries need them and begin with a
//!   line. The last bytes of a full block are a pointer to the next one, written as the last bytes
//!   before them are, and read with the list.
//! - **Two passes.** The first pass counts, with the same pointers. Then every list gets a place,
//!   which begins with a line; where not all pointers are on chip, all are written to DRAM, and
//!   those of lists with entries are read for that. The second pass writes.

use super::{FrameWorkload, STORAGE_BLOCK, STORAGE_RECORDS_MAX};
use powergs_base::budget::{Budget, OverBudget};

/// How lists are made, and what of it is on chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ListShape {
    /// Bytes of an entry.
    pub entry: u64,
    /// Bytes of a pointer.
    pub pointer: u64,
    /// Pointers on chip.
    pub pointers: u64,
    /// Bytes of a line, 1 to 65,535.
    pub line: u64,
    /// Lines on chip.
    pub lines: u64,
    /// Whether bytes that begin inside of a line are written with those before them, which are
    /// read for that; otherwise writes are masked.
    pub merges: bool,
    /// Bytes of a block of a list that is appended to, a multiple of `line` and more than a
    /// pointer; `None`: two passes.
    pub block: Option<u64>,
}

/// A move of bytes between the chip and DRAM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ListMove {
    /// What is moved.
    pub what: Moved,
    /// Bytes.
    pub bytes: u16,
    /// Whose list or pointer it is: a tile, or a sort group where there are such, row-major.
    pub tile: u32,
    /// First byte in the list, pointers to blocks included.
    pub from: u64,
}

/// What a [`ListMove`] moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moved {
    /// Bytes of a list, to DRAM.
    Entries,
    /// A pointer, from DRAM.
    PointerIn,
    /// A pointer, to DRAM.
    PointerOut,
}

/// The moves of a run of records in storage order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ListPart {
    /// First move of its pass.
    pub first: u64,
    /// Moves.
    pub moves: u64,
    /// Bytes from DRAM.
    pub read: u64,
    /// Bytes to DRAM.
    pub write: u64,
}

/// The moves of one pass over all records.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct BinningPass {
    moves: Vec<ListMove>,
    /// Moves up to the end of each block of [`STORAGE_BLOCK`] records. What ends the pass belongs
    /// to none. Empty for scenes beyond [`STORAGE_RECORDS_MAX`].
    blocks: Vec<u32>,
    /// Bytes read and written before each [`SUMMED`]-th move.
    sums: Vec<[u64; 2]>,
    total: [u64; 2],
}

/// Moves whose bytes are added up together.
const SUMMED: usize = 64;

/// Where the lists of a frame lie, and how their bytes get there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ListWrites {
    shape: ListShape,
    records: u64,
    /// The pass that writes, and the one that counts.
    passes: [BinningPass; 2],
    /// Of each tile: the place of its list, or of its first block in `blocks`.
    starts: Vec<u64>,
    blocks: Vec<u32>,
    /// Bytes of all lists, and of all pointers.
    sizes: [u64; 2],
}

impl ListShape {
    /// Bytes that a list of `entries` entries takes, pointers to further blocks included.
    pub fn list_bytes(&self, entries: u64) -> u64 {
        let bytes = entries * self.entry;
        match self.block {
            Some(block) => bytes + bytes.saturating_sub(1) / (block - self.pointer) * self.pointer,
            None => bytes,
        }
    }
}

/// The lists while they grow.
struct Growth<'a> {
    lists: &'a mut ListWrites,
    pass: usize,
    /// Entries of each tile so far, and bytes of its list that have left.
    tiles: Vec<(u64, u64)>,
    /// Tiles with a place for their pointer or their line.
    pointers: Vec<u32>,
    lines: Vec<u32>,
    allocated: u32,
    /// Moves so far, whether they are kept or not.
    count: u64,
    keeps: bool,
}

/// A place that nobody has.
const FREE: u32 = u32::MAX;

impl Growth<'_> {
    fn emit(&mut self, what: Moved, tile: u32, from: u64, bytes: u64) {
        self.count += 1;
        if !self.keeps {
            return;
        }
        let own = ListMove { what, bytes: bytes as u16, tile, from };
        let [read, write] = self.lists.bytes_of(&own);
        let pass = &mut self.lists.passes[self.pass];
        if pass.moves.len().is_multiple_of(SUMMED) {
            pass.sums.push(pass.total);
        }
        pass.moves.push(own);
        pass.total = [pass.total[0] + read, pass.total[1] + write];
    }

    /// The pointer of a tile is needed, and changes.
    fn point(&mut self, tile: u32) {
        let bytes = self.lists.shape.pointer;
        let places = self.pointers.len();
        if places == 0 {
            if self.is_there(tile) {
                self.emit(Moved::PointerIn, tile, 0, bytes);
            }
            return self.emit(Moved::PointerOut, tile, 0, bytes);
        }
        let before = std::mem::replace(&mut self.pointers[tile as usize % places], tile);
        if before == tile {
            return;
        }
        if before != FREE {
            self.emit(Moved::PointerOut, before, 0, bytes);
        }
        if self.is_there(tile) {
            self.emit(Moved::PointerIn, tile, 0, bytes);
        }
    }

    /// Whether the pointer of a tile may be in DRAM: a list without entries is known to have none,
    /// but in the pass behind the one that counts, if not all pointers are on chip.
    fn is_there(&self, tile: u32) -> bool {
        let is_placed = self.pass == 0 && self.lists.shape.block.is_none();
        let spills = self.pointers.len() < self.tiles.len();
        self.tiles[tile as usize].0 > 0 || is_placed && spills
    }

    /// What a tile has in its line leaves up to byte `to` of its list, line by line.
    fn leave(&mut self, tile: u32, to: u64) {
        let line = self.lists.shape.line;
        let mut from = self.tiles[tile as usize].1;
        while from < to {
            let end = to.min((from / line + 1) * line);
            self.emit(Moved::Entries, tile, from, end - from);
            from = end;
        }
        self.tiles[tile as usize].1 = from;
    }

    /// Bytes of the list of a tile that are known. A block that is full has its last pointer only
    /// when there is an entry behind it.
    fn length(&self, tile: u32) -> u64 {
        self.lists.shape.list_bytes(self.tiles[tile as usize].0)
    }

    /// An entry for a tile.
    fn append(&mut self, tile: u32) {
        self.point(tile);
        let places = self.lines.len();
        let before = if places == 0 {
            FREE
        } else {
            std::mem::replace(&mut self.lines[tile as usize % places], tile)
        };
        if before != tile && before != FREE {
            self.leave(before, self.length(before));
        }
        let known = self.length(tile);
        self.tiles[tile as usize].0 += 1;
        let length = self.length(tile);
        if let Some(block) = self.lists.shape.block {
            let start = self.lists.starts[tile as usize];
            for place in start + known.div_ceil(block)..start + length.div_ceil(block) {
                self.lists.blocks[place as usize] = self.allocated;
                self.allocated += 1;
            }
        }
        let line = self.lists.shape.line;
        self.leave(tile, if places == 0 { length } else { length / line * line });
    }

    /// Everything that is on chip leaves.
    fn end(&mut self) {
        for tile in 0..self.tiles.len() as u32 {
            self.leave(tile, self.length(tile));
        }
    }
}

impl ListWrites {
    /// Makes the lists of a frame.
    pub fn new(workload: &FrameWorkload, shape: ListShape) -> ListWrites {
        ListWrites::grown(workload, shape, true).0
    }

    /// The lists of a frame and how many moves make them; the moves themselves where they are kept.
    fn grown(workload: &FrameWorkload, shape: ListShape, keeps: bool) -> (ListWrites, u64) {
        let entries = entries(workload);
        let tiles = entries.len();
        let mut lists = ListWrites {
            shape,
            records: workload.counters.points,
            passes: Default::default(),
            starts: Vec::with_capacity(tiles),
            blocks: Vec::new(),
            sizes: [0, tiles as u64 * shape.pointer],
        };
        let mut end = 0;
        for &entries in &entries {
            lists.starts.push(end);
            let bytes = shape.list_bytes(u64::from(entries));
            end += match shape.block {
                Some(block) => bytes.div_ceil(block),
                None => bytes.next_multiple_of(shape.line),
            };
        }
        lists.sizes[0] = end * shape.block.unwrap_or(1);
        lists.blocks = vec![0; if shape.block.is_some() { end as usize } else { 0 }];
        let pairs = Pairs::new(workload);
        let counted = if shape.block.is_none() { lists.walk(&pairs, 1, tiles, keeps) } else { 0 };
        let moves = counted + lists.walk(&pairs, 0, tiles, keeps);
        (lists, moves)
    }

    /// Moves of a pass.
    fn walk(&mut self, pairs: &Pairs, pass: usize, tiles: usize, keeps: bool) -> u64 {
        let places = |n: u64| vec![FREE; n.min(tiles as u64) as usize];
        let (pointers, lines) = (places(self.shape.pointers), places(self.shape.lines));
        let spilled = tiles.saturating_sub(pointers.len());
        let is_counted = self.records <= STORAGE_RECORDS_MAX;
        let blocks = if is_counted { self.records.div_ceil(STORAGE_BLOCK) as usize } else { 0 };
        let mut own = Growth {
            lists: self,
            pass,
            tiles: vec![(0, 0); tiles],
            pointers,
            lines,
            allocated: 0,
            count: 0,
            keeps,
        };
        own.lists.passes[pass].blocks.reserve(blocks);
        for splat in 0..pairs.records.len() {
            let block = (pairs.records[splat] / STORAGE_BLOCK as u32) as usize;
            own.lists.passes[pass].close(block.min(blocks));
            for &tile in pairs.of(splat) {
                match pass {
                    0 => own.append(tile),
                    _ => {
                        own.point(tile);
                        own.tiles[tile as usize].0 += 1;
                    }
                }
            }
        }
        own.lists.passes[pass].close(blocks);
        if pass == 0 {
            own.end();
            return own.count;
        }
        let bytes = own.lists.shape.pointer;
        if spilled == 0 {
            return own.count;
        }
        for tile in own.pointers.clone().into_iter().filter(|&tile| tile != FREE) {
            own.emit(Moved::PointerOut, tile, 0, bytes);
        }
        for tile in 0..tiles as u32 {
            if own.is_there(tile) {
                own.emit(Moved::PointerIn, tile, 0, bytes);
            }
            own.emit(Moved::PointerOut, tile, 0, bytes);
        }
        own.count
    }

    /// Whether there is a pass that counts.
    pub fn counts_first(&self) -> bool {
        self.shape.block.is_none()
    }

    /// Bytes of the lists, and of the pointers.
    pub fn sizes(&self) -> [u64; 2] {
        self.sizes
    }

    /// How lists are made.
    pub fn shape(&self) -> &ListShape {
        &self.shape
    }

    /// The moves of the records up to `end`, in the pass that writes or the one that counts. All
    /// records bring what ends the pass too.
    fn until(&self, pass: usize, end: u64) -> [u64; 3] {
        let own = &self.passes[pass];
        let all = own.moves.len() as u64;
        if end >= self.records || all == 0 {
            return [all, own.total[0], own.total[1]];
        }
        let moves = if own.blocks.is_empty() {
            (u128::from(all) * u128::from(end) / u128::from(self.records)) as u64
        } else {
            let (block, part) = ((end / STORAGE_BLOCK) as usize, end % STORAGE_BLOCK);
            let low = if block == 0 { 0 } else { u64::from(own.blocks[block - 1]) };
            let size = (self.records - block as u64 * STORAGE_BLOCK).min(STORAGE_BLOCK);
            low + (u64::from(own.blocks[block]) - low) * part / size
        };
        let first = moves as usize / SUMMED * SUMMED;
        let [mut read, mut write] = own.sums.get(first / SUMMED).copied().unwrap_or(own.total);
        for own in &own.moves[first.min(own.moves.len())..moves as usize] {
            let [more_read, more_write] = self.bytes_of(own);
            (read, write) = (read + more_read, write + more_write);
        }
        [moves, read, write]
    }

    /// The moves of the records from `first` to `end`, in the pass that writes or the one that
    /// counts.
    pub fn part(&self, counts: bool, first: u64, end: u64) -> ListPart {
        let pass = usize::from(counts);
        let from = if first == 0 { [0; 3] } else { self.until(pass, first) };
        let to = self.until(pass, end);
        let [moves, read, write] = std::array::from_fn(|i| to[i] - from[i]);
        ListPart { first: from[0], moves, read, write }
    }

    /// A move of a pass.
    pub fn moved(&self, counts: bool, at: u64) -> &ListMove {
        &self.passes[usize::from(counts)].moves[at as usize]
    }

    /// Bytes before those of a move that are written with them.
    fn before(&self, own: &ListMove) -> u64 {
        if self.shape.merges && own.what == Moved::Entries { own.from % self.shape.line } else { 0 }
    }

    /// Bytes that a move reads, and bytes that it writes.
    pub fn bytes_of(&self, own: &ListMove) -> [u64; 2] {
        let (bytes, before) = (u64::from(own.bytes), self.before(own));
        match own.what {
            Moved::Entries => [before, before + bytes],
            Moved::PointerIn => [bytes, 0],
            Moved::PointerOut => [0, bytes],
        }
    }

    /// Where a move begins in the region of lists, or of pointers.
    pub fn place_of(&self, own: &ListMove) -> u64 {
        match own.what {
            Moved::Entries => self.place(own.tile, own.from - self.before(own)),
            Moved::PointerIn | Moved::PointerOut => u64::from(own.tile) * self.shape.pointer,
        }
    }

    /// Where byte `at` of the list of a tile lies in the region of lists.
    fn place(&self, tile: u32, at: u64) -> u64 {
        let start = self.starts[tile as usize];
        match self.shape.block {
            Some(block) => {
                u64::from(self.blocks[(start + at / block) as usize]) * block + at % block
            }
            None => start + at,
        }
    }

    /// The contiguous bytes from byte `at` of the list of a tile, of at most `bytes`.
    pub fn run(&self, tile: u32, at: u64, bytes: u64) -> (u64, u64) {
        let most = self.shape.block.map_or(bytes, |block| block - at % block);
        (self.place(tile, at), bytes.min(most))
    }
}

impl BinningPass {
    /// Closes blocks of records until there are `blocks`.
    fn close(&mut self, blocks: usize) {
        while self.blocks.len() < blocks {
            self.blocks.push(self.moves.len() as u32);
        }
    }
}

/// Host memory that a frame takes with its lists, bytes, at most about so much: what is sure to be
/// enough where that is allowed, else as much as the moves of the lists are.
///
/// # Errors
/// [`OverBudget`]: more than `budget`.
pub fn demand(
    workload: &FrameWorkload,
    shape: &ListShape,
    budget: Budget,
) -> Result<u64, OverBudget> {
    let pairs = workload.list.len() as u64;
    let tiles = workload.tiles.len() as u64;
    // A vector that grows may reserve twice its length; what it does not use is never touched.
    let each = size_of::<ListMove>() as u64;
    let others = workload.bytes() as u64 + (2 * size_of::<u32>() as u64) * pairs;
    let bytes = |moves: u64| others.saturating_add(moves.saturating_mul(each));
    // A pointer in and one out, what the tile before had in its line, and the lines of an entry; in
    // two passes the pointers twice.
    let lines = (shape.entry + shape.pointer).div_ceil(shape.line);
    let most = bytes(pairs.saturating_mul(6 + lines).saturating_add(4 * tiles));
    if budget.check(most).is_ok() {
        return Ok(most);
    }
    budget.check(others)?;
    let needed = bytes(ListWrites::grown(workload, *shape, false).1);
    budget.check(needed).map(|()| needed)
}

/// Entries of all lists, those of tiles or of sort groups.
pub fn entries(workload: &FrameWorkload) -> Vec<u32> {
    match workload.groups.as_slice() {
        [] => workload.tiles.iter().map(|tile| tile.entries).collect(),
        groups => groups.iter().map(|group| group.entries).collect(),
    }
}

/// The tiles of every splat, in storage order.
struct Pairs {
    /// Record of each splat that has a tile.
    records: Vec<u32>,
    /// First pair of each, and the end of all.
    starts: Vec<u32>,
    tiles: Vec<u32>,
}

impl Pairs {
    fn new(workload: &FrameWorkload) -> Pairs {
        let splats = workload.counters.intersecting_points as usize;
        let mut records = vec![0; splats];
        for (&slot, &index) in workload.slot.iter().zip(&workload.index) {
            if let Some(record) = records.get_mut(slot as usize) {
                *record = index;
            }
        }
        let slots = || workload.list.iter().map(|&rank| workload.slot[rank as usize] as usize);
        let mut starts = vec![0u32; splats + 2];
        for slot in slots() {
            starts[slot + 2] += 1;
        }
        let group = |tile: usize| match workload.geometry.tiles_per_group_side() {
            1 => tile as u32,
            side => {
                let (x, y) = (tile as u32 % workload.tiles_x, tile as u32 / workload.tiles_x);
                y / side * workload.groups_x() + x / side
            }
        };
        for slot in 2..starts.len() {
            starts[slot] += starts[slot - 1];
        }
        let mut tiles = vec![0; workload.list.len()];
        for (tile, work) in workload.tiles.iter().enumerate() {
            for &rank in workload.list_of(work) {
                let next = &mut starts[workload.slot[rank as usize] as usize + 1];
                tiles[*next as usize] = group(tile);
                *next += 1;
            }
        }
        starts.pop();
        if workload.groups.is_empty() {
            return Pairs { records, starts, tiles };
        }
        // A splat has one entry in the list of a group.
        let mut once = Pairs { records, starts: vec![0], tiles: Vec::new() };
        for splat in starts.windows(2) {
            let own = &mut tiles[splat[0] as usize..splat[1] as usize];
            own.sort_unstable();
            let from = once.tiles.len();
            for &group in &*own {
                if once.tiles[from..].last() != Some(&group) {
                    once.tiles.push(group);
                }
            }
            once.starts.push(once.tiles.len() as u32);
        }
        once
    }

    fn of(&self, splat: usize) -> &[u32] {
        &self.tiles[self.starts[splat] as usize..self.starts[splat + 1] as usize]
    }
}
