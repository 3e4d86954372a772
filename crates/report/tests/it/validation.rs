//! `evidence/validation.md` and what `validate` prints.

use expect_test::expect_file;
use powergs_report::validate::{differences, document, page};
use powergs_study::validate::{Judged, Tables, judge};

#[test]
fn the_page_is_that_of_the_tables() {
    let tables = Tables::embedded();
    let of_baseline = |row| {
        let row: &powergs_study::validate::Row = row;
        let ours = tables.before(row);
        judge(row, ours, ours)
    };
    let judged: Vec<Judged> = tables.rows.iter().map(of_baseline).collect();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../evidence/validation.md");
    expect_file![path].assert_eq(&page(&tables, &judged));
    for line in document(&tables, &judged).terminal(80).lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }

    let model = tables.model.expect("the baseline says which");
    let text = page(&tables, &judged);
    let found = |text: &str, model| differences(text, &tables, &judged, model).join("\n");
    assert_eq!(found(&text, model), "");
    assert!(found(&text, model + 1).contains("not of model version"));
    let row = text.lines().find(|line| line.starts_with("| `gscore-area` |")).unwrap();
    assert!(found(&text.replace(row, ""), model).contains("gscore-area"));
    let worse = row.replace("| 3.95 |", "| 3.94 |");
    assert_eq!(found(&text.replace(row, &worse), model).lines().count(), 3);
}
