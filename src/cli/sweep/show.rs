//! `sweep show`: one design of a sweep: its values, the commands of its row, its machine file.

use std::fs;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::args::ShowArgs;
use super::confirm;
use super::meter::Meter;
use super::parts::interrupted;
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_base::shell;
use powergs_core::machine::DramModel;
use powergs_core::run::FileStore;
use powergs_study::analysis::Confirmation;
use powergs_study::sweep::design::Design;
use powergs_study::sweep::run::parts::{FoundDesign, find, reopen};
use powergs_study::sweep::run::{HandedDesign, HandedRow, OpenedSweep};
use powergs_study::sweep::table::{Cell, FIRST};

/// A design of a sweep with its cells in the columns of the axes.
struct ShownDesign<'a> {
    sweep: &'a OpenedSweep<'static>,
    point: Option<u64>,
    design: &'a Design,
    cells: Vec<(String, Cell)>,
    /// Label of the energy table of the row that is shown.
    table: String,
    /// The model of the DRAM of that row.
    model: &'static str,
}

/// `sweep show`.
///
/// # Errors
/// Exit code 2 or 3: a folder that holds no sweep, or one whose files have changed; a design that
/// is not there.
pub fn show(args: &ShowArgs, context: &Context) -> Result<Exit, Failure> {
    let sweep = reopen(&FileStore::new(&args.folder))?;
    let place = args.folder.display().to_string();
    let found = find(&sweep.designs, &args.id, &place, &Meter::new(context))?;
    let FoundDesign::Found(point, design) = found else { return Err(interrupted()) };
    let names = sweep.designs.columns().iter().map(|column| column.name.clone());
    let shown = ShownDesign {
        cells: names.zip(sweep.designs.cells(point)).collect(),
        table: sweep.designs.tables().into_iter().next().unwrap_or_default(),
        model: model(&sweep, point, &design, &args.folder),
        sweep: &sweep,
        point,
        design: &design,
    };
    if args.toml {
        out::text(&shown.machine_file()?)?;
    } else if context.global.json {
        out::json(&shown.json())?;
    } else {
        out::text(&shown.text())?;
    }
    Ok(Exit::Done)
}

/// The model of the DRAM of the row of a design: `banked` where it was confirmed.
fn model(
    sweep: &OpenedSweep<'_>,
    point: Option<u64>,
    design: &Design,
    folder: &Path,
) -> &'static str {
    let noted = fs::read(folder.join(confirm::JSON)).ok();
    let noted = noted.and_then(|text| serde_json::from_slice::<Confirmation>(&text).ok());
    let is_confirmed = noted.is_some_and(|all| {
        point.is_none_or(|point| all.designs.iter().any(|design| design.point == point))
    });
    match is_confirmed && sweep.banked.is_some() {
        true => DramModel::Banked.name(),
        false => design.machine.dram.model.name(),
    }
}

impl ShownDesign<'_> {
    fn handed(&self) -> HandedTexts {
        let own = self.cells.iter().filter(|(name, _)| !name.ends_with(".si"));
        let cells: Vec<(String, String)> =
            own.map(|(name, cell)| (name.clone(), cell.text())).collect();
        let cells = cells.iter().map(|(name, text)| (name.as_str(), text.as_str()));
        let cells = if self.point.is_some() { cells.collect() } else { Vec::new() };
        let design = HandedDesign { point: self.point, cells };
        let row = HandedRow { table: &self.table, model: self.model, trace: None };
        let Some(hand_out) = &self.sweep.hand_out else { return HandedTexts::default() };
        let others = hand_out.design(&design, row.table).others;
        HandedTexts {
            commands: hand_out.commands(&design, row).iter().map(shell::line).collect(),
            together: hand_out.together(None),
            head: hand_out.head(row, &others),
        }
    }

    /// The machine file of a design, with the model of the DRAM that its base has. Above it stand
    /// what it is, how it gives its row, and the keys of other files that the sweep changes.
    fn machine_file(&self) -> Result<String, Failure> {
        let name = self.point.map_or("Baseline".to_owned(), |p| format!("Point {p}"));
        let (sweep, id) = (&self.sweep.name, self.design.id);
        let mut text = format!("# {name} of the sweep `{sweep}`, {id:032x}.\n");
        for (name, cell) in &self.cells {
            if name.contains(':') {
                text += &format!("# In another file: {name} = {}\n", cell.text());
            } else if !name.ends_with(".si") {
                text += &format!("# {name} = {}\n", cell.text());
            }
        }
        text += "# Its row:\n";
        self.handed().head.iter().for_each(|line| text += &format!("{line}\n"));
        let hand_out = self.sweep.hand_out.as_ref();
        let has_other_model = hand_out.is_some_and(|hand_out| hand_out.has_other_model);
        let machine = match &self.sweep.banked {
            Some(banked) if has_other_model => {
                let own = banked.design(self.point).or_exit(Exit::Internal, "the design")?;
                own.resolved_machine_toml()
            }
            Some(_) | None => self.design.resolved_machine_toml(),
        };
        Ok(text + "\n" + &machine)
    }

    fn json(&self) -> Value {
        let settings: Map<String, Value> =
            self.cells.iter().map(|(name, cell)| (name.clone(), json_of(cell))).collect();
        let handed = self.handed();
        json!({
            FIRST[0].0: self.point,
            "id": format!("{:032x}", self.design.id),
            "settings": settings,
            "dram_model": self.model,
            "commands": handed.commands,
        })
    }

    fn text(&self) -> String {
        let name = self.point.map_or("baseline".to_owned(), |p| p.to_string());
        let mut text = format!("point  {name}\nid     {:032x}\n\n", self.design.id);
        let width = self.cells.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, cell) in &self.cells {
            text += &format!("{name:width$}  {}\n", cell.text());
        }
        let HandedTexts { commands, together, .. } = self.handed();
        if !commands.is_empty() {
            text += &format!("\nIts row, of the DRAM model {}:\n", self.model);
            commands.iter().for_each(|line| text += &format!("  {line}\n"));
        }
        if !together.is_empty() {
            text += &format!("{together}\n");
        }
        text + "\nIts machine file: --toml\n"
    }
}

/// What is handed out of a design, as lines.
#[derive(Default)]
struct HandedTexts {
    commands: Vec<String>,
    together: String,
    head: Vec<String>,
}

fn json_of(cell: &Cell) -> Value {
    match cell {
        Cell::Empty => Value::Null,
        Cell::Text(text) => json!(text),
        Cell::Integer(n) => json!(n),
        Cell::Real(x) => json!(x),
        Cell::Truth(yes) => json!(yes),
    }
}
