//! `motes smooth`.

use std::time::Instant;

use motes::output::{EstimateTable, Output, Report, filter_json, filter_settings, filter_summary, report};
use motes::{Data, FilterOptions, Model, ModelNames, MotesError, Smoothed, on_threads, smooth};
use motes_cli::{Interrupt, status};

use super::args::SmoothArgs;
use super::failure::Failure;
use super::fitted_args::ModelAtFit;
use super::input;
use super::mixture::{self, MixtureRequest};
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::summary::{command_line, in_one_line};

/// Parts that the work of both passes is told in: a row of the data is more or less of it in the first than in the second.
const PARTS: usize = 10_000;

pub(super) fn run(args: &SmoothArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    args.output.check()?;
    let ModelAtFit { model, draws } =
        args.fitted.of(args.model.read_beside(Some(&args.data))?, &args.model.set)?;
    let options = args.settings.options(&model, args.model.seed, 0)?;
    let data = input::data(&args.data, &model, interrupt)?;
    say_ignored(&data.columns, args.model.quiet);
    if let Some(draws) = &draws {
        let asked = MixtureRequest {
            model: &model,
            draws,
            data: &data,
            options: &options,
            args: &args.model,
            output: &args.output,
            paths: Some(args.paths),
        };
        return mixture::run(&asked, interrupt);
    }
    let start = Instant::now();
    let progress = Progress::new(PARTS, args.model.quiet);
    let smoothed = on_threads(args.model.threads, || {
        smooth(&model, &data, &options, args.paths, |share| {
            progress.done((share * PARTS as f64) as usize);
            interrupt.check()
        })
    });
    progress.finish();
    let smoothed = smoothed??;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(output) = args.output.table() {
        let table = EstimateTable::new(&ModelNames::from(&model), &data.columns, &options.quantiles);
        write(&output, &table.smoothed(&data, &smoothed.estimates))?;
    }
    if let Some(path) = &args.output.report {
        write(&Output::File(path.clone()), &page(args, &model, &data, &options, &smoothed)?)?;
    }
    if args.output.json {
        write(&Output::Standard, &filter_json(&smoothed.filtered, &options, seconds))?;
    }
    if !args.model.quiet {
        let figures =
            filter_summary(data.rows.len(), data.columns.has_series(), &smoothed.filtered, &options);
        status(&format!("motes: {} paths, of a filter with {}", args.paths, in_one_line(&figures)));
    }
    Ok(warn(&smoothed.filtered.warnings, args.model.quiet, args.output.strict))
}

/// The report of a smoother.
fn page(
    args: &SmoothArgs,
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    smoothed: &Smoothed,
) -> Result<String, MotesError> {
    let warnings: Vec<String> = smoothed.filtered.warnings.iter().map(ToString::to_string).collect();
    let mut settings = filter_settings(&args.model.model.display().to_string(), &args.model.set, options);
    settings.push(("paths".into(), args.paths.to_string()));
    report(&Report {
        title: "Smoother",
        names: &ModelNames::from(model),
        data,
        estimates: &smoothed.estimates,
        quantiles: &options.quantiles,
        forecasts: &[],
        summary: &filter_summary(data.rows.len(), data.columns.has_series(), &smoothed.filtered, options),
        settings: &settings,
        warnings: &warnings,
        command: &command_line(),
    })
    .map_err(|error| MotesError::Report(error.to_string()))
}
