//! The table: aggregates, failures, and the same numbers in both files.

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use powergs_study::sweep::parquet::ParquetWriter;
use powergs_study::sweep::table::{Cell, Column, Entry, Fate, Kind, TraceLabel, columns, rows};

use super::outcome;

fn traces() -> [TraceLabel; 2] {
    [("room", 1.0), ("garden", 3.0)].map(|(l, weight)| TraceLabel { label: l.into(), weight })
}

fn entry(point: Option<u64>) -> Entry {
    let axes = vec![Cell::Integer(4), Cell::Text("64 KiB".into())];
    Entry { point, id: Some(0xabc), axes }
}

fn axes() -> Vec<Column> {
    vec![
        Column { name: "vru.cores".into(), kind: Kind::Integer },
        Column { name: "buffers.feature.capacity".into(), kind: Kind::Text },
    ]
}

fn cell(row: &[Cell], name: &str) -> Cell {
    row[columns(&axes()).iter().position(|c| c.name == name).unwrap()].clone()
}

#[test]
fn a_row_per_trace_the_mean_and_the_worst() {
    let fates = [Fate::Ok(outcome(&[1.0])), Fate::Ok(outcome(&[3.0]))];
    let rows = rows(&entry(Some(9)), "28nm", &traces(), &fates);
    assert_eq!(rows.len(), 4);
    let times: Vec<Cell> = rows.iter().map(|r| cell(r, "frame_time_ms.mean")).collect();
    assert_eq!(times, [1.0, 3.0, 2.5, 3.0].map(Cell::Real));
    assert_eq!(cell(&rows[3], "trace"), Cell::Text("garden".into()));
    assert_eq!(cell(&rows[2], "trace"), Cell::Text(String::new()));
    assert_eq!(cell(&rows[0], "id"), Cell::Text(format!("{:032x}", 0xabc)));
    assert_eq!(cell(&rows[0], "point"), Cell::Integer(9));
    assert!(rows.iter().all(|row| row.len() == columns(&axes()).len()));
}

#[test]
fn a_failed_trace_is_never_averaged_away() {
    let fates = [Fate::Ok(outcome(&[1.0])), Fate::Failed("frame 3: broke".into())];
    let rows = rows(&entry(Some(9)), "28nm", &traces(), &fates);
    let of = |name: &str| rows.iter().map(|r| cell(r, name).text()).collect::<Vec<_>>();
    assert_eq!(of("status"), ["ok", "failed", "failed", "failed"]);
    assert_eq!(of("reason"), ["", "frame 3: broke", "frame 3: broke", "frame 3: broke"]);
    assert_eq!(of("energy_pj.mean"), ["10", "", "", ""]);
    let missing = [Fate::Ok(outcome(&[1.0])), Fate::Missing];
    let rows = super::table::rows(&entry(Some(9)), "28nm", &traces(), &missing);
    assert_eq!(cell(&rows[2], "status").text(), "missing");
}

#[test]
fn parquet_holds_what_csv_says() {
    let columns = columns(&axes());
    let mut written = Vec::new();
    let mut table = ParquetWriter::new(Vec::new(), &columns).unwrap();
    for point in [None, Some(0), Some(1)] {
        let second = if point == Some(1) { Fate::Missing } else { Fate::Ok(outcome(&[0.1])) };
        let fates = [Fate::Ok(outcome(&[1.0, 1.0 / 3.0])), second];
        for row in rows(&entry(point), "28nm", &traces(), &fates) {
            written.push(row.clone());
            table.row(row).unwrap();
        }
    }
    let bytes = table.finish().unwrap();
    let reader = SerializedFileReader::new(parquet_bytes(bytes)).unwrap();
    let read: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(read.len(), written.len());
    for (read, written) in read.iter().zip(&written) {
        for (((name, field), cell), column) in read.get_column_iter().zip(written).zip(&columns) {
            assert_eq!(*name, column.name);
            let same = match (field, cell) {
                (Field::Null, Cell::Empty) => true,
                (Field::Str(a), Cell::Text(b)) => a == b,
                (Field::Long(a), Cell::Integer(b)) => a == b,
                (Field::Double(a), Cell::Real(b)) => a == b,
                (Field::Bool(a), Cell::Truth(b)) => a == b,
                _ => false,
            };
            assert!(same, "{name}: {field:?} is not {cell:?}");
        }
    }
}

fn parquet_bytes(bytes: Vec<u8>) -> bytes::Bytes {
    bytes.into()
}

#[test]
fn a_cell_of_another_kind_is_an_error() {
    let columns = [Column { name: "n".into(), kind: Kind::Integer }];
    let mut table = ParquetWriter::new(Vec::new(), &columns).unwrap();
    table.row(vec![Cell::Text("7".into())]).unwrap();
    let error = table.finish().unwrap_err().to_string();
    assert!(error.contains("column n"), "{error}");
}
