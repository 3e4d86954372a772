//! `meta.json` of SOG, versions 1 and 2.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::super::convert::logit;
use super::super::error::{DAMAGED, REEXPORT, SceneError};

/// What every byte of a channel stands for.
pub(super) type SogTable = [f32; 256];

/// A checked `meta.json`.
pub(super) struct Meta {
    pub version: u8,
    /// Gaussians, as the file claims.
    pub count: u64,
    /// `antialiased` or `2dgs`, where the model is not a usual one.
    pub model: Option<String>,
    /// Minima and maxima of the positions, in the logarithmic space.
    pub means: [[f64; 3]; 2],
    /// Logarithmic scales.
    pub scales: [SogTable; 3],
    /// Red, green, blue DC coefficients and raw opacity.
    pub sh0: [SogTable; 4],
    /// The other SH coefficients, where the model has some.
    pub sh_n: Option<SogTable>,
    /// Image files: two of means, scales, rotations, sh0, and for `shN` centroids and labels.
    pub files: Vec<String>,
}

#[derive(Deserialize)]
struct RawMeta {
    version: Option<u64>,
    count: Option<u64>,
    model: Option<String>,
    means: SogPart,
    scales: SogPart,
    quats: SogPart,
    sh0: SogPart,
    #[serde(rename = "shN")]
    sh_n: Option<SogPart>,
}

#[derive(Deserialize)]
struct SogPart {
    shape: Option<Vec<u64>>,
    mins: Option<Numbers>,
    maxs: Option<Numbers>,
    codebook: Option<Vec<Option<f64>>>,
    files: Vec<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Numbers {
    One(f64),
    Many(Vec<f64>),
}

impl Meta {
    /// Checks the keys of a `meta.json`.
    pub(crate) fn new(keys: Map<String, Value>) -> Result<Self, SceneError> {
        let mut raw: RawMeta = serde_json::from_value(Value::Object(keys))
            .map_err(|e| wrong("the file", format!("{e}")))?;
        let version = match raw.version {
            None | Some(1) => 1,
            Some(2) => 2,
            Some(other) => {
                let what = format!("version {other}; 1 and 2 are known");
                return Err(SceneError::malformed("meta.json", what, REEXPORT));
            }
        };
        let shape = raw.means.shape.as_ref().and_then(|shape| shape.first().copied());
        let Some(count) = (if version == 2 { raw.count } else { shape }) else {
            return Err(wrong("count", "the number of Gaussians is missing"));
        };
        let means = [
            raw.means.range("means.mins", &raw.means.mins)?,
            raw.means.range("means.maxs", &raw.means.maxs)?,
        ];
        let [red, green, blue, opacity] = raw.sh0.tables("sh0", version)?;
        let opacity = if version == 2 {
            std::array::from_fn(|byte| logit(byte as f64 / 255.0))
        } else {
            opacity
        };
        let sh_n = match &raw.sh_n {
            Some(part) => Some(part.tables::<1>("shN", version)?[0]),
            None => None,
        };
        let scales = raw.scales.tables("scales", version)?;
        let files = raw.take_files()?;
        let model = raw.model;
        Ok(Self {
            version,
            count,
            model,
            means,
            scales,
            sh0: [red, green, blue, opacity],
            sh_n,
            files,
        })
    }
}

impl RawMeta {
    fn take_files(&mut self) -> Result<Vec<String>, SceneError> {
        let parts = [
            ("means", Some(&mut self.means), 2),
            ("scales", Some(&mut self.scales), 1),
            ("quats", Some(&mut self.quats), 1),
            ("sh0", Some(&mut self.sh0), 1),
            ("shN", self.sh_n.as_mut(), 2),
        ];
        let mut files = Vec::new();
        for (key, part, n) in parts {
            let Some(part) = part else { continue };
            if part.files.len() != n {
                let what = format!("{} names instead of {n}", part.files.len());
                return Err(wrong(&format!("{key}.files"), what));
            }
            files.append(&mut part.files);
        }
        Ok(files)
    }
}

impl SogPart {
    /// `N` numbers; a single one stands for all.
    fn range<const N: usize>(
        &self,
        key: &str,
        numbers: &Option<Numbers>,
    ) -> Result<[f64; N], SceneError> {
        match numbers {
            Some(Numbers::One(number)) => Ok([*number; N]),
            Some(Numbers::Many(list)) if list.len() >= N => Ok(std::array::from_fn(|i| list[i])),
            Some(Numbers::Many(list)) => {
                Err(wrong(key, format!("{} numbers instead of {N}", list.len())))
            }
            None => Err(wrong(key, "missing")),
        }
    }

    /// The values of the bytes of `N` channels.
    fn tables<const N: usize>(&self, key: &str, version: u8) -> Result<[SogTable; N], SceneError> {
        if version == 2 {
            return Ok([self.codebook(&format!("{key}.codebook"))?; N]);
        }
        let mins: [f64; N] = self.range(&format!("{key}.mins"), &self.mins)?;
        let maxs: [f64; N] = self.range(&format!("{key}.maxs"), &self.maxs)?;
        Ok(std::array::from_fn(|channel| {
            std::array::from_fn(|byte| {
                let t = byte as f64 / 255.0;
                (mins[channel] * (1.0 - t) + maxs[channel] * t) as f32
            })
        }))
    }

    fn codebook(&self, key: &str) -> Result<SogTable, SceneError> {
        let Some(book) = &self.codebook else { return Err(wrong(key, "missing")) };
        if book.len() != 256 {
            return Err(wrong(key, format!("{} entries instead of 256", book.len())));
        }
        let mut table = [0.0; 256];
        for (i, entry) in book.iter().enumerate() {
            table[i] = match (entry, book[1], book[255]) {
                (Some(value), ..) => *value as f32,
                // An early writer left the first entry out; the others are about evenly spaced.
                (None, Some(second), Some(last)) if i == 0 => {
                    (second + (second - last) / 255.0) as f32
                }
                _ => return Err(wrong(key, format!("entry {i} is not a number"))),
            };
        }
        Ok(table)
    }
}

fn wrong(key: &str, what: impl Into<String>) -> SceneError {
    SceneError::malformed(format!("meta.json, {key}"), what, DAMAGED)
}
