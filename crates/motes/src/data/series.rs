//! All rows of a file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::Columns;
use super::error::{DataError, RowSource};
use super::rows::{Row, Rows};
use crate::model::Model;
use crate::timeline::Clock;

/// Measurements at the times of one or several series, in the order of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Data {
    /// What the columns of the file are for.
    pub columns: Columns,
    /// The names of the series, in order of appearance; one without a name where there is no column `series`.
    pub series: Vec<String>,
    /// The rows, in the order of the file.
    pub rows: Vec<Row>,
    /// Where each series is after its last row.
    pub clocks: Vec<Clock>,
    /// Where the rows come from, for errors.
    pub source: RowSource,
    /// What an index beside the columns says of each row, where a table in memory has one.
    pub index: Option<Vec<String>>,
}

impl Data {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// As [`Data::read`].
    pub fn open(path: &Path, model: &Model) -> Result<Self, DataError> {
        let (file, name) = opened(path)?;
        Data::read(file, &name, model)
    }

    /// Reads a CSV file of times and inputs; if it has measurements, they play no part.
    ///
    /// # Errors
    /// As [`Data::read`], but that it may lack measurements.
    pub fn open_inputs(path: &Path, model: &Model) -> Result<Self, DataError> {
        let (file, name) = opened(path)?;
        Data::of_rows(Rows::of_inputs(file, &name, model)?, &name)
    }

    /// Reads CSV with a header from anything; errors call it `file`.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read, has no rows, or is not the data of `model`.
    pub fn read(input: impl Read, file: &str, model: &Model) -> Result<Self, DataError> {
        Data::of_rows(Rows::new(input, file, model)?, file)
    }

    fn of_rows(mut reader: Rows<impl Read>, file: &str) -> Result<Self, DataError> {
        let mut rows = Vec::new();
        while let Some(row) = reader.next_row().map_err(|error| reader.looked_ahead(error))? {
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(DataError::Empty { file: file.into() });
        }
        let series: Vec<String> = reader.series().map(String::from).collect();
        let clocks = reader.clocks();
        let columns = reader.columns().clone();
        Ok(Data { columns, series, rows, clocks, source: RowSource::of_file(file), index: None })
    }

    /// Whether a column `t` counts the rows of times and inputs alone.
    pub(crate) fn counts_rows(&self) -> bool {
        self.columns.counts()
    }

    /// For each series, where its rows stand in [`Data::rows`], in order of time.
    pub fn by_series(&self) -> Vec<Vec<usize>> {
        let mut places = vec![Vec::new(); self.series.len()];
        for (at, row) in self.rows.iter().enumerate() {
            places[row.series].push(at);
        }
        places
    }

    /// How many steps a filter of a series takes before that of its first row.
    pub fn steps_before(&self, series: usize) -> usize {
        self.of_series(series).next().map_or(0, |row| row.steps.len().saturating_sub(1))
    }

    /// The rows of one series, in order of time. Who goes through all series asks [`Data::by_series`] once.
    pub fn of_series(&self, series: usize) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.series == series)
    }
}

/// A file that can be read, and its name.
fn opened(path: &Path) -> Result<(File, String), DataError> {
    let name = path.display().to_string();
    let reason = |error: &std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        std::io::ErrorKind::PermissionDenied => "the permission to read it is missing".to_string(),
        _ => error.to_string(),
    };
    match File::open(path) {
        Ok(file) => Ok((file, name)),
        Err(error) => {
            let (reason, kind) = (reason(&error), Some(error.kind()));
            Err(DataError::Read { file: name, kind, reason })
        }
    }
}
