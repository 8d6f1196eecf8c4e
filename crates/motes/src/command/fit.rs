//! `motes fit`.

use std::time::{Duration, Instant};

use motes::output::{Output, fit_json, fit_summary, fit_text};
use motes::{FitFolder, FitProgress, FitRecord, MotesError, fit_from, on_threads};
use motes_cli::{Interrupt, status};

use super::failure::Failure;
use super::fit_args::FitArgs;
use super::input;
use super::say::{say_ignored, warn, write};
use super::spinner::Spinner;
use super::summary::in_one_line;

/// Where a fit stands is written down so often.
const EVERY: Duration = Duration::from_secs(5);

pub(super) fn run(args: &FitArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read()?;
    let options = args.options(&model)?;
    let data = input::data(&args.data, &model, interrupt)?;
    say_ignored(&data.columns, args.model.quiet);
    let folder = FitFolder::open(&args.output, FitRecord::of(&model, &data, &options)?)?;
    let before = folder.progress()?;
    if before.is_some() && !args.model.quiet {
        status(&format!("motes: {}: going on from where it was stopped", args.output.display()));
    }
    let (start, mut spinner) = (Instant::now(), Spinner::new(args.model.quiet));
    let mut kept = Instant::now();
    let fitted = on_threads(args.model.threads, || {
        fit_from(&model, &data, &options, before, &|| interrupt.check(), &mut |progress: FitProgress<'_>| {
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
