//! `motes filter`.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use motes::output::{EstimateTable, Output, filter_json, filter_summary};
use motes::{Data, FilterOptions, ModelNames, filter, on_threads};
use motes_cli::{Interrupt, status};

use super::args::FilterArgs;
use super::failure::Failure;
use super::filter_page::page;
use super::fitted_args::ModelAtFit;
use super::mixture::{self, MixtureRequest};
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::stream;
use super::summary::in_one_line;

pub(super) fn run(args: &FilterArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    args.output.check()?;
    let ModelAtFit { model, draws } =
        args.fitted.of(args.model.read_beside(Some(&args.data))?, &args.model.set)?;
    let ahead = args.inputs.as_ref().map(|path| Data::open_inputs(path, &model)).transpose()?;
    let options = args.settings.options(&model, args.model.seed, args.forecast)?;
    let options = FilterOptions { ahead: ahead.map(Arc::new), predictive: args.predictive, ..options };
    if draws.is_some() && args.data == Path::new("-") {
        let line = "--parameters: rows that come one by one are filtered at one point alone; take --at mean";
        return Err(Failure::new(2, line));
    }
    if args.data == Path::new("-") {
        return Ok(on_threads(args.model.threads, || stream::run(args, &model, &options, interrupt))??);
    }
    let data = Data::open(&args.data, &model)?;
    say_ignored(&data.columns, args.model.quiet);
    if let Some(draws) = &draws {
        let asked = MixtureRequest {
            model: &model,
            draws,
            data: &data,
            options: &options,
            args: &args.model,
            output: &args.output,
            paths: None,
        };
        return mixture::run(&asked, interrupt);
    }
    let start = Instant::now();
    let progress = Progress::new(data.rows.len(), args.model.quiet);
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
        let (names, has_forecasts) = (ModelNames::from(&model), options.has_forecasts());
        let FilterOptions { quantiles, predictive, .. } = &options;
        let table = EstimateTable::of_filter(&names, &data.columns, quantiles, *predictive, has_forecasts);
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
