//! All rows of a file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::Columns;
use super::error::{Counted, DataError};
use super::rows::{Row, Rows};
use crate::model::Model;

/// Measurements at the times of one or several series, in the order of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Data {
    /// What the columns of the file are for.
    pub columns: Columns,
    /// The names of the series, in order of appearance; one without a name where there is no column `series`.
    pub series: Vec<String>,
    /// The rows, in the order of the file.
    pub rows: Vec<Row>,
    /// How rows are counted, for errors.
    pub counted: Counted,
    /// What an index beside the columns says of each row, where a table in memory has one.
    pub index: Option<Vec<String>>,
}

impl Data {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// As [`Data::read`].
    pub fn open(path: &Path, model: &Model) -> Result<Self, DataError> {
        let name = path.display().to_string();
        let reason = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".to_string(),
            std::io::ErrorKind::PermissionDenied => "the permission to read it is missing".to_string(),
            _ => error.to_string(),
        };
        match File::open(path) {
            Ok(file) => Data::read(file, &name, model),
            Err(error) => {
                Err(DataError::Read { file: name, kind: Some(error.kind()), reason: reason(error) })
            }
        }
    }

    /// Reads CSV with a header from anything; errors call it `file`.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read, has no rows, or is not the data of `model`.
    pub fn read(input: impl Read, file: &str, model: &Model) -> Result<Self, DataError> {
        let mut reader = Rows::new(input, file, model)?;
        let mut rows = Vec::new();
        while let Some(row) = reader.next_row()? {
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(DataError::Empty { file: file.into() });
        }
        let series = reader.series().map(String::from).collect();
        Ok(Data { columns: reader.columns().clone(), series, rows, counted: Counted::Line, index: None })
    }

    /// For each series, where its rows stand in [`Data::rows`], in order of time.
    pub fn by_series(&self) -> Vec<Vec<usize>> {
        let mut places = vec![Vec::new(); self.series.len()];
        for (at, row) in self.rows.iter().enumerate() {
            places[row.series].push(at);
        }
        places
    }

    /// The rows of one series, in order of time. Who goes through all series asks [`Data::by_series`] once.
    pub fn of_series(&self, series: usize) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.series == series)
    }
}
