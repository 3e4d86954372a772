//! One document, five writers.

use powergs_chart::Format;
use proptest::prelude::*;

use powergs_report::document::{
    Block, Cell, Column, DesignColumn, DesignValue, Document, Kind, PageDesigns, Shown, Table, Text,
};
use serde_json::json;

fn machines() -> Table {
    let percent = |x: f64| format!("{:.0} %", 100.0 * x);
    let columns = [
        Column::text("machine").key("name"),
        Column::real("ms").key("frame_time_ms").group("a frame"),
        Column::fixed("mJ", 1).key("energy_mj").group("a frame"),
        Column::new("bus", Kind::Real(percent)).key("busy_frac").on(Shown::Page),
        Column::text("fits").key("fits"),
    ];
    let mut table = Table::new(columns);
    table.row(["gscore".into(), 3.25125.into(), 2.0.into(), 0.25.into(), true.into()]);
    table.row(["a|b, \"c\"".into(), Cell::Missing, 10.25.into(), Cell::Empty, false.into()]);
    table
}

#[test]
fn a_table_has_one_meaning_in_every_format() {
    let table = machines();
    assert_eq!(
        String::from_utf8_lossy(&table.csv()),
        "name,frame_time_ms,energy_mj,busy_frac,fits\ngscore,3.25125,2.0,0.25,true\n\
         \"a|b, \"\"c\"\"\",,10.2,,false\n"
    );
    assert_eq!(
        table.json(),
        [
            json!({"name": "gscore", "frame_time_ms": 3.25125, "energy_mj": 2.0,
                "busy_frac": 0.25, "fits": true}),
            json!({"name": "a|b, \"c\"", "frame_time_ms": null, "energy_mj": 10.25,
                "busy_frac": null, "fits": false}),
        ]
    );
    assert_eq!(
        table.markdown(),
        "| machine | a frame: ms | a frame: mJ | bus | fits |\n|---|--:|--:|--:|---|\n\
         | gscore | 3.25 | 2.0 | 25 % | yes |\n| a\\|b, \"c\" | - | 10.2 |  | no |\n"
    );
    assert_eq!(
        table.terminal(80),
        "             a frame\nmachine     ms    mJ  fits\ngscore    3.25   2.0  yes\n\
         a|b, \"c\"     -  10.2  no\n"
    );
}

#[test]
fn text_from_files_cannot_start_markup() {
    let mut page = Document::new();
    page.title("<b> *x* # `y`");
    page.paragraph(Text::marked("Our `a|b` and **this**, then ").then("<i>theirs</i> | `z`"));
    page.add(Block::List(vec![Text::code("tick`s")]));
    let markdown = page.markdown(Format::Png);
    assert!(markdown.starts_with("# \\<b> \\*x\\* # \\`y\\`\n\n"), "{markdown}");
    assert!(markdown.contains("Our `a|b` and **this**, then \\<i>theirs"), "{markdown}");
    assert!(markdown.ends_with("- `tick's`\n"), "{markdown}");
    let hostile = "</script><i>&".to_owned();
    let rows = vec![vec![Some(DesignValue::Text(hostile.clone()))]];
    let column = DesignColumn { name: hostile.clone(), ..DesignColumn::default() };
    let designs = PageDesigns {
        columns: vec![column],
        names: vec![(hostile, true)],
        rows,
        ..PageDesigns::default()
    };
    page.on(Shown::Screen, Block::Designs(designs));
    let html = page.html().expect("no chart");
    assert!(html.contains("<title>&lt;b&gt; *x* # `y`</title>"), "{html}");
    assert_eq!(html.matches("</script>").count(), 2, "{html}");
    assert_eq!(markdown, page.markdown(Format::Png), "on screens alone");
    assert!(html.contains("<code>a|b</code> and <strong>this</strong>"), "{html}");
    assert!(!html.contains("<i>"), "{html}");
}

#[test]
fn sentences_take_several_lines() {
    let columns = [Column::text("name"), Column::text("what it is").wraps()];
    let table = Table::new(columns).rows([
        ["one".into(), "a sentence that is longer than there is room".into()],
        ["two".into(), "short".into()],
    ]);
    let narrow = "name  what it is\none   a sentence that is\n      longer than there is\n      \
                  room\ntwo   short\n";
    assert_eq!(table.terminal(26), narrow);
    let wide = "name  what it is\none   a sentence that is longer than there is room\n\
                two   short\n";
    assert_eq!(table.terminal(80), wide);
}

#[test]
fn names_from_files_cannot_steer_the_terminal() {
    let mut page = Document::new();
    page.title("a\x1b[2Jb");
    page.facts([("file\x07", "c\rd")]);
    page.table(Table::new([Column::text("name")]).rows([["e\x1bf".into()]]));
    assert_eq!(page.terminal(80), "a?[2Jb\nfile?  c d\n\nname\ne?f\n");
}

#[test]
fn blocks_are_shown_where_they_belong() {
    let mut page = Document::new();
    page.on(Shown::Page, Block::Heading("only on pages".into()));
    page.on(Shown::Terminal, Block::Facts(vec![("report".into(), "here".into())]));
    page.table(Table::new([Column::text("empty")]));
    page.paragraph("");
    assert_eq!(page.terminal(80), "report  here\n");
    assert_eq!(page.markdown(Format::Png), "## only on pages\n");
    page.facts([("model", "cycle")]);
    page.table(machines());
    let json = page.json();
    assert_eq!(json[0], json!({ "heading": "only on pages" }));
    assert_eq!(json[1], json!({ "facts": { "model": "cycle" } }));
    assert_eq!(json[2]["table"][0]["frame_time_ms"], 3.25125);
    assert_eq!(page.tables().count(), 1, "a table without rows is left out");
}

proptest! {
    #[test]
    fn no_line_is_wider_than_the_terminal(
        width in 40_usize..160,
        words in proptest::collection::vec("[a-m ]{0,60}", 1..6),
        numbers in 1_usize..12,
    ) {
        let mut columns: Vec<Column> = vec![Column::text("name"), Column::text("what")];
        columns.extend((0..numbers).map(|i| Column::real(format!("n{i:02}")).group("group")));
        let mut table = Table::new(columns);
        for word in &words {
            let first = [Cell::from(word.as_str()), Cell::from(word.as_str())];
            let rest = (0..numbers).map(|i| Cell::Real(1.5 * i as f64));
            table.row(first.into_iter().chain(rest));
        }
        let text = table.terminal(width);
        for line in text.lines() {
            prop_assert!(line.chars().count() <= width, "{width}: {line}");
            prop_assert_eq!(line, line.trim_end());
        }
        // Every number is somewhere, below each other or not.
        for i in 0..numbers {
            prop_assert_eq!(text.matches(&format!("n{i:02}")).count(), 1);
        }
    }
}
