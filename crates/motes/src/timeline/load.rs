//! What a model says of times and inputs, with the files that it names.

use std::path::Path;

use motes_formulas::{Between, Frame, InputRule, InputSource, TimeLabel, TimeRule, TimeUnit};
use motes_models::Stream;

use super::error::TimelineError;
use super::file::InputFile;
use crate::calendar::time_of;

/// The times and inputs of a model.
#[derive(Debug, Clone)]
pub(crate) struct Timeline {
    pub(super) frame: Frame,
    pub(super) rule: TimeRule,
    /// The time of `x_0`: a number, or a date in days, weeks or years.
    pub(super) start: Option<f64>,
    /// The file of each input that has one.
    pub(super) files: Vec<Option<InputFile>>,
    /// The columns of the data that inputs come from.
    pub(super) columns: Vec<String>,
    pub(super) measurements: Vec<String>,
}

impl Timeline {
    /// Reads the files that the model names, relative to a folder; none where the model has neither `[time]` nor inputs, nor sums over a step.
    ///
    /// # Errors
    /// A file, or the section, and what is wrong with it.
    pub(crate) fn load(
        frame: &Frame,
        measurements: &[String],
        folder: &Path,
    ) -> Result<Option<Self>, (String, String)> {
        let of_times = frame.time_rule().and_then(|rule| rule.column.as_deref());
        for (key, column, what) in [
            ("[time] column", of_times, "the times"),
            ("[series] by", frame.series_column(), "the name of each row's series"),
        ] {
            if let Some(column) = column.filter(|column| measurements.iter().any(|name| name == column)) {
                let reason = format!("{column} is a measurement; name the column that has {what}");
                return Err((key.into(), reason));
            }
        }
        let mut inputs = frame.inputs().iter().enumerate();
        if let Some((_, input)) = inputs.find(|(number, _)| sees_itself(frame, measurements, *number)) {
            let reason = "is a measurement of the same row, which is measured by it; rows = 1 takes that of the row before";
            return Err((format!("[inputs] {}", input.name), reason.into()));
        }
        let needs_step = (0..measurements.len()).any(|entry| frame.needs_step(entry));
        if frame.time_rule().is_none() && frame.inputs().is_empty() && !needs_step {
            return Ok(None);
        }
        let rule = frame.time_rule().cloned().unwrap_or_default();
        let start = match &rule.start {
            None => None,
            Some(TimeLabel::Number(number)) => Some(*number),
            Some(TimeLabel::Date(date)) => Some(
                time_of(date, rule.unit).map_err(|error| ("[time] start".to_string(), error.to_string()))?,
            ),
        };
        let file = |input: &InputRule| match &input.source {
            InputSource::File { path, column } => {
                let path = folder.join(path);
                let read = InputFile::read(
                    &path,
                    column,
                    frame.series_column().unwrap_or("series"),
                    rule.column.as_deref(),
                    rule.unit,
                );
                read.map(Some).map_err(|reason| (path.display().to_string(), reason))
            }
            _ => Ok(None),
        };
        let files = frame.inputs().iter().map(file).collect::<Result<_, _>>()?;
        let mut columns: Vec<String> = Vec::new();
        for input in frame.inputs() {
            if let InputSource::Column(column) | InputSource::Lag { column, .. } = &input.source
                && !columns.contains(column)
            {
                columns.push(column.clone());
            }
        }
        let measurements = measurements.to_vec();
        Ok(Some(Timeline { frame: frame.clone(), rule, start, files, columns, measurements }))
    }

    /// The same of the model with other parameters, which do not change its inputs; the length of sub-steps may depend on them.
    pub(crate) fn of_model(&self, frame: &Frame) -> Timeline {
        let rule = frame.time_rule().cloned().unwrap_or_default();
        Timeline { frame: frame.clone(), rule, ..self.clone() }
    }

    /// Draws what the columns of a row say that inputs come from; a measurement says nothing yet.
    ///
    /// # Errors
    /// [`TimelineError::Simulated`] with an input that is not simulated.
    pub(crate) fn simulated_columns(
        &self,
        time: f64,
        stream: &mut Stream,
    ) -> Result<Vec<Option<f64>>, TimelineError> {
        let mut columns = vec![None; self.columns.len()];
        let at = |column: &String| self.columns.iter().position(|known| known == column);
        let inputs = self.frame.inputs();
        for (number, value) in self.frame.simulate_inputs(time, stream) {
            if let InputSource::Column(column) = &inputs[number].source
                && let Some(at) = at(column)
            {
                columns[at] = Some(value);
            }
        }
        let is_known = |input: &&InputRule| match &input.source {
            InputSource::File { .. } => true,
            InputSource::Column(column) | InputSource::Lag { column, .. } => {
                self.measurements.contains(column) || at(column).is_none_or(|at| columns[at].is_some())
            }
        };
        match inputs.iter().find(|input| !is_known(input)) {
            Some(input) => Err(TimelineError::Simulated { input: input.name.clone() }),
            None => Ok(columns),
        }
    }

    /// The date of `x_0`, if the file states one.
    pub(crate) fn start_date(&self) -> Option<&str> {
        match &self.rule.start {
            Some(TimeLabel::Date(date)) => Some(date),
            _ => None,
        }
    }

    /// The column of times that are dates, where it is not known when the first row is.
    pub(crate) fn undated_column(&self) -> Option<&str> {
        let is_dated = match self.rule.unit {
            None => true,
            Some(TimeUnit::Year) => self.start.is_some(),
            Some(TimeUnit::Day | TimeUnit::Week) => self.start_date().is_some(),
        };
        self.rule.column.as_deref().filter(|_| !is_dated)
    }

    /// Whether rows that nobody gave have dates.
    pub(crate) fn has_dates(&self) -> bool {
        self.rule.unit.is_some() && self.undated_column().is_none()
    }

    /// Whether `x_0` has a time of its own.
    pub(crate) fn has_start(&self) -> bool {
        self.start.is_some()
    }

    /// The column of times, if there is one.
    pub(crate) fn time_column(&self) -> Option<&str> {
        self.rule.column.as_deref()
    }

    /// The columns of data that inputs come from: those of measurements, too.
    pub(crate) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The time of `x_0`, where times count from this one.
    pub(super) fn start_since(&self, origin: f64) -> Option<f64> {
        let is_number = matches!(self.rule.start, Some(TimeLabel::Number(_)));
        let is_relative = is_number && self.rule.counts_from_first_row();
        self.start.map(|start| if is_relative { start } else { start - origin })
    }

    /// The column of data that an input comes from.
    pub(crate) fn column_of(&self, input: &str) -> Option<&str> {
        let rule = self.frame.inputs().iter().find(|rule| rule.name == input)?;
        match &rule.source {
            InputSource::Column(column) | InputSource::Lag { column, .. } => Some(column),
            InputSource::File { .. } => None,
        }
    }

    /// A section as errors call it: a function has its name.
    pub(super) fn place(&self, section: &'static str) -> &'static str {
        if self.frame.is_of_functions() { section.trim_matches(['[', ']']) } else { section }
    }

    /// How many rows inputs look back at most.
    pub(super) fn look_back(&self) -> usize {
        let of = |input: &InputRule| match input.source {
            InputSource::Lag { rows, .. } => rows,
            _ => 1,
        };
        self.frame.inputs().iter().map(of).max().unwrap_or(0)
    }
}

/// Whether an input is a measurement of the row that it leads to, in a way that what is measured depends on itself: through the state, or by other measurements of the row.
fn sees_itself(frame: &Frame, measurements: &[String], input: usize) -> bool {
    let of_measurement = |number: usize| match &frame.inputs()[number].source {
        InputSource::Column(column) => measurements.iter().position(|name| name == column),
        _ => None,
    };
    let Some(measured) = of_measurement(input) else { return false };
    // Functions do not say which equation uses an input.
    if frame.is_of_functions() {
        return false;
    }
    let (rule, used) = (&frame.inputs()[input], frame.input_use(input));
    if used.initial || (used.transition && rule.between != Between::Hold) {
        return true;
    }
    let (mut seen, mut behind) = (vec![false; measurements.len()], vec![measured]);
    while let Some(entry) = behind.pop() {
        for (number, _) in
            frame.inputs().iter().enumerate().filter(|(number, _)| frame.needs_input(entry, *number))
        {
            match of_measurement(number) {
                Some(next) if next == measured && number == input => return true,
                Some(next) if !seen[next] => {
                    seen[next] = true;
                    behind.push(next);
                }
                _ => {}
            }
        }
    }
    false
}
