//! The configuration files that come with the program, found by name.

use super::layer;

/// A file of `arch-configs/`, compiled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Embedded {
    /// Its name without `.toml`.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

impl Embedded {
    /// Its text with all of its base.
    pub fn complete(&self) -> String {
        let kinds = [MACHINES, ENERGY, DISPLAYS, DRAM, SYNTH];
        let kind = kinds.into_iter().find(|files| files.contains(self)).unwrap_or_default();
        let whole = layer::on_embedded(self.text, kind);
        whole.map_or_else(|_| self.text.to_owned(), |text| layer::without_places(&text))
    }
}

/// The list of a folder, which `build.rs` reads: one file first, the others by name.
macro_rules! embedded {
    ($folder:literal) => {
        include!(concat!(env!("OUT_DIR"), "/", $folder, ".rs"))
    };
}

/// Machine files, the default first.
pub const MACHINES: &[Embedded] = embedded!("machines");

/// Energy tables, the default first.
pub const ENERGY: &[Embedded] = embedded!("energy");

/// Display-power presets, the default first.
pub const DISPLAYS: &[Embedded] = embedded!("display");

/// DRAM devices, the default first.
pub const DRAM: &[Embedded] = embedded!("dram");

/// Sweeps.
pub const SWEEPS: &[Embedded] = embedded!("sweeps");

/// Presets of synthetic scenes, in the order of `synth --list`.
pub const SYNTH: &[Embedded] = embedded!("synth");

/// Where the numbers come from.
pub(crate) const REFERENCES: &str = include_str!("../../arch-configs/references.toml");

/// Every assumption with its knob.
pub(crate) const ASSUMPTIONS: &str = include_str!("../../arch-configs/assumptions.toml");

/// Keys that move nothing under a condition.
pub const INERT: &str = include_str!("../../arch-configs/inert.toml");

/// Energy and area from one technology node to another.
pub const NODES: &str = include_str!("../../arch-configs/nodes.toml");

/// SRAM banks after CACTI 7.
pub const CACTI: &str = include_str!("../../arch-configs/sram/cacti-7.csv");

/// The file of this name.
pub fn find(files: &[Embedded], name: &str) -> Option<&'static str> {
    files.iter().find(|f| f.name == name).map(|f| f.text)
}
