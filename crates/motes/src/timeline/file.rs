//! Files of inputs: values at times, for one or several series.

use std::collections::BTreeMap;
use std::path::Path;

use csv::ReaderBuilder;
use motes_formulas::{Between, TimeUnit};

use super::error::{BeyondFile, TimelineError, zone_words};
use crate::calendar::{has_zone, label_of, time_of};

/// How far times are apart, relative to their size, that are the same but for rounding: 60 ms of dates in days.
const ROUNDING: f64 = 1e-12;

/// The values of a column at increasing times.
#[derive(Debug, Clone, Default, PartialEq)]
struct Values {
    times: Vec<f64>,
    values: Vec<f64>,
}

/// A column of a file: of one sequence for all series, or of one for each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InputFile {
    file: String,
    has_series: bool,
    unit: Option<TimeUnit>,
    /// Whether its times have a zone, where they are times of a day.
    zones: Option<bool>,
    series: BTreeMap<String, Values>,
}

impl InputFile {
    /// Reads a column, with the column of times that the model names, or else `t`, and perhaps one that tells series apart.
    ///
    /// # Errors
    /// What is wrong, with the line.
    pub(super) fn read(
        path: &Path,
        column: &str,
        series: &str,
        time: Option<&str>,
        unit: Option<TimeUnit>,
    ) -> Result<Self, String> {
        let mut reader = ReaderBuilder::new().from_path(path).map_err(|error| match error.kind() {
            csv::ErrorKind::Io(error) if error.kind() == std::io::ErrorKind::NotFound => {
                "there is no such file".to_string()
            }
            _ => error.to_string(),
        })?;
        let header: Vec<String> = match reader.headers() {
            Ok(header) => header.iter().map(|name| name.trim().to_string()).collect(),
            Err(error) => return Err(error.to_string()),
        };
        if let Some(twice) = header.iter().enumerate().find(|(at, name)| header[..*at].contains(name)) {
            return Err(format!("line 1: the column {} stands twice", twice.1));
        }
        let position = |name: &str| header.iter().position(|known| known == name);
        let missing =
            |name: &str| format!("line 1: there is no column {name}; there are {}", header.join(", "));
        let value_at = position(column).ok_or_else(|| missing(column))?;
        let time_at = match time {
            Some(name) => position(name).ok_or_else(|| missing(name))?,
            None => position("t").ok_or_else(|| missing("t"))?,
        };
        let series_at = position(series);
        let mut series: BTreeMap<String, Values> = BTreeMap::new();
        let mut zones: Option<bool> = None;
        for record in reader.records() {
            let record = record.map_err(|error| error.to_string())?;
            let line = record.position().map_or(0, csv::Position::line);
            let cell = |at: usize| record.get(at).unwrap_or_default();
            let name = series_at.map(cell).unwrap_or_default().to_string();
            let fault = |at: usize, reason: String| format!("line {line}, column {}: {reason}", header[at]);
            let time = time_of(cell(time_at), unit).map_err(|error| fault(time_at, error.to_string()))?;
            if let Some(has) = has_zone(cell(time_at)).filter(|_| unit.is_some()) {
                if zones.is_some_and(|before| before != has) {
                    let [this, other] = zone_words(has);
                    return Err(fault(
                        time_at,
                        format!("{} has {this} zone, and times before it have {other}", cell(time_at)),
                    ));
                }
                zones = Some(has);
            }
            let text = cell(value_at).trim();
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            let value = value.ok_or_else(|| {
                let found = if text.is_empty() { "an empty cell" } else { text };
                fault(value_at, format!("{found} is no number; an input has one in each row"))
            })?;
            let values = series.entry(name).or_default();
            if let Some(before) = values.times.last().filter(|before| **before >= time) {
                let [time, before] = [time, *before].map(|time| label_of(time, unit, zones == Some(true)));
                return Err(fault(time_at, format!("{time} comes after {before}; times increase")));
            }
            values.times.push(time);
            values.values.push(value);
        }
        if series.is_empty() {
            return Err("there are no rows".to_string());
        }
        let (file, has_series) = (path.display().to_string(), series_at.is_some());
        Ok(InputFile { file, has_series, unit, zones, series })
    }

    /// Refuses times whose zones are known beside those of rows that are not, or the other way round.
    pub(super) fn check_zones(&self, of_rows: Option<bool>) -> Result<(), TimelineError> {
        let words = |has: bool| zone_words(has)[0];
        match (self.zones, of_rows) {
            (Some(own), Some(of_rows)) if own != of_rows => Err(TimelineError::FileZones {
                file: self.file.clone(),
                own: words(own),
                of_rows: words(of_rows),
            }),
            _ => Ok(()),
        }
    }

    /// The value at a time less a lag. What leads to a row is that of the next one where a step begins at a time of the file, and of that one where the row `is_reached`.
    ///
    /// # Errors
    /// [`TimelineError::BeyondFile`] if the file does not have it, [`TimelineError::NoSeries`] if it has nothing of the series.
    pub(super) fn value(
        &self,
        input: &str,
        series: &str,
        (time, lag): (f64, f64),
        between: Between,
        holds_beyond: bool,
        is_reached: bool,
    ) -> Result<f64, TimelineError> {
        let time = time - lag;
        let name = if self.has_series { series } else { "" };
        let Some(Values { times, values }) = self.series.get(name) else {
            return Err(TimelineError::NoSeries { file: self.file.clone(), series: series.into() });
        };
        let (first, last) = (times[0], times[times.len() - 1]);
        // Rounding of the times of sub-steps is no reason to be beyond.
        let slack = 1e-9 * time.abs().max(last - first).max(1.0);
        if !holds_beyond && (time < first - slack || time > last + slack) {
            let (file, input, is_after) = (self.file.clone(), input.to_string(), time > last);
            let [first, last, time] = [first, last, time].map(|time| label_of(time, self.unit, false));
            let lag = if lag == 0.0 { String::new() } else { format!(", as it lags by {lag}") };
            let beyond = BeyondFile { file, input, first, last, time, lag, is_after, on_to: String::new() };
            return Err(TimelineError::BeyondFile(Box::new(beyond)));
        }
        // A sub-step that begins at a time of the file does so but for rounding.
        let slack = ROUNDING * time.abs().max(last - first).max(lag.abs());
        // How many times are at or before it.
        let before = times.partition_point(|known| *known <= time + slack);
        let at_or_after = times.partition_point(|known| *known < time - slack);
        let of = |at: usize| values[at.min(values.len() - 1)];
        Ok(match between {
            _ if before == 0 => values[0],
            _ if before == times.len() => values[before - 1],
            Between::Hold => of(before - 1),
            Between::Next => of(if is_reached { at_or_after } else { before }),
            Between::Linear => {
                let share = (time - times[before - 1]) / (times[before] - times[before - 1]);
                of(before - 1) + share * (of(before) - of(before - 1))
            }
        })
    }
}
