//! Arrays of any library in, arrays of NumPy out.

use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{Class, Fault};

/// An array that cannot be used.
pub fn wrong(message: impl Into<String>) -> PyErr {
    Fault::new(Class::Input, message).raise()
}

/// The numbers of an array with this many axes, in C order, and their counts: of NumPy, of PyTorch
/// on the host, nested lists, with any strides and of any kind of number.
fn numbers<T: numpy::Element + Copy>(
    given: &Bound<'_, PyAny>,
    name: &str,
    (axes, dtype): (&str, &str),
) -> PyResult<(Vec<usize>, Vec<T>)> {
    let py = given.py();
    // A tensor that a gradient is kept of has to be detached first.
    let given = match given.hasattr("detach")? {
        true => given.call_method0("detach")?.call_method0("cpu")?,
        false => given.clone(),
    };
    let numpy = py.import("numpy")?;
    let options = PyDict::new(py);
    options.set_item("dtype", numpy.getattr(dtype)?)?;
    let values = numpy.call_method("ascontiguousarray", (given,), Some(&options));
    let values = values.map_err(|e| {
        PyTypeError::new_err(format!("{name}: an array of numbers of shape {axes}: {e}"))
    })?;
    let values: PyReadonlyArrayDyn<'_, T> = values.extract()?;
    let shape = values.shape().to_vec();
    Ok((shape, values.as_slice().map_err(|e| wrong(format!("{name}: {e}")))?.to_vec()))
}

/// A matrix of this many rows and columns.
pub fn matrix<const R: usize, const C: usize>(
    given: &Bound<'_, PyAny>,
    name: &str,
) -> PyResult<[[f64; C]; R]> {
    let (shape, values) = numbers::<f64>(given, name, (&format!("({R}, {C})"), "float64"))?;
    if shape != [R, C] {
        return Err(wrong(format!("{name} has the shape ({R}, {C}), this array has {shape:?}")));
    }
    Ok(std::array::from_fn(|row| std::array::from_fn(|column| values[row * C + column])))
}

/// Numbers of every Gaussian: an array of shape `[count, ...]`; `count` is that of the others.
pub fn of_each(
    given: &Bound<'_, PyAny>,
    name: &str,
    count: Option<usize>,
    fits: impl Fn(&[usize]) -> bool,
    axes: &str,
) -> PyResult<(Vec<usize>, Vec<f32>)> {
    let (shape, values) = numbers::<f32>(given, name, (axes, "float32"))?;
    if shape.is_empty() || !fits(&shape[1..]) {
        return Err(wrong(format!("{name} has the shape {axes}, this array has {shape:?}")));
    }
    if let Some(count) = count.filter(|count| *count != shape[0]) {
        return Err(wrong(format!("{name} has {} Gaussians, means have {count}", shape[0])));
    }
    if let Some(place) = values.iter().position(|value| !value.is_finite()) {
        let each = (values.len() / shape[0].max(1)).max(1);
        return Err(wrong(format!("{name}: no number (NaN or infinite) at #{}", place / each)));
    }
    Ok((shape, values))
}

/// An array that owns these numbers.
pub fn array<'py>(
    py: Python<'py>,
    values: Vec<f32>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}

/// A matrix as an array.
pub fn array_of_rows<'py>(
    py: Python<'py>,
    rows: &[Vec<f64>],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let shape = [rows.len(), rows[0].len()];
    PyArray1::from_vec(py, rows.concat()).reshape(&shape[..])
}
