//! `motes filter`.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use motes::output::{EstimateTable, Output, filter_json, filter_summary};
use motes::{Data, FilterOptions, filter, on_threads};
use motes_cli::{Interrupt, status};

use super::args::FilterArgs;
use super::failure::Failure;
use super::filter_page::page;
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::stream;
use super::summary::in_one_line;

pub(super) fn run(args: &FilterArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read_beside(Some(&args.data))?;
    args.output.check()?;
    let ahead = args.inputs.as_ref().map(|path| Data::open_inputs(path, &model)).transpose()?;
    let options = args.settings.options(&model, args.model.seed, args.forecast)?;
    let options = FilterOptions { ahead: ahead.map(Arc::new), ..options };
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
