//! `motes filter`.

use std::path::Path;
use std::time::Instant;

use motes::output::{EstimateTable, Output, Report, filter_json, report};
use motes::{Columns, Data, FilterOptions, Filtered, Model, MotesError, Warning, filter};
use motes_cli::{Interrupt, status};

use super::args::{FilterArgs, on_threads};
use super::failure::Failure;
use super::progress::Progress;
use super::stream;
use super::summary::{command_line, filter_settings, filter_summary, in_one_line};

pub(super) fn run(args: &FilterArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read()?;
    args.output.check()?;
    let options = args.settings.options(args.model.seed, args.forecast);
    if args.data == Path::new("-") {
        return Ok(on_threads(args.model.threads, || stream::run(args, &model, &options, interrupt))??);
    }
    let data = Data::open(&args.data, &model)?;
    say_ignored(&data.columns, args.model.quiet);
    let start = Instant::now();
    let mut progress = Progress::new(data.rows.len(), args.model.quiet);
    let filtered = on_threads(args.model.threads, || {
        filter(&model, &data, &options, |done| {
            progress.done(done);
            interrupt.check()
        })
    });
    progress.finish();
    let filtered = filtered??;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(output) = args.output.table() {
        let table = EstimateTable::new(&model, &data.columns, true);
        write(&output, &table.filtered(&data, &filtered))?;
    }
    if let Some(path) = &args.output.report {
        write(&Output::File(path.clone()), &page(args, &model, &data, &options, &filtered)?)?;
    }
    if args.output.json {
        write(&Output::Standard, &filter_json(&filtered, &options, seconds))?;
    }
    if !args.model.quiet {
        let figures = filter_summary(data.rows.len(), data.columns.has_series(), &filtered, &options);
        status(&format!("motes: {}", in_one_line(&figures)));
    }
    Ok(warn(&filtered.warnings, args.model.quiet, args.output.strict))
}

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
    let settings = filter_settings(&args.model, options);
    report(&Report {
        title: "Filter",
        model,
        data,
        estimates: &filtered.estimates,
        forecasts: &filtered.forecasts,
        summary: &summary,
        settings: &settings,
        warnings: &warnings,
        command: &command_line(),
    })
    .map_err(|error| MotesError::Report(error.to_string()))
}

/// Writes a result.
pub(super) fn write(output: &Output, text: &str) -> Result<(), MotesError> {
    output.write(text).map_err(|source| MotesError::Output { file: output.name(), source })
}

/// Says which columns are not used.
pub(super) fn say_ignored(columns: &Columns, quiet: bool) {
    if !quiet && !columns.ignored.is_empty() {
        status(&format!("motes: columns that are not used: {}", columns.ignored.join(", ")));
    }
}

/// Says what cannot be trusted; the exit status that follows.
pub(super) fn warn(warnings: &[Warning], quiet: bool, strict: bool) -> u8 {
    if !quiet {
        warnings.iter().for_each(|warning| status(&format!("motes: warning: {warning}")));
    }
    u8::from(strict && !warnings.is_empty())
}
