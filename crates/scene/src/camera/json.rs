//! Shared by the JSON layouts: recognising them, and reading values with errors that name
//! the view and the key.

use glam::{DMat3, DVec3};
use serde_json::{Map, Value};

use super::check::MAX_SIZE;
use super::nerf::SizeOf;
use super::{CameraError, CameraFile, Eye, Split, foreign, inria, nerf, nerfstudio};

/// Reads a camera file in any JSON layout. `size` is the image size in pixels where the file
/// does not say it (`camera_angle_x` sets of Blender); it does not override what the file says.
///
/// # Errors
/// [`CameraError`]: no JSON, an unknown layout, or a value that is missing or cannot be used.
pub fn read(text: &str, size: Option<(u32, u32)>) -> Result<CameraFile, CameraError> {
    read_sized(text, &|_| size)
}

/// As [`read`], where every view has a size of its own: `size` is asked with the `file_path` of
/// those that do not say it.
///
/// # Errors
/// Those of [`read`].
pub fn read_sized(text: &str, size: &SizeOf<'_>) -> Result<CameraFile, CameraError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let value: Value = serde_json::from_str(text).map_err(|e| CameraError::Syntax {
        line: e.line(),
        column: e.column(),
        what: e.to_string(),
    })?;
    let file = match &value {
        Value::Array(views) => match foreign::by_first(views) {
            Some(error) => return Err(error),
            None => inria::views(views)?,
        },
        Value::Object(file) if file.contains_key("frames") => nerf::views(file, size)?,
        Value::Object(file) if nerfstudio::is_path(file) => nerfstudio::path(file)?,
        Value::Object(file) => return Err(foreign::by_keys(file).unwrap_or(CameraError::Layout)),
        _ => return Err(CameraError::Layout),
    };
    if file.cameras.is_empty() { Err(CameraError::Empty) } else { Ok(file) }
}

/// One view of a JSON file.
pub(super) struct JsonView<'a> {
    /// `view 3` or `view 3 (0001.jpg)`.
    pub label: String,
    /// Its own keys.
    own: &'a Map<String, Value>,
    /// Keys of the whole file, which hold where the view has none.
    file: Option<&'a Map<String, Value>>,
}

impl<'a> JsonView<'a> {
    /// View `idx` of the file, named by `name_key`.
    pub(crate) fn new(
        idx: usize,
        value: &'a Value,
        name_key: &'static str,
        file: Option<&'a Map<String, Value>>,
    ) -> Result<Self, CameraError> {
        let label = format!("view {idx}");
        let Value::Object(own) = value else {
            let what = "the view must be an object".to_string();
            return Err(CameraError::Value { view: label, key: name_key, what });
        };
        let label = match own.get(name_key).and_then(Value::as_str) {
            Some(name) => format!("{label} ({})", name.chars().take(80).collect::<String>()),
            None => label,
        };
        Ok(Self { label, own, file })
    }

    /// The keys of a whole file, called `label` in messages.
    pub(crate) fn whole(value: &'a Value, label: &str) -> Result<Self, CameraError> {
        let Value::Object(own) = value else {
            return Err(CameraError::Layout);
        };
        Ok(Self { label: label.to_owned(), own, file: None })
    }

    /// Whether there is something at `key`.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    fn get(&self, key: &str) -> Option<&'a Value> {
        let value = self.own.get(key).or_else(|| self.file.and_then(|file| file.get(key)));
        value.filter(|v| !v.is_null())
    }

    /// An error about `key`.
    pub(crate) fn fault(&self, key: &'static str, what: impl Into<String>) -> CameraError {
        CameraError::Value { view: self.label.clone(), key, what: what.into() }
    }

    /// The string at `key`.
    pub(crate) fn text(&self, key: &'static str) -> Result<Option<&'a str>, CameraError> {
        let text = |v: &'a Value| v.as_str().ok_or_else(|| self.fault(key, "must be a string"));
        self.get(key).map(text).transpose()
    }

    /// The number at `key`.
    pub(crate) fn number(&self, key: &'static str) -> Result<Option<f64>, CameraError> {
        let number = |v: &Value| v.as_f64().ok_or_else(|| self.fault(key, "must be a number"));
        self.get(key).map(number).transpose()
    }

    /// Whether `key` is there and true.
    pub(crate) fn flag(&self, key: &'static str) -> Result<bool, CameraError> {
        let flag = |v: &Value| v.as_bool().ok_or_else(|| self.fault(key, "must be true or false"));
        Ok(self.get(key).map(flag).transpose()?.unwrap_or(false))
    }

    /// The number at `key`, which must be there.
    pub(crate) fn required(&self, key: &'static str) -> Result<f64, CameraError> {
        self.number(key)?.ok_or_else(|| self.fault(key, "is missing"))
    }

    /// The whole number of pixels at `key`.
    pub(crate) fn pixels(&self, key: &'static str) -> Result<Option<u32>, CameraError> {
        let Some(value) = self.number(key)? else { return Ok(None) };
        if value.fract() != 0.0 || !(1.0..=f64::from(MAX_SIZE)).contains(&value) {
            let what = format!("{value} is not an image size; must be 1 to {MAX_SIZE} pixels");
            return Err(self.fault(key, what));
        }
        Ok(Some(value as u32))
    }

    /// The split at `split`; a name that is not known is an error.
    pub(crate) fn split(&self) -> Result<Option<Split>, CameraError> {
        let Some(name) = self.text("split")? else { return Ok(None) };
        let what = || format!("`{name}` is not a split; write `train` or `test`");
        Split::from_name(name).map(Some).ok_or_else(|| self.fault("split", what()))
    }

    /// The eye at `eye`; a name that is not known is an error.
    pub(crate) fn eye(&self) -> Result<Option<Eye>, CameraError> {
        let Some(name) = self.text("eye")? else { return Ok(None) };
        let what = || format!("`{name}` is not an eye; write `left` or `right`");
        Eye::from_name(name).map(Some).ok_or_else(|| self.fault("eye", what()))
    }

    /// Row `row` of the matrix at `key`, at least `N` numbers.
    fn row<const N: usize>(
        &self,
        key: &'static str,
        rows: &[Value],
        row: usize,
    ) -> Result<[f64; N], CameraError> {
        let numbers = rows.get(row).and_then(Value::as_array).filter(|r| r.len() >= N);
        let what = || format!("row {row} must have {N} numbers");
        let numbers = numbers.ok_or_else(|| self.fault(key, what()))?;
        let mut out = [0.0; N];
        for (slot, value) in out.iter_mut().zip(numbers) {
            *slot = value.as_f64().ok_or_else(|| self.fault(key, what()))?;
        }
        Ok(out)
    }

    fn list(&self, key: &'static str) -> Result<&'a [Value], CameraError> {
        let value = self.get(key).ok_or_else(|| self.fault(key, "is missing"))?;
        let list = value.as_array().ok_or_else(|| self.fault(key, "must be a list"))?;
        Ok(list)
    }

    /// The vector at `key`.
    pub(crate) fn vector(&self, key: &'static str) -> Result<DVec3, CameraError> {
        let list = self.list(key)?;
        let numbers: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
        let array: Result<[f64; 3], _> = numbers.try_into();
        match array {
            Ok(array) if list.len() == 3 => Ok(DVec3::from_array(array)),
            _ => Err(self.fault(key, "must be three numbers")),
        }
    }

    /// The 3x3 matrix at `key`, a list of rows.
    pub(crate) fn matrix(&self, key: &'static str) -> Result<DMat3, CameraError> {
        let rows = self.list(key)?;
        let row = |i| self.row::<3>(key, rows, i).map(DVec3::from_array);
        Ok(DMat3::from_cols(row(0)?, row(1)?, row(2)?).transpose())
    }

    /// Rotation and translation of the 4x4 matrix at `key`, sixteen numbers row by row.
    pub(crate) fn square(&self, key: &'static str) -> Result<(DMat3, DVec3), CameraError> {
        let list = self.list(key)?;
        if list.first().is_some_and(Value::is_array) {
            return self.transform(key);
        }
        let numbers: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
        let (rows, rest) = numbers.as_chunks::<4>();
        let &[a, b, c, [0.0, 0.0, 0.0, 1.0]] = rows else {
            return Err(self.fault(key, "must be sixteen numbers, the last four 0 0 0 1"));
        };
        if !rest.is_empty() || list.len() != 16 {
            return Err(self.fault(key, "must be sixteen numbers, the last four 0 0 0 1"));
        }
        let axis = |k: usize| DVec3::new(a[k], b[k], c[k]);
        Ok((DMat3::from_cols(axis(0), axis(1), axis(2)), axis(3)))
    }

    /// Rotation and translation of the 3x4 or 4x4 matrix at `key`, a list of rows.
    pub(crate) fn transform(&self, key: &'static str) -> Result<(DMat3, DVec3), CameraError> {
        let rows = self.list(key)?;
        if rows.len() > 3 && self.row::<4>(key, rows, 3)? != [0.0, 0.0, 0.0, 1.0] {
            return Err(self.fault(key, "the last row must be 0 0 0 1"));
        }
        let row = |i| self.row::<4>(key, rows, i);
        let [a, b, c] = [row(0)?, row(1)?, row(2)?];
        let axis = |k: usize| DVec3::new(a[k], b[k], c[k]);
        Ok((DMat3::from_cols(axis(0), axis(1), axis(2)), axis(3)))
    }
}
