//! `motes filter MODEL -`: on-line, an answer to each line as it comes.

use std::time::Instant;

use motes::output::{EstimateTable, Output, Sink, filter_json, filter_summary};
use motes::{
    Data, DataError, Estimate, FilterOptions, Model, ModelNames, MotesError, Row, RowOrder, RowSource, Rows,
    Running, SeriesTally, Tally, TimeLabel, Warning, of_proposal, of_starts, rows_ahead,
};
use motes_cli::{Interrupt, status};

use super::args::FilterArgs;
use super::filter_page::page;
use super::input::{STANDARD, Standard, stopped};
use super::say::{say_ignored, warn, write};
use super::summary::in_one_line;

/// The filter of one series.
struct Series<'m> {
    name: String,
    running: Running<'m>,
    tally: SeriesTally<'m>,
}

/// Filters what comes on standard input until it ends; the exit status.
pub(super) fn run(
    args: &FilterArgs,
    model: &Model,
    options: &FilterOptions,
    interrupt: &Interrupt,
) -> Result<u8, MotesError> {
    let start = Instant::now();
    let of_input = |error: DataError| stopped(error.into(), interrupt);
    let mut rows = Rows::new(Standard::new(interrupt), STANDARD, model).map_err(of_input)?;
    let source = RowSource::of_file(STANDARD);
    say_ignored(rows.columns(), args.model.quiet);
    let (names, has_forecasts) = (ModelNames::from(model), options.has_forecasts());
    let FilterOptions { quantiles, predictive, .. } = options;
    let table = EstimateTable::of_filter(&names, rows.columns(), quantiles, *predictive, has_forecasts);
    let mut answers = Answers::to(args.output.table())?;
    answers.say(&table.header())?;
    let mut series: Vec<Series<'_>> = Vec::new();
    let (mut tally, mut times) = (Tally::new(vec![]), 0);
    // Only a report needs what went by.
    let mut kept: Option<(Vec<Row>, Vec<Estimate>)> = args.output.report.as_ref().map(|_| Default::default());
    let (mut order, mut warnings) = (RowOrder::default(), Vec::new());
    while answers.are_read {
        let Some(row) = rows.next_row().map_err(of_input)? else { break };
        if row.series == series.len() {
            let name = rows.series().last().unwrap_or_default().to_string();
            let running = Running::new(model, options, row.series)?;
            let tally = SeriesTally::new(model, options);
            series.push(Series { name, running, tally });
        }
        let of = &mut series[row.series];
        // Where the model names the column of times, a wrong order is an error.
        let carried = rows.columns().carried().filter(|_| rows.columns().clock().is_none());
        let label = carried.zip(row.label.as_deref());
        let said = label.and_then(|(column, label)| order.next(column, row.series, row.line, label));
        if let Some(text) = said {
            let warning = Warning { series: rows.columns().has_series().then(|| of.name.clone()), text };
            warn(std::slice::from_ref(&warning), args.model.quiet, false);
            warnings.push(warning);
        }
        let named = rows.columns().has_series().then_some(of.name.as_str());
        let step = of.running.step_by(&row.steps, &row.measurement);
        let estimate = step.map_err(|error| error.at_row(&source, named, row.line))?;
        answers.say(&table.row(&of.name, row.label.as_deref(), row.time, &estimate))?;
        tally.step(&mut of.tally, &row.steps, &row.measurement, of.running.diagnosis().as_ref());
        times += 1;
        if let Some((rows, estimates)) = &mut kept {
            rows.push(row);
            estimates.push(estimate);
        }
        if interrupt.check().is_break() {
            return Err(MotesError::Interrupted);
        }
    }
    if times == 0 && !answers.are_read {
        // Nobody reads, from the first line on.
        return Ok(0);
    }
    if times == 0 {
        return Err(DataError::Empty { file: STANDARD.into() }.into());
    }
    let has_series = rows.columns().has_series();
    let mut forecasts = Vec::new();
    // Those of the order were said as their rows came.
    let said = warnings.len();
    warnings.extend(of_starts(model));
    warnings.extend(of_proposal(model, options));
    tally.warn(warnings);
    let mut clocks = rows.clocks();
    for (Series { name, running, tally: of_this }, clock) in series.iter_mut().zip(&mut clocks) {
        // Rows went by: only their times are known.
        let named = has_series.then_some(name.as_str());
        tally.end_series(named, of_this, running, |_| TimeLabel::default());
        let mut forecast = Vec::new();
        for row in rows_ahead(options, named, clock.rows())? {
            let ahead = running.predict_by(clock, row)?;
            answers.say(&table.row(name, ahead.label.as_deref(), ahead.time, &ahead.estimate))?;
            forecast.push(ahead);
        }
        tally.warn(running.forecast_warning(named));
        forecasts.push(forecast);
    }
    answers.finish()?;
    let (kept_rows, estimates) = kept.unwrap_or_default();
    let filtered = tally.into_filtered(estimates, forecasts);
    if let Some(path) = &args.output.report {
        let names = series.into_iter().map(|of| of.name).collect();
        let columns = rows.columns().clone();
        let data = Data { columns, series: names, rows: kept_rows, clocks, source, index: None };
        write(&Output::File(path.clone()), &page(args, model, &data, options, &filtered)?)?;
    }
    if args.output.json {
        write(&Output::Standard, &filter_json(&filtered, options, start.elapsed().as_secs_f64()))?;
    }
    if !args.model.quiet {
        let figures = filter_summary(times, has_series, &filtered, options);
        status(&format!("motes: {}", in_one_line(&figures)));
    }
    let status = warn(&filtered.warnings[said..], args.model.quiet, args.output.strict);
    Ok(status.max(u8::from(args.output.strict && said > 0)))
}

/// Where answers go as they are made, if anywhere, and whether anybody still reads them.
struct Answers {
    to: Option<(Sink, String)>,
    are_read: bool,
}

impl Answers {
    fn to(output: Option<Output>) -> Result<Self, MotesError> {
        let opened = output.map(|output| {
            let name = output.name();
            let sink = output.open().map_err(|source| MotesError::Output { file: name.clone(), source })?;
            Ok::<_, MotesError>((sink, name))
        });
        Ok(Answers { to: opened.transpose()?, are_read: true })
    }

    fn say(&mut self, line: &str) -> Result<(), MotesError> {
        if let (Some((sink, name)), true) = (&mut self.to, self.are_read) {
            self.are_read =
                sink.write(line).map_err(|source| MotesError::Output { file: name.clone(), source })?;
        }
        Ok(())
    }

    fn finish(self) -> Result<(), MotesError> {
        match self.to {
            Some((sink, file)) => sink.finish().map_err(|source| MotesError::Output { file, source }),
            None => Ok(()),
        }
    }
}
