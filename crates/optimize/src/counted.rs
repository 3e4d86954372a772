//! How the watts of a run are counted. The same model takes forty times as much on a machine that
//! stands by as in a closed form without time, so whoever compares two numbers has to know.

use serde::{Deserialize, Serialize};

/// By which counts rendering power is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PowerCounts {
    /// The published closed form: operations and bytes of a frame times unit prices. It knows no
    /// time, and so no standby.
    ClosedForm,
    /// A simulated machine.
    Machine,
}

impl PowerCounts {
    /// Whether standby is in the watts: leakage, DRAM background and refresh.
    pub fn has_standby(self) -> bool {
        match self {
            PowerCounts::ClosedForm => false,
            PowerCounts::Machine => true,
        }
    }
}

/// How the watts of a run are counted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PowerCounted {
    /// By which counts.
    pub counts: PowerCounts,
    /// Whether standby is in them: leakage, DRAM background and refresh.
    pub has_standby: bool,
    /// What the panel was scaled to: display power over rendering power of the dense model; `None`:
    /// it is as its file has it.
    pub display_ratio: Option<f64>,
    /// Factor on the power that the file of the panel gives it.
    pub display_factor: f64,
}

impl PowerCounted {
    /// A panel as its file has it.
    pub(crate) fn by(counts: PowerCounts) -> PowerCounted {
        let has_standby = counts.has_standby();
        PowerCounted { counts, has_standby, display_ratio: None, display_factor: 1.0 }
    }

    /// By which counts, and whether standby is in them; `oracle` is the name of what counts.
    pub fn by_what(&self, oracle: &str) -> String {
        match self.counts {
            PowerCounts::ClosedForm => "the published closed form, without standby".into(),
            PowerCounts::Machine => format!("the machine {oracle}, with its standby"),
        }
    }

    /// How the panel was scaled.
    pub fn panel(&self, display: &str) -> String {
        match self.display_ratio {
            None => format!("panel {display} as it is"),
            Some(ratio) => format!(
                "panel {display} scaled by {}, so that the dense model has a display-to-render \
                 ratio of {ratio}",
                three_digits(self.display_factor)
            ),
        }
    }
}

/// A factor with three significant digits.
fn three_digits(factor: f64) -> String {
    let digits = (2.0 - factor.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{factor:.digits$}")
}
