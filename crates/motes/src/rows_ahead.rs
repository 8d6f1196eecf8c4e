//! Which rows are predicted after a series.

use crate::data::{Data, Row};
use crate::error::MotesError;
use crate::model::Model;
use crate::options::FilterOptions;
use crate::timeline::RowTime;

/// The rows that are predicted after the `behind` rows of a series: with times and inputs where they are known. Of a file whose column `t` counts rows, those that the data have are left out; of more
/// rows than are asked for, the first ones are taken.
///
/// # Errors
/// [`MotesError::Setting`] if the file's rows are fewer than are asked for, or do not go on where the data end.
pub fn rows_ahead<'o>(
    options: &'o FilterOptions,
    series: Option<&str>,
    behind: usize,
) -> Result<Vec<Option<RowTime<'o>>>, MotesError> {
    let Some(ahead) = &options.ahead else { return Ok(vec![None; options.forecast]) };
    let is_of_series = |row: &&Row| {
        !ahead.columns.has_series() || series.is_none_or(|name| ahead.series[row.series] == name)
    };
    let mut rows: Vec<&Row> = ahead.rows.iter().filter(is_of_series).collect();
    let refused = |reason: String| {
        let of = series.map_or_else(String::new, |series| format!("series {series}: "));
        let file = ahead.source.file.as_deref().unwrap_or("a table");
        Err(MotesError::Setting(format!("--inputs: {of}{file} {reason}")))
    };
    if ahead.counts_rows() && !rows.is_empty() {
        rows.retain(|row| row.time >= behind as f64);
        let goes_on = rows.iter().enumerate().all(|(number, row)| row.time == (behind + number) as f64);
        if !goes_on || rows.is_empty() {
            return refused(format!("has no row at t = {behind}, where the data end, or not all after it"));
        }
    }
    if rows.len() < options.forecast {
        return refused(format!(
            "has {} rows after the data, and --forecast asks for {}",
            rows.len(),
            options.forecast
        ));
    }
    if options.forecast > 0 {
        rows.truncate(options.forecast);
    }
    Ok(rows
        .into_iter()
        .map(|row| Some(RowTime { label: row.written_time.as_deref(), columns: &row.inputs }))
        .collect())
}

/// Refuses forecasts after data that need what is not known then, before a filter runs over the data.
///
/// # Errors
/// As [`rows_ahead`], and [`MotesError::Ahead`] with the input that is missing.
pub fn check_forecasts(model: &Model, data: &Data, options: &FilterOptions) -> Result<(), MotesError> {
    check_ahead(options, data)?;
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut clock = data.clocks[series].clone();
        for row in rows_ahead(options, name, places.len())? {
            // What is drawn for measurements that are inputs is known later.
            if model.fed_back_measurement().is_none() {
                model.steps_ahead(&mut clock, row).map_err(|error| MotesError::Ahead(Box::new(error)))?;
            }
        }
    }
    Ok(())
}

/// Refuses rows ahead of series that the data do not have.
///
/// # Errors
/// [`MotesError::Setting`] with the first one.
pub(crate) fn check_ahead(options: &FilterOptions, data: &Data) -> Result<(), MotesError> {
    let Some(ahead) = options.ahead.as_ref().filter(|ahead| ahead.columns.has_series()) else {
        return Ok(());
    };
    match ahead.series.iter().find(|name| data.columns.has_series() && !data.series.contains(name)) {
        None => Ok(()),
        Some(name) => Err(MotesError::Setting(format!(
            "--inputs: {} has the series {name}, and the data have none of that name",
            ahead.source.file.as_deref().unwrap_or("a table")
        ))),
    }
}
