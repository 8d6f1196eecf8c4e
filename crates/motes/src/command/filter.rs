//! `motes filter`.

use std::path::Path;
use std::time::Instant;

use motes::output::{EstimateTable, Output, Report, filter_json, report};
use motes::{Data, FilterOptions, Filtered, Model, MotesError, filter};
use motes_cli::{Interrupt, status};

use super::args::{FilterArgs, on_threads};
use super::failure::Failure;
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::stream;
use super::summary::{command_line, filter_settings, filter_summary};

pub(super) fn run(args: &FilterArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read()?;
    args.output.check()?;
    let options = args.settings.options(args.model.seed, args.forecast);
    if args.data == Path::new("-") {
        return Ok(on_threads(args.model.threads, || stream::run(args, &model, &options))??);
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
        let page = page(args, &model, &data, &options, &filtered)?;
        write(&Output::File(path.clone()), &page)?;
    }
    if args.output.json {
        write(&Output::Standard, &filter_json(&filtered, &options, seconds))?;
    }
    if !args.model.quiet {
        let parts = filter_summary(&data, &filtered, &options).into_iter();
        let parts: Vec<String> = parts.map(|(name, value)| format!("{name} {value}")).collect();
        status(&format!("motes: {}", parts.join(", ")));
    }
    Ok(warn(&filtered.warnings, args.model.quiet, args.output.strict))
}

/// The report of a filter.
fn page(
    args: &FilterArgs,
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    filtered: &Filtered,
) -> Result<String, MotesError> {
    let summary = filter_summary(data, filtered, options);
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
