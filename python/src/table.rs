//! Tables: columns with names, units and definitions, handed on by the Arrow PyCapsule interface.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::{
    Array, ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray, StructArray,
    UInt64Array,
};
use arrow_schema::{DataType, Field, Schema};
use pyo3::exceptions::{PyIndexError, PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyIterator, PyList, PySlice, PyString};
use pyo3_arrow::ffi::{ArrayIterator, to_schema_pycapsule, to_stream_pycapsule};

use crate::error::{Fault, defect};
use powergs_base::config::suggest::nearest;
use powergs_report::document::{Cell, Column as Head, Document, Kind, Table as Page};
use powergs_report::format::significant;

/// Rows and columns that are shown of a large table.
const SHOWN: (usize, usize) = (20, 12);

/// A column to be.
pub struct Column {
    name: String,
    unit: String,
    definition: String,
    values: ArrayRef,
}

impl Column {
    /// Words; `None` where nothing is known.
    pub fn text<S: AsRef<str>>(
        name: &str,
        definition: &str,
        values: impl IntoIterator<Item = Option<S>>,
    ) -> Column {
        Column::new(name, "", definition, Arc::new(StringArray::from_iter(values)))
    }

    /// Whole numbers.
    pub fn count(
        name: &str,
        unit: &str,
        definition: &str,
        values: impl IntoIterator<Item = Option<u64>>,
    ) -> Column {
        Column::new(name, unit, definition, Arc::new(UInt64Array::from_iter(values)))
    }

    /// Whole numbers that may be negative.
    pub fn integer(
        name: &str,
        unit: &str,
        definition: &str,
        values: impl IntoIterator<Item = Option<i64>>,
    ) -> Column {
        Column::new(name, unit, definition, Arc::new(Int64Array::from_iter(values)))
    }

    /// Measures.
    pub fn real(
        name: &str,
        unit: &str,
        definition: &str,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Column {
        Column::new(name, unit, definition, Arc::new(Float64Array::from_iter(values)))
    }

    /// Yes or no.
    pub fn flag(
        name: &str,
        definition: &str,
        values: impl IntoIterator<Item = Option<bool>>,
    ) -> Column {
        Column::new(name, "", definition, Arc::new(BooleanArray::from_iter(values)))
    }

    fn new(name: &str, unit: &str, definition: &str, values: ArrayRef) -> Column {
        let [name, unit, definition] = [name, unit, definition].map(str::to_owned);
        Column { name, unit, definition, values }
    }
}

/// A table of results: columns with units and definitions.
///
/// pandas, polars, pyarrow and DuckDB read it through the Arrow PyCapsule interface without a copy:
/// ``pandas.DataFrame.from_arrow(t)``, ``polars.DataFrame(t)``, ``pyarrow.table(t)``. Each column's
/// Arrow metadata has ``unit`` and ``definition``.
#[pyclass(frozen, module = "powergs", name = "Table")]
pub struct Table {
    batch: RecordBatch,
}

impl Table {
    /// A table of columns of one length.
    pub fn new(columns: impl IntoIterator<Item = Column>) -> PyResult<Table> {
        let mut fields = Vec::new();
        let mut arrays = Vec::new();
        for column in columns {
            let known = [("unit", column.unit), ("definition", column.definition)];
            let known = known.into_iter().filter(|(_, text)| !text.is_empty());
            let metadata: HashMap<_, _> = known.map(|(k, v)| (k.to_owned(), v)).collect();
            let kind = column.values.data_type().clone();
            fields.push(Field::new(column.name, kind, true).with_metadata(metadata));
            arrays.push(column.values);
        }
        let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays);
        Ok(Table { batch: batch.map_err(defect)? })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.batch.num_rows()
    }

    /// The first rows and columns as HTML.
    pub fn html(&self) -> PyResult<String> {
        self.page().fragment().map_err(defect)
    }

    fn field(&self, name: &str) -> PyResult<usize> {
        let schema = self.batch.schema_ref();
        schema.index_of(name).map_err(|_| {
            let names = schema.fields().iter().map(|field| field.name().as_str());
            let near = nearest(name, names).map(|n| format!("; did you mean `{n}`?"));
            PyKeyError::new_err(format!("no column `{name}`{}", near.unwrap_or_default()))
        })
    }

    fn facts<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for field in self.batch.schema_ref().fields() {
            let text = field.metadata().get(key).map_or("", String::as_str);
            dict.set_item(field.name(), text)?;
        }
        Ok(dict)
    }

    /// The first rows and columns as a page.
    fn page(&self) -> Document {
        let (rows, columns) = (self.batch.num_rows(), self.batch.num_columns());
        let shown = columns.min(SHOWN.1);
        let head = |i: usize| {
            let field = self.batch.schema_ref().field(i).clone();
            match field.data_type() {
                DataType::Float64 => Head::new(field.name(), Kind::Real(significant)),
                DataType::UInt64 | DataType::Int64 => Head::count(field.name()),
                _ => Head::text(field.name()).at_most(48),
            }
        };
        let mut table = Page::new((0..shown).map(head));
        for row in 0..rows.min(SHOWN.0) {
            table.row((0..shown).map(|i| cell(self.batch.column(i), row)));
        }
        let mut page = Document::new();
        page.table(table);
        page.paragraph(format!("{rows} rows x {columns} columns"));
        page
    }
}

fn cell(array: &ArrayRef, row: usize) -> Cell {
    if array.is_null(row) {
        return Cell::Missing;
    }
    let any = array.as_any();
    if let Some(values) = any.downcast_ref::<Float64Array>() {
        return Cell::Real(values.value(row));
    }
    if let Some(values) = any.downcast_ref::<UInt64Array>() {
        return Cell::Count(values.value(row));
    }
    if let Some(values) = any.downcast_ref::<Int64Array>() {
        return values.value(row).to_string().into();
    }
    if let Some(values) = any.downcast_ref::<BooleanArray>() {
        return Cell::Flag(values.value(row));
    }
    any.downcast_ref::<StringArray>().map_or(Cell::Missing, |values| values.value(row).into())
}

/// A column as a list; `None` where a value is missing.
fn listed<'py>(py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyList>> {
    let any = array.as_any();
    if let Some(values) = any.downcast_ref::<Float64Array>() {
        return PyList::new(py, values.iter().collect::<Vec<_>>());
    }
    if let Some(values) = any.downcast_ref::<UInt64Array>() {
        return PyList::new(py, values.iter().collect::<Vec<_>>());
    }
    if let Some(values) = any.downcast_ref::<Int64Array>() {
        return PyList::new(py, values.iter().collect::<Vec<_>>());
    }
    if let Some(values) = any.downcast_ref::<BooleanArray>() {
        return PyList::new(py, values.iter().collect::<Vec<_>>());
    }
    let values = any.downcast_ref::<StringArray>().map(|v| v.iter().collect::<Vec<_>>());
    PyList::new(py, values.unwrap_or_default())
}

#[pymethods]
impl Table {
    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.batch.schema_ref().fields().iter().map(|field| field.name().clone()).collect()
    }

    /// Number of rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.batch.num_rows(), self.batch.num_columns())
    }

    /// Units by column; ``1`` for counts and ratios, empty for words.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.facts(py, "unit")
    }

    /// Definitions by column.
    #[getter]
    fn definitions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.facts(py, "definition")
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    /// A column by name, as a list; a row by its position, as a dictionary; some rows in a row, as
    /// a table: ``table["area_mm2"]``, ``table[0]``, ``table[:5]``. Missing values are ``None``.
    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        which: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if let Ok(name) = which.cast::<PyString>() {
            return Ok(listed(py, self.batch.column(self.field(name.to_str()?)?))?.into_any());
        }
        if let Ok(slice) = which.cast::<PySlice>() {
            let at = slice.indices(self.batch.num_rows() as isize)?;
            if at.step != 1 {
                let what = "rows in a row: table[2:5]; for others use pandas or polars";
                return Err(PyValueError::new_err(what));
            }
            let batch = self.batch.slice(at.start as usize, at.slicelength);
            return Ok(Bound::new(py, Table { batch })?.into_any());
        }
        let position = which.extract().map_err(|_| {
            PyTypeError::new_err("a table has columns by name, and rows by position or as a slice")
        })?;
        Ok(self.row(py, position)?.into_any())
    }

    /// The rows, as dictionaries.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let rows = (0..self.batch.num_rows() as isize).map(|at| self.row(py, at));
        PyList::new(py, rows.collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    /// The first rows.
    #[pyo3(signature = (rows=5))]
    fn head(&self, rows: usize) -> Table {
        Table { batch: self.batch.slice(0, rows.min(self.batch.num_rows())) }
    }

    /// The table as a ``pandas.DataFrame``; needs pandas 3, or pyarrow beside an older one.
    fn to_pandas<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let frame = py.import("pandas")?.getattr("DataFrame")?;
        match frame.hasattr("from_arrow")? {
            true => frame.call_method1("from_arrow", (slf,)),
            false => py.import("pyarrow")?.call_method1("table", (slf,))?.call_method0("to_pandas"),
        }
    }

    /// The table as a ``polars.DataFrame``.
    fn to_polars<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("polars")?.call_method1("DataFrame", (slf,))
    }

    fn __contains__(&self, name: &str) -> bool {
        self.batch.schema_ref().index_of(name).is_ok()
    }

    /// One row as a dictionary; negative positions count from the end.
    fn row<'py>(&self, py: Python<'py>, position: isize) -> PyResult<Bound<'py, PyDict>> {
        let rows = self.batch.num_rows() as isize;
        let at = if position < 0 { position + rows } else { position };
        if !(0..rows).contains(&at) {
            return Err(PyIndexError::new_err(format!("row {position} of {rows}")));
        }
        let dict = PyDict::new(py);
        for (field, array) in self.batch.schema_ref().fields().iter().zip(self.batch.columns()) {
            let one = array.slice(at as usize, 1);
            dict.set_item(field.name(), listed(py, &one)?.get_item(0)?)?;
        }
        Ok(dict)
    }

    /// All columns as a dictionary of lists.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (field, array) in self.batch.schema_ref().fields().iter().zip(self.batch.columns()) {
            dict.set_item(field.name(), listed(py, array)?)?;
        }
        Ok(dict)
    }

    /// The schema in the Arrow C data interface.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        Ok(to_schema_pycapsule(py, self.batch.schema_ref().as_ref())?)
    }

    /// The table in the Arrow C stream interface; its memory is shared, not copied.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let fields = self.batch.schema_ref().fields().clone();
        let array: ArrayRef = Arc::new(StructArray::from(self.batch.clone()));
        let field = Arc::new(Field::new_struct("", fields, false));
        let stream = Box::new(ArrayIterator::new([Ok(array)].into_iter(), field));
        Ok(to_stream_pycapsule(py, stream, requested_schema)?)
    }

    fn __repr__(&self) -> String {
        self.page().terminal(100).trim_end().to_owned()
    }

    fn _repr_html_(&self) -> PyResult<String> {
        self.html()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts<'py>)> {
        let of = py.import("powergs._powergs")?.getattr("_table")?;
        let schema = self.batch.schema_ref();
        let kinds = schema.fields().iter().map(|f| kind(f.data_type()).to_owned()).collect();
        let parts = (self.columns(), kinds, self.units(py)?, self.definitions(py)?);
        Ok((of, (parts.0, parts.1, parts.2, parts.3, self.to_dict(py)?)))
    }
}

/// What a table is pickled as: names, kinds, units, definitions, values.
type Parts<'py> =
    (Vec<String>, Vec<String>, Bound<'py, PyDict>, Bound<'py, PyDict>, Bound<'py, PyDict>);

const fn kind(kind: &DataType) -> &'static str {
    match kind {
        DataType::Float64 => "real",
        DataType::UInt64 => "count",
        DataType::Int64 => "integer",
        DataType::Boolean => "flag",
        _ => "text",
    }
}

/// A pickled table.
#[pyfunction]
pub fn _table(
    names: Vec<String>,
    kinds: Vec<String>,
    units: &Bound<'_, PyDict>,
    definitions: &Bound<'_, PyDict>,
    values: &Bound<'_, PyDict>,
) -> PyResult<Table> {
    let column = |(name, kind): (&String, &String)| -> PyResult<Column> {
        let missing = || Fault::config(format!("a pickled table without `{name}`"));
        let text = |dict: &Bound<'_, PyDict>| -> PyResult<String> {
            dict.get_item(name)?.map_or(Ok(String::new()), |text| text.extract())
        };
        let (unit, definition) = (text(units)?, text(definitions)?);
        let list = values.get_item(name)?.ok_or_else(missing)?;
        Ok(match kind.as_str() {
            "real" => Column::real(name, &unit, &definition, list.extract::<Vec<Option<f64>>>()?),
            "count" => Column::count(name, &unit, &definition, list.extract::<Vec<Option<u64>>>()?),
            "integer" => {
                Column::integer(name, &unit, &definition, list.extract::<Vec<Option<i64>>>()?)
            }
            "flag" => Column::flag(name, &definition, list.extract::<Vec<Option<bool>>>()?),
            _ => Column::text(name, &definition, list.extract::<Vec<Option<String>>>()?),
        })
    };
    let columns: Vec<Column> = names.iter().zip(&kinds).map(column).collect::<PyResult<_>>()?;
    Table::new(columns)
}
