//! The results of a sweep: the table, streamed in the order of the space from the journals.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use super::folder::SweepFolder;
use super::opened::Opened;
use super::plan::Plan;
use crate::cli::aside::temporary;
use crate::cli::{Exit, Failure, OrExit};
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::parquet::ParquetWriter;
use powergs_study::sweep::table::{Cell, Column, Entry, Fate, TraceLabel, columns, rows};

/// The table as CSV.
pub const CSV: &str = "results.csv";
/// The same table as Parquet.
pub const PARQUET: &str = "results.parquet";

/// What a table has.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    /// Designs with all results.
    pub ok: u64,
    /// Designs that failed, on some trace at least.
    pub failed: u64,
    /// Designs with a result missing.
    pub missing: u64,
}

/// Writes `results.csv` and `results.parquet`, each whole or not at all.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn write(folder: &mut SweepFolder, opened: &Opened, plan: &Plan) -> Result<Tally, Failure> {
    let path = folder.path.clone();
    let mut table = Files::create(&path, &columns(opened.axis_columns()))?;
    let traces: Vec<TraceLabel> = opened.traces.iter().map(|t| t.label.clone()).collect();
    let mut tally = Tally::default();
    let mut invalid = plan.invalid.iter().peekable();
    for (design, planned) in plan.designs.iter().enumerate() {
        while let Some((point, reason)) = invalid.next_if(|(p, _)| Some(*p) < planned.point) {
            table.invalid(opened, *point, reason, &traces)?;
            tally.failed += 1;
        }
        let entry = Entry {
            point: planned.point,
            id: Some(planned.id),
            axes: opened.axis_cells(planned.point),
        };
        let mut status = [false; 2];
        for (t, label) in opened.tables().iter().enumerate() {
            let mut fates = Vec::new();
            for trace in &opened.traces {
                let fate = match folder.records.get(plan.key(design, t, trace.hash))? {
                    Some(Record::Ok(outcome)) => Fate::Ok(outcome),
                    Some(Record::Failed(reason)) => Fate::Failed(reason),
                    None => Fate::Missing,
                };
                status[0] |= matches!(fate, Fate::Failed(_));
                status[1] |= matches!(fate, Fate::Missing);
                fates.push(fate);
            }
            for row in rows(&entry, label, &traces, &fates) {
                table.row(row)?;
            }
        }
        match status {
            [true, _] => tally.failed += 1,
            [false, true] => tally.missing += 1,
            [false, false] => tally.ok += 1,
        }
    }
    for (point, reason) in invalid {
        table.invalid(opened, *point, reason, &traces)?;
        tally.failed += 1;
    }
    table.finish(&path)?;
    Ok(tally)
}

/// The two files, under temporary names.
struct Files {
    csv: csv::Writer<BufWriter<tempfile::NamedTempFile>>,
    parquet: ParquetWriter<BufWriter<File>>,
    parquet_file: tempfile::NamedTempFile,
}

impl Files {
    fn create(folder: &Path, columns: &[Column]) -> Result<Files, Failure> {
        let csv = temporary(&folder.join(CSV)).or_exit(Exit::Usage, folder.display())?;
        let mut csv = csv::Writer::from_writer(BufWriter::new(csv));
        let header = columns.iter().map(|c| c.name.as_str());
        csv.write_record(header).or_exit(Exit::Usage, folder.display())?;
        let parquet_file =
            temporary(&folder.join(PARQUET)).or_exit(Exit::Usage, folder.display())?;
        let file = parquet_file.reopen().or_exit(Exit::Usage, folder.display())?;
        let parquet = ParquetWriter::new(BufWriter::new(file), columns);
        let parquet = parquet.or_exit(Exit::Internal, PARQUET)?;
        Ok(Files { csv, parquet, parquet_file })
    }

    fn row(&mut self, row: Vec<Cell>) -> Result<(), Failure> {
        self.csv.write_record(row.iter().map(Cell::text)).or_exit(Exit::Usage, CSV)?;
        self.parquet.row(row).or_exit(Exit::Usage, PARQUET)
    }

    /// The rows of a design that is no machine.
    fn invalid(
        &mut self,
        opened: &Opened,
        point: u64,
        reason: &str,
        traces: &[TraceLabel],
    ) -> Result<(), Failure> {
        let entry = Entry { point: Some(point), id: None, axes: opened.axis_cells(Some(point)) };
        let fates = vec![Fate::Failed(reason.to_owned()); traces.len()];
        for label in opened.tables() {
            rows(&entry, &label, traces, &fates).into_iter().try_for_each(|row| self.row(row))?;
        }
        Ok(())
    }

    fn finish(self, folder: &Path) -> Result<(), Failure> {
        let csv = self.csv.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, CSV)?;
        let csv = csv.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, CSV)?;
        let parquet = self.parquet.finish().or_exit(Exit::Usage, PARQUET)?;
        parquet.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, PARQUET)?;
        csv.persist(folder.join(CSV)).or_exit(Exit::Usage, CSV)?;
        self.parquet_file.persist(folder.join(PARQUET)).or_exit(Exit::Usage, PARQUET)?;
        Ok(())
    }
}
