//! SRAM banks as CACTI 7 builds them: energy, leakage and area by size, word, ports, cell and node.
//!
//! The rows are `arch-configs/sram/cacti-7.csv`. Rows of one word width form a column, interpolated
//! linearly in the logarithms of size and value; between the two nearest columns that reach the
//! size, everything is linear in the width of the word. A bank with a read and a write port costs
//! what a single-ported one costs times the ratio of the rows that exist with both kinds of ports
//! (LOP cells, 32-byte words). Leakage at another temperature than 350 K is scaled by the ratio of
//! the rows that exist at both temperatures.

use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::config::embedded::CACTI;

/// Transistors of the cells and of the periphery, after the ITRS classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Cell {
    /// High performance.
    Hp,
    /// Low operating power.
    Lop,
    /// Low standby power.
    Lstp,
    /// Low standby power cells, low operating power periphery.
    LstpLop,
}

impl Cell {
    const fn classes(self) -> (&'static str, &'static str) {
        match self {
            Cell::Hp => ("hp", "hp"),
            Cell::Lop => ("lop", "lop"),
            Cell::Lstp => ("lstp", "lstp"),
            Cell::LstpLop => ("lstp", "lop"),
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Cell::Hp => "hp",
            Cell::Lop => "lop",
            Cell::Lstp => "lstp",
            Cell::LstpLop => "lstp-lop",
        }
    }

    const ALL: [Cell; 4] = [Cell::Hp, Cell::Lop, Cell::Lstp, Cell::LstpLop];
}

/// How many times a bank may be smaller or larger than the rows where extrapolation is allowed.
const BEYOND: u64 = 4;

/// Temperature of the rows, kelvin.
const RUN_AT: u32 = 350;

/// The prices of one bank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bank {
    /// Energy of reading one word, picojoules.
    pub read_pj: f64,
    /// Energy of writing one word, picojoules.
    pub write_pj: f64,
    /// Leakage, watts.
    pub leakage_w: f64,
    /// Area, mm².
    pub area_mm2: f64,
}

/// The order of a row's values: read, write, leakage, area.
type CactiValues = [f64; 4];

#[derive(Debug, Clone)]
struct CactiRow {
    node_nm: f64,
    classes: (String, String),
    two_ports: bool,
    kelvin: u32,
    size: u64,
    word: u64,
    values: CactiValues,
}

fn rows() -> &'static [CactiRow] {
    static ROWS: OnceLock<Vec<CactiRow>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let data = CACTI.lines().filter(|l| !l.starts_with('#')).skip(1);
        data.map(|line| row(line).unwrap_or_else(|| panic!("cacti-7.csv: {line}"))).collect()
    })
}

fn row(line: &str) -> Option<CactiRow> {
    let fields: Vec<&str> = line.split(',').collect();
    let [node, cell, periphery, ports, kelvin, size, word, read, write, leakage, area] =
        fields.try_into().ok()?;
    Some(CactiRow {
        node_nm: node.parse().ok()?,
        classes: (cell.to_owned(), periphery.to_owned()),
        two_ports: ports == "1r1w",
        kelvin: kelvin.parse().ok()?,
        size: size.parse().ok()?,
        word: word.parse().ok()?,
        values: [
            read.parse().ok()?,
            write.parse().ok()?,
            leakage.parse::<f64>().ok()? * 1e-3,
            area.parse().ok()?,
        ],
    })
}

/// Rows of one word width, ascending in size.
#[derive(Debug, Clone)]
struct CactiColumn {
    word: u64,
    points: Vec<(u64, CactiValues)>,
}

impl CactiColumn {
    fn reaches(&self, size: u64) -> bool {
        let (least, most) = self.ends();
        (least..=most).contains(&size)
    }

    fn ends(&self) -> (u64, u64) {
        (self.points[0].0, self.points[self.points.len() - 1].0)
    }

    /// The values at a size; beyond its ends, on the line through the two rows there.
    fn at(&self, size: u64) -> CactiValues {
        if self.points.len() == 1 {
            return self.points[0].1;
        }
        let above = self.points.partition_point(|p| p.0 < size);
        let high = above.clamp(1, self.points.len() - 1);
        let ((a, low), (b, high)) = (self.points[high - 1], self.points[high]);
        if size == a {
            return low;
        }
        if size == b {
            return high;
        }
        let log = |bytes: u64| (bytes as f64).ln();
        let t = (log(size) - log(a)) / (log(b) - log(a));
        std::array::from_fn(|i| (low[i].ln() * (1.0 - t) + high[i].ln() * t).exp())
    }
}

/// The banks of one node and cell.
#[derive(Debug, Clone)]
pub struct Macros {
    columns: Vec<CactiColumn>,
    /// What two ports cost beyond one, by size.
    two_ports: (CactiColumn, CactiColumn),
    /// Leakage at the wanted temperature over that at 350 K.
    warmth: f64,
}

/// A bank that the rows do not reach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outside {
    /// Smallest and largest bank, bytes.
    pub sizes: (u64, u64),
    /// Narrowest and widest word at the size that was asked for, bytes; `None` if there is none.
    pub words: Option<(u64, u64)>,
}

impl Macros {
    /// The banks of a node and cell, at a temperature.
    ///
    /// # Errors
    /// What there is instead, in one line.
    pub fn new(node_nm: f64, cell: Cell, kelvin: u32) -> Result<Macros, String> {
        let (cells, periphery) = cell.classes();
        let of = |node_nm: f64, two_ports: bool, kelvin: u32| {
            let mine = rows().iter().filter(move |r| {
                (r.classes.0.as_str(), r.classes.1.as_str()) == (cells, periphery)
                    && (r.node_nm, r.two_ports, r.kelvin) == (node_nm, two_ports, kelvin)
            });
            columns(mine)
        };
        let columns_350 = of(node_nm, false, RUN_AT);
        if columns_350.is_empty() {
            return Err(format!(
                "there are no rows for {} cells at {node_nm} nm: {}",
                cell.name(),
                known()
            ));
        }
        let warmth = match kelvin {
            RUN_AT => 1.0,
            _ => warmth(&columns_350, &of(node_nm, false, kelvin)).ok_or_else(|| {
                let there = rows().iter().filter(|r| {
                    (r.classes.0.as_str(), r.classes.1.as_str()) == (cells, periphery)
                        && r.node_nm == node_nm
                });
                let mut there: Vec<u32> = there.map(|r| r.kelvin).collect();
                there.sort_unstable();
                there.dedup();
                let there: Vec<String> = there.iter().map(|k| format!("{k} K")).collect();
                format!("there are no rows at {kelvin} K: {}", there.join(", "))
            })?,
        };
        let pair = columns(rows().iter().filter(|r| r.two_ports)).remove(0);
        let (node, classes) = (28.0, ("lop", "lop"));
        let single = rows().iter().filter(|r| {
            (r.node_nm, r.two_ports, r.kelvin, r.word) == (node, false, RUN_AT, pair.word)
                && (r.classes.0.as_str(), r.classes.1.as_str()) == classes
        });
        let single = columns(single).remove(0);
        Ok(Macros { columns: columns_350, two_ports: (single, pair), warmth })
    }

    /// The prices of a bank of `size` bytes with words of `word` bytes.
    ///
    /// # Errors
    /// A size or word that the rows do not reach, unless `beyond` allows it: sizes up to four times
    /// outside then follow the last two rows, and words the nearest width (a narrower word costs as
    /// much as that; a wider one is several smaller banks side by side).
    pub fn bank(&self, size: u64, word: u64, two: bool, beyond: bool) -> Result<Bank, Outside> {
        let mut reach: Vec<&CactiColumn> =
            self.columns.iter().filter(|c| c.reaches(size)).collect();
        let ends = |of: &[&CactiColumn]| Some((of.first()?.word, of.last()?.word));
        let words = ends(&reach);
        if !words.is_some_and(|(least, most)| (least..=most).contains(&word)) {
            let (least, most) = self.sizes();
            let near = (least.div_ceil(BEYOND)..=most * BEYOND).contains(&size);
            if !beyond || !near || word == 0 {
                return Err(Outside { sizes: self.sizes(), words });
            }
            if reach.is_empty() {
                reach = self.columns.iter().collect();
            }
        }
        let mut values = between(&reach, size, word);
        if two {
            let (single, pair) = (self.two_ports.0.at(size), self.two_ports.1.at(size));
            values = std::array::from_fn(|i| values[i] * pair[i] / single[i]);
        }
        let [read_pj, write_pj, leakage, area_mm2] = values;
        Ok(Bank { read_pj, write_pj, leakage_w: leakage * self.warmth, area_mm2 })
    }

    fn sizes(&self) -> (u64, u64) {
        let ends = self.columns.iter().map(CactiColumn::ends);
        ends.fold((u64::MAX, 0), |(a, b), (c, d)| (a.min(c), b.max(d)))
    }
}

/// Linear in the width of the word between the nearest columns.
fn between(columns: &[&CactiColumn], size: u64, word: u64) -> CactiValues {
    let above = columns.partition_point(|c| c.word < word);
    let last = columns[columns.len() - 1];
    if above == columns.len() {
        let beside = word.div_ceil(last.word);
        return last.at((size / beside).max(1)).map(|x| x * beside as f64);
    }
    let high = columns[above];
    if above == 0 || high.word == word {
        return high.at(size);
    }
    let low = columns[above - 1];
    let t = (word - low.word) as f64 / (high.word - low.word) as f64;
    let (a, b) = (low.at(size), high.at(size));
    std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t)
}

fn columns<'a>(rows: impl Iterator<Item = &'a CactiRow>) -> Vec<CactiColumn> {
    let mut columns: Vec<CactiColumn> = Vec::new();
    for row in rows {
        let point = (row.size, row.values);
        match columns.iter_mut().find(|c| c.word == row.word) {
            Some(column) => column.points.push(point),
            None => columns.push(CactiColumn { word: row.word, points: vec![point] }),
        }
    }
    columns.sort_by_key(|c| c.word);
    columns.iter_mut().for_each(|c| c.points.sort_by_key(|p| p.0));
    columns
}

/// Geometric mean of the leakage of the rows that both have.
fn warmth(at_350: &[CactiColumn], other: &[CactiColumn]) -> Option<f64> {
    let mut logs = Vec::new();
    for column in other {
        let Some(same) = at_350.iter().find(|c| c.word == column.word) else { continue };
        for (size, values) in &column.points {
            let there = same.points.iter().find(|p| p.0 == *size);
            logs.extend(there.map(|(_, hot)| (values[2] / hot[2]).ln()));
        }
    }
    (!logs.is_empty()).then(|| (logs.iter().sum::<f64>() / logs.len() as f64).exp())
}

/// The nodes and cells that have rows.
fn known() -> String {
    let mut known: Vec<String> = Vec::new();
    for row in rows().iter().filter(|r| r.kelvin == RUN_AT && !r.two_ports) {
        let mine = |c: &&Cell| c.classes() == (row.classes.0.as_str(), row.classes.1.as_str());
        let cell = Cell::ALL.iter().find(mine).map_or("?", |c| c.name());
        let text = format!("{cell} at {} nm", row.node_nm);
        if !known.contains(&text) {
            known.push(text);
        }
    }
    known.join(", ")
}
