//! JSON: blocks in order, rows as objects under the keys of their columns.

use serde_json::{Map, Value, json};

use super::{Block, Cell, Document, Table, Text};

impl Document {
    /// The blocks of the page, one object each, under the name of what they are. Numbers are exact,
    /// charts are named.
    pub fn json(&self) -> Vec<Value> {
        let shown = self.blocks.iter().filter(|(shown, _)| shown.on_page());
        shown.map(|(_, block)| object(block)).collect()
    }
}

fn object(block: &Block) -> Value {
    match block {
        Block::Title(text) => json!({ "title": text.plain() }),
        Block::Heading(text) => json!({ "heading": text.plain() }),
        Block::Paragraph(text) => json!({ "paragraph": text.plain() }),
        Block::Quote(text) => json!({ "quote": text.plain() }),
        Block::List(items) => json!({ "list": items.iter().map(Text::plain).collect::<Vec<_>>() }),
        Block::Facts(facts) => {
            let fact = |(name, text): &(String, Text)| (name.clone(), text.plain().into());
            json!({ "facts": facts.iter().map(fact).collect::<Map<_, _>>() })
        }
        Block::Verbatim(text) => json!({ "verbatim": text }),
        Block::Table(table) => json!({ "table": table.json() }),
        Block::Chart(chart) => json!({ "chart": chart.name, "title": chart.title }),
        Block::Designs(_) | Block::BeforeAfter(_) => Value::Null,
    }
}

impl Table {
    /// One object a row; numbers exact, what is missing null.
    pub fn json(&self) -> Vec<Value> {
        let object = |row: &Vec<Cell>| {
            let cells = self.columns.iter().zip(row);
            Value::Object(cells.map(|(c, cell)| (c.key.clone(), value(cell))).collect())
        };
        self.rows.iter().map(object).collect()
    }
}

fn value(cell: &Cell) -> Value {
    match cell {
        Cell::Missing | Cell::Empty => Value::Null,
        Cell::Words(text) => text.plain().into(),
        Cell::Count(n) => (*n).into(),
        Cell::Real(x) => (*x).into(),
        Cell::Flag(yes) => (*yes).into(),
    }
}
