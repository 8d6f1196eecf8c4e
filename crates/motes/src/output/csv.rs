//! Tables of estimates and of simulated series.

use motes_smc::Predictive;

use super::number::text;
use crate::calendar::{following, is_same_time};
use crate::data::{Columns, Data, Row};
use crate::estimate::{Coordinate, Estimate, Forecast, MOMENTS, OF_WEIGHTS, PLACE};
use crate::filtered::Filtered;
use crate::mixture::PosteriorEstimates;
use crate::model::Model;
use crate::names::ModelNames;
use crate::quantiles::Quantiles;
use crate::simulating::Simulated;

/// A table of estimates: its header and its rows, each a line that ends.
#[derive(Debug, Clone)]
pub struct EstimateTable {
    series: Option<String>,
    carried: Option<String>,
    states: Vec<String>,
    /// Whether rows have the effective sample size and the log-evidence.
    has_weights: bool,
    measurements: Vec<String>,
    /// What the quantiles are called.
    quantiles: Vec<String>,
    /// Whether measurements are predicted one step ahead, and in forecasts.
    is_predictive: bool,
    has_forecasts: bool,
}

impl EstimateTable {
    /// That of a model's states, with these quantiles, for data with such columns: a smoother's.
    pub fn new(names: &ModelNames, columns: &Columns, quantiles: &Quantiles) -> Self {
        EstimateTable {
            series: columns.series().map(String::from),
            carried: columns.carried().map(String::from),
            states: names.states.clone(),
            has_weights: false,
            measurements: names.measurements.clone(),
            quantiles: quantiles.names(),
            is_predictive: false,
            has_forecasts: false,
        }
    }

    /// That of a filter: with what weights say, and with what is expected of measurements, one step ahead or in forecasts, as far as it is there.
    pub fn of_filter(
        names: &ModelNames,
        columns: &Columns,
        quantiles: &Quantiles,
        is_predictive: bool,
        has_forecasts: bool,
    ) -> Self {
        let of_states = EstimateTable::new(names, columns, quantiles);
        EstimateTable { has_weights: true, is_predictive, has_forecasts, ..of_states }
    }

    /// That of what is predicted after the last measurements, whose rows are labelled in a column of that name if there is one.
    pub fn of_forecasts(
        names: &ModelNames,
        columns: &Columns,
        quantiles: &Quantiles,
        label: Option<&str>,
    ) -> Self {
        EstimateTable {
            carried: label.map(String::from),
            has_weights: false,
            ..EstimateTable::of_filter(names, columns, quantiles, false, true)
        }
    }

    /// The names of the columns.
    pub fn header(&self) -> String {
        let (series, quantiles) = (self.series.clone(), self.quantiles.iter().map(String::as_str));
        let mut cells: Vec<String> =
            series.into_iter().chain(self.carried.clone()).chain(["t".to_string()]).collect();
        for state in &self.states {
            let figures = MOMENTS.into_iter().chain(quantiles.clone());
            cells.extend(figures.map(|figure| format!("{state}_{figure}")));
        }
        if self.has_weights {
            cells.extend(OF_WEIGHTS.map(String::from));
        }
        for name in &self.measurements {
            let moments = MOMENTS.into_iter().filter(|_| self.is_predictive || self.has_forecasts);
            let quantiles = quantiles.clone().filter(|_| self.has_forecasts);
            let figures = moments.chain(quantiles).chain(self.is_predictive.then_some(PLACE));
            cells.extend(figures.map(|figure| format!("{name}_{figure}")));
        }
        line(&cells)
    }

    /// The row of a time of a series.
    pub fn row(&self, series: &str, label: Option<&str>, time: f64, estimate: &Estimate) -> String {
        let mut cells = Vec::new();
        if self.series.is_some() {
            cells.push(series.to_string());
        }
        if self.carried.is_some() {
            cells.push(label.unwrap_or_default().to_string());
        }
        cells.push(time.to_string());
        for Coordinate { mean, sd, quantiles } in &estimate.state {
            cells.push(text(*mean));
            cells.extend([sd].into_iter().chain(quantiles).map(|value| text_or_nothing(*value)));
        }
        if self.has_weights {
            cells.extend(
                [estimate.ess, estimate.log_evidence].map(|value| value.map(text).unwrap_or_default()),
            );
        }
        for entry in 0..self.measurements.len() {
            let expected = estimate.predictive.get(entry);
            let figure = |of: fn(&Predictive) -> f64| text_or_nothing(expected.map_or(f64::NAN, of));
            if self.is_predictive || self.has_forecasts {
                cells.extend([figure(|expected| expected.mean), figure(|expected| expected.sd)]);
            }
            if self.has_forecasts {
                let quantile = |at| expected.map_or(f64::NAN, |expected| expected.quantiles[at]);
                cells.extend((0..self.quantiles.len()).map(|at| text_or_nothing(quantile(at))));
            }
            if self.is_predictive {
                cells.push(figure(|expected| expected.pit.unwrap_or(f64::NAN)));
            }
        }
        line(&cells)
    }

    /// The whole table of a filter: rows in the order of the data, then what is predicted.
    pub fn filtered(&self, data: &Data, filtered: &Filtered) -> String {
        self.with_forecasts(data, &filtered.estimates, &filtered.forecasts)
    }

    /// The whole table over the posterior of parameters: rows in the order of the data, then what is predicted.
    pub fn of_posterior(&self, data: &Data, posterior: &PosteriorEstimates) -> String {
        self.with_forecasts(data, &posterior.estimates, &posterior.forecasts)
    }

    /// The rows of the data, then what is predicted after each series.
    fn with_forecasts(&self, data: &Data, estimates: &[Estimate], forecasts: &[Vec<Forecast>]) -> String {
        let of_series = |(series, (ahead, places)): (usize, (&Vec<Forecast>, Vec<usize>))| -> String {
            // Labels that nobody gave go on as those of the rows do, where that is the time.
            let labels: Option<Vec<&str>> = places.iter().map(|at| data.rows[*at].label.as_deref()).collect();
            let followed = labels
                .filter(|_| !ahead.is_empty())
                .and_then(|labels| following(&labels, ahead.len(), data.columns.clock().is_none()));
            let rows = ahead.iter().enumerate().map(|(number, ahead)| {
                let followed = followed.as_ref().map(|labels| labels[number].as_str());
                let label = match (ahead.label.as_deref(), followed) {
                    (Some(label), Some(followed)) if !ahead.is_given && is_same_time(label, followed) => {
                        Some(followed)
                    }
                    (label, followed) => label.or(followed),
                };
                self.row(&data.series[series], label, ahead.time, &ahead.estimate)
            });
            rows.collect()
        };
        let ahead = forecasts.iter().zip(data.by_series()).enumerate().map(of_series);
        self.smoothed(data, estimates) + &ahead.collect::<String>()
    }

    /// What is predicted after each series and nothing else, with the label of each row if there are any.
    pub fn forecasts(&self, data: &Data, filtered: &Filtered, labels: &[String]) -> String {
        let (mut table, mut labels) = (self.header(), labels.iter());
        for (series, forecasts) in filtered.forecasts.iter().enumerate() {
            for forecast in forecasts {
                let label = labels.next().map(String::as_str);
                table += &self.row(&data.series[series], label, forecast.time, &forecast.estimate);
            }
        }
        table
    }

    /// The whole table of a smoother: rows in the order of the data.
    pub fn smoothed(&self, data: &Data, estimates: &[Estimate]) -> String {
        let rows = data.rows.iter().zip(estimates).map(|(row, estimate)| self.row_of(data, row, estimate));
        self.header() + &rows.collect::<String>()
    }

    /// The row of a row of data.
    pub fn row_of(&self, data: &Data, row: &Row, estimate: &Estimate) -> String {
        self.row(&data.series[row.series], row.label.as_deref(), row.time, estimate)
    }
}

/// The table of simulated series: `series`, the column of times that the model names or else `t`, the columns of inputs, the states, the measurements. It is data of the
/// model.
pub fn simulated_table(model: &Model, simulated: &Simulated) -> String {
    let is_measured = |name: &String| model.measurements().contains(name);
    let inputs: Vec<usize> =
        (0..model.input_columns().len()).filter(|at| !is_measured(&model.input_columns()[*at])).collect();
    let of_inputs = inputs.iter().map(|at| model.input_columns()[*at].clone());
    let time = model.time_column().unwrap_or("t");
    let names = of_inputs.chain(model.states().iter().chain(model.measurements()).cloned());
    let drawn = simulated.parameters.first().into_iter().flatten().map(|(name, _)| name.clone());
    let header: Vec<String> =
        [model.series_column(), time].map(String::from).into_iter().chain(names).chain(drawn).collect();
    let mut table = line(&header);
    for (series, (trajectory, rows)) in simulated.series.iter().zip(&simulated.rows).enumerate() {
        let numbers = trajectory.states.rows().zip(trajectory.measurements.rows());
        for (row, (state, measurement)) in rows.iter().zip(numbers) {
            let label = row.label.clone().unwrap_or_else(|| row.time().to_string());
            let inputs = inputs.iter().map(|at| row.inputs[*at].map(text).unwrap_or_default());
            let parameters = simulated.parameters.get(series).into_iter().flatten().map(|(_, value)| value);
            let numbers = state.iter().chain(measurement).chain(parameters).map(|value| text(*value));
            let cells: Vec<String> =
                [simulated.names[series].clone(), label].into_iter().chain(inputs).chain(numbers).collect();
            table += &line(&cells);
        }
    }
    table
}

/// A number, or an empty cell where there is none.
fn text_or_nothing(value: f64) -> String {
    if value.is_nan() { String::new() } else { text(value) }
}

/// Cells separated by commas, in quotes where they have to be.
pub(super) fn line(cells: &[String]) -> String {
    let cell = |cell: &String| match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.clone(),
    };
    cells.iter().map(cell).collect::<Vec<_>>().join(",") + "\n"
}
