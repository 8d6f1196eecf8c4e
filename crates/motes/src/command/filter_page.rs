//! The report of `motes filter`.

use motes::output::{Report, filter_settings, filter_summary, report};
use motes::{Data, FilterOptions, Filtered, Model, ModelNames, MotesError};

use super::args::FilterArgs;
use super::summary::command_line;

/// The report of a filter.
pub(super) fn page(
    args: &FilterArgs,
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    filtered: &Filtered,
) -> Result<String, MotesError> {
    let summary = filter_summary(data.rows.len(), data.columns.has_series(), filtered, options);
    let warnings: Vec<String> = filtered.warnings.iter().map(ToString::to_string).collect();
    let settings = filter_settings(&args.model.model.display().to_string(), &args.model.set, options);
    report(&Report {
        title: "Filter",
        names: &ModelNames::from(model),
        data,
        estimates: &filtered.estimates,
        quantiles: &options.quantiles,
        forecasts: &filtered.forecasts,
        summary: &summary,
        settings: &settings,
        warnings: &warnings,
        command: &command_line(),
    })
    .map_err(|error| MotesError::Report(error.to_string()))
}
