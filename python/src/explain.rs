//! Definitions of everything that has a name.

use pyo3::prelude::*;
use serde_json::Value as Json;

use crate::error::{Fault, defect};
use powergs_base::config::embedded::SYNTH;
use powergs_base::config::key_docs;
use powergs_report::document::Document;
use powergs_report::explain::{Entry, Keys, document, entries, find};
use powergs_scene::synth::Preset;

/// What a name means: ``str(x)`` is the text, ``x.entries`` a list of dictionaries.
#[pyclass(frozen, module = "powergs", name = "Explanation")]
pub struct Explanation {
    page: Document,
    entries: Vec<Json>,
}

/// What is called ``name``: a statistic (``"frame_time_ms"``), a key (``"vru.cores"``), the start
/// of several (``"dram"``), an assumption (``"A26"``), a source (``"gscore"``) or a word.
///
/// Raises ``ConfigError`` with a suggestion where nothing is.
#[pyfunction]
pub fn explain(name: &str) -> PyResult<Explanation> {
    let docs = key_docs::<Preset>();
    let all = entries([Keys { kind: "key of synthetic scenes", docs, example: &SYNTH[0] }]);
    let found: Vec<&Entry> = find(&all, name).map_err(Fault::config)?;
    let page = document(&found);
    Ok(Explanation { page, entries: found.iter().map(|entry| entry.json()).collect() })
}

#[pymethods]
impl Explanation {
    /// The definitions: dictionaries with ``kind``, ``name``, ``unit``, ``definition``, ``value``
    /// and what else is known.
    #[getter]
    fn entries<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.entries).map_err(defect)?;
        py.import("json")?.call_method1("loads", (text,))
    }

    fn __repr__(&self) -> String {
        self.page.terminal(88).trim_end().to_owned()
    }

    fn _repr_html_(&self) -> PyResult<String> {
        self.page.fragment().map_err(defect)
    }
}
