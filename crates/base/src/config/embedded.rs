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

macro_rules! embedded {
    ($folder:literal: $($name:literal),*) => {
        &[$(Embedded {
            name: $name,
            text: include_str!(concat!("../../arch-configs/", $folder, "/", $name, ".toml")),
        }),*]
    };
}

/// Machine files, the default first.
pub const MACHINES: &[Embedded] = embedded!("machines":
    "gscore",
    "a100",
    "a5000",
    "a6000",
    "agx-orin",
    "agx-orin-draws",
    "agx-orin-vrpipe",
    "axis-shared",
    "chang",
    "degs",
    "edge",
    "flicker",
    "gaurast",
    "gbu",
    "gcc",
    "gs-tg",
    "gsacc",
    "gsarch",
    "gscore-16core",
    "gscore-neo",
    "gscore-nerarch",
    "gscore-powergs",
    "h100",
    "ls-gaussian",
    "lumina",
    "metasapiens",
    "nebula",
    "neo",
    "orin-nx",
    "orin-nx-gaurast",
    "orin-nx-gbu",
    "rtgs",
    "rtx-3090",
    "splatonic",
    "titan-rtx",
    "vorion",
    "vorion-16",
    "vorion-train",
    "xavier-nx"
);

/// Energy tables, the default first.
pub const ENERGY: &[Embedded] = embedded!("energy":
    "gscore-28nm",
    "gscore-16nm",
    "gscore-28nm-flat",
    "gscore-28nm-nerarch",
    "gscore-7nm",
    "gscore-7nm-neo",
    "gscore-rtl-28nm",
    "gscore-rtl-45nm",
    "gscore-rtl-7nm",
    "neo-7nm",
    "paper",
    "resident-16nm",
    "gbu-28nm",
    "axis-28nm",
    "resident-28nm",
    "xavier-nx-module",
    "orin-nx-gbu",
    "orin-nx-module",
    "agx-orin-module",
    "agx-orin-rops",
    "rtx-3090-board",
    "titan-rtx-board",
    "a5000-board",
    "a6000-board",
    "a100-board",
    "h100-board"
);

/// Display-power presets, the default first.
pub const DISPLAYS: &[Embedded] = embedded!("display": "oled-powergs", "oled-d22");

/// DRAM devices, the default first.
pub const DRAM: &[Embedded] = embedded!("dram":
    "lpddr4-3200-x16x8",
    "hbm2-8ch",
    "lpddr4-3200-x16x16",
    "lpddr4-3200-x16x2",
    "lpddr4-3200-x16x32",
    "lpddr4-3200-x16x4",
    "lpddr4-3200-x16x8-flat",
    "lpddr4-3200-x16x8-full",
    "lpddr4-3200-x32x4",
    "lpddr5-6400-x16x16",
    "lpddr5-6400-x16x2",
    "lpddr5-6400-x16x4",
    "lpddr5-6400-x16x8",
    "lpddr5x-8533-x16x4",
    "lpddr5x-8533-x16x8",
    "lpddr6-10667-x12x4",
    "lpddr6-10667-x12x8"
);

/// Sweeps.
pub const SWEEPS: &[Embedded] =
    embedded!("sweeps": "gscore-units", "sram-bandwidth", "tiles", "node-choice", "node-energy");

/// Presets of synthetic scenes, in the order of `synth --list`.
pub const SYNTH: &[Embedded] = embedded!("synth":
    "demo",
    "lego",
    "room",
    "train",
    "truck",
    "garden",
    "bicycle",
    "stump",
    "uhd-capture",
    "city",
    "replica"
);

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
