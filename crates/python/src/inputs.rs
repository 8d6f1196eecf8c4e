//! Times and inputs of rows, given and simulated.

use std::path::PathBuf;

use motes::{Columns, InputTable};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::data::Data;
use crate::errors::to_python;
use crate::model::Model;

/// Times and inputs of a CSV file.
#[pyfunction]
pub(crate) fn open_inputs(model: &Bound<'_, Model>, path: PathBuf) -> PyResult<Data> {
    motes::Data::open_inputs(&path, model.get().motes()).map(Data).map_err(to_python)
}

/// The columns of the series, of `t`, of the times and of each input.
type InputPlaces = (Option<usize>, Option<usize>, Option<usize>, Vec<Option<usize>>);

/// The columns of a table of times and inputs: the series, `t`, the times and the inputs; none for a measurement that is an input of later steps and is not there.
#[pyfunction]
pub(crate) fn columns_of_inputs(model: &Bound<'_, Model>, header: Vec<String>) -> PyResult<InputPlaces> {
    let columns = Columns::of_inputs(&header, "inputs", model.get().motes()).map_err(to_python)?;
    let [series, time, _] = columns.others();
    Ok((series, time, columns.clock(), columns.inputs().to_vec()))
}

/// Times and inputs of a table of so many rows, whose measurements play no part.
#[pyfunction]
pub(crate) fn inputs_of_table(
    model: &Bound<'_, Model>,
    header: Vec<String>,
    count: usize,
    series: Option<Vec<String>>,
    times: Option<Vec<f64>>,
    clock: Option<Vec<String>>,
    inputs: PyReadonlyArray1<'_, f64>,
) -> PyResult<Data> {
    let table = InputTable {
        name: "inputs",
        header: &header,
        rows: count,
        series: series.as_deref(),
        times: times.as_deref(),
        clock: clock.as_deref(),
        inputs: inputs.as_slice()?,
    };
    motes::Data::of_inputs(&table, model.get().motes()).map(Data).map_err(to_python)
}
