//! The space file: axes of the model, axes of the machine, and what both may take.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::config::{self, Config, ConfigError, Problem};
use powergs_base::number::NumberFormat;
use powergs_base::quantity::{Nanoseconds, SquareMillimetres};
use powergs_core::flow;
use powergs_optimize::record::RecordFormats;
use powergs_study::sweep::file::{AxisSpec, EnergySpec, Sampling, Settings};

/// Models of a space at most: each is a fine-tune.
pub const MODELS_MAX: usize = 1000;
/// Entries of a codebook at most.
pub const ENTRIES_MAX: u32 = 65_536;
/// What formats are called where the file has none.
pub const EXACT: &str = "exact";

/// A space of models and machines, as its file has it.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SpaceFile {
    /// The axes of the model; every combination is a model that is fine-tuned once.
    pub model: ModelSpec,
    /// The machine and its axes, as sweep files have them.
    #[serde(default)]
    pub machine: MachineSpec,
    /// What a pair may take; without it, what the base machine takes.
    #[serde(default)]
    pub budget: BudgetSpec,
}

/// The axes of the model.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ModelSpec {
    /// Shares of the Gaussians that are pruned, each from 0 to below 1.
    pub rho: Vec<f64>,
    /// Degrees of the spherical harmonics that are kept; without it, that of the dense model.
    #[serde(default)]
    pub sh_degree: Vec<u8>,
    /// Number formats of the record of a Gaussian; without it, nothing is rounded and the record
    /// is that of the machine.
    #[serde(default)]
    pub formats: Vec<FormatSpec>,
    /// Entries of the codebook that colours beyond the constant one are taken from; 0: each
    /// Gaussian has its own. Without it, only that.
    #[serde(default)]
    pub codebook: Vec<u32>,
}

/// Number formats of the fields of a record. A field without one is not rounded, and is as wide as
/// the machine has it.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FormatSpec {
    /// Name in results: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// The three numbers of a centre, world units.
    pub position: Option<NumberFormat>,
    /// The three standard deviations, world units.
    pub scale: Option<NumberFormat>,
    /// The four numbers of a unit quaternion.
    pub rotation: Option<NumberFormat>,
    /// The opacity.
    pub opacity: Option<NumberFormat>,
    /// The three constant coefficients of the colour.
    pub colour_dc: Option<NumberFormat>,
    /// The other coefficients of the colour, 45 at degree 3.
    pub colour_rest: Option<NumberFormat>,
}

impl FormatSpec {
    /// Nothing is rounded.
    pub fn exact() -> FormatSpec {
        FormatSpec { name: EXACT.into(), ..FormatSpec::default() }
    }

    /// The formats without their name.
    pub fn formats(&self) -> RecordFormats {
        let FormatSpec { name: _, position, scale, rotation, opacity, colour_dc, colour_rest } =
            *self;
        let codebook = None;
        RecordFormats { position, scale, rotation, opacity, colour_dc, colour_rest, codebook }
    }
}

/// The machine and its axes.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct MachineSpec {
    /// Machine that every point starts from: a name, or a path.
    pub base: String,
    /// Keys that every machine has.
    pub set: Settings,
    /// Energy tables; the first decides, the others say whether the answer holds under them.
    /// Without any: the machine's own, and where that is `gscore-28nm` two further ones.
    pub energy: Vec<EnergySpec>,
    /// Display preset, a name or a path.
    pub display: String,
    /// Frames per second that the display shows.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 10000, "x-unit" = "1/s"))]
    pub display_fps: f64,
    /// What is varied, the last axis fastest.
    pub axes: Vec<AxisSpec>,
    /// Keys that follow from others: an expression for each.
    pub derived: Settings,
    /// Expressions that every machine must fulfil.
    pub constraints: Vec<String>,
    /// Which machines of the space are taken.
    pub sampling: Sampling,
    /// Where the files lie that it names; the working folder without one.
    #[serde(skip)]
    #[schemars(skip)]
    pub folder: Option<PathBuf>,
}

impl Default for MachineSpec {
    fn default() -> MachineSpec {
        MachineSpec {
            base: "gscore".into(),
            set: Settings::default(),
            energy: Vec::new(),
            display: "oled-powergs".into(),
            display_fps: 60.0,
            axes: Vec::new(),
            derived: Settings::default(),
            constraints: Vec::new(),
            sampling: Sampling::default(),
            folder: None,
        }
    }
}

/// What a pair may take.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct BudgetSpec {
    /// Area of the chip by the first energy table; without it, that of the base machine.
    pub area: Option<SquareMillimetres>,
    /// Time of the slowest frame; without it, the time that the display shows one for.
    pub frame_time: Option<Nanoseconds>,
    /// PSNR over the gate views, dB; `--quality` and `--quality-db` come in its place.
    #[schemars(range(min = 1.0, max = 120.0), extend("x-unit" = "dB"))]
    pub psnr: Option<f64>,
}

impl SpaceFile {
    /// Reads a space file.
    ///
    /// # Errors
    /// Everything that is wrong with its form, each with its line. What the axes of the machine
    /// name is checked where they are opened.
    pub fn parse(text: &str) -> Result<SpaceFile, ConfigError> {
        let config = config::parse::<SpaceFile>(text, &[])?;
        let problems = problems(&config);
        config.checked(problems)
    }
}

fn problems(config: &Config<SpaceFile>) -> Vec<Problem> {
    let mut found = Vec::new();
    let mut wrong = |key: &str, message: String| found.push(config.problem(key, message));
    let SpaceFile { model, machine, budget } = &config.value;
    if model.rho.is_empty() {
        wrong("model.rho", "`model.rho` is empty: a model is pruned by 0 at least".into());
    }
    for (i, rho) in model.rho.iter().enumerate() {
        if !(0.0..1.0).contains(rho) {
            let message = format!("`model.rho`: {rho} must be a share from 0 to below 1");
            wrong("model.rho", message);
        }
        if model.rho[..i].contains(rho) {
            wrong("model.rho", format!("`model.rho`: {rho} appears twice"));
        }
    }
    for (i, degree) in model.sh_degree.iter().enumerate() {
        if *degree > 3 {
            let message = format!("`model.sh-degree`: {degree} must be 0 to 3");
            wrong("model.sh-degree", message);
        }
        if model.sh_degree[..i].contains(degree) {
            wrong("model.sh-degree", format!("`model.sh-degree`: {degree} appears twice"));
        }
    }
    for (i, entries) in model.codebook.iter().enumerate() {
        if *entries == 1 || *entries > ENTRIES_MAX {
            let message = format!(
                "`model.codebook`: {entries} must be 0 for none, or 2 to {ENTRIES_MAX} entries"
            );
            wrong("model.codebook", message);
        }
        if model.codebook[..i].contains(entries) {
            wrong("model.codebook", format!("`model.codebook`: {entries} appears twice"));
        }
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    for (i, spec) in model.formats.iter().enumerate() {
        let (name, key) = (&spec.name, "model.formats");
        if name.is_empty() || name.len() > 40 || !name.chars().all(plain) || name.starts_with('.') {
            let message = "`name` must be letters, digits, `-`, `_` and `.`, 40 at most";
            wrong(key, format!("`model.formats`, number {}: {message}", i + 1));
        }
        let digits = name.trim_end_matches(|c: char| c.is_ascii_digit());
        if digits != name && digits.ends_with("-cb") {
            let message = "ends as the name of a model with a codebook does; choose another";
            wrong(key, format!("`model.formats`: `{name}` {message}"));
        }
        if let Some(other) = model.formats[..i].iter().find(|o| o.name == *name) {
            wrong(key, format!("`model.formats`: `{}` appears twice", other.name));
        }
        let same = model.formats[..i].iter().find(|o| o.formats() == spec.formats());
        if let Some(other) = same {
            let message = format!("`model.formats`: `{}` and `{name}` are the same", other.name);
            wrong(key, message);
        }
    }
    let models = model.rho.len() * model.sh_degree.len().max(1) * model.formats.len().max(1);
    let models = models * model.codebook.len().max(1);
    if models > MODELS_MAX {
        let message = format!("{models} models: at most {MODELS_MAX}; each is a fine-tune");
        wrong("model.rho", message);
    }
    for key in keys(machine) {
        if let Some(message) = contradiction(&key) {
            wrong("machine", message);
        }
    }
    if let Some(area) = budget.area.filter(|area| area.0 <= 0.0) {
        wrong("budget.area", format!("`budget.area`: {} mm2 holds no machine", area.0));
    }
    if let Some(time) = budget.frame_time.filter(|time| time.0 <= 0.0) {
        wrong("budget.frame-time", format!("`budget.frame-time`: {} ns is no time", time.0));
    }
    found
}

fn settings_keys(settings: &Settings) -> impl Iterator<Item = String> + '_ {
    settings.0.iter().map(|(key, _)| key.clone())
}

/// The keys that an axis varies.
pub(crate) fn axis_keys(axis: &AxisSpec) -> Vec<String> {
    let zipped = axis.zip.iter().flat_map(|zip| zip.0.iter().map(|(key, _)| key.clone()));
    let variants = axis.variants.iter().flatten();
    let named = variants.flat_map(|variant| settings_keys(&variant.set));
    axis.key.iter().cloned().chain(zipped).chain(named).collect()
}

/// All keys that a machine space changes.
fn keys(machine: &MachineSpec) -> Vec<String> {
    let all = settings_keys(&machine.set).chain(settings_keys(&machine.derived));
    all.chain(machine.axes.iter().flat_map(axis_keys)).collect()
}

/// Why a machine space must not change a key: records are the model's, and what a picture looks
/// like is not measured for every machine.
fn contradiction(key: &str) -> Option<String> {
    let table = |key: &str| key.split('.').next().unwrap_or_default().to_owned();
    let mut records = flow::all().filter_map(|flow| Some(table(flow.record()?.position)));
    let is_record = records.any(|record| record == table(key));
    let what = match key {
        "machine" => "one base machine has all models: give it as `base`",
        "codebook" | "codebook.entries" | "codebook.entry" => {
            "the codebook of colours is the model's: give its sizes as `model.codebook`"
        }
        _ if is_record => {
            "the record of a Gaussian follows from `model.formats`, and other keys of it change \
             the picture, which is not measured for every machine"
        }
        _ => return None,
    };
    Some(format!("`{key}` is not an axis of the machine here: {what}; leave it out"))
}
