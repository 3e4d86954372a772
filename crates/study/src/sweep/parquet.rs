//! The table of results as a Parquet file: row groups of bounded size, a plain page of Zstandard
//! for each column, no statistics.
//!
//! The format is that of <https://parquet.apache.org/docs/file-format>; names and numbers of fields
//! are those of its `parquet.thrift`.

use std::io::{Error, ErrorKind, Result, Write};

use super::table::{Cell, Column, ColumnKind};
use thrift::Struct;

mod thrift;

/// Rows of a row group: what is held in memory.
const GROUP_ROWS: usize = 8192;
/// Level of Zstandard.
const LEVEL: i32 = 1;
/// What a file begins and ends with.
const MAGIC: &[u8; 4] = b"PAR1";
/// `Encoding.PLAIN` and `Encoding.RLE`.
const PLAIN: i64 = 0;
const RLE: i64 = 3;
/// `CompressionCodec.ZSTD`.
const ZSTD: i64 = 6;

/// Writes a table row by row.
pub struct ParquetWriter<W: Write> {
    out: W,
    /// Bytes written so far.
    written: u64,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
    groups: Vec<Struct>,
    /// Rows in `groups`.
    grouped: u64,
}

impl<W: Write> ParquetWriter<W> {
    /// A file of these columns.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(mut out: W, columns: &[Column]) -> Result<Self> {
        out.write_all(MAGIC)?;
        Ok(ParquetWriter {
            out,
            written: MAGIC.len() as u64,
            columns: columns.to_vec(),
            rows: Vec::new(),
            groups: Vec::new(),
            grouped: 0,
        })
    }

    /// Adds a row: a cell per column.
    ///
    /// # Errors
    /// Those of the file, and a cell that does not fit its column.
    pub fn row(&mut self, row: Vec<Cell>) -> Result<()> {
        self.rows.push(row);
        if self.rows.len() == GROUP_ROWS { self.group() } else { Ok(()) }
    }

    /// Writes the rest and the footer, and gives the output back.
    ///
    /// # Errors
    /// Those of the file.
    pub fn finish(mut self) -> Result<W> {
        if !self.rows.is_empty() {
            self.group()?;
        }
        let mut schema = vec![Struct::new().text(4, "sweep").int(5, self.columns.len() as i64)];
        schema.extend(self.columns.iter().map(element));
        let footer = Struct::new()
            .int(1, 1)
            .structs(2, &schema)
            .long(3, self.grouped as i64)
            .structs(4, &self.groups)
            .text(6, "powergs-sim")
            .bytes();
        self.out.write_all(&footer)?;
        self.out.write_all(&(footer.len() as u32).to_le_bytes())?;
        self.out.write_all(MAGIC)?;
        Ok(self.out)
    }

    /// Writes a row group: a page per column.
    fn group(&mut self) -> Result<()> {
        let rows = std::mem::take(&mut self.rows);
        let start = self.written;
        let mut chunks = Vec::new();
        let mut total = 0;
        for (i, column) in self.columns.iter().enumerate() {
            let page = page(rows.iter().map(|row| &row[i]), column)?;
            let compressed = zstd::bulk::compress(&page, LEVEL)?;
            let values = Struct::new().int(1, rows.len() as i64).int(2, PLAIN).int(3, RLE);
            let header = Struct::new()
                .int(1, 0)
                .int(2, size(page.len())?)
                .int(3, size(compressed.len())?)
                .inner(5, values.int(4, RLE))
                .bytes();
            // The sizes of a column count the headers of its pages.
            let sizes = [page.len(), compressed.len()].map(|n| (header.len() + n) as i64);
            let chunk = Struct::new()
                .int(1, physical(column.kind))
                .ints(2, &[PLAIN, RLE])
                .texts(3, &[&column.name])
                .int(4, ZSTD)
                .long(5, rows.len() as i64)
                .long(6, sizes[0])
                .long(7, sizes[1])
                .long(9, self.written as i64);
            chunks.push(Struct::new().long(2, self.written as i64).inner(3, chunk));
            self.out.write_all(&header)?;
            self.out.write_all(&compressed)?;
            self.written += sizes[1] as u64;
            total += sizes[0];
        }
        let group = Struct::new()
            .structs(1, &chunks)
            .long(2, total)
            .long(3, rows.len() as i64)
            .long(5, start as i64)
            .long(6, (self.written - start) as i64);
        self.groups.push(group);
        self.grouped += rows.len() as u64;
        Ok(())
    }
}

/// Sizes of pages are `i32`.
fn size(bytes: usize) -> Result<i64> {
    let small = i32::try_from(bytes).map_err(|_| Error::other("a column of more than 2 GiB"))?;
    Ok(small.into())
}

/// `Type`: what values are in the file.
fn physical(kind: ColumnKind) -> i64 {
    match kind {
        ColumnKind::Truth => 0,
        ColumnKind::Integer => 2,
        ColumnKind::Real => 5,
        ColumnKind::Text => 6,
    }
}

/// The `SchemaElement` of a column. Texts are required, everything else is optional.
fn element(column: &Column) -> Struct {
    let text = column.kind == ColumnKind::Text;
    let head = Struct::new().int(1, physical(column.kind)).int(3, i64::from(!text));
    let named = head.text(4, &column.name);
    // `ConvertedType.UTF8` for old readers, `LogicalType.STRING` for new ones.
    if text { named.int(6, 0).inner(10, Struct::new().inner(1, Struct::new())) } else { named }
}

/// The values of a column; before those that may be absent, which of them are there.
fn page<'a>(cells: impl ExactSizeIterator<Item = &'a Cell>, column: &Column) -> Result<Vec<u8>> {
    let mut there = Bits::default();
    let mut truths = Bits::default();
    let mut values = Vec::new();
    for cell in cells {
        there.push(*cell != Cell::Empty);
        match (column.kind, cell) {
            (ColumnKind::Text, Cell::Text(text)) => {
                values.extend((text.len() as u32).to_le_bytes());
                values.extend(text.as_bytes());
            }
            (ColumnKind::Text, Cell::Empty) => values.extend(0u32.to_le_bytes()),
            (_, Cell::Empty) => {}
            (ColumnKind::Integer, Cell::Integer(n)) => values.extend(n.to_le_bytes()),
            (ColumnKind::Real, Cell::Real(x)) => values.extend(x.to_le_bytes()),
            (ColumnKind::Real, Cell::Integer(n)) => values.extend((*n as f64).to_le_bytes()),
            (ColumnKind::Truth, Cell::Truth(yes)) => truths.push(*yes),
            _ => {
                let what = format!("column {}: a cell of another kind", column.name);
                return Err(Error::new(ErrorKind::InvalidData, what));
            }
        }
    }
    if column.kind == ColumnKind::Text {
        return Ok(values);
    }
    // One bit-packed run: twice the number of its bytes, plus one.
    let mut levels = Vec::new();
    thrift::varint(&mut levels, 2 * there.bytes.len() as u64 + 1);
    levels.extend(there.bytes);
    let mut page = (levels.len() as u32).to_le_bytes().to_vec();
    page.extend(levels);
    page.extend(values);
    page.extend(truths.bytes);
    Ok(page)
}

/// Bits, the first in the lowest place.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    count: usize,
}

impl Bits {
    fn push(&mut self, bit: bool) {
        if self.count.is_multiple_of(8) {
            self.bytes.push(0);
        }
        if let Some(last) = self.bytes.last_mut() {
            *last |= u8::from(bit) << (self.count % 8);
        }
        self.count += 1;
    }
}
