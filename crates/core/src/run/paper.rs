//! The published PowerGS model: closed-form counts and three unit prices. It has no machine.

use powergs_frame::display::Display;
use toml::{Table, Value};

use super::error::RunError;
use super::files::{ConfigText, DiskFiles, FileKind, Files};
use super::input::Input;
use crate::sim::paper::UnitPrices;
use crate::stage::EnergyTable;
use crate::workload::paper::Padding;

/// The energy table of the model.
const TABLE: &str = "paper";

/// The model with its prices.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperModel {
    /// Unit prices.
    pub prices: UnitPrices,
    /// How odd image sizes are padded.
    pub padding: Padding,
    /// The display that shows the frames.
    pub display: Option<Display>,
    table: ConfigText,
    display_file: Option<ConfigText>,
}

impl PaperModel {
    /// The model with the table `paper` that comes with the program.
    ///
    /// # Errors
    /// [`RunError::Internal`]: the table is damaged.
    pub fn new(padding: Padding) -> Result<PaperModel, RunError> {
        let table = DiskFiles.read(FileKind::Energy, TABLE, None)?;
        let parsed = EnergyTable::parse(&table.text);
        let parsed = parsed.map_err(|e| RunError::Internal(format!("{TABLE}: {e}")))?;
        let Some([flop_pj, sram_pj_per_byte, dram_pj_per_byte]) = parsed.flat_pj() else {
            return Err(RunError::Internal("the table `paper` has no flat prices".to_owned()));
        };
        let prices = UnitPrices { flop_pj, sram_pj_per_byte, dram_pj_per_byte };
        Ok(PaperModel { prices, padding, display: None, table, display_file: None })
    }

    /// The energy table as it was read.
    pub fn table(&self) -> &ConfigText {
        &self.table
    }

    /// The same with the display that shows the frames.
    ///
    /// # Errors
    /// [`RunError::Config`]: an unknown name, or what is wrong in the file.
    pub fn with_display(mut self, name: &str, files: &dyn Files) -> Result<PaperModel, RunError> {
        let file = files.read(FileKind::Display, name, None)?;
        let display = Display::parse(&file.text);
        self.display = Some(display.map_err(|e| RunError::config(&file.origin, e))?);
        self.display_file = Some(file);
        Ok(self)
    }

    fn files(&self) -> impl Iterator<Item = (FileKind, &ConfigText)> {
        let display = self.display_file.iter().map(|file| (FileKind::Display, file));
        [(FileKind::Energy, &self.table)].into_iter().chain(display)
    }

    /// Hashes of the files as they were read.
    pub fn inputs(&self) -> Vec<Input> {
        let hash = |(kind, f): (FileKind, &ConfigText)| f.inputs(kind.role());
        self.files().flat_map(hash).collect()
    }

    /// Every file under its role.
    pub fn configuration(&self) -> Table {
        let entry = |(kind, file): (FileKind, &ConfigText)| {
            let table = file.text.parse().unwrap_or_default();
            (kind.role().to_owned(), Value::Table(table))
        };
        self.files().map(entry).collect()
    }
}
