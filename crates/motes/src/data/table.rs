//! Data that a program has in memory.

use super::columns::Columns;
use super::error::{Counted, DataError, Place};
use super::rows::Row;
use super::seen::SeenSeries;
use super::series::Data;
use crate::model::Model;

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
    /// The column that is carried to the output, if it has one.
    pub carried: Option<&'a [String]>,
    /// What an index beside the columns says of each row, if it has one: it is looked at as the carried column is ([`Data::warnings`]).
    pub index: Option<&'a [String]>,
}

impl Data {
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
        let columns = Columns::of(table.header, table.name, model.states(), model.measurements())?;
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
        ];
        if let Some((found, expected)) =
            lengths.into_iter().flatten().find(|(found, expected)| found != expected)
        {
            return Err(DataError::Lengths { file: file(), found, expected });
        }
        let place = |row: usize, column: usize| Place {
            file: file(),
            counted: Counted::Row,
            line: row as u64,
            column: columns.names[column].clone(),
        };
        let (mut seen, mut rows) = (SeenSeries::default(), Vec::with_capacity(count));
        for (at, values) in table.measurements.chunks_exact(width).enumerate() {
            let series = seen.number_of(table.series.map_or("", |names| &names[at]));
            let time = seen.times(series);
            if let (Some(times), Some(column)) = (table.times, columns.time)
                && times[at] != time as f64
            {
                let value = times[at].to_string();
                return Err(DataError::Time { place: place(at, column), value, expected: time });
            }
            if let Some(wrong) = values.iter().position(|value| value.is_infinite()) {
                return Err(DataError::Cell {
                    place: place(at, columns.measurements[wrong]),
                    value: values[wrong].to_string(),
                    problem: "is not finite; a measurement that is missing is NaN",
                });
            }
            let measurement: Vec<Option<f64>> =
                values.iter().map(|value| (!value.is_nan()).then_some(*value)).collect();
            if let Some(impossible) = model.impossible(time, &measurement) {
                let place = place(at, columns.measurements[impossible.coordinate]);
                return Err(DataError::Impossible { place, impossible: impossible.into() });
            }
            seen.add(series);
            rows.push(Row {
                line: at as u64,
                series,
                time,
                label: table.carried.map(|labels| labels[at].clone()),
                measurement,
            });
        }
        let series = seen.names().map(String::from).collect();
        let index = table.index.map(<[String]>::to_vec);
        Ok(Data { columns, series, rows, counted: Counted::Row, index })
    }
}
