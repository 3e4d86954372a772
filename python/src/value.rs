//! Values of Python as values of configuration files, and back.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString};
use toml::Value;

use crate::error::Fault;
use powergs_base::config::knob;
use powergs_core::run::Change;

/// A number, a text (a number with its unit, or a word), a truth value or a list of them.
pub fn toml(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(knob::written(text.to_str()?.trim()));
    }
    if let Ok(flag) = value.extract::<bool>() {
        return Ok(flag.into());
    }
    if let Ok(list) = value.cast::<PyList>() {
        let items = list.iter().map(|item| toml(key, &item));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    if value.hasattr("__index__")? {
        let outside = |_| Fault::config(format!("{key}: {value} is not a 64-bit number")).raise();
        return value.extract::<i64>().map(Value::Integer).map_err(outside);
    }
    match value.extract::<f64>() {
        Ok(number) if number.is_finite() => Ok(Value::Float(number)),
        Ok(number) => Err(Fault::config(format!("{key}: {number} is not a number")).raise()),
        Err(_) => {
            let kind = value.get_type().name()?.to_string();
            let what = "a value is a number, a text such as \"1.2 GHz\", True, False or a list";
            Err(PyTypeError::new_err(format!("{key}: {what}, not {kind}")))
        }
    }
}

/// A table of a file: keys with values, or with tables.
pub fn table(keys: &Bound<'_, PyDict>) -> PyResult<toml::Table> {
    let mut table = toml::Table::new();
    for (key, value) in keys {
        let key = key.cast::<PyString>();
        let key = key.map_err(|_| PyTypeError::new_err("keys are texts such as \"vru\""))?;
        let value = match value.cast::<PyDict>() {
            Ok(inner) => Value::Table(self::table(inner)?),
            Err(_) => toml(key.to_str()?, &value)?,
        };
        table.insert(key.to_str()?.to_owned(), value);
    }
    Ok(table)
}

/// Changes of keys: a dictionary of dotted names, and names with `__` for the dots.
pub fn changes(
    keys: Option<&Bound<'_, PyDict>>,
    named: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<Change>> {
    let mut changes = Vec::new();
    let mut add = |key: String, value: &Bound<'_, PyAny>| -> PyResult<()> {
        // The path and its file as `Change` reads them; the value is Python's.
        let written: Change = format!("{key}=0").parse().map_err(Fault::config)?;
        changes.push(Change { value: toml(&key, value)?, ..written });
        Ok(())
    };
    for (key, value) in keys.into_iter().flatten() {
        let key = key.cast::<PyString>();
        let key = key.map_err(|_| PyTypeError::new_err("keys are texts such as \"vru.cores\""))?;
        add(key.to_str()?.to_owned(), &value)?;
    }
    for (key, value) in named.into_iter().flatten() {
        add(key.cast::<PyString>()?.to_str()?.replace("__", ".").replace('_', "-"), &value)?;
    }
    Ok(changes)
}

/// A value of a file in Python.
pub fn python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        Value::Float(number) => number.into_pyobject(py)?.into_any(),
        Value::Boolean(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Value::Datetime(date) => date.to_string().into_pyobject(py)?.into_any(),
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(|v| python(py, v)).collect::<PyResult<_>>()?;
            PyList::new(py, items)?.into_any()
        }
        Value::Table(table) => {
            let dict = PyDict::new(py);
            for (key, value) in table {
                dict.set_item(key, python(py, value)?)?;
            }
            dict.into_any()
        }
    })
}

/// The range of a display rate, frames per second.
pub fn display_rate(rate: f64) -> PyResult<f64> {
    if (1.0..=1000.0).contains(&rate) {
        return Ok(rate);
    }
    Err(Fault::config(format!("fps={rate}: must be 1 to 1000 frames per second")).raise())
}
