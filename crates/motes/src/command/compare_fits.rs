//! `motes compare` of two models that were fitted.

use std::path::Path;
use std::time::Instant;

use motes::output::{Output, fit_comparison_json, fit_comparison_text};
use motes::{FilterOptions, FittedModel, Model, compare_fits, on_threads};
use motes_cli::Interrupt;

use super::args::CompareArgs;
use super::failure::Failure;
use super::input;
use super::progress::Progress;
use super::say::{say_ignored, write};

/// Parts that progress is told in.
const PARTS: usize = 1000;

/// Particles of each filter where the exact one is not to be had, and no number was given that is larger.
const PARTICLES: usize = 1000;

/// Holds the model of the arguments and the one in `other` beside each other.
pub(super) fn run(
    args: &CompareArgs,
    [other, data]: [&Path; 2],
    filter: &FilterOptions,
    interrupt: &Interrupt,
) -> Result<u8, Failure> {
    let [first, second] = args.parameters.as_slice() else {
        let line = "--parameters: two models are held beside each other by what was fitted of both; give the folder of each fit, as in --parameters a-fit \
                    --parameters b-fit, in the order of the models";
        return Err(Failure::new(2, line));
    };
    if data == Path::new("-") {
        return Err(Failure::new(
            2,
            "-: two models read the data, and standard input can be read once; name a file",
        ));
    }
    if !args.model.set.is_empty() {
        let line = "--set: two fitted models have the parameters of their fits; leave it out";
        return Err(Failure::new(2, line));
    }
    if args.at.is_some() {
        let line =
            "--at: two fitted models are held beside each other over all that was fitted; leave it out";
        return Err(Failure::new(2, line));
    }
    if args.report.is_some() || !args.proposals.is_empty() {
        return Err(Failure::new(2, "two fitted models have no card: leave --report and --proposals out"));
    }
    if let Some(path) = &args.output {
        let output = Output::File(path.clone());
        output.check().map_err(|source| motes::MotesError::Output { file: output.name(), source })?;
    }
    let model = args.model.read_beside(Some(data))?;
    let other = Model::read(other, &[])?;
    let read = |folder, model: Model| -> Result<FittedModel, Failure> {
        let data = input::data(data, &model, interrupt)?;
        say_ignored(&data.columns, args.model.quiet);
        Ok(FittedModel::load(folder, model, data)?)
    };
    let fits = [read(first, model)?, read(second, other)?];
    let options = FilterOptions { particles: args.particles.max(PARTICLES), ..filter.clone() };
    let (start, progress) = (Instant::now(), Progress::new(PARTS, args.model.quiet));
    let compared = on_threads(args.model.threads, || {
        compare_fits([&fits[0], &fits[1]], &options, &|share| {
            progress.done((share * PARTS as f64) as usize);
            interrupt.check()
        })
    });
    progress.finish();
    let compared = compared??;
    let text = fit_comparison_text(&compared);
    match (&args.output, args.json) {
        (Some(path), _) => write(&Output::File(path.clone()), &text)?,
        (None, false) => write(&Output::Standard, &text)?,
        (None, true) => {}
    }
    if args.json {
        write(&Output::Standard, &fit_comparison_json(&compared, start.elapsed().as_secs_f64()))?;
    }
    Ok(0)
}
