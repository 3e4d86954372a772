//! The table: aggregates, failures, and the same numbers in both files.

use std::path::Path;

use powergs_core::flow;
use powergs_study::sweep::parquet::ParquetWriter;
use powergs_study::sweep::table::{
    Cell, Column, ColumnKind, PointFate, TableEntry, TraceLabel, columns, rows,
};

use super::outcome;

fn traces() -> [TraceLabel; 2] {
    [("room", 1.0), ("garden", 3.0)].map(|(l, weight)| TraceLabel { label: l.into(), weight })
}

fn entry(point: Option<u64>) -> TableEntry {
    let axes = vec![Cell::Integer(4), Cell::Text("64 KiB".into())];
    TableEntry {
        point,
        id: Some(0xabc),
        model: "banked",
        flow: flow::DEFAULT,
        axes,
        facts: vec![[None, Some(0.25), Some(64.0)]],
    }
}

fn axes() -> Vec<Column> {
    vec![
        Column { name: "vru.cores".into(), kind: ColumnKind::Integer },
        Column { name: "buffers.feature.capacity".into(), kind: ColumnKind::Text },
    ]
}

fn cell(row: &[Cell], name: &str) -> Cell {
    row[columns(&axes(), flow::DEFAULT).iter().position(|c| c.name == name).unwrap()].clone()
}

#[test]
fn a_row_per_trace_the_mean_and_the_worst() {
    let fates = [PointFate::Ok(outcome(&[1.0])), PointFate::Ok(outcome(&[3.0]))];
    let rows = rows(&entry(Some(9)), (0, "28nm"), &traces(), &fates);
    assert_eq!(rows.len(), 4);
    let times: Vec<Cell> = rows.iter().map(|r| cell(r, "frame_time_ms.mean")).collect();
    assert_eq!(times, [1.0, 3.0, 2.5, 3.0].map(Cell::Real));
    assert_eq!(cell(&rows[3], "trace"), Cell::Text("garden".into()));
    assert_eq!(cell(&rows[2], "trace"), Cell::Text(String::new()));
    assert_eq!(cell(&rows[0], "id"), Cell::Text(format!("{:032x}", 0xabc)));
    assert_eq!(cell(&rows[0], "point"), Cell::Integer(9));
    assert!(rows.iter().all(|row| row.len() == columns(&axes(), flow::DEFAULT).len()));
}

#[test]
fn a_failed_trace_is_never_averaged_away() {
    let fates = [PointFate::Ok(outcome(&[1.0])), PointFate::Failed("frame 3: broke".into())];
    let rows = rows(&entry(Some(9)), (0, "28nm"), &traces(), &fates);
    let of = |name: &str| rows.iter().map(|r| cell(r, name).text()).collect::<Vec<_>>();
    assert_eq!(of("status"), ["ok", "failed", "failed", "failed"]);
    assert_eq!(of("reason"), ["", "frame 3: broke", "frame 3: broke", "frame 3: broke"]);
    assert_eq!(of("energy_pj.mean"), ["10", "", "", ""]);
    let missing = [PointFate::Ok(outcome(&[1.0])), PointFate::Missing];
    let rows = super::table::rows(&entry(Some(9)), (0, "28nm"), &traces(), &missing);
    assert_eq!(cell(&rows[2], "status").text(), "missing");
}

/// `parquet.py` beside this folder holds the two files against each other with the readers that
/// people use; it
/// has to say so again before a new file is committed.
#[test]
fn parquet_holds_what_csv_says() {
    let columns = columns(&axes(), flow::DEFAULT);
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(columns.iter().map(|c| &c.name)).unwrap();
    let mut table = ParquetWriter::new(Vec::new(), &columns).unwrap();
    for point in [None, Some(0), Some(1)] {
        let second = match point {
            Some(0) => PointFate::Failed("frame 3: \"broke\", größer".into()),
            Some(1) => PointFate::Missing,
            _ => PointFate::Ok(outcome(&[0.1])),
        };
        let fates = [PointFate::Ok(outcome(&[1.0, 1.0 / 3.0])), second];
        for row in rows(&entry(point), (0, "28nm"), &traces(), &fates) {
            csv.write_record(row.iter().map(Cell::text)).unwrap();
            table.row(row).unwrap();
        }
    }
    let folder = Path::new("tests/golden/parquet");
    for (name, bytes) in
        [("table.csv", csv.into_inner().unwrap()), ("table.parquet", table.finish().unwrap())]
    {
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(folder.join(name), &bytes).unwrap();
        }
        assert!(bytes == std::fs::read(folder.join(name)).unwrap(), "{name} is another");
    }
}

#[test]
fn a_cell_of_another_kind_is_an_error() {
    let columns = [Column { name: "n".into(), kind: ColumnKind::Integer }];
    let mut table = ParquetWriter::new(Vec::new(), &columns).unwrap();
    table.row(vec![Cell::Text("7".into())]).unwrap();
    let error = table.finish().unwrap_err().to_string();
    assert!(error.contains("column n"), "{error}");
}
