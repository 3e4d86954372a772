//! The models of a space: which there are, what they start from, and what a machine reads of them.

use std::num::NonZeroU32;

use serde::Serialize;
use toml::{Table, Value};

use powergs_base::config::knob;
use powergs_base::number::NumberFormat;
use powergs_base::quantity::Bytes;
use powergs_core::flow::RecordKeys;
use powergs_core::machine::Machine;
use powergs_optimize::record::RecordFormats;
use powergs_scene::Gaussians;

use super::space::{FormatSpec, ModelSpec};

/// The name of the dense model.
pub const DENSE: &str = "dense";
/// The key of the entries of a codebook.
pub(crate) const ENTRIES: &str = "codebook.entries";
/// Coefficients of a channel at degree 3.
const COEFFICIENTS: u64 = 16;
/// Colour records are aligned to at most this, bytes, as machines have them.
const ALIGNMENT_MAX: u64 = 32;

/// A choice on every axis of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelPoint {
    /// Share of the Gaussians of the dense model that is pruned.
    pub rho: f64,
    /// Degree of the spherical harmonics.
    pub sh_degree: u8,
    /// Name of its formats.
    pub format: String,
    /// Number formats of its record.
    pub formats: RecordFormats,
    /// Whether it is the dense model as it is: neither pruned nor trained.
    pub is_dense: bool,
}

impl ModelPoint {
    /// The dense model as it was trained, with the record that the machine has for it.
    pub fn dense(sh_degree: u8) -> ModelPoint {
        let exact = FormatSpec::exact();
        let (format, formats) = (exact.name, RecordFormats::default());
        ModelPoint { rho: 0.0, sh_degree, format, formats, is_dense: true }
    }

    /// The name in results: `rho0.4-sh3-fp16`.
    pub fn name(&self) -> String {
        match self.is_dense {
            true => DENSE.into(),
            false => {
                let book = self.formats.codebook.map(|n| format!("-cb{n}")).unwrap_or_default();
                format!("rho{}-sh{}-{}{book}", self.rho, self.sh_degree, self.format)
            }
        }
    }

    /// What its fine-tune starts from: the dense model without the coefficients beyond its degree.
    pub fn start(&self, dense: &Gaussians) -> Gaussians {
        let (from, to) = (dense.sh_coefficients(), (usize::from(self.sh_degree) + 1).pow(2));
        if to >= from {
            return dense.clone();
        }
        let channels = dense.sh.chunks_exact(from);
        let sh = channels.flat_map(|channel| channel[..to].iter().copied()).collect();
        Gaussians { sh_degree: self.sh_degree, sh, ..dense.clone() }
    }
}

/// The models of a space: the dense model, then every combination, the last axis fastest. Models of
/// degree 0 have no codebook.
pub fn models(spec: &ModelSpec, dense: &Gaussians) -> Vec<ModelPoint> {
    let own = [dense.sh_degree];
    let degrees = if spec.sh_degree.is_empty() { &own[..] } else { &spec.sh_degree };
    let exact = [FormatSpec::exact()];
    let formats = if spec.formats.is_empty() { &exact[..] } else { &spec.formats };
    let mut models = vec![ModelPoint::dense(dense.sh_degree)];
    let books = if spec.codebook.is_empty() { &[0][..] } else { &spec.codebook };
    for &rho in &spec.rho {
        for &sh_degree in degrees {
            for format in formats {
                // Constant colours alone have no codebook.
                let books = books.iter().filter(|&&n| n == 0 || sh_degree > 0);
                models.extend(books.map(|&entries| ModelPoint {
                    rho,
                    sh_degree,
                    format: format.name.clone(),
                    formats: RecordFormats {
                        codebook: NonZeroU32::new(entries),
                        ..format.formats()
                    },
                    is_dense: false,
                }));
            }
        }
    }
    models
}

/// Bytes of a record that are not those of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordBytes {
    /// Of the position, where its format is given.
    pub position: Option<Bytes>,
    /// Of scale, rotation and opacity, where one of their formats is given.
    pub geometry: Option<Bytes>,
    /// Of a colour of the degree of the model, with the distance of two of them, where one of its
    /// formats is given.
    pub colour: Option<(Bytes, Bytes)>,
    /// Entries of the codebook and bytes of one, where the model has one; then `colour` is given.
    pub codebook: Option<(u32, Bytes)>,
    keys: RecordKeys,
}

/// Bytes that a key of a machine has; none where it has no such key.
fn bytes_of(machine: &Table, key: &str) -> Bytes {
    let value = knob::values(machine, key).pop();
    let bytes = value.as_ref().and_then(Value::as_str).and_then(|text| text.parse().ok());
    bytes.unwrap_or(Bytes(0))
}

impl RecordBytes {
    /// The record of a model on a machine whose own record has these keys.
    pub fn of(model: &ModelPoint, machine: &Machine, keys: RecordKeys) -> RecordBytes {
        let table = machine.table();
        let [position_bytes, shape_bytes, colour_bytes, pitch] =
            [keys.position, keys.shape, keys.colour, keys.pitch].map(|key| bytes_of(&table, key));
        let extra = keys.extra.map_or(Bytes(0), |key| bytes_of(&table, key));
        let RecordFormats { position, scale, rotation, opacity, colour_dc, colour_rest, codebook } =
            model.formats;
        // A field without a format is as wide as the machine has it.
        let total = |fields: &[(u64, Option<NumberFormat>)], own: f64| {
            let any = fields.iter().any(|(_, format)| format.is_some());
            let bits = |format: Option<NumberFormat>| format.map_or(own, |f| f64::from(f.bits()));
            let sum: f64 = fields.iter().map(|(n, format)| *n as f64 * bits(*format)).sum();
            any.then(|| Bytes((sum / 8.0).ceil() as u64))
        };
        let own = |bytes: u64, numbers: u64| 8.0 * bytes as f64 / numbers as f64;
        let rest = (u64::from(model.sh_degree) + 1).pow(2) - 1;
        let coefficients = colour_bytes.0.saturating_sub(extra.0);
        let own_colour = own(coefficients, 3 * COEFFICIENTS);
        let width = |format: Option<NumberFormat>| {
            format.map_or(own_colour, |format| f64::from(format.bits()))
        };
        let whole = |bits: f64| Bytes((bits / 8.0).ceil() as u64);
        // Three constant coefficients and the number of an entry, or all coefficients.
        let colour = match codebook {
            Some(entries) => {
                let number = u32::BITS - (entries.get() - 1).leading_zeros();
                Some(whole(3.0 * width(colour_dc) + f64::from(number)))
            }
            None => total(&[(3, colour_dc), (3 * rest, colour_rest)], own_colour),
        };
        RecordBytes {
            codebook: codebook
                .map(|entries| (entries.get(), whole(3.0 * rest as f64 * width(colour_rest)))),
            position: total(&[(3, position)], own(position_bytes.0, 3)),
            geometry: total(&[(3, scale), (4, rotation), (1, opacity)], own(shape_bytes.0, 8)),
            colour: colour.map(|bytes| {
                let alignment = (1 << pitch.0.trailing_zeros()).min(ALIGNMENT_MAX);
                let bytes = Bytes(bytes.0 + extra.0);
                // As a machine has it.
                let alignment = match codebook {
                    None => alignment,
                    Some(_) => bytes.0.next_power_of_two().min(alignment),
                };
                (bytes, Bytes(bytes.0.next_multiple_of(alignment)))
            }),
            keys,
        }
    }

    /// The keys of the machine with their values, as files have them.
    pub fn settings(&self) -> Vec<(String, Value)> {
        let mut keys = Vec::new();
        let mut set =
            |key: &str, bytes: Bytes| keys.push((key.to_owned(), bytes.to_string().into()));
        if let Some(bytes) = self.position {
            set(self.keys.position, bytes);
        }
        if let Some(bytes) = self.geometry {
            set(self.keys.shape, bytes);
        }
        if let Some((bytes, pitch)) = self.colour {
            // These bytes are of one degree: none of them go with another.
            set(self.keys.colour, bytes);
            self.keys.extra.into_iter().for_each(|key| set(key, bytes));
            set(self.keys.pitch, pitch);
        }
        if let Some((entries, entry)) = self.codebook {
            set("codebook.entry", entry);
            keys.push((ENTRIES.to_owned(), i64::from(entries).into()));
        }
        keys
    }
}

/// Why a machine that computes with `numbers` cannot read the record of a model: coefficients of
/// colours go to its units as they are, so every number of their format must be one of `numbers`.
/// Centres and shapes are converted, in numbers that are wider than any of a record.
pub fn unreadable(model: &ModelPoint, numbers: Option<NumberFormat>) -> Option<String> {
    let numbers = numbers?;
    let colours =
        [("colour-dc", model.formats.colour_dc), ("colour-rest", model.formats.colour_rest)];
    colours.into_iter().find_map(|(field, format)| {
        let format = format?;
        let fits = format.exponent_bits() <= numbers.exponent_bits()
            && format.mantissa_bits() <= numbers.mantissa_bits();
        (!fits).then(|| {
            format!(
                "`model.formats`, `{}`: `{field} = \"{format}\"` contradicts the base machine, \
                 whose units compute with {numbers} and cannot hold every {format}: give it at \
                 most {} bits of exponent and {} of mantissa",
                model.format,
                numbers.exponent_bits(),
                numbers.mantissa_bits()
            )
        })
    })
}
