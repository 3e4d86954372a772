//! Half a page on a machine for whoever has to judge numbers of it: its files, its prices and
//! assumptions, and which published numbers are held against it.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::document::{Block, Cell, Column, Document, Shown, Table, Text};
use crate::validate::{headline, rows, rows_json};
use powergs_base::config::assumptions::assumptions;
use powergs_base::config::references::references;
use powergs_base::format::counted;
use powergs_study::validate::{Gap, HeldRows, Judged, Status};

/// What is known of a machine without simulating it.
#[derive(Debug, Clone)]
pub struct Certificate {
    /// What the machine is called.
    pub machine: String,
    /// Its file and the files that this is based on, the nearest first.
    pub files: Vec<CertifiedFile>,
    /// The name of the file where it comes with the program.
    pub shipped: Option<String>,
    /// What a file of the user is based on, where that comes with the program.
    pub base: Option<CertifiedBase>,
    /// Which build says all this.
    pub program: CertifiedBuild,
    /// Its energy table.
    pub energy: CertifiedPrices,
    /// Its DRAM: the model, and the device where it has one.
    pub memory: String,
    /// Assumption numbers that its files cite.
    pub assumptions: Vec<String>,
    /// Keys of publications that its files cite.
    pub sources: Vec<String>,
}

/// A file with the hash of its contents.
#[derive(Debug, Clone)]
pub struct CertifiedFile {
    /// Its role: machine, energy, dram.
    pub role: &'static str,
    /// Its name, or its path.
    pub name: String,
    /// xxh3, 128 bits.
    pub xxh3: u128,
}

/// What a machine of the user is based on.
#[derive(Debug, Clone)]
pub struct CertifiedBase {
    /// A machine that comes with the program.
    pub name: String,
    /// Keys that differ, with what the base has and what the machine has; `None` where one has no
    /// such key.
    pub changed: Vec<(String, [Option<String>; 2])>,
}

/// A build of the program.
#[derive(Debug, Clone)]
pub struct CertifiedBuild {
    /// Version of the program.
    pub version: String,
    /// Its commit.
    pub commit: String,
    /// Version of its models.
    pub models: u32,
    /// Version of the models that the stored values came out of.
    pub stored: Option<u32>,
}

/// What prices a machine.
#[derive(Debug, Clone)]
pub struct CertifiedPrices {
    /// Name of the energy table.
    pub name: String,
    /// Its technology node.
    pub node: Option<String>,
    /// Keys of publications that it cites.
    pub sources: Vec<String>,
}

/// Said where nothing is held against a machine.
const NOTHING: &str = "No published number is held against this file; nothing here is evidence.";

impl Certificate {
    /// The page, with the rows that are held against the machine, or against its base where it is
    /// a file of the user.
    pub fn document(&self, held: &HeldRows) -> Document {
        let mut page = Document::new();
        page.title(format!("Certificate of {}", self.machine));
        page.facts(self.facts());
        self.differences(&mut page);
        page.heading("Published numbers");
        match (&self.shipped, &self.base) {
            (Some(_), _) => self.evidence(&mut page, held),
            (None, base) => {
                page.paragraph(NOTHING);
                if let Some(base) = base {
                    page.paragraph(of_base(&base.name, held));
                }
            }
        }
        if !self.assumptions.is_empty() {
            let known = assumptions();
            let item = |name: &String| {
                let number = name[1..].parse().ok();
                let text = number.and_then(|n: u32| known.get(&n)).map(|a| a.text.as_str());
                Text::code(name.as_str()).then(text.map_or(String::new(), |t| format!(": {t}")))
            };
            page.page_heading("Assumptions");
            page.on(Shown::Page, Block::List(self.assumptions.iter().map(item).collect()));
        }
        let sources: Vec<Text> = self.sources.iter().filter_map(|key| source(key)).collect();
        if !sources.is_empty() {
            page.page_heading("Sources");
            page.on(Shown::Page, Block::List(sources));
        }
        page
    }

    fn facts(&self) -> Vec<(&'static str, Text)> {
        let mut facts: Vec<(&'static str, Text)> = Vec::new();
        for file in &self.files {
            let text = format!("{}, xxh3 {:032x}", file.name, file.xxh3);
            facts.push((file.role, text.into()));
        }
        let CertifiedBuild { version, commit, models, .. } = &self.program;
        let program = format!("powergs-sim {version}, models {models}, commit {commit}");
        facts.push(("program", program.into()));
        let node = self.energy.node.as_ref().map_or("node not said".to_owned(), Clone::clone);
        let by = match self.energy.sources.is_empty() {
            true => "no sources".to_owned(),
            false => self.energy.sources.join(", "),
        };
        facts.push(("prices", format!("{}, {node}: {by}", self.energy.name).into()));
        facts.push(("memory", self.memory.as_str().into()));
        let assumed = match self.assumptions.is_empty() {
            true => "none cited".to_owned(),
            false => {
                format!("{} ({})", self.assumptions.join(" "), "`powergs-sim explain A1`, …")
            }
        };
        facts.push(("assumptions", Text::marked(&assumed)));
        facts
    }

    /// How a file of the user differs from what it is based on.
    fn differences(&self, page: &mut Document) {
        if self.shipped.is_some() {
            return;
        }
        let Some(base) = &self.base else {
            page.paragraph("The file is based on no machine that comes with the program.");
            return;
        };
        let keys = counted(base.changed.len(), "key");
        page.paragraph(format!("Differs from its base, {}, in {keys}:", base.name));
        let cell = |value: &Option<String>| Cell::from(value.clone().unwrap_or_else(|| "-".into()));
        let columns =
            [Column::text("key"), Column::text("base").wraps(), Column::text("value").wraps()];
        let row = |(key, [then, now]): &(String, [Option<String>; 2])| {
            [Cell::from(key.as_str()), cell(then), cell(now)]
        };
        page.table(Table::new(columns).rows(base.changed.iter().map(row)));
    }

    fn evidence(&self, page: &mut Document, held: &HeldRows) {
        if held.rows.is_empty() {
            page.paragraph(NOTHING);
        } else {
            let n = counted(held.rows.len(), "row");
            page.paragraph(format!("{n}: {}.", counts(&held.rows)));
            match held.headline() {
                Some(judged) => page.paragraph(format!("Missed most: {}.", headline(judged))),
                None => page.paragraph("No rate, power or energy of whole frames is missed."),
            }
            page.table(rows("row", &held.rows));
        }
        if !held.variants.is_empty() {
            let n = counted(held.variants.len(), "row");
            page.paragraph(format!(
                "With other keys than in this file: {n}, {}.",
                counts(&held.variants)
            ));
        }
        if !held.against.is_empty() {
            page.paragraph(format!(
                "On the other side of a comparison: {}.",
                counted(held.against.len(), "row")
            ));
        }
        page.paragraph(Text::marked(&self.stored()));
    }

    /// Where the numbers of ours are from.
    fn stored(&self) -> String {
        let CertifiedBuild { models, stored, .. } = &self.program;
        let mut text = "Nothing was simulated for this page: ours are the values that come with \
                        the program"
            .to_owned();
        match stored {
            Some(stored) if stored == models => {
                let _ = write!(text, ", of model version {stored}, which is its own");
            }
            Some(stored) => {
                let _ =
                    write!(text, ", of model version {stored}; its models are version {models}");
            }
            None => text.push_str(", of an unknown model version"),
        }
        text.push_str(". `powergs-sim validate` measures them anew.");
        text
    }

    /// The same as JSON.
    pub fn json(&self, held: &HeldRows) -> Value {
        let file = |file: &CertifiedFile| {
            let hash = format!("{:032x}", file.xxh3);
            json!({ "role": file.role, "name": file.name, "xxh3_128": hash })
        };
        let changed = |(key, values): &(String, [Option<String>; 2])| {
            let [base, value] = values;
            json!({ "key": key, "base": base, "value": value })
        };
        let (program, energy) = (&self.program, &self.energy);
        let base = self.base.as_ref().map(|base| {
            let keys: Vec<Value> = base.changed.iter().map(changed).collect();
            json!({ "name": base.name, "changed": keys, "rows": held.rows.len() })
        });
        let own = self.shipped.is_some();
        let of = |rows: &[Judged]| if own { rows_json(rows) } else { Vec::new() };
        let headline = held.headline().filter(|_| own).map(|judged| {
            json!({
                "id": judged.row.id,
                "deviation": judged.deviation(),
                "text": headline(judged),
            })
        });
        let against: Vec<&str> = held.against.iter().map(|row| row.id.as_str()).collect();
        json!({
            "machine": self.machine,
            "shipped": self.shipped,
            "files": self.files.iter().map(file).collect::<Vec<_>>(),
            "program": {
                "version": program.version,
                "commit": program.commit,
                "model_version": program.models,
            },
            "energy": { "name": energy.name, "node": energy.node, "sources": energy.sources },
            "memory": self.memory,
            "assumptions": self.assumptions,
            "sources": self.sources,
            "base": base,
            "stored_model_version": program.stored,
            "is_evidence": own && held.rows.iter().any(|j| j.row.status == Status::Enforced),
            "headline": headline,
            "rows": of(&held.rows),
            "variants": of(&held.variants),
            "against": if own { against } else { Vec::new() },
        })
    }
}

/// What is held against the machine that a file of the user is based on.
fn of_base(name: &str, held: &HeldRows) -> String {
    if held.rows.is_empty() {
        return format!("Nor is any against {name}.");
    }
    let missed = held.headline().map_or(String::new(), |j| format!(" It misses {}.", headline(j)));
    format!(
        "Against {name} as it comes with the program: {}.{missed} They say nothing of the keys \
         above; powergs-sim certificate {name} lists them.",
        counts(&held.rows)
    )
}

/// How many rows there are of each status, and how many of them hold.
fn counts(judged: &[Judged]) -> String {
    let of = |status: Status| judged.iter().filter(move |j| j.row.status == status);
    let mut parts = Vec::new();
    for status in [Status::Enforced, Status::Calibrated, Status::Plausibility] {
        let all = of(status).count();
        let near = of(status).filter(|j| j.holds()).count();
        if all > 0 {
            parts.push(format!("{} {near} of {all} within tolerance", status.name()));
        }
    }
    let gaps = Gap::ALL.map(|gap| (gap.name(), of(Status::KnownGap(gap)).count()));
    let gaps: Vec<String> =
        gaps.iter().filter(|(_, n)| *n > 0).map(|(name, n)| format!("{name} {n}")).collect();
    if !gaps.is_empty() {
        parts.push(format!("known gaps: {}", gaps.join(", ")));
    }
    let dropped = of(Status::Dropped).count();
    if dropped > 0 {
        parts.push(format!("dropped {dropped}"));
    }
    parts.join("; ")
}

/// A publication with its address.
fn source(key: &str) -> Option<Text> {
    let source = references().get(key)?;
    Some(Text::link(source.title.as_str(), source.link()).then(format!(", {}", source.venue)))
}
