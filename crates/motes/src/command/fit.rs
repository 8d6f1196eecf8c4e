//! `motes fit`.

use std::time::{Duration, Instant};

use motes::output::{
    FitReport, Output, fit_json, fit_report, fit_summary, fit_text, maximum_json, maximum_summary,
    maximum_text,
};
use motes::{
    Data, FitFolder, FitOptions, FitProgress, FitRecord, Model, MotesError, PosteriorFit, fit_from, maximise,
    on_threads,
};
use motes_cli::{Interrupt, status};

use super::failure::Failure;
use super::fit_args::{FitArgs, Method};
use super::input;
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::spinner::Spinner;
use super::summary::{command_line, in_one_line};

/// Where a fit stands is written down so often.
const EVERY: Duration = Duration::from_secs(5);

pub(super) fn run(args: &FitArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read_beside(Some(&args.data))?;
    let options = args.options(&model)?;
    let data = input::data(&args.data, &model, interrupt)?;
    say_ignored(&data.columns, args.model.quiet);
    if let Some(path) = &args.report {
        let output = Output::File(path.clone());
        output.check().map_err(|source| MotesError::Output { file: output.name(), source })?;
    }
    match args.method {
        Method::Posterior => posterior(args, &model, &data, &options, interrupt),
        Method::Maximum => maximum(args, &model, &data, &options, interrupt),
    }
}

fn posterior(
    args: &FitArgs,
    model: &Model,
    data: &Data,
    options: &FitOptions,
    interrupt: &Interrupt,
) -> Result<u8, Failure> {
    let folder = FitFolder::open(&args.output, FitRecord::of(model, data, options)?)?;
    let before = folder.progress()?;
    if before.is_some() && !args.model.quiet {
        status(&format!("motes: {}: going on from where it was stopped", args.output.display()));
    }
    let (start, mut spinner) = (Instant::now(), Spinner::new(args.model.quiet));
    let mut kept = Instant::now();
    let fitted = on_threads(args.model.threads, || {
        fit_from(model, data, options, before, &|| interrupt.check(), &mut |progress: FitProgress<'_>| {
            spinner.say(&|| progress.describe());
            if kept.elapsed() >= EVERY {
                folder.keep(progress.posterior)?;
                kept = Instant::now();
            }
            match interrupt.check().is_break() {
                true => Err(MotesError::Interrupted),
                false => Ok(()),
            }
        })
    });
    spinner.finish();
    let fitted = fitted??;
    let seconds = start.elapsed().as_secs_f64();
    folder.finish(&fitted)?;
    if let Some(path) = &args.report {
        write(&Output::File(path.clone()), &page(args, model, options, &fitted)?)?;
    }
    let exit_status = warn(&fitted.warnings, args.model.quiet, args.strict);
    match args.json {
        true => write(&Output::Standard, &fit_json(&fitted, Some(seconds)))?,
        false => write(&Output::Standard, &fit_text(&fitted))?,
    }
    if !args.model.quiet {
        status(&format!("motes: {}; {seconds:.1} s", in_one_line(&fit_summary(&fitted))));
    }
    Ok(exit_status)
}

/// The report of a posterior.
fn page(
    args: &FitArgs,
    model: &Model,
    options: &FitOptions,
    fitted: &PosteriorFit,
) -> Result<String, MotesError> {
    let mut settings = vec![
        ("model".to_string(), args.model.model.display().to_string()),
        ("data".into(), args.data.display().to_string()),
        ("chains".into(), options.chains.to_string()),
        ("seed".into(), options.seed.to_string()),
    ];
    settings.extend(args.model.set.iter().map(|(name, value)| (format!("--set {name}"), value.to_string())));
    fit_report(&FitReport { model: model.name(), fitted, settings: &settings, command: &command_line() })
        .map_err(|error| MotesError::Report(error.to_string()))
}

fn maximum(
    args: &FitArgs,
    model: &Model,
    data: &Data,
    options: &FitOptions,
    interrupt: &Interrupt,
) -> Result<u8, Failure> {
    if args.draws.is_some() || args.budget.is_some() || args.report.is_some() {
        let line = "--method maximum draws nothing: leave --draws, --budget and --report out; --chains is its number of searches";
        return Err(Failure::new(2, line));
    }
    let folder = FitFolder::open(&args.output, FitRecord::of_maximum(model, data, options)?)?;
    let (start, mut progress) = (Instant::now(), Progress::new(PARTS, args.model.quiet));
    let found = on_threads(args.model.threads, || {
        maximise(model, data, options, &|| interrupt.check(), &mut |done, all| {
            progress.done(PARTS * done / all);
            Ok(())
        })
    });
    progress.finish();
    let found = found??;
    let seconds = start.elapsed().as_secs_f64();
    folder.finish_maximum(&found)?;
    let exit_status = warn(&found.warnings, args.model.quiet, args.strict);
    match args.json {
        true => write(&Output::Standard, &maximum_json(&found, Some(seconds)))?,
        false => write(&Output::Standard, &maximum_text(&found))?,
    }
    if !args.model.quiet {
        status(&format!("motes: {}; {seconds:.1} s", in_one_line(&maximum_summary(&found))));
    }
    Ok(exit_status)
}

/// Parts that the progress of a search is told in.
const PARTS: usize = 1000;
