//! Data that a program has in memory.

use super::columns::{Columns, counts_rows};
use super::error::{DataError, Place, RowNumbering, RowSource};
use super::rows::Row;
use super::seen::SeenSeries;
use super::series::Data;
use crate::model::Model;
use crate::timeline::RowTime;

/// Measurements in memory, as a data frame has them: a row for each time.
///
/// Its columns mean what those of a CSV file mean; [`Columns`] says which ones are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table<'a> {
    /// What errors call it.
    pub name: &'a str,
    /// The names of all columns, in order.
    pub header: &'a [String],
    /// The measurements, row by row, each with `M` values in the order of the model; NaN is missing.
    pub measurements: &'a [f64],
    /// The column `series`, if it has one.
    pub series: Option<&'a [String]>,
    /// The column `t`, if it has one.
    pub times: Option<&'a [f64]>,
    /// The column of times that the model names, if it names one.
    pub clock: Option<&'a [String]>,
    /// The columns that inputs come from, row by row, in the order of [`Model::input_columns`]; NaN is missing.
    pub inputs: &'a [f64],
    /// The column that is carried to the output, if it has one.
    pub carried: Option<&'a [String]>,
    /// What an index beside the columns says of each row, if it has one: it is looked at as the carried column is ([`Data::warnings`]).
    pub index: Option<&'a [String]>,
}

/// Times and inputs in memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputTable<'a> {
    /// What errors call it.
    pub name: &'a str,
    /// The names of all columns, in order.
    pub header: &'a [String],
    /// How many rows it has.
    pub rows: usize,
    /// The column `series`, if it has one.
    pub series: Option<&'a [String]>,
    /// The column `t`, which counts rows, if it has one.
    pub times: Option<&'a [f64]>,
    /// The column of times that the model names, if it names one.
    pub clock: Option<&'a [String]>,
    /// The columns that inputs come from, row by row, in the order of [`Model::input_columns`]; NaN is missing.
    pub inputs: &'a [f64],
}

impl Data {
    /// Times and inputs of a table in memory, as [`Data::open_inputs`] has them of a file.
    ///
    /// # Errors
    /// [`DataError`] if there are no rows, or a column is missing or has another length.
    pub fn of_inputs(table: &InputTable<'_>, model: &Model) -> Result<Self, DataError> {
        let file = || table.name.to_string();
        let columns = Columns::of_inputs(table.header, table.name, model)?;
        let (count, width) = (table.rows, columns.inputs.len());
        if count == 0 {
            return Err(DataError::Empty { file: file() });
        }
        let lengths = [
            table.series.map(|column| (column.len(), count)),
            table.times.map(|column| (column.len(), count)),
            table.clock.map(|column| (column.len(), count)),
            Some((table.inputs.len(), count * width)),
        ];
        check_lengths(table.name, lengths)?;
        let (mut seen, mut rows) = (SeenSeries::default(), Vec::with_capacity(count));
        for at in 0..count {
            let series = seen.number_of(table.series.map_or("", |names| &names[at]));
            let inputs = &table.inputs[at * width..][..width];
            let written_time = table.clock.map(|labels| labels[at].clone());
            let time = match (table.times, columns.time) {
                (Some(times), Some(column)) if !counts_rows(times[at]) => {
                    let column = columns.names.get(column).cloned();
                    let place = Place { file: file(), counted: RowNumbering::Row, line: at as u64, column };
                    return Err(DataError::Time { place, value: times[at].to_string(), expected: 0 });
                }
                (Some(times), Some(_)) => times[at],
                _ => 0.0,
            };
            rows.push(Row {
                line: at as u64,
                series,
                time,
                steps: vec![],
                label: written_time.clone(),
                written_time,
                inputs: known(inputs),
                measurement: vec![],
            });
        }
        let (series, clocks) = (seen.names().map(String::from).collect(), seen.clocks().cloned().collect());
        Ok(Data { columns, series, rows, clocks, source: RowSource::of_table(), index: None })
    }

    /// Makes data of a table in memory.
    ///
    /// ```
    /// use motes::{Data, Model, Table};
    ///
    /// let text = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    /// let model = Model::parse(text, "walk", &[])?;
    /// let header = ["y".to_string()];
    /// let table = Table {
    ///     name: "data",
    ///     header: &header,
    ///     measurements: &[0.5, f64::NAN, 1.5],
    ///     series: None,
    ///     times: None,
    ///     clock: None,
    ///     inputs: &[],
    ///     carried: None,
    ///     index: None,
    /// };
    /// let data = Data::of_table(&table, &model)?;
    /// assert_eq!(data.rows[1].measurement, [None]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DataError`] if there are no rows, a column is missing or shorter than others, times do not count, or a measurement is infinite or one that no
    /// state can give.
    pub fn of_table(table: &Table<'_>, model: &Model) -> Result<Self, DataError> {
        let file = || table.name.to_string();
        let columns = Columns::of(table.header, table.name, model)?;
        let width = model.measurements().len();
        if table.measurements.is_empty() {
            return Err(DataError::Empty { file: file() });
        }
        let count = table.measurements.len() / width;
        let lengths = [
            Some(table.measurements.len()).map(|length| (length, count * width)),
            table.series.map(|column| (column.len(), count)),
            table.times.map(|column| (column.len(), count)),
            table.carried.map(|column| (column.len(), count)),
            table.index.map(|column| (column.len(), count)),
            table.clock.map(|column| (column.len(), count)),
            Some((table.inputs.len(), count * columns.inputs.len())),
        ];
        check_lengths(table.name, lengths)?;
        let place = |row: usize, column: Option<&String>| Place {
            file: file(),
            counted: RowNumbering::Row,
            line: row as u64,
            column: column.cloned(),
        };
        let (mut seen, mut rows) = (SeenSeries::default(), Vec::with_capacity(count));
        let inputs = columns.inputs.len();
        for (at, values) in table.measurements.chunks_exact(width).enumerate() {
            let series = seen.number_of(table.series.map_or("", |names| &names[at]));
            let time = seen.times(series);
            if let (Some(times), Some(column)) = (table.times, columns.time)
                && times[at] != time as f64
            {
                let value = times[at].to_string();
                let place = place(at, columns.names.get(column));
                return Err(DataError::Time { place, value, expected: time });
            }
            if let Some(wrong) = values.iter().position(|value| value.is_infinite()) {
                return Err(DataError::Cell {
                    place: place(at, columns.names.get(columns.measurements[wrong])),
                    value: values[wrong].to_string(),
                    problem: "is not finite; a measurement that is missing is NaN",
                });
            }
            let (measurement, inputs) = (known(values), known(&table.inputs[at * inputs..][..inputs]));
            let row = RowTime { label: table.clock.map(|labels| labels[at].as_str()), columns: &inputs };
            let mut steps =
                seen.steps_to(series, row, &measurement, (model, &columns), |column| place(at, column));
            if let (Err(DataError::Timeline { error, .. }), Some(labels)) = (&mut steps, table.clock) {
                let is_of_series = |row: &usize| table.series.is_none_or(|names| names[*row] == names[at]);
                if let Some(last) = (at + 1..count).rev().find(is_of_series) {
                    error.go_on_to(&labels[last]);
                }
            }
            let steps = steps?;
            seen.add(series);
            rows.push(Row {
                line: at as u64,
                series,
                time: steps.last().map_or(0.0, |last| last.step().time),
                steps,
                written_time: table.clock.map(|labels| labels[at].clone()),
                inputs,
                label: table.carried.map(|labels| labels[at].clone()),
                measurement,
            });
        }
        let (series, clocks) = (seen.names().map(String::from).collect(), seen.clocks().cloned().collect());
        let index = table.index.map(<[String]>::to_vec);
        Ok(Data { columns, series, rows, clocks, source: RowSource::of_table(), index })
    }
}

/// Columns of numbers have NaN where a value is missing.
fn known(values: &[f64]) -> Vec<Option<f64>> {
    values.iter().map(|value| (!value.is_nan()).then_some(*value)).collect()
}

/// Refuses a column that is shorter or longer than it must be.
fn check_lengths(
    file: &str,
    lengths: impl IntoIterator<Item = Option<(usize, usize)>>,
) -> Result<(), DataError> {
    match lengths.into_iter().flatten().find(|(found, expected)| found != expected) {
        Some((found, expected)) => Err(DataError::Lengths { file: file.into(), found, expected }),
        None => Ok(()),
    }
}
