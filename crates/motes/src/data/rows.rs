//! Rows of a CSV file, one at a time: what a file and a stream have in common.

use std::io::Read;

use csv::{ByteRecord, Reader, ReaderBuilder, Trim};
use motes_models::StepRecord;
use serde::{Deserialize, Serialize};

use super::cell::{number, of_input};
use super::columns::{Columns, counts_rows};
use super::error::{DataError, Place, RowNumbering};
use super::seen::SeenSeries;
use super::shown::shown;
use crate::model::Model;
use crate::timeline::{Clock, RowTime, TimelineError};

/// A row of data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its line in a file, from 1, or its row in a table, from 0.
    pub line: u64,
    /// The number of its series, in order of appearance.
    pub series: usize,
    /// Its time in the series.
    pub time: f64,
    /// The steps that lead to it; all but the last have no measurement.
    pub steps: Vec<StepRecord>,
    /// What the carried column says.
    pub label: Option<String>,
    /// Its time as it is written, where the model names a column of times.
    pub written_time: Option<String>,
    /// What the columns say that inputs come from, in the order of [`Model::input_columns`].
    pub inputs: Vec<Option<f64>>,
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
    /// Whether rows have steps.
    has_steps: bool,
    /// Which measurements no state can give.
    model: Model,
}

impl<R: Read> Rows<R> {
    /// Reads the header of `input`, which errors call `file`.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read or lacks a measurement of the model.
    pub fn new(input: R, file: &str, model: &Model) -> Result<Self, DataError> {
        Rows::with_columns(input, file, model, Columns::of)
    }

    /// The same of data whose measurements play no part: rows have their times as they are written and their inputs, and no steps.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read or lacks an input of the model.
    pub fn of_inputs(input: R, file: &str, model: &Model) -> Result<Self, DataError> {
        Ok(Rows { has_steps: false, ..Rows::with_columns(input, file, model, Columns::of_inputs)? })
    }

    fn with_columns(
        input: R,
        file: &str,
        model: &Model,
        columns: impl Fn(&[String], &str, &Model) -> Result<Columns, DataError>,
    ) -> Result<Self, DataError> {
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
        let columns = columns(&names, &format!("{file}, line 1"), model)?;
        Ok(Rows {
            reader,
            record: ByteRecord::new(),
            file: file.into(),
            columns,
            series: SeenSeries::default(),
            has_steps: true,
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
                if name.trim().is_empty() {
                    return Err(DataError::NoSeries { place: self.place(line, at) });
                }
                self.series.number_of(&name)
            }
        };
        if self.has_steps {
            self.check_time(line, self.series.times(series))?;
        }
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
        let inputs = self.inputs(line)?;
        let written_time = self.columns.clock.map(|at| self.text(at, line)).transpose()?.map(String::from);
        let row = RowTime { label: written_time.as_deref(), columns: &inputs };
        let steps = match self.has_steps {
            true => {
                let (model, columns) = (&self.model, &self.columns);
                let place = |column: Option<&String>| Place {
                    file: self.file.clone(),
                    counted: RowNumbering::Line,
                    line,
                    column: column.cloned(),
                };
                self.series.steps_to(series, row, &measurement, (model, columns), place)?
            }
            false => vec![],
        };
        self.series.add(series);
        // A row of times and inputs alone has no steps.
        let time = match steps.last() {
            Some(step) => step.step().time,
            None => self.counted(line)?,
        };
        Ok(Some(Row { line, series, time, label, written_time, inputs, measurement, steps }))
    }

    /// An error with how far the rows behind it in its series go, where a file of inputs ends before them.
    pub(super) fn looked_ahead(&mut self, mut error: DataError) -> DataError {
        if let DataError::Timeline { error, .. } = &mut error
            && matches!(error.as_ref(), TimelineError::BeyondFile(_))
            && let Some(at) = self.columns.clock
        {
            let name =
                |record: &ByteRecord| self.columns.series.and_then(|at| record.get(at)).map(<[u8]>::to_vec);
            let series = name(&self.record);
            while let Ok(true) = self.reader.read_byte_record(&mut self.record) {
                if let Some(Ok(time)) = self.record.get(at).map(std::str::from_utf8)
                    && name(&self.record) == series
                {
                    error.go_on_to(time);
                }
            }
        }
        error
    }

    /// What the columns of a row say that inputs come from.
    fn inputs(&self, line: u64) -> Result<Vec<Option<f64>>, DataError> {
        let input = |at: &Option<usize>| {
            let Some(at) = at else { return Ok(None) };
            let text = self.text(*at, line)?;
            number(text).map_err(|problem| DataError::Cell {
                place: self.place(line, *at),
                value: shown(text),
                problem: of_input(problem),
            })
        };
        self.columns.inputs.iter().map(input).collect()
    }

    /// Where each series is after its last row.
    pub fn clocks(&self) -> Vec<Clock> {
        self.series.clocks().cloned().collect()
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

    /// What `t` says of a row of times and inputs alone; 0 where there is no such column.
    fn counted(&self, line: u64) -> Result<f64, DataError> {
        let Some(at) = self.columns.time else { return Ok(0.0) };
        let text = self.text(at, line)?.trim();
        let time = text.parse::<f64>().ok().filter(|time| counts_rows(*time));
        let wrong = || DataError::Time { place: self.place(line, at), value: shown(text), expected: 0 };
        time.ok_or_else(wrong)
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
            counted: RowNumbering::Line,
            line,
            column: Some(self.columns.names[at].clone()),
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
