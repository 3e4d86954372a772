//! The table of results as a Parquet file: row groups of bounded size, Zstandard, no statistics
//! that depend on how it was made.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::table::{Cell, Column, Kind};

/// Rows of a row group: what is held in memory.
const GROUP_ROWS: usize = 8192;

/// Writes a table row by row.
pub struct ParquetWriter<W: Write + Send> {
    file: SerializedFileWriter<W>,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

impl<W: Write + Send> ParquetWriter<W> {
    /// A file of these columns.
    ///
    /// # Errors
    /// Those of `out`, and two columns of one name.
    pub fn new(out: W, columns: &[Column]) -> Result<Self> {
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(Default::default()))
            .set_created_by("powergs-sim".into())
            .build();
        let file = SerializedFileWriter::new(out, schema(columns)?, Arc::new(properties))?;
        Ok(ParquetWriter { file, columns: columns.to_vec(), rows: Vec::new() })
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
        self.file.into_inner()
    }

    fn group(&mut self) -> Result<()> {
        let rows = std::mem::take(&mut self.rows);
        let mut group = self.file.next_row_group()?;
        for (i, column) in self.columns.iter().enumerate() {
            let cells = rows.iter().map(|row| &row[i]);
            let mut writer = group.next_column()?.ok_or_else(|| wrong(column))?;
            match column.kind {
                Kind::Text => {
                    let texts: Vec<ByteArray> = cells.map(|c| c.text().as_str().into()).collect();
                    writer.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
                }
                Kind::Integer => {
                    let (values, levels) = nullable(cells, column, integer)?;
                    writer.typed::<Int64Type>().write_batch(&values, Some(&levels), None)?;
                }
                Kind::Real => {
                    let (values, levels) = nullable(cells, column, real)?;
                    writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
                }
                Kind::Truth => {
                    let (values, levels) = nullable(cells, column, truth)?;
                    writer.typed::<BoolType>().write_batch(&values, Some(&levels), None)?;
                }
            }
            writer.close()?;
        }
        group.close()?;
        Ok(())
    }
}

/// Values that are there, and a level per row: 1 if it is, 0 if not.
fn nullable<'a, T>(
    cells: impl Iterator<Item = &'a Cell>,
    column: &Column,
    value: impl Fn(&Cell) -> Option<T>,
) -> Result<(Vec<T>, Vec<i16>)> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    for cell in cells {
        levels.push(i16::from(*cell != Cell::Empty));
        if *cell != Cell::Empty {
            values.push(value(cell).ok_or_else(|| wrong(column))?);
        }
    }
    Ok((values, levels))
}

fn integer(cell: &Cell) -> Option<i64> {
    if let Cell::Integer(n) = cell { Some(*n) } else { None }
}

fn real(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Real(x) => Some(*x),
        Cell::Integer(n) => Some(*n as f64),
        _ => None,
    }
}

fn truth(cell: &Cell) -> Option<bool> {
    if let Cell::Truth(yes) = cell { Some(*yes) } else { None }
}

fn wrong(column: &Column) -> ParquetError {
    ParquetError::General(format!("column {}: a cell of another kind", column.name))
}

fn schema(columns: &[Column]) -> Result<TypePtr> {
    let field = |column: &Column| {
        let (physical, logical, repetition) = match column.kind {
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
            Kind::Integer => (Physical::INT64, None, Repetition::OPTIONAL),
            Kind::Real => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            Kind::Truth => (Physical::BOOLEAN, None, Repetition::OPTIONAL),
        };
        let builder = Type::primitive_type_builder(&column.name, physical);
        let field = builder.with_logical_type(logical).with_repetition(repetition).build()?;
        Ok(Arc::new(field))
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<TypePtr>>>()?;
    Ok(Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?))
}
