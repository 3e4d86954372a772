//! Charts: SVG and PNG.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{Fault, defect};
use powergs_chart::{Chart as Drawing, Format, Sheet, Style};
use powergs_core::run::store::atomic::write_atomically;

/// A chart. Notebooks show it; ``svg``, ``png`` and ``pdf`` give its bytes.
#[pyclass(frozen, module = "powergs", name = "Chart")]
pub struct Chart {
    /// File name without its ending.
    #[pyo3(get)]
    name: String,
    /// What it shows.
    #[pyo3(get)]
    title: String,
    drawn: Drawn,
}

enum Drawn {
    /// It can be drawn in any format and size.
    Live(Box<Drawing>, Style),
    /// It was pickled.
    Kept(String),
}

impl Chart {
    /// A chart of the library.
    pub fn new(chart: Drawing) -> Chart {
        let (name, title) = (chart.name.to_owned(), chart.title.clone());
        Chart { name, title, drawn: Drawn::Live(Box::new(chart), Style::default()) }
    }

    /// A chart that only its SVG is left of.
    pub fn kept(name: String, title: String, svg: String) -> Chart {
        Chart { name, title, drawn: Drawn::Kept(svg) }
    }

    /// Its name and title.
    pub fn names(&self) -> (&str, &str) {
        (&self.name, &self.title)
    }

    /// Its SVG.
    pub fn drawn(&self) -> PyResult<String> {
        match &self.drawn {
            Drawn::Live(chart, style) => chart.svg(*style).map_err(defect),
            Drawn::Kept(svg) => Ok(svg.clone()),
        }
    }

    fn live(&self) -> PyResult<(&Drawing, Style)> {
        match &self.drawn {
            Drawn::Live(chart, style) => Ok((chart, *style)),
            Drawn::Kept(_) => {
                let what = "a chart that was pickled is there as SVG only";
                Err(PyValueError::new_err(what))
            }
        }
    }
}

/// How a chart is laid out.
pub fn style(size: &str, title: bool) -> PyResult<Style> {
    let sheet = size.parse::<Sheet>();
    let sheet = sheet.map_err(|why| Fault::config(format!("size \"{size}\": {why}")).raise())?;
    Ok(Style { sheet, title })
}

#[pymethods]
impl Chart {
    /// The chart as SVG.
    #[getter]
    fn svg(&self) -> PyResult<String> {
        self.drawn()
    }

    /// The same chart in another size: ``"slide"`` (1920 x 1080 pixels), ``"page"`` (7 in wide),
    /// ``"column"`` (3.33 in), or a width such as ``"3.5in"``, ``"88mm"`` or ``"252pt"``, with or
    /// without its title.
    #[pyo3(signature = (size="slide", *, title=true))]
    fn styled(&self, size: &str, title: bool) -> PyResult<Chart> {
        let (chart, _) = self.live()?;
        let drawn = Drawn::Live(Box::new(chart.clone()), style(size, title)?);
        Ok(Chart { name: self.name.clone(), title: self.title.clone(), drawn })
    }

    /// The chart as PNG.
    #[getter]
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let (chart, style) = self.live()?;
        Ok(PyBytes::new(py, &chart.png(style).map_err(defect)?))
    }

    /// The chart as PDF of one page.
    #[getter]
    fn pdf<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let (chart, style) = self.live()?;
        let pdf = Format::Pdf.file(chart, style).map_err(defect)?;
        Ok(PyBytes::new(py, &pdf))
    }

    /// Writes the chart; the ending of ``path`` (``.svg``, ``.png``, ``.pdf``) says how.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let format = Format::ALL.into_iter().find(|format| format.ending() == ending);
        let Some(format) = format else {
            let what = format!("{}: a chart is saved as .svg, .png or .pdf", path.display());
            return Err(PyValueError::new_err(what));
        };
        let bytes = match format {
            Format::Svg => self.drawn()?.into_bytes(),
            format => {
                let (chart, style) = self.live()?;
                format.file(chart, style).map_err(defect)?
            }
        };
        Ok(write_atomically(&path, |out| out.write_all(&bytes)).map_err(Fault::from)?)
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        Ok(within(&self.drawn()?))
    }

    fn __repr__(&self) -> String {
        format!("<Chart {}: {}>", self.name, self.title)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (String, String, String))> {
        let of = py.import("powergs._powergs")?.getattr("_chart")?;
        Ok((of, (self.name.clone(), self.title.clone(), self.drawn()?)))
    }
}

/// A drawing that is at most as wide as the cell of a notebook.
fn within(svg: &str) -> String {
    let Some((head, rest)) = svg.split_once("<svg width=\"") else { return svg.to_owned() };
    let Some((width, rest)) = rest.split_once('"') else { return svg.to_owned() };
    let style = format!("style=\"max-width: 100%; width: {width}px; height: auto\"");
    format!("{head}<svg {style} width=\"{width}\"{rest}")
}

/// A pickled chart.
#[pyfunction]
pub fn _chart(name: String, title: String, svg: String) -> Chart {
    Chart::kept(name, title, svg)
}
