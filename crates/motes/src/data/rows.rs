//! Rows of a CSV file, one at a time: what a file and a stream have in common.

use std::io::Read;

use csv::{ByteRecord, Reader, ReaderBuilder, Trim};
use serde::{Deserialize, Serialize};

use super::cell::number;
use super::columns::Columns;
use super::error::{Counted, DataError, Place};
use super::seen::SeenSeries;
use super::shown::shown;
use crate::model::Model;

/// A row of data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its line in a file, from 1, or its row in a table, from 0.
    pub line: u64,
    /// The number of its series, in order of appearance.
    pub series: usize,
    /// Its time in the series.
    pub time: usize,
    /// What the carried column says.
    pub label: Option<String>,
    /// The measurement, in the model's order.
    pub measurement: Vec<Option<f64>>,
}

/// The rows of a CSV text, which are read as they come.
pub struct Rows<R> {
    reader: Reader<R>,
    record: ByteRecord,
    file: String,
    columns: Columns,
    series: SeenSeries,
    /// Which measurements no state can give.
    model: Model,
}

impl<R: Read> Rows<R> {
    /// Reads the header of `input`, which errors call `file`.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read or lacks a measurement of the model.
    pub fn new(input: R, file: &str, model: &Model) -> Result<Self, DataError> {
        let mut reader = ReaderBuilder::new().trim(Trim::None).flexible(true).from_reader(input);
        let header = reader.byte_headers().map_err(|error| read_error(file, &error))?.clone();
        if header.is_empty() {
            return Err(DataError::Empty { file: file.into() });
        }
        let text = |cell: &[u8]| match std::str::from_utf8(cell) {
            Ok(text) => Ok(text.to_string()),
            Err(_) => Err(DataError::NotUtf8 { file: file.into(), line: 1 }),
        };
        let names: Vec<String> = header.iter().map(text).collect::<Result<_, _>>()?;
        let columns = Columns::of(&names, &format!("{file}, line 1"), model.states(), model.measurements())?;
        Ok(Rows {
            reader,
            record: ByteRecord::new(),
            file: file.into(),
            columns,
            series: SeenSeries::default(),
            model: model.clone(),
        })
    }

    /// What the columns are for.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// The names of the series so far, in order of appearance.
    pub fn series(&self) -> impl Iterator<Item = &str> {
        self.series.names()
    }

    /// The next row, or none at the end.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read or is no row of data.
    pub fn next_row(&mut self) -> Result<Option<Row>, DataError> {
        let is_there = self.reader.read_byte_record(&mut self.record);
        if !is_there.map_err(|error| read_error(&self.file, &error))? {
            return Ok(None);
        }
        let line = self.record.position().map_or(0, csv::Position::line);
        self.check_width(line)?;
        self.check_blank(line)?;
        let series = match self.columns.series {
            None => self.series.number_of(""),
            Some(at) => {
                let name = self.text(at, line)?.to_string();
                self.series.number_of(&name)
            }
        };
        let time = self.series.times(series);
        self.check_time(line, time)?;
        let label = match self.columns.carried {
            Some(at) => Some(self.text(at, line)?.to_string()),
            None => None,
        };
        let mut measurement = Vec::with_capacity(self.columns.measurements.len());
        for &at in &self.columns.measurements {
            let text = self.text(at, line)?;
            measurement.push(number(text).map_err(|problem| DataError::Cell {
                place: self.place(line, at),
                value: shown(text),
                problem,
            })?);
        }
        if let Some(impossible) = self.model.impossible(time, &measurement) {
            let place = self.place(line, self.columns.measurements[impossible.coordinate]);
            return Err(DataError::Impossible { place, impossible: impossible.into() });
        }
        self.series.add(series);
        Ok(Some(Row { line, series, time, label, measurement }))
    }

    /// A reader of CSV passes over blank lines, which in a file of one column would be times that get lost.
    fn check_blank(&self, line: u64) -> Result<(), DataError> {
        match self.columns.names.len() == 1 && self.reader.position().line() > line + 1 {
            true => Err(DataError::Blank { file: self.file.clone(), line }),
            false => Ok(()),
        }
    }

    fn check_width(&self, line: u64) -> Result<(), DataError> {
        let (found, expected) = (self.record.len(), self.columns.names.len());
        if found == expected {
            return Ok(());
        }
        let hint =
            if found > expected { "; a decimal comma, or a comma in a text without quotes?" } else { "" };
        Err(DataError::Ragged { file: self.file.clone(), line, found, expected, hint: hint.into() })
    }

    /// `t` counts, where there is such a column.
    fn check_time(&self, line: u64, expected: usize) -> Result<(), DataError> {
        let Some(at) = self.columns.time else { return Ok(()) };
        let text = self.text(at, line)?.trim();
        if text.parse::<f64>().is_ok_and(|time| time == expected as f64) {
            return Ok(());
        }
        Err(DataError::Time { place: self.place(line, at), value: shown(text), expected })
    }

    fn text(&self, at: usize, line: u64) -> Result<&str, DataError> {
        std::str::from_utf8(&self.record[at])
            .map_err(|_| DataError::NotUtf8 { file: self.file.clone(), line })
    }

    fn place(&self, line: u64, at: usize) -> Place {
        Place {
            file: self.file.clone(),
            counted: Counted::Line,
            line,
            column: self.columns.names[at].clone(),
        }
    }
}

fn read_error(file: &str, error: &csv::Error) -> DataError {
    let reason = match error.kind() {
        csv::ErrorKind::Io(error) => match error.kind() {
            std::io::ErrorKind::IsADirectory => "this is a folder; data are a file".to_string(),
            _ => error.to_string(),
        },
        _ => error.to_string(),
    };
    let kind = match error.kind() {
        csv::ErrorKind::Io(error) => Some(error.kind()),
        _ => None,
    };
    DataError::Read { file: file.into(), kind, reason }
}
