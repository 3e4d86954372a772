//! JSON: rows as objects under the keys of their columns.

use serde_json::{Map, Value};

use super::{Cell, Table};

impl Table {
    /// One object a row; numbers exact, what is missing null.
    pub fn json(&self) -> Vec<Value> {
        let object = |row: &Vec<Cell>| {
            let cells = self.columns.iter().zip(row);
            Value::Object(
                cells.map(|(c, cell)| (c.key.clone(), value(cell))).collect::<Map<_, _>>(),
            )
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
