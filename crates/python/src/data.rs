//! Data: the rows of measurements of one or several series.

use motes::{pack, unpack};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::to_python;

/// What errors call their bytes, and the version of these.
const PACKED: (&str, u32) = ("data", 2);

/// Rows of measurements that are fit for a model.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Data(pub(crate) motes::Data);

#[pymethods]
impl Data {
    /// Those of which `__getnewargs__` gives the bytes: for pickles and copies.
    #[new]
    fn new(bytes: &[u8]) -> PyResult<Self> {
        unpack(PACKED.0, PACKED.1, bytes).map(Data).map_err(to_python)
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>,)> {
        let bytes = pack(PACKED.0, PACKED.1, &self.0).map_err(to_python)?;
        Ok((PyBytes::new(py, &bytes),))
    }

    /// The names of the series, in order of appearance; none where the data have one series without a name.
    #[getter]
    fn series_names(&self) -> Option<Vec<String>> {
        self.0.columns.has_series().then(|| self.0.series.clone())
    }

    /// The name of the column that tells series apart.
    #[getter]
    fn series_column(&self) -> Option<&str> {
        self.0.columns.series()
    }

    /// The number of the series of each row.
    #[getter]
    fn series<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.0.rows.iter().map(|row| row.series as i64).collect::<Vec<_>>().into_pyarray(py)
    }

    /// The time of each row in its series.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.rows.iter().map(|row| row.time).collect::<Vec<_>>().into_pyarray(py)
    }

    /// The measurements, row by row; NaN where one is missing.
    #[getter]
    fn measurements<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values = self.0.rows.iter().flat_map(|row| &row.measurement);
        values.map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<_>>().into_pyarray(py)
    }

    /// The name of the column that is carried to results, and what it says in each row.
    #[getter]
    fn carried(&self) -> Option<(String, Vec<String>)> {
        let name = self.0.columns.carried()?;
        let labels = self.0.rows.iter().map(|row| row.label.clone().unwrap_or_default());
        Some((name.to_string(), labels.collect()))
    }

    /// The names of the columns that are not used.
    #[getter]
    fn ignored(&self) -> Vec<String> {
        self.0.columns.ignored.clone()
    }
}
